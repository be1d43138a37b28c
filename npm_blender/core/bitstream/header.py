"""What a stream holds and its limits. Needs no compiled code: a receiver that is given a `ParsedStream` does without numba."""
import math
from dataclasses import dataclass

import numpy as np

from ..errors import StreamError
from ..mesh import Sharp, UnitFrame

MIN_BITS, MAX_BITS = 4, 20      # of a coordinate of the base mesh
MAX_LEVELS, MAX_CHANNELS, MAX_NAME, MAX_STAGES = 8, 32, 32, 24
MAX_RUNGS = 8
MAX_LEVEL_FACES = 1 << 24       # faces of all levels together
MAX_NUMBERS = 1 << 25           # integers of all stages together
MAX_SOURCE = 1 << 40            # faces and vertices of the source: only shown, never allocated
STEP_UNIT, GROWTH_UNIT, SMOOTHEST = 16, 16, 8
BASE_NUMBERS = 3                # features that a vertex of a later base counts for: its coordinates


@dataclass(frozen=True)
class DisplacedCoding:
    """Integers along normals, stage by stage (see `displacements`).

    smooth: of the subdivision scheme, 0..SMOOTHEST; step: the step of level 0 in the first stage is 2**(-step / STEP_UNIT), unit
    frame; growth: the step of each level is growth / GROWTH_UNIT times that of the level below; stages: each halves the steps;
    payload: bytes of all numbers; ends: of each level but the finest, the number of stages after which it stays as it is.

    >>> from npm_blender.core.bitstream import DisplacedCoding
    >>> DisplacedCoding(smooth=8, step=128, growth=32, stages=2, payload=0).steps(levels=2, stage=1).tolist()
    [0.001953125, 0.00390625, 0.0078125]
    """

    smooth: int
    step: int
    growth: int
    stages: int
    payload: int
    ends: tuple[int, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "ends", tuple(int(end) for end in self.ends))
        check_header(all(0 <= end <= MAX_STAGES for end in self.ends), f"levels of at most {MAX_STAGES} stages", self.ends)
        check_header(0 <= self.smooth <= SMOOTHEST, f"a smoothness of 0 to {SMOOTHEST}", self.smooth)
        check_header(0 <= self.step < 1 << 10, "a step of 0 to 1023", self.step)
        check_header(1 <= self.growth <= 64, "a growth of 1 to 64", self.growth)
        check_header(0 <= self.stages <= MAX_STAGES, f"at most {MAX_STAGES} stages", self.stages)
        check_header(0 <= self.payload < 1 << 30, "a payload below 1 GB", self.payload)

    def steps(self, levels: int, stage: int) -> np.ndarray:
        """Steps of levels 0..levels in a stage, (levels + 1,) float64, unit frame."""
        return 2.0 ** (-self.step / STEP_UNIT - stage) * (self.growth / GROWTH_UNIT) ** np.arange(levels + 1.0)


@dataclass(frozen=True)
class LatentCoding:
    """The paper's features: latents of faces, which a network decodes.

    model_id: ASCII, 1 to 32 characters; weights_hash: 8 bytes; steps: one float32 per level 0..levels - 1; channels: numbers
    per feature.

    >>> from npm_blender.core.bitstream import LatentCoding
    >>> LatentCoding("demo", bytes(8), (1, 0.5), channels=8).steps
    (1.0, 0.5)
    """

    model_id: str
    weights_hash: bytes
    steps: tuple[float, ...]
    channels: int

    def __post_init__(self) -> None:
        object.__setattr__(self, "steps", tuple(float(np.float32(s)) for s in self.steps))
        check_header(self.model_id.isascii() and self.model_id.isprintable() and 1 <= len(self.model_id) <= MAX_NAME,
                     f"model id of 1 to {MAX_NAME} ASCII characters", self.model_id)
        check_header(len(self.weights_hash) == 8, "weights hash of 8 bytes", self.weights_hash)
        check_header(1 <= self.channels <= MAX_CHANNELS, f"1 to {MAX_CHANNELS} channels", self.channels)
        check_header(all(0 < s < math.inf for s in self.steps), "positive steps", self.steps)


