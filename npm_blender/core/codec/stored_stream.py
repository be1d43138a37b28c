"""A stream beside what `read_stream` made of it, both as bytes: opens without compiled code.

Reading takes numba, which takes half a second to load and up to ten to compile once. So a worker process reads, and
Blender keeps these bytes, in the .blend too, and opens them with NumPy alone.
"""
import io
import json
import zipfile
import zlib
from dataclasses import asdict, dataclass, replace

import numpy as np

from ..bitstream import DisplacedCoding, DisplacedNumbers, Header, LatentCoding, LatentFeatures, ParsedStream
from ..errors import MeshError, StreamError
from ..mesh import Sharp, hierarchy
from .progressive_mesh import ProgressiveMesh

# what a damaged zip file, and arrays other than those of `pack`, can raise
_DAMAGE = (OSError, ValueError, KeyError, TypeError, AttributeError, IndexError, EOFError, RuntimeError, MemoryError,
           StreamError, MeshError, zipfile.BadZipFile, zlib.error)


@dataclass(frozen=True)
class StoredStream:
    """data: an `.npmesh` stream or a prefix of one; arrays: the `ParsedStream` read from it, see `pack`; measured: text of its
    `evaluation.PrefixErrors`, empty where the original is not at hand.

    >>> from npm_blender.core import CompressSettings, LodSettings, TriMesh, compress
    >>> from npm_blender.core.codec import StoredStream, receive
    >>> V = [[x, y, x * y / 8] for y in range(5) for x in range(5)]
    >>> F = [f for i in range(19) if i % 5 < 4 for f in ([i, i + 1, i + 5], [i + 1, i + 6, i + 5])]
    >>> settings = CompressSettings(LodSettings(base_faces=8, levels=1))
    >>> read = receive(compress(TriMesh.from_arrays(V, F), settings, progress=lambda fraction, message: None).data)
    >>> len(StoredStream(read.data, read.arrays).open().decode(level=0).F)
    8
    """


    data: bytes
    arrays: bytes
    measured: str = ""

    def open(self) -> ProgressiveMesh:
        """The mesh of the stream. Raises StreamError (damaged arrays), WeightsError."""
        return ProgressiveMesh(unpack(self.arrays), len(self.data))


def receive(data: bytes) -> StoredStream:
    """Read a stream, or any prefix of one past its base mesh. Raises StreamError as `read_stream` does.

    >>> from npm_blender.core import StreamError
    >>> from npm_blender.core.codec import receive
    >>> try:
    ...     receive(b"PK..")
    ... except StreamError as error:
    ...     print(error)
    Expected an .npmesh stream, found b'PK..' at its start; this is another kind of file
    """
    from ..bitstream import read_stream  # only here: this import loads or compiles the entropy decoder

    return StoredStream(data, pack(read_stream(data)))


def pack(stream: ParsedStream) -> bytes:
    """A stream that was read, as a compressed .npz: exact, and at most about twice the size of the file."""
    facts: list[dict] = []
    arrays: dict[str, np.ndarray] = {}
    for place, rung in enumerate(stream.rungs):
        facts.append(_facts(rung))
        arrays |= {f"{place}.{name}": _narrow(array) for name, array in _arrays(rung).items()}
    file = io.BytesIO()
    np.savez_compressed(file, facts=np.array(json.dumps(facts)), **arrays)
    return file.getvalue()


def _facts(rung: ParsedStream) -> dict:
    """What is not an array, as JSON can hold it."""
    fields = asdict(rung.header)
    if "weights_hash" in fields["coding"]:
        fields["coding"]["weights_hash"] = fields["coding"]["weights_hash"].hex()
    return {"header": fields, "base_bytes": rung.base_bytes, "truncated": rung.truncated, "corrupt": rung.corrupt}


def _arrays(rung: ParsedStream) -> dict[str, np.ndarray]:
    """What is an array, by name."""
    details = dict(vars(rung.details))
    if isinstance(rung.details, DisplacedNumbers):
        details["table"] = _changes(rung.details.table)
    if rung.sharp:
        details |= {"creases": rung.sharp.edges, "corners": rung.sharp.corners}
    return {"grid": rung.grid, "F0": rung.F0, "ends": np.diff(np.stack(rung.ends), axis=1, prepend=0), **details}


def _changes(table: np.ndarray) -> np.ndarray:
    """What each stage adds to twice the values of the stage before; most of it is zero."""
    out = table.copy()
    out[1:] -= 2 * table[:-1]
    return out


