"""The sender's side of `packets`: the packets of any number of the first features."""
from binascii import crc_hqx

import numpy as np

from ..errors import StreamError
from .packets import CRC_BYTES, MAX_VALUE, Features, PacketState, code_packet, first_state, most_bytes, packet_sizes
from .range_coder import finish_encoding, range_encoder
from .significance import Faces, Sent
from .varint import write_varint


class PacketEncoder:
    """Packets of the first k of some features, for any k: batches that several k have in common are coded once.

    A batch depends on the features in it and on those of the batches before it. So for the first k features only the batch
    that k cuts is coded anew, from the state that was kept when the batches before it had been coded.
    """

    def __init__(self, faces: Faces, features: Features, batches: bool = True) -> None:
        """faces: of all groups; features: in order of importance; batches: as for `packet_sizes`.

        Raises StreamError if a face comes twice in a group, or an index or value is out of range.
        """
        self._faces, self._batches = faces, batches
        self._features = Features(*(np.array(a, dtype=np.int64) for a in features))
        self._number = _feature_numbers(faces, self._features)
        self._sorted = Features(*(np.zeros_like(a) for a in self._features))  # within each batch that was coded
        self._sizes = packet_sizes(len(self._number), batches)
        self._packets: list[list[bytes]] = []  # of each batch that was coded
        self._states = [first_state(faces, self._features.value.shape[1])]  # before each batch; they share `Sent.row`

    def packets(self, count: int | None = None) -> list[bytes]:
        """Length and payload of each packet of the first `count` features, None for all; the CRCs are not yet there."""
        out: list[bytes] = []
        at = 0
        for k, sizes in enumerate(packet_sizes(len(self._number) if count is None else count, self._batches)):
            state = self._states[k]
            if sizes != self._sizes[k]:  # `count` cuts this batch
                row = state.sent.row * (state.sent.row <= at)
                features = Features(*(a[:at + sum(sizes)].copy() for a in self._sorted))
                return out + self._coded(_copied(state, row), features, at, sizes)
            if k == len(self._packets):
                state = _copied(state, state.sent.row)
                self._packets.append(self._coded(state, self._sorted, at, sizes))
                self._states.append(state)
            out += self._packets[k]
            at += sum(sizes)
        return out

    def _coded(self, state: PacketState, features: Features, at: int, sizes: list[int]) -> list[bytes]:
        """The packets of a batch of packets of so many features from `at` on. Changes `state` and `features`."""
        out, whole = [], sum(sizes)
        order = at + np.argsort(self._number[at:at + whole], kind="stable")
        for target, given in zip(features, self._features, strict=True):
            target[at:at + whole] = given[order]
        for size in sizes:
            most = most_bytes(size, features.value.shape[1], len(state.sent.row))
            coder = range_encoder(state.contexts, state.weights, most)
            code_packet(coder, self._faces, state, features, at, size, whole)
            payload = finish_encoding(coder)
            out.append(write_varint(len(payload)) + payload)
            at, whole = at + size, 0
        return out


def _copied(state: PacketState, row: np.ndarray) -> PacketState:
    """A copy of a state with this `Sent.row`."""
    sent = Sent(row, *(a.copy() for a in state.sent[1:]))
    return PacketState(sent, *(a.copy() for a in state[1:]))


def _feature_numbers(faces: Faces, features: Features) -> np.ndarray:
    """Number of the face of each feature in `faces` (k,). Raises StreamError as `PacketEncoder` does."""
    group, face, value = features
    groups = len(faces.first) - 1
    fits = (0 <= group) & (group < groups) & (0 <= face) & (np.abs(value) <= MAX_VALUE).all(1)
    if not fits.all():
        raise StreamError(f"Expected features of levels 0..{groups - 1} and values within +-{MAX_VALUE}, found others")
    number = faces.first[group] + face
    if (number >= faces.first[group + 1]).any() or len(np.unique(number)) != len(number):
        raise StreamError("Expected at most one feature per existing face, found one twice or beyond the last face")
    return number


def with_checksums(packets: list[bytes], crc: int) -> list[bytes]:
    """Packets of a `PacketEncoder`, each with its CRC, a chain that starts from `crc` (16 bits)."""
    out = []
    for packet in packets:
        crc = crc_hqx(packet, crc)
        out.append(packet + crc.to_bytes(CRC_BYTES, "big"))
    return out


def encode_packets(faces: Faces, features: Features, crc: int, batches: bool = True) -> list[bytes]:
    """Packets of features in their order of importance.

    faces: of all groups, see `faces_of`; features: k of them. A group is the level 0..levels - 1 of latents, levels * p + the
    level of the offsets of pass p; of the values of offsets the first three count, one for each half-edge of the face, the
    same on both sides of an edge. crc: 16 bits that the first packet's CRC starts from; batches: as for `packet_sizes`.
    Raises StreamError if a face comes twice in a group, or an index or value is out of range.
    """
    return with_checksums(PacketEncoder(faces, features, batches).packets(), crc)
