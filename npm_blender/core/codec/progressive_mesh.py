"""The receiver: an opened `.npmesh` stream that decodes any number of its features to any of its levels."""

from collections import OrderedDict
from os import PathLike

import numpy as np

from ..bitstream import LatentCoding, ParsedStream
from ..errors import SettingsError, StreamError
from ..mesh import TriMesh
from ..settings import DISPLACED, PAPER
from .displaced_decoder import DisplacedDecoder
from .latent_decoder import LatentDecoder

CACHED, ROOM = 32, 24_000_000  # decodes kept, and their bytes; a slider that goes back finds its meshes at once


class ProgressiveMesh:
    """A stream as far as it has arrived. Connectivity is built once; positions of recent decodes are kept.

    Made by `open_stream` and `StoredStream.open` (the receiver of the paper's section 3). A feature is a number of a displaced
    surface, or a latent of the paper's stream. features: that arrived; total_features: of the whole stream; levels: the finest;
    base_bytes, total_bytes: of the shortest prefix, and of this one; stops: numbers of features worth stopping at, ascending,
    from 0 to all; model: 'displaced' or 'paper'.

    >>> from npm_blender.core import CompressSettings, LodSettings, TriMesh, compress, open_stream
    >>> V = [[x, y, x * y / 8] for y in range(5) for x in range(5)]
    >>> F = [f for i in range(19) if i % 5 < 4 for f in ([i, i + 1, i + 5], [i + 1, i + 6, i + 5])]
    >>> settings = CompressSettings(LodSettings(base_faces=8, levels=1))
    >>> data = compress(TriMesh.from_arrays(V, F), settings, progress=lambda fraction, message: None).data
    >>> mesh = open_stream(data)
    >>> [mesh.faces_at(level) for level in (0, 1)], mesh.bytes_for(0) == mesh.base_bytes
    ([8, 32], True)
    """

    def __init__(self, stream: ParsedStream, size: int) -> None:
        """stream: what `read_stream` returned for `size` bytes. Raises WeightsError if its weights are not here."""
        header, coding = stream.header, stream.header.coding
        latent = isinstance(coding, LatentCoding)
        self._decoder: LatentDecoder | DisplacedDecoder = (LatentDecoder if latent else DisplacedDecoder)(stream)
        self.header, self.total_bytes, self.model = header, size, PAPER if latent else DISPLACED
        self.levels, self.position_bits = header.levels, header.position_bits
        self.total_features, self.features = header.total_features, stream.features
        self.truncated, self.corrupt = stream.truncated, stream.corrupt
        self.source_faces, self.source_vertices = header.source_faces, header.source_vertices
        self.base_faces, self.base_vertices, self.base_bytes = len(stream.F0), len(stream.grid), stream.base_bytes
        self.stops = (0, *(k for k in self._decoder.stops if 0 < k < self.features), *([self.features] if self.features else []))
        self._end_features, self._end_bytes = stream.ends
        self._levels = self._decoder.levels
        self._cache: OrderedDict[tuple[int, int], np.ndarray] = OrderedDict()

    @property
    def shortfall(self) -> str:
        """What is wrong with a file that ends early or is damaged, as one line that goes on from its name; else empty."""
        opened = f"opened with {self.features:,} of {self.total_features:,} features"
        if self.corrupt:
            return (f"is damaged after {self._end_bytes[-1]:,} of {self.total_bytes:,} bytes: "
                    f"{self.corrupt[0].lower()}{self.corrupt[1:]}; {opened}; get the file again")
        return f"ends early: {opened}" if self.truncated else ""

    def bytes_for(self, features: int) -> int:
        """Bytes of the shortest prefix that holds this many features; they arrive some at a time."""
        features = self._checked_features(features)
        return int(self._end_bytes[np.searchsorted(self._end_features, features)])

    def features_for(self, size: int) -> int:
        """Features that a prefix of this many bytes holds. Raises SettingsError if it ends before the base mesh."""
        if size < self.base_bytes:
            raise SettingsError(f"Expected at least {self.base_bytes} bytes (the base mesh), found {size}")
        return int(self._end_features[np.searchsorted(self._end_bytes, size, side="right") - 1])

    def numbers(self, features: int) -> int:
        """Numbers in the first features: 8 in a latent, as paper section 4.1 counts them for CR."""
        return self._decoder.scalars(self._checked_features(features))

    def faces_at(self, level: int) -> int:
        """Faces of a level."""
        return self.base_faces * 4 ** self._checked_level(level)

    def level_faces(self, level: int | None = None) -> np.ndarray:
        """Faces (m, 3) int32 of a level (None: the finest); they depend on nothing else."""
        return self._levels[self._checked_level(level)].F

    def decode_positions(self, features: int | None = None, level: int | None = None) -> np.ndarray:
        """Vertices (n, 3) float64, object space, of a level (None: finest) with the first features (None: all)."""
        level = self._checked_level(level)
        return self.header.frame.to_object(self._unit_positions(self._checked_features(features), level).astype(np.float64))

    def decode(self, features: int | None = None, level: int | None = None) -> TriMesh:
        """The mesh of `decode_positions` and `level_faces`, in object space. Raises SettingsError if out of range."""
        return TriMesh(self.decode_positions(features, level), self.level_faces(level))

    def _unit_positions(self, features: int, level: int) -> np.ndarray:
        """Vertices (n, 3) of a level, unit frame; the last decodes are kept."""
        found = self._cache.get((features, level))
        if found is None:
            found = self._decoder.vertices(features, level)
        self._cache[features, level] = found
        self._cache.move_to_end((features, level))
        while len(self._cache) > min(CACHED, max(2, ROOM // found.nbytes)):
            self._cache.popitem(last=False)
        return found

    def _checked_level(self, level: int | None) -> int:
        level = self.levels if level is None else level
        _check_whole("level", level)
        if not 0 <= level <= self.levels:
            raise SettingsError(f"Expected a level from 0 to {self.levels}, found {level}")
        return level

    def _checked_features(self, features: int | None) -> int:
        features = self.features if features is None else features
        _check_whole("features", features)
        if not 0 <= features <= self.features:
            raise SettingsError(f"Expected 0 to {self.features} features, found {features}")
        return features


def _check_whole(name: str, value: object) -> None:
    if isinstance(value, bool) or not isinstance(value, int | np.integer):
        raise SettingsError(f"Expected {name} to be a whole number, found {value!r}; call decode({name}=2), say")


def open_stream(data: bytes) -> ProgressiveMesh:
    """Open the bytes of an `.npmesh` file, or any prefix of them past the base mesh.

    Raises StreamError (no bytes, foreign, newer, corrupted, or cut before the end of the base mesh), WeightsError.

    >>> from npm_blender.core import CompressSettings, LodSettings, TriMesh, compress, open_stream
    >>> V = [[x, y, x * y / 8] for y in range(5) for x in range(5)]
    >>> F = [f for i in range(19) if i % 5 < 4 for f in ([i, i + 1, i + 5], [i + 1, i + 6, i + 5])]
    >>> settings = CompressSettings(LodSettings(base_faces=8, levels=1))
    >>> data = compress(TriMesh.from_arrays(V, F), settings, progress=lambda fraction, message: None).data
    >>> whole = open_stream(data)
    >>> cut = open_stream(data[:whole.base_bytes])  # what has arrived after the base mesh
    >>> cut.features, cut.truncated, len(cut.decode(level=0).F)
    (0, True, 8)
    """
    if not isinstance(data, bytes | bytearray | memoryview):
        kind = "a path" if isinstance(data, str | PathLike) else f"a {type(data).__name__}"
        raise StreamError(f"Expected the bytes of a stream, found {kind}; call open_stream(Path(name).read_bytes())")
    from ..bitstream import read_stream  # only here: this import loads or compiles the entropy decoder

    return ProgressiveMesh(read_stream(data), len(data))