def _values(changes: np.ndarray) -> np.ndarray:
    """The inverse of `_changes`."""
    for stage in range(1, len(changes)):
        changes[stage] += 2 * changes[stage - 1]
    return changes


def unpack(arrays: bytes) -> ParsedStream:
    """The inverse of `pack`. Raises StreamError if the bytes are damaged or do not fit together."""
    try:
        with np.load(io.BytesIO(arrays), allow_pickle=False) as z:
            found: ParsedStream | None = None
            for place, facts in reversed(list(enumerate(json.loads(str(z["facts"]))))):
                mine = {name.split(".", 1)[1]: z[name] for name in z.files if name.startswith(f"{place}.")}
                found = replace(_rung(facts, mine), finer=found)
        fits = found is not None and all(map(_fits, found.rungs))
    except _DAMAGE as error:
        raise StreamError(f"Expected a stream that was read before, found damaged arrays ({error}); "
                          "open the file again") from error
    if found is None or not fits:
        raise StreamError("Expected a stream that was read before, found arrays that do not fit together; "
                          "open the file again")
    return found


def _rung(facts: dict, z: dict[str, np.ndarray]) -> ParsedStream:
    """The inverse of `_facts` and `_arrays`."""
    fields = facts.pop("header")
    grid, F0, ends = z["grid"].astype(np.int64), z["F0"].astype(np.int32), z["ends"].astype(np.int64).cumsum(axis=1)
    coding = fields.pop("coding")
    details: LatentFeatures | DisplacedNumbers
    if "weights_hash" in coding:
        coding["weights_hash"] = bytes.fromhex(coding["weights_hash"])
        header = Header(**fields, coding=LatentCoding(**coding))
        details = LatentFeatures(z["level"].astype(np.uint8), z["face"].astype(np.int32), z["value"].astype(np.int32))
    else:
        header = Header(**fields, coding=DisplacedCoding(**coding))
        details = DisplacedNumbers(_values(z["table"].astype(np.int64)), z["coded"].astype(bool))
    sharp = Sharp(z["creases"].astype(bool), z["corners"].astype(bool)) if "creases" in z else None
    return ParsedStream(header, grid, F0, details, (ends[0], ends[1]), **facts, sharp=sharp)


def _narrow(array: np.ndarray) -> np.ndarray:
    """The same integers in the narrowest signed type."""
    low, high = (int(array.min()), int(array.max())) if array.size else (0, 0)
    return array.astype(np.result_type(np.min_scalar_type(min(low, -1)), np.min_scalar_type(-high - 1)))


def _fits(s: ParsedStream) -> bool:
    """Whether every shape and index is one that a stream can have."""
    features, ends = s.ends
    return bool(
        s.grid.ndim == s.F0.ndim == 2 and s.grid.shape[1] == s.F0.shape[1] == 3 and s.F0.size
        and s.F0.min() >= 0 and s.F0.max() < len(s.grid)
        and features.ndim == 1 and (np.diff(features) >= 0).all() and (np.diff(ends) >= 0).all()
        and features[0] == 0 and ends[0] == s.base_bytes
        and (_latents_fit(s, s.details) if isinstance(s.details, LatentFeatures) else _numbers_fit(s, s.details)))


def _latents_fit(s: ParsedStream, details: LatentFeatures) -> bool:
    faces = len(s.F0) * 4 ** np.arange(s.header.levels, dtype=np.int64)
    return bool(details.value.ndim == 2 and isinstance(s.header.coding, LatentCoding)
                and details.level.shape == details.face.shape == (len(details.value),)
                and details.value.shape[1] == s.header.coding.channels and s.features == len(details.value)
                and (details.level < len(faces)).all() and (details.face >= 0).all()
                and (details.face < faces[details.level]).all())


def _numbers_fit(s: ParsedStream, details: DisplacedNumbers) -> bool:
    levels = hierarchy(s.F0, len(s.grid), s.header.levels)
    new = np.diff([0, *(level.n for level in levels)])
    sharp = s.sharp or Sharp(np.zeros(len(levels[0].edges), bool), np.zeros(levels[0].n, bool))
    return bool(isinstance(s.header.coding, DisplacedCoding)
                and sharp.edges.shape == (len(levels[0].edges),) and sharp.corners.shape == (levels[0].n,)
                and details.table.shape == (s.header.coding.stages, levels[-1].n)
                and details.coded.shape == (s.header.coding.stages, len(levels))
                and s.features <= (details.coded * new).sum())
