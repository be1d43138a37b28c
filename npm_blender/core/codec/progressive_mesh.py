"""The receiver: an opened `.npmesh` stream that decodes any number of its features to any of its levels."""

from collections import OrderedDict
from os import PathLike

import numpy as np

from ..bitstream import ParsedStream
from ..errors import SettingsError, StreamError, WeightsError
from ..mesh import TriMesh, UnitFrame, hierarchy
from ..network import EDGES, FEATURES, NUMPY, MeshIndex, Step, handed_down, load_weights, predict

CACHED = 32  # decodes kept; a slider that goes back finds its meshes at once


class ProgressiveMesh:
    """A stream as far as it has arrived. Connectivity is built once; positions of recent decodes are kept, and of each
    level's step what the network said last: another number of features changes only the levels that see those features.

    Made by `open_stream` and `StoredStream.open` (the receiver of the paper's section 3). features: that arrived;
    total_features: of the whole stream; levels: the finest; base_bytes, total_bytes: of the shortest prefix, and of this one.

    >>> from npm_blender.core import CompressSettings, LodSettings, TriMesh, compress, open_stream
    >>> V = [[x, y, x * y / 8] for y in range(5) for x in range(5)]
    >>> F = [f for i in range(19) if i % 5 < 4 for f in ([i, i + 1, i + 5], [i + 1, i + 6, i + 5])]
    >>> settings = CompressSettings(LodSettings(base_faces=8, levels=1), refine_steps=0)
    >>> data = compress(TriMesh.from_arrays(V, F), settings, progress=lambda fraction, message: None).data
    >>> mesh = open_stream(data)
    >>> [mesh.faces_at(level) for level in (0, 1)], mesh.bytes_for(0) == mesh.base_bytes
    ([8, 32], True)
    """

    def __init__(self, stream: ParsedStream, size: int) -> None:
        """stream: what `read_stream` returned for `size` bytes. Raises WeightsError if its weights are not here."""
        header = stream.header
        model = load_weights(header.model_id)
        if model.digest != header.weights_hash:
            raise WeightsError(
                f"Expected weights '{header.model_id}' {header.weights_hash.hex()}, found {model.digest.hex()}; "
                "install the version of the extension that wrote this file"
            )
        self.header, self.total_bytes = header, size
        self.levels, self.model_id, self.position_bits = header.levels, header.model_id, header.position_bits
        self.total_features, self.features = header.total_features, len(stream.group)
        self.truncated, self.corrupt = stream.truncated, stream.corrupt
        self.source_faces, self.source_vertices = header.source_faces, header.source_vertices
        self.base_faces, self.base_vertices, self.base_bytes = len(stream.F0), len(stream.V0), stream.base_bytes
        self._packet_features, self._packet_bytes = stream.packet_ends
        self._frame = UnitFrame(np.asarray(header.centre), header.size)
        self._params = model.params
        self._V0 = NUMPY.array(stream.V0)
        self._levels = hierarchy(stream.F0, len(stream.V0), header.levels)
        self._meshes = [MeshIndex.of(NUMPY, level) for level in self._levels[:-1]]
        step = np.asarray(header.feature_steps, dtype=np.float32)
        self._group, self._face = stream.group, stream.face
        self._value = stream.value.astype(np.float32) * step[stream.group][:, None]
        self._cache: OrderedDict[int, list[np.ndarray]] = OrderedDict()
        self._steps: list[tuple[tuple, Step] | None] = [None] * header.levels

    @property
    def shortfall(self) -> str:
        """What is wrong with a file that ends early or is damaged, as one line that goes on from its name; else empty."""
        opened = f"opened with {self.features:,} of {self.total_features:,} features"
        if self.corrupt:
            return (f"is damaged after {self._packet_bytes[-1]:,} of {self.total_bytes:,} bytes: "
                    f"{self.corrupt[0].lower()}{self.corrupt[1:]}; {opened}; get the file again")
        return f"ends early: {opened}" if self.truncated else ""

    def bytes_for(self, features: int) -> int:
        """Bytes of the shortest prefix that holds this many features; whole packets arrive, never parts."""
        features = self._checked_features(features)
        return int(self._packet_bytes[np.searchsorted(self._packet_features, features)])

    def features_for(self, size: int) -> int:
        """Features that a prefix of this many bytes holds. Raises SettingsError if it ends before the base mesh."""
        if size < self.base_bytes:
            raise SettingsError(f"Expected at least {self.base_bytes} bytes (the base mesh), found {size}")
        return int(self._packet_features[np.searchsorted(self._packet_bytes, size, side="right") - 1])

    def numbers(self, features: int) -> int:
        """Numbers in the first features: 8 in a latent, 3 in a feature of offsets (paper section 4.1 counts them for CR)."""
        latents = int((self._group[: self._checked_features(features)] < self.levels).sum())
        return FEATURES * latents + EDGES * (features - latents)

    def faces_at(self, level: int) -> int:
        """Faces of a level."""
        return self.base_faces * 4 ** self._checked_level(level)

    def level_faces(self, level: int | None = None) -> np.ndarray:
        """Faces (m, 3) int32 of a level (None: the finest); they depend on nothing else."""
        return self._levels[self._checked_level(level)].F

    def decode_positions(self, features: int | None = None, level: int | None = None) -> np.ndarray:
        """Vertices (n, 3) float64, object space, of a level (None: finest) with the first features (None: all)."""
        level = self._checked_level(level)
        return self._frame.to_object(self._unit_positions(self._checked_features(features), level).astype(np.float64))

    def decode(self, features: int | None = None, level: int | None = None) -> TriMesh:
        """The mesh of `decode_positions` and `level_faces`, in object space. Raises SettingsError if out of range."""
        return TriMesh(self.decode_positions(features, level), self.level_faces(level))

    def _unit_positions(self, features: int, level: int) -> np.ndarray:
        """Cached decode. It passes all coarser levels on its way, so they are kept with it."""
        found = self._cache.get(features, [self._V0])
        if len(found) <= level:
            found = self._decoded(features, level)
        self._cache[features] = found
        self._cache.move_to_end(features)
        while len(self._cache) > CACHED:
            self._cache.popitem(last=False)
        return found[level]

    def _decoded(self, features: int, level: int) -> list[np.ndarray]:
        """Vertices of levels 0..level, unit frame: what `decoder.decode` gives."""
        groups = np.bincount(self._group[:features], minlength=len(self.header.feature_steps)).reshape(-1, self.levels)
        out = [self._V0]
        for i in range(level):
            # what the network sees: the latents of this level and the ones below, the offsets of those below
            seen = (*groups[0, :i + 1], *groups[1:, :i].reshape(-1))
            known = self._steps[i]
            if known is None or known[0] != seen:
                before = self._steps[i - 1] if i else None
                below = before[1].hidden if before else None
                step = predict(NUMPY, self._params, i, out[i], below, self._latents(features, i), self._meshes[i])
                known = self._steps[i] = seen, step._replace(hidden=self._handed_down(i, step.hidden))
            out.append(known[1].vertices(NUMPY, self._offsets(features, i) if self.header.passes else None))
        return out

    def _handed_down(self, level: int, hidden: np.ndarray) -> np.ndarray | None:
        """What the step from `level` leaves for the next one, if there is one."""
        return handed_down(NUMPY, self._params, level, hidden, self._meshes[level]) if level + 1 < self.levels else None

    def _latents(self, features: int, level: int) -> np.ndarray:
        """Latents (m, 8) of the faces of a level, zero where none is among the first `features`."""
        out = np.zeros((self._meshes[level].m, FEATURES), np.float32)
        mine = np.flatnonzero(self._group[:features] == level)
        out[self._face[mine]] = self._value[mine]
        return out

    def _offsets(self, features: int, level: int) -> np.ndarray:
        """Offsets (e, 1) of the midpoints of the edges of a level, unit frame, zero where none has arrived."""
        mesh = self._meshes[level]
        out = np.zeros((len(mesh.edge_a), 1), np.float32)
        for group in range(self.levels + level, len(self.header.feature_steps), self.levels):
            mine = np.flatnonzero(self._group[:features] == group)
            edge = mesh.edge_of.reshape(-1, 3)[self._face[mine]]
            added = np.zeros_like(out)
            added[edge, 0] = self._value[mine, :3]
            out += added
        return out

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
    >>> settings = CompressSettings(LodSettings(base_faces=8, levels=1), refine_steps=0)
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
