"""The receiver: an opened `.npmesh` stream that decodes any number of its features to any of its levels."""

from bisect import bisect_right
from collections import OrderedDict
from os import PathLike
from typing import NamedTuple

import numpy as np

from ..bitstream import BASE_NUMBERS, LatentCoding, ParsedStream
from ..errors import SettingsError, StreamError
from ..mesh import TriMesh
from ..settings import DISPLACED, PAPER
from .displaced_decoder import DisplacedDecoder
from .latent_decoder import LatentDecoder

CACHED, ROOM = 32, 24_000_000  # decodes kept, and their bytes; a slider that goes back finds its meshes at once


class RungFacts(NamedTuple):
    """Of a rung: base_faces; levels; features and bytes from which on it is shown; begin: the byte where its base begins.

    >>> from npm_blender.core.codec import RungFacts
    >>> RungFacts(base_faces=3200, levels=3, features=4800, bytes=5000, begin=1600).base_faces
    3200
    """

    base_faces: int
    levels: int
    features: int
    bytes: int
    begin: int


class ProgressiveMesh:
    """A stream as far as it has arrived. Connectivity is built once; positions of recent decodes are kept.

    Made by `open_stream` and `StoredStream.open` (the receiver of the paper's section 3). A stream is a ladder of rungs, each a
    base mesh with levels and details; what is shown is the last rung whose base has arrived. A feature is a number that has
    arrived, of a displaced surface or of a later base, or a latent of the paper's stream.

    features: that arrived; total_features: of the whole stream; levels: the finest, of any rung (one that has fewer shows its
    finest); base_faces, base_vertices: of the first rung; base_bytes, total_bytes: of the shortest prefix, and of this one;
    stops: numbers of features worth stopping at, ascending, from 0 to all; model: 'displaced' or 'paper'.

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
        header, parsed = stream.header, stream.rungs
        latent = isinstance(header.coding, LatentCoding)
        decoder = LatentDecoder if latent else DisplacedDecoder
        self._rungs: list[LatentDecoder | DisplacedDecoder] = [decoder(one) for one in parsed]
        self._shapes = [(len(one.F0), one.header.levels) for one in parsed]  # without making the levels of any rung
        self.header, self.total_bytes, self.model = header, size, PAPER if latent else DISPLACED
        self.levels, self.position_bits = max(one.header.levels for one in parsed), header.position_bits
        self.truncated = any(one.truncated for one in parsed)
        self.corrupt = next((one.corrupt for one in parsed if one.corrupt), None)
        self.source_faces, self.source_vertices = header.source_faces, header.source_vertices
        self.base_faces, self.base_vertices, self.base_bytes = len(stream.F0), len(stream.grid), stream.base_bytes
        # features from which each rung is there, and what stands between that and the end of the one before: its base
        self._from, stops, ends = [], [0], []
        count = 0
        for place, (one, rung) in enumerate(zip(parsed, self._rungs, strict=True)):
            count += BASE_NUMBERS * len(one.grid) if place else 0
            self._from.append(count)
            ends.append((count + one.ends[0], one.ends[1]))
            stops += [count, *(count + k for k in rung.stops if k <= one.features)]
            count += one.features
        self.features, self.total_features = count, header.total_features
        self.stops = tuple(sorted({*stops, count}))
        self._end_features, self._end_bytes = map(np.concatenate, zip(*ends, strict=True))
        self._cache: OrderedDict[tuple[int, int], np.ndarray] = OrderedDict()

    @property
    def rungs(self) -> tuple[RungFacts, ...]:
        """The rungs that have arrived."""
        out = []
        for (faces, levels), features in zip(self._shapes, self._from, strict=True):
            place = int(np.searchsorted(self._end_features, features))
            begin = int(self._end_bytes[place - 1]) if place else 0
            out.append(RungFacts(faces, levels, features, int(self._end_bytes[place]), begin))
        return tuple(out)

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
        return self._rungs[0].scalars(self._checked_features(features))

    def faces_at(self, level: int, features: int | None = None) -> int:
        """Faces of a level with the first features (None: all)."""
        faces, levels = self._shapes[self.rung_at(self._checked_features(features))]
        return faces * 4 ** min(self._checked_level(level), levels)

    def level_faces(self, level: int | None = None, features: int | None = None) -> np.ndarray:
        """Faces (m, 3) int32 of a level (None: the finest) with the first features (None: all): those of the last rung that
        is there."""
        level, features = self._checked_level(level), self._checked_features(features)
        levels = self._rungs[self.rung_at(features)].levels
        return levels[min(level, len(levels) - 1)].F

    def decode_positions(self, features: int | None = None, level: int | None = None) -> np.ndarray:
        """Vertices (n, 3) float64, object space, of a level (None: finest) with the first features (None: all)."""
        level = self._checked_level(level)
        return self.header.frame.to_object(self._unit_positions(self._checked_features(features), level).astype(np.float64))

    def decode(self, features: int | None = None, level: int | None = None) -> TriMesh:
        """The mesh of `decode_positions` and `level_faces`, in object space. Raises SettingsError if out of range."""
        return TriMesh(self.decode_positions(features, level), self.level_faces(level, features))

    def rung_at(self, features: int) -> int:
        """The last rung whose base is among the first features; the first is 0. Faces depend on it and on the level alone."""
        return bisect_right(self._from, features) - 1

    def _unit_positions(self, features: int, level: int) -> np.ndarray:
        """Vertices (n, 3) of a level, unit frame; the last decodes are kept."""
        found = self._cache.get((features, level))
        if found is None:
            place = self.rung_at(features)
            rung = self._rungs[place]
            found = rung.vertices(min(features - self._from[place], rung.features), min(level, len(rung.levels) - 1))
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
    >>> V = [[x, y, x * y % 3 / 4] for y in range(5) for x in range(5)]
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
