"""The .npmesh file: bytes and integers, no floats."""
from typing import TYPE_CHECKING

from ..lazy import lazy_exports

if TYPE_CHECKING:
    from .base_positions import decode_positions, encode_positions, quantize_positions
    from .connectivity import (
        OrderedConnectivity,
        canonical_order,
        decode_connectivity,
        encode_connectivity,
        order_connectivity,
    )
    from .container import EncodedBase, displaced_size, encode_base, read_stream, write_displaced, write_latents
    from .displacements import around, decode_displacements, encode_displacements
    from .header import STEP_UNIT, DisplacedCoding, DisplacedNumbers, Header, LatentCoding, LatentFeatures, ParsedStream
    from .range_coder import (
        DECODE,
        ENCODE,
        MODE,
        code_bit,
        code_raw,
        code_signed,
        code_unsigned,
        finish_encoding,
        new_contexts,
        new_weights,
        range_decoder,
        range_encoder,
    )
    from .varint import read_varint, write_varint

__all__ = [
    "DECODE",
    "DisplacedCoding",
    "DisplacedNumbers",
    "ENCODE",
    "EncodedBase",
    "Header",
    "LatentCoding",
    "LatentFeatures",
    "MODE",
    "OrderedConnectivity",
    "ParsedStream",
    "STEP_UNIT",
    "around",
    "canonical_order",
    "code_bit",
    "code_raw",
    "code_signed",
    "code_unsigned",
    "decode_connectivity",
    "decode_displacements",
    "decode_positions",
    "displaced_size",
    "encode_base",
    "encode_connectivity",
    "encode_displacements",
    "encode_positions",
    "finish_encoding",
    "new_contexts",
    "new_weights",
    "order_connectivity",
    "quantize_positions",
    "range_decoder",
    "range_encoder",
    "read_stream",
    "read_varint",
    "write_displaced",
    "write_latents",
    "write_varint",
]
__getattr__, __dir__ = lazy_exports(__name__, {
    "base_positions": ("decode_positions", "encode_positions", "quantize_positions",),
    "connectivity": ("OrderedConnectivity", "canonical_order", "decode_connectivity", "encode_connectivity",
                     "order_connectivity",),
    "container": ("EncodedBase", "displaced_size", "encode_base", "read_stream", "write_displaced", "write_latents",),
    "displacements": ("around", "decode_displacements", "encode_displacements",),
    "header": ("STEP_UNIT", "DisplacedCoding", "DisplacedNumbers", "Header", "LatentCoding", "LatentFeatures", "ParsedStream",),
    "range_coder": ("DECODE", "ENCODE", "MODE", "code_bit", "code_raw", "code_signed", "code_unsigned", "finish_encoding",
                    "new_contexts", "new_weights", "range_decoder", "range_encoder",),
    "varint": ("read_varint", "write_varint",),
})
