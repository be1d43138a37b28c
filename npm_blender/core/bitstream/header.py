"""What a stream holds and its limits. Needs no compiled code: a receiver that is given a `ParsedStream` does without numba."""
import math
from dataclasses import dataclass

import numpy as np

from ..errors import StreamError
from ..mesh import UnitFrame

MIN_BITS, MAX_BITS = 4, 20      # of a coordinate of the base mesh
MAX_LEVELS, MAX_CHANNELS, MAX_NAME, MAX_PASSES = 8, 32, 32, 4
MAX_LEVEL_FACES = 1 << 24       # faces of all feature levels together
MAX_SOURCE = 1 << 40            # faces and vertices of the source: only shown, never allocated


@dataclass(frozen=True)
class Header:
    """What a stream says about itself. Feature levels are 0..levels - 1; features come in groups, first the latents of
    each level, then, for each pass over them, the offsets of each level.

    model_id: ASCII, 1 to 32 characters; weights_hash: 8 bytes; position_bits: lattice step 2**-bits in the unit frame;
    feature_steps: one float32 per group; total_features: of the whole stream, arrived or not; source_faces,
    source_vertices: of the mesh that was compressed; centre, size: unit frame to object space, see `UnitFrame`;
    channels: numbers per feature. Raises StreamError if a field is out of range.

    >>> from npm_blender.core.bitstream import Header
    >>> header = Header("demo", bytes(8), levels=2, position_bits=12, feature_steps=(1, 1, 0.5, 0.5), total_features=40,
    ...                 source_faces=1280, source_vertices=642, centre=(0, 0, 0), size=2)
    >>> header.passes  # over the offsets: steps of two levels of latents, then of two levels of offsets
    1
    """

    model_id: str
    weights_hash: bytes
    levels: int
    position_bits: int
    feature_steps: tuple[float, ...]
    total_features: int
    source_faces: int
    source_vertices: int
    centre: tuple[float, float, float]
    size: float
    channels: int = 8

    def __post_init__(self) -> None:
        steps = tuple(float(np.float32(s)) for s in self.feature_steps)
        object.__setattr__(self, "feature_steps", steps)
        object.__setattr__(self, "centre", tuple(float(c) for c in self.centre))
        object.__setattr__(self, "size", float(self.size))
        check_header(self.model_id.isascii() and self.model_id.isprintable() and 1 <= len(self.model_id) <= MAX_NAME,
               f"model id of 1 to {MAX_NAME} ASCII characters", self.model_id)
        check_header(len(self.weights_hash) == 8, "weights hash of 8 bytes", self.weights_hash)
        check_header(1 <= self.levels <= MAX_LEVELS, f"1 to {MAX_LEVELS} levels", self.levels)
        check_header(1 <= self.channels <= MAX_CHANNELS, f"1 to {MAX_CHANNELS} channels", self.channels)
        check_header(MIN_BITS <= self.position_bits <= MAX_BITS, f"{MIN_BITS} to {MAX_BITS} bits", self.position_bits)
        check_header(len(steps) == self.levels * (1 + self.passes) and self.passes <= MAX_PASSES
               and all(0 < s < math.inf for s in steps), "one positive step per group of features", steps)
        check_header(not self.passes or self.channels >= 3, "three numbers per feature at least", self.channels)
        check_header(0 <= self.total_features <= MAX_LEVEL_FACES, f"at most {MAX_LEVEL_FACES} features", self.total_features)
        check_header(0 <= self.source_faces <= MAX_SOURCE and 0 <= self.source_vertices <= MAX_SOURCE,
               f"at most {MAX_SOURCE} source faces and vertices", (self.source_faces, self.source_vertices))
        check_header(len(self.centre) == 3 and all(map(math.isfinite, self.centre)) and 0 < self.size < math.inf,
               "a finite centre and a positive size", (self.centre, self.size))

    @property
    def passes(self) -> int:
        """How often the stream comes to the offsets of a level: 0 for none, each time more finely."""
        return len(self.feature_steps) // self.levels - 1

    @property
    def frame(self) -> UnitFrame:
        """Unit frame of everything in the stream."""
        return UnitFrame(np.array(self.centre), self.size)


def check_header(fine: bool, expected: str, found: object) -> None:
    """Raise StreamError unless `fine`."""
    if not fine:
        raise StreamError(f"Expected {expected} in the header, found {found!r}; the file is corrupted")


@dataclass(frozen=True)
class ParsedStream:
    """A stream as far as it has arrived.

    V0 (n0, 3) float64: base positions, unit frame; F0 (m0, 3) int32; group (k,) uint8, face (k,) int32, value
    (k, channels) int32: the features that arrived; packet_ends: (features, bytes), int64 (p + 1,) each: cumulative
    features and offset in the file at the end of the base mesh and of each packet; base_bytes: offset of the first
    packet; truncated: the data end before the last promised feature; corrupt: what damage ended the reading, or None.

    >>> import numpy as np
    >>> from npm_blender.core.bitstream import Header, read_stream, write_stream
    >>> V0, F0 = np.array([[0, 0, 0], [9, 0, 0], [0, 9, 0], [9, 9, 0]]), np.array([[0, 1, 2], [1, 0, 3]])
    >>> header = Header("demo", bytes(8), 1, 10, (0.5,), 2, 2, 4, (0, 0, 0), 1.0)
    >>> stream = read_stream(write_stream(header, V0, F0, [0, 0], [1, 0], np.ones((2, 8), int)))
    >>> stream.face.tolist(), stream.packet_ends[0].tolist()  # one packet of two features, inside it sorted by face
    ([0, 1], [0, 2])
    """

    header: Header
    V0: np.ndarray
    F0: np.ndarray
    group: np.ndarray
    face: np.ndarray
    value: np.ndarray
    packet_ends: tuple[np.ndarray, np.ndarray]
    base_bytes: int
    truncated: bool
    corrupt: str | None
