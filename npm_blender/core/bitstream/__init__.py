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
    from .container import EncodedBase, Rung, encode_base, read_stream, write_displaced, write_ladder, write_latents
    from .displacements import around, decode_displacements, encode_displacements
    from .header import (
        BASE_NUMBERS,
        STEP_UNIT,
        DisplacedCoding,
        DisplacedNumbers,
        Header,
        LatentCoding,
        LatentFeatures,
        ParsedStream,
    )
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
    from .sharp_coding import decode_sharp, encode_sharp
    from .varint import read_varint, write_varint

__all__ = [
    "BASE_NUMBERS",
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
    "Rung",
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
    "decode_sharp",
    "encode_base",
    "encode_connectivity",
    "encode_displacements",
    "encode_positions",
    "encode_sharp",
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
    "write_ladder",
    "write_latents",
    "write_varint",
]
__getattr__, __dir__ = lazy_exports(__name__, {
    "base_positions": ("decode_positions", "encode_positions", "quantize_positions",),
    "connectivity": ("OrderedConnectivity", "canonical_order", "decode_connectivity", "encode_connectivity",
                     "order_connectivity",),
    "container": ("EncodedBase", "Rung", "encode_base", "read_stream", "write_displaced", "write_ladder", "write_latents",),
    "displacements": ("around", "decode_displacements", "encode_displacements",),
    "header": ("BASE_NUMBERS", "STEP_UNIT", "DisplacedCoding", "DisplacedNumbers", "Header", "LatentCoding", "LatentFeatures",
               "ParsedStream",),
    "range_coder": ("DECODE", "ENCODE", "MODE", "code_bit", "code_raw", "code_signed", "code_unsigned", "finish_encoding",
                    "new_contexts", "new_weights", "range_decoder", "range_encoder",),
    "sharp_coding": ("decode_sharp", "encode_sharp",),
    "varint": ("read_varint", "write_varint",),
})