@dataclass(frozen=True)
class Header:
    """What a stream says about itself.

    levels: subdivisions of the base; position_bits: lattice step 2**-bits in the unit frame; total_features: of this rung and
    all that follow, arrived or not: latents, or numbers of displaced surfaces and coordinates of all bases but the first;
    source_faces, source_vertices: of the mesh that was compressed; low, size: unit frame to object space: the corner that the
    lattice starts from, and the unit; coding: of the features; followed: whether a finer rung comes behind. Raises StreamError if
    a field is out of range.

    >>> from npm_blender.core.bitstream import DisplacedCoding, Header
    >>> coding = DisplacedCoding(smooth=8, step=128, growth=22, stages=0, payload=0, ends=(0, 0))
    >>> Header(levels=2, position_bits=8, total_features=0, source_faces=1280, source_vertices=642, low=(0, 0, 0), size=2,
    ...        coding=coding).frame.to_object(0.5)
    array([1., 1., 1.])
    """

    levels: int
    position_bits: int
    total_features: int
    source_faces: int
    source_vertices: int
    low: tuple[float, float, float]
    size: float
    coding: DisplacedCoding | LatentCoding
    followed: bool = False

    def __post_init__(self) -> None:
        object.__setattr__(self, "low", tuple(float(c) for c in self.low))
        object.__setattr__(self, "size", float(np.float32(self.size)))
        latent = isinstance(self.coding, LatentCoding)
        check_header(latent <= self.levels <= MAX_LEVELS, f"{int(latent)} to {MAX_LEVELS} levels", self.levels)
        check_header(MIN_BITS <= self.position_bits <= MAX_BITS, f"{MIN_BITS} to {MAX_BITS} bits", self.position_bits)
        check_header(0 <= self.total_features <= MAX_NUMBERS, f"at most {MAX_NUMBERS} features", self.total_features)
        check_header(0 <= self.source_faces <= MAX_SOURCE and 0 <= self.source_vertices <= MAX_SOURCE,
                     f"at most {MAX_SOURCE} source faces and vertices", (self.source_faces, self.source_vertices))
        check_header(len(self.low) == 3 and all(map(math.isfinite, self.low)) and 0 < self.size < math.inf,
                     "a finite corner and a positive size", (self.low, self.size))
        said = self.coding.steps if isinstance(self.coding, LatentCoding) else self.coding.ends
        check_header(len(said) == self.levels, "one entry per level", said)

    @property
    def frame(self) -> UnitFrame:
        """Unit frame of everything in the stream: its origin is the low corner of the lattice."""
        return UnitFrame(np.array(self.low), self.size)


def check_header(fine: bool, expected: str, found: object) -> None:
    """Raise StreamError unless `fine`."""
    if not fine:
        raise StreamError(f"Expected {expected} in the header, found {found!r}; the file is corrupted")


@dataclass(frozen=True)
class LatentFeatures:
    """Latents that arrived, in the order of the stream: level (k,) uint8, face (k,) int32 of it, value (k, channels) int32.

    >>> import numpy as np
    >>> from npm_blender.core.bitstream import LatentFeatures
    >>> LatentFeatures(np.array([0]), np.array([7]), np.array([[1, 0, -2, 0, 0, 0, 0, 0]])).value.shape
    (1, 8)
    """

    level: np.ndarray
    face: np.ndarray
    value: np.ndarray


@dataclass(frozen=True)
class DisplacedNumbers:
    """Integers of a displaced surface as far as they have arrived.

    table (stages, n) int64: of every vertex after each stage, twice the value of the stage before where none has arrived;
    coded (stages, levels + 1) bool: the levels of a stage in which numbers are sent.

    >>> import numpy as np
    >>> from npm_blender.core.bitstream import DisplacedNumbers
    >>> numbers = DisplacedNumbers(table=np.array([[0, 0, 0, 1], [0, 0, 0, 3]]), coded=np.array([[False, True]] * 2))
    >>> (numbers.table[1] - 2 * numbers.table[0]).tolist()  # what the second stage sent
    [0, 0, 0, 1]
    """

    table: np.ndarray
    coded: np.ndarray


@dataclass(frozen=True)
class ParsedStream:
    """A stream, or a rung of one, as far as it has arrived.

    grid (n0, 3) int64: base positions on the lattice; F0 (m0, 3) int32; details: the features that arrived, of the kind of
    `header.coding`; ends: (features, bytes), int64 (p + 1,) each: features that have arrived with so many bytes of the file,
    from the base mesh on; base_bytes: offset behind the base mesh; truncated: the data end before the last promised
    feature; corrupt: what damage ended the reading, or None; sharp: creases and corners of the base, or None; finer:
    the next rung.

    >>> import numpy as np
    >>> from npm_blender.core.bitstream import DisplacedCoding, DisplacedNumbers, Header, ParsedStream
    >>> header = Header(0, 8, 0, 2, 4, (0, 0, 0), 1.0, DisplacedCoding(0, 0, 22, 0, 0))
    >>> numbers, ends = DisplacedNumbers(np.zeros((0, 3)), np.zeros((0, 1), bool)), (np.array([0]), np.array([99]))
    >>> ParsedStream(header, 64 * np.eye(3, dtype=int), np.array([[0, 1, 2]]), numbers, ends, 99, False, None).V0[0].tolist()
    [0.25, 0.0, 0.0]
    """

    header: Header
    grid: np.ndarray
    F0: np.ndarray
    details: LatentFeatures | DisplacedNumbers
    ends: tuple[np.ndarray, np.ndarray]
    base_bytes: int
    truncated: bool
    corrupt: str | None
    sharp: Sharp | None = None
    finer: "ParsedStream | None" = None

    @property
    def rungs(self) -> list["ParsedStream"]:
        """This rung and all finer ones, as far as their bases have arrived."""
        return [self, *(self.finer.rungs if self.finer else ())]

    @property
    def V0(self) -> np.ndarray:
        """Base positions (n0, 3) float64, unit frame."""
        return self.grid * 2.0**-self.header.position_bits

    @property
    def features(self) -> int:
        """How many of this rung have arrived."""
        return int(self.ends[0][-1])
