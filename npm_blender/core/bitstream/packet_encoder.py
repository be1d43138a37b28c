"""The sender's side of `packets`."""
from binascii import crc_hqx

import numpy as np

from ..errors import StreamError
from .packets import CRC_BYTES, MAX_VALUE, Features, code_packet, first_state, most_bytes, packet_sizes
from .range_coder import finish_encoding, range_encoder
from .significance import Faces
from .varint import write_varint


def encode_packets(faces: Faces, features: Features, crc: int) -> list[bytes]:
    """Packets of features in their order of importance, each with its CRC.

    faces: of all levels, see `faces_of`; features: k of them; crc: 16 bits that the first packet's CRC starts from.
    Raises StreamError if a face comes twice in a level, or an index or value is out of range.
    """
    given = Features(*(np.array(a, dtype=np.int64) for a in features))
    number = _feature_numbers(faces, given)
    state, ordered = first_state(faces, given.value.shape[1]), Features(*(np.zeros_like(a) for a in given))
    out, at = [], 0
    for sizes in packet_sizes(len(number)):
        whole = sum(sizes)
        order = at + np.argsort(number[at:at + whole], kind="stable")
        for target, source in zip(ordered, given, strict=True):
            target[at:at + whole] = source[order]
        for size in sizes:
            most = most_bytes(size, given.value.shape[1], len(state.sent.row))
            coder = range_encoder(state.contexts, state.weights, most)
            code_packet(coder, faces, state, ordered, at, size, whole)
            payload = finish_encoding(coder)
            packet = write_varint(len(payload)) + payload
            crc = crc_hqx(packet, crc)
            out.append(packet + crc.to_bytes(CRC_BYTES, "big"))
            at, whole = at + size, 0
    return out


def _feature_numbers(faces: Faces, features: Features) -> np.ndarray:
    """Number of the face of each feature in `faces` (k,). Raises StreamError as `encode_packets` does."""
    level, face, value = features
    levels = len(faces.first) - 1
    fits = (0 <= level) & (level < levels) & (0 <= face) & (np.abs(value) <= MAX_VALUE).all(1)
    if not fits.all():
        raise StreamError(f"Expected features of levels 0..{levels - 1} and values within +-{MAX_VALUE}, found others")
    number = faces.first[level] + face
    if (number >= faces.first[level + 1]).any() or len(np.unique(number)) != len(number):
        raise StreamError("Expected at most one feature per existing face, found one twice or beyond the last face")
    return number
