"""A stream beside what `read_stream` made of it, both as bytes: opens without compiled code.

Reading takes numba, which takes half a second to load and up to ten to compile once. So a worker process reads, and
Blender keeps these bytes, in the .blend too, and opens them with NumPy alone.
"""
import io
import json
import zipfile
import zlib
from dataclasses import asdict, dataclass

import numpy as np

from ..bitstream import Header, ParsedStream
from ..errors import StreamError
from .progressive_mesh import ProgressiveMesh

_FEATURE_ARRAYS = ("group", "face", "value")  # of `ParsedStream`, by the same names in the file
# what a damaged zip file, and arrays other than those of `pack`, can raise
_DAMAGE = (OSError, ValueError, KeyError, TypeError, AttributeError, IndexError, EOFError, RuntimeError, MemoryError,
           StreamError, zipfile.BadZipFile, zlib.error)


@dataclass(frozen=True)
class StoredStream:
    """data: an `.npmesh` stream or a prefix of one; arrays: the `ParsedStream` read from it, see `pack`; measured: text of its
    `evaluation.PrefixErrors`, empty where the original is not at hand.

    >>> from npm_blender.core import CompressSettings, LodSettings, TriMesh, compress
    >>> from npm_blender.core.codec import StoredStream, receive
    >>> V, F = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]
    >>> settings = CompressSettings(LodSettings(base_faces=4, levels=1), refine_steps=0)
    >>> read = receive(compress(TriMesh.from_arrays(V, F), settings, progress=lambda fraction, message: None).data)
    >>> len(StoredStream(read.data, read.arrays).open().decode(level=0).F)
    4
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
    """A stream that was read, as a compressed .npz: exact, and about one and a half times the size of the file."""
    header = {**asdict(stream.header), "weights_hash": stream.header.weights_hash.hex()}
    facts = {"header": header, "base_bytes": stream.base_bytes, "truncated": stream.truncated,
             "corrupt": stream.corrupt}
    grid = np.rint(stream.V0 * 2.0**stream.header.position_bits).astype(np.int64)
    arrays = {"grid": grid, "F0": stream.F0, **{name: getattr(stream, name) for name in _FEATURE_ARRAYS},
              "ends": np.stack(stream.packet_ends)}
    file = io.BytesIO()
    np.savez_compressed(file, facts=np.array(json.dumps(facts)), **{k: _narrow(a) for k, a in arrays.items()})
    return file.getvalue()


def unpack(arrays: bytes) -> ParsedStream:
    """The inverse of `pack`. Raises StreamError if the bytes are damaged or do not fit together."""
    try:
        with np.load(io.BytesIO(arrays), allow_pickle=False) as z:
            facts = json.loads(str(z["facts"]))
            fields = facts.pop("header")
            header = Header(**{**fields, "weights_hash": bytes.fromhex(fields["weights_hash"])})
            grid, F0, ends = z["grid"].astype(np.int64), z["F0"].astype(np.int32), z["ends"].astype(np.int64)
            group, face, value = z["group"].astype(np.uint8), z["face"].astype(np.int32), z["value"].astype(np.int32)
        stream = ParsedStream(header, grid * 2.0**-header.position_bits, F0, group, face, value, (ends[0], ends[1]), **facts)
    except _DAMAGE as error:
        raise StreamError(f"Expected a stream that was read before, found damaged arrays ({error}); "
                          "open the file again") from error
    if not _fits(stream):
        raise StreamError("Expected a stream that was read before, found arrays that do not fit together; "
                          "open the file again")
    return stream


def _narrow(array: np.ndarray) -> np.ndarray:
    """The same integers in the narrowest signed type."""
    low, high = (int(array.min()), int(array.max())) if array.size else (0, 0)
    return array.astype(np.result_type(np.min_scalar_type(min(low, -1)), np.min_scalar_type(-high - 1)))


def _fits(s: ParsedStream) -> bool:
    """Whether every shape and index is one that a stream can have."""
    features, ends = s.packet_ends
    faces = len(s.F0) * 4 ** np.tile(np.arange(s.header.levels, dtype=np.int64), 1 + s.header.passes)
    return bool(
        s.V0.ndim == s.F0.ndim == s.value.ndim == 2 and s.V0.shape[1] == s.F0.shape[1] == 3 and s.F0.size
        and s.F0.min() >= 0 and s.F0.max() < len(s.V0)
        and s.group.shape == s.face.shape == (len(s.value),) and s.value.shape[1] == s.header.channels
        and (s.group < len(faces)).all() and (s.face >= 0).all() and (s.face < faces[s.group]).all()
        and features.ndim == 1 and (np.diff(features) >= 0).all() and (np.diff(ends) >= 0).all()
        and features[0] == 0 and features[-1] == len(s.value) and ends[0] == s.base_bytes)
