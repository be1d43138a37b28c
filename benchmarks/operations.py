"""What `speed` measures: our operations and their fitting peers, each on inputs that lie ready as files in a folder.

A peer does the same for who uses it: libigl's qslim and Draco make and read a mesh of as many bytes, or as many faces;
qslim also is what makes "the same with other detail" without a progressive file, where we move a slider.
"""

from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from types import ModuleType

import numpy as np

from npm_blender.core.mesh import TriMesh
from npm_blender.core.settings import CompressSettings

from .methods import drc
from .methods.case import Case

BITS = 11  # Draco's default for positions
LEVEL = 3
FEATURES = 200  # where the slider stands
FILES = ("ours.npmesh", "size.drc", "detail.drc", "detail.meshopt")
GROUPS = {
    "encode": "encode",
    "decode": "decode, as many faces as our finest level",
    "open": "open, as many bytes",
    "slider": "another detail, as many faces as our finest level",
}


@dataclass(frozen=True)
class Inputs:
    """The files of a folder. mesh: the input; ours: its stream, not refined; size: QSlim + Draco of as many bytes;
    detail: QSlim + Draco of as many faces as our finest level; other: the same by meshoptimizer, empty where its package
    is not installed; faces: of `size` and of `detail`."""

    mesh: TriMesh
    ours: bytes
    size: bytes
    detail: bytes
    other: bytes
    faces: tuple[int, int]

    @staticmethod
    def read(folder: Path) -> "Inputs":
        """What `write` wrote."""
        with np.load(folder / "mesh.npz", allow_pickle=False) as z:
            mesh, faces = TriMesh(z["V"], z["F"]), tuple(int(f) for f in z["faces"])
        return Inputs(mesh, *((folder / name).read_bytes() for name in FILES), faces)

    @staticmethod
    def write(folder: Path, mesh: TriMesh) -> "Inputs":
        """Make and write the files of a mesh in the unit frame."""
        from npm_blender.core.codec import compress, open_stream

        ours = compress(mesh, CompressSettings(refine_steps=0)).data
        finest = len(open_stream(ours).level_faces(LEVEL))
        faces = min(len(mesh.F), len(ours) // 2)  # about two bytes a face
        for _ in range(4):
            size = drc.encode(slim(mesh, faces), BITS)
            faces = min(len(mesh.F), round(faces * len(ours) / len(size)))
        size = drc.encode(slim(mesh, faces), BITS)
        detail, codec = slim(mesh, finest), meshopt()
        data = (ours, size, drc.encode(detail, BITS), codec.encode(detail, BITS) if codec else b"")
        for name, content in zip(FILES, data, strict=True):
            (folder / name).write_bytes(content)
        np.savez(folder / "mesh.npz", V=mesh.V, F=mesh.F, faces=np.array([faces, finest]))
        return Inputs.read(folder)


def slim(mesh: TriMesh, faces: int) -> TriMesh:
    """libigl's qslim, made anew at every call."""
    return Case("", mesh).qslim(faces)


def meshopt() -> ModuleType | None:
    """The module with encode and decode of meshoptimizer's codec, if its package is installed."""
    try:
        return import_module("benchmarks.methods.meshopt")
    except ImportError:
        return None


@dataclass(frozen=True)
class Operation:
    """One thing to measure. group: what is done, a key of GROUPS; method: by whom; peer: the one that ratios are to;
    prepare(inputs): the call to measure, which gives the bytes or the mesh that it made; slow: once is enough."""

    group: str
    method: str
    prepare: Callable[[Inputs], Callable[[], object]]
    peer: bool = False
    slow: bool = False

    @property
    def name(self) -> str:
        """A unique name."""
        return f"{self.group}: {self.method}"


def operations() -> list[Operation]:
    """All of them, by group; the peer of a group comes after ours. Meshoptimizer's only where it is installed."""
    encode, decode, opening, slider = GROUPS
    found = [
        Operation(encode, "ours, not refined", lambda i: lambda: _compress(i.mesh, 0)),
        Operation(encode, "ours", lambda i: lambda: _compress(i.mesh, None), slow=True),
        Operation(encode, "QSlim + Draco, same bytes", lambda i: lambda: drc.encode(slim(i.mesh, i.faces[0]), BITS), True),
        Operation(encode, "Draco", lambda i: lambda: drc.encode(i.mesh, BITS)),
        Operation(decode, "ours", lambda i: lambda: _open(i.ours).decode(None, LEVEL)),
        Operation(decode, "Draco", lambda i: lambda: drc.decode(i.detail), True),
        Operation(opening, "ours, base mesh", lambda i: lambda: _open(i.ours).decode(0, 0)),
        Operation(opening, "ours, finest level", lambda i: lambda: _open(i.ours).decode(None, LEVEL)),
        Operation(opening, "Draco", lambda i: lambda: drc.decode(i.size), True),
        Operation(slider, "ours, new prefix", _new_prefix),
        Operation(slider, "ours, prefix seen before", _seen_prefix),
        Operation(slider, "libigl qslim", lambda i: lambda: slim(i.mesh, i.faces[1]), True),
    ]
    codec = meshopt()
    if codec is not None:
        found.insert(4, Operation(encode, "meshoptimizer", lambda i: lambda: codec.encode(i.mesh, BITS)))
        found.insert(7, Operation(decode, "meshoptimizer", lambda i: lambda: codec.decode(i.other)))
    return found


def _compress(mesh: TriMesh, refine_steps: int | None) -> bytes:
    from npm_blender.core.codec import compress

    return compress(mesh, CompressSettings(refine_steps=refine_steps)).data


def _open(data: bytes):
    from npm_blender.core.codec import open_stream

    return open_stream(data)


def _new_prefix(inputs: Inputs) -> Callable[[], object]:
    opened = _open(inputs.ours)

    def slide():
        opened._cache.clear()
        return opened.decode(FEATURES, LEVEL)

    return slide


def _seen_prefix(inputs: Inputs) -> Callable[[], object]:
    opened = _open(inputs.ours)
    opened.decode(FEATURES, LEVEL)
    return lambda: opened.decode(FEATURES, LEVEL)
