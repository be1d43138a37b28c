"""What `speed` measures: our operations and their fitting peers, each on inputs that lie ready as files in a folder.

A peer does the same for who uses it: libigl's qslim and Draco make and read a mesh of as many bytes, or as many faces;
qslim also is what makes "the same with other detail" without a progressive file, where we move a slider.
"""

import json
from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from types import ModuleType

from npm_blender.core.mesh import TriMesh
from npm_blender.core.settings import PAPER, PAPER_FACES, PAPER_LEVELS, CompressSettings, LodSettings

from .methods import drc
from .methods.case import Case

BITS = 11  # Draco's default for positions
SIZE = 8_000  # bytes of a stream that is made for a size
FINE = LodSettings(PAPER_FACES, PAPER_LEVELS)  # of the stream that is decoded: 25,600 faces at its finest level
FACTS = "facts.json"


@dataclass(frozen=True)
class Inputs:
    """The files of a folder, and what is known of them.

    small.ply, large.ply: the meshes; ours.npmesh: the small one's stream; base.npmesh: its prefix that holds the base alone,
    base.drc: that base by Draco; fine.npmesh: the small one's stream with FINE; fine.drc, fine.meshopt: QSlim's mesh of as
    many faces as its finest level; paper.npmesh: the small one's by the paper's model. facts: faces of the small and large
    mesh, the base and the finest level, `same` and `sized`: of QSlim's mesh whose Draco file has as many bytes as
    ours.npmesh, and SIZE; bits: of a coordinate of the base.
    """

    folder: Path
    facts: dict[str, int]

    @staticmethod
    def read(folder: Path) -> "Inputs":
        """What `write` wrote."""
        return Inputs(folder, json.loads((folder / FACTS).read_text()))

    @staticmethod
    def write(folder: Path, small: TriMesh, large: TriMesh) -> "Inputs":
        """Make and write the files of two meshes, the small and the large."""
        from npm_blender.core.codec import compress, open_stream
        from npm_blender.core.meshio import read_mesh, write_mesh

        write_mesh(folder / "large.ply", large)
        write_mesh(folder / "small.ply", small)
        small = read_mesh(folder / "small.ply")  # as it is compressed
        streams = {"ours": CompressSettings(), "fine": CompressSettings(FINE), "paper": CompressSettings(model=PAPER)}
        data = {name: compress(small, settings).data for name, settings in streams.items()}
        ours, fine = open_stream(data["ours"]), open_stream(data["fine"])
        base, finest = ours.decode(0, 0), fine.faces_at(fine.levels)
        detail, codec = slim(small, finest), meshopt()
        files = {f"{name}.npmesh": content for name, content in data.items()}
        files["base.npmesh"] = data["ours"][: ours.base_bytes]
        files["base.drc"], files["fine.drc"] = drc.encode(base, ours.position_bits), drc.encode(detail, BITS)
        files["fine.meshopt"] = codec.encode(detail, BITS) if codec else b""
        facts = {"small": len(small.F), "large": len(large.F), "base": len(base.F), "fine": finest, "bits": ours.position_bits}
        facts |= {"same": faces_of(small, len(data["ours"])), "sized": faces_of(small, SIZE)}
        for name, content in files.items():
            (folder / name).write_bytes(content)
        (folder / FACTS).write_text(json.dumps(facts))
        return Inputs(folder, facts)

    def bytes_of(self, name: str) -> bytes:
        """The content of a file."""
        return (self.folder / name).read_bytes()

    def mesh(self, name: str) -> TriMesh:
        """The mesh of a file."""
        from npm_blender.core.meshio import read_mesh

        return read_mesh(self.folder / name)


def faces_of(mesh: TriMesh, size: int) -> int:
    """Faces of QSlim's mesh whose Draco file has about so many bytes."""
    faces = min(len(mesh.F), size // 2)  # about two bytes a face
    for _ in range(4):
        faces = min(len(mesh.F), round(faces * size / len(drc.encode(slim(mesh, faces), BITS))))
    return faces


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
    """One thing to measure. name: unique; prepare(inputs): the call to measure, which gives the bytes or the mesh that it
    made; slow: once is enough."""

    name: str
    prepare: Callable[[Inputs], Callable[[], object]]
    slow: bool = False


@dataclass(frozen=True)
class Pair:
    """A row of the table. group: a short name; title: what is done, with {facts} of the inputs in it; ours, peer: names of
    operations; who: does the peer's."""

    group: str
    title: str
    ours: str
    peer: str
    who: str


PAIRS = (
    Pair("compress", "compress {small:,} faces, from file to file", "compress", "slim", "QSlim + Draco, the same bytes"),
    Pair("sized", f"compress them to {SIZE:,} bytes", "sized", "slim sized", "QSlim + Draco, the same bytes"),
    Pair("decode", "open and decode {fine:,} faces", "decode", "decode drc", "Draco, as many faces"),
    Pair("decode", "open and decode {fine:,} faces", "decode", "decode meshopt", "meshoptimizer, as many faces"),
    Pair("open", "open the base, {base:,} faces", "open", "open drc", "Draco, the same mesh"),
    Pair("slider", "another prefix at {fine:,} faces", "slide", "slim fine", "libigl's qslim from the input"),
    Pair("slider", "a prefix that was seen before", "seen", "slim fine", "the same"),
    Pair("large", "compress {large:,} faces, from file to file", "compress large", "compress", "ours, {small:,} faces"),
)
GROUPS = tuple(dict.fromkeys(pair.group for pair in PAIRS))


def pairs(groups: tuple[str, ...] = (), slow: bool = True) -> list[Pair]:
    """The rows to measure. groups: of GROUPS, all if none is named; slow: whether those too that take long; meshoptimizer's
    only where its package is installed."""
    names = {o.name: o.slow for o in operations()}
    found = [pair for pair in PAIRS if pair.ours in names and pair.peer in names and (pair.group in groups or not groups)]
    return [pair for pair in found if slow or not (names[pair.ours] or names[pair.peer])]


def operations() -> list[Operation]:
    """All of them."""
    found = [
        Operation("compress", lambda i: lambda: _compressed(i, "small.ply", CompressSettings()), slow=True),
        Operation("slim", lambda i: lambda: _slimmed(i, i.facts["same"])),
        Operation("sized", lambda i: lambda: _compressed(i, "small.ply", CompressSettings(budget=SIZE)), slow=True),
        Operation("slim sized", lambda i: lambda: _slimmed(i, i.facts["sized"])),
        Operation("compress large", lambda i: lambda: _compressed(i, "large.ply", CompressSettings()), slow=True),
        Operation("decode", lambda i: _with("fine.npmesh", i, lambda data: _open(data).decode())),
        Operation("decode drc", lambda i: _with("fine.drc", i, drc.decode)),
        Operation("open", lambda i: _with("base.npmesh", i, lambda data: _open(data).decode(0, 0))),
        Operation("open drc", lambda i: _with("base.drc", i, drc.decode)),
        Operation("slide", _new_prefix),
        Operation("seen", _seen_prefix),
        Operation("slim fine", lambda i: _slimming(i.mesh("small.ply"), i.facts["fine"])),
    ]
    codec = meshopt()
    if codec is not None:
        found.append(Operation("decode meshopt", lambda i: _with("fine.meshopt", i, codec.decode)))
    return found


def _compressed(inputs: Inputs, name: str, settings: CompressSettings) -> bytes:
    """All that the command does: read the file, compress, write the stream."""
    from npm_blender.core.codec import compress
    from npm_blender.core.files import write_file

    made = compress(inputs.mesh(name), settings).data
    write_file(inputs.folder / "written.npmesh", made)
    return made


def _slimmed(inputs: Inputs, faces: int) -> bytes:
    """The same by QSlim and Draco."""
    from npm_blender.core.files import write_file

    made = drc.encode(slim(inputs.mesh("small.ply"), faces), BITS)
    write_file(inputs.folder / "written.drc", made)
    return made


def _slimming(mesh: TriMesh, faces: int) -> Callable[[], object]:
    return lambda: slim(mesh, faces)


def _with(name: str, inputs: Inputs, call: Callable[[bytes], object]) -> Callable[[], object]:
    """The call on a file that has been read."""
    data = inputs.bytes_of(name)
    return lambda: call(data)


def _open(data: bytes):
    from npm_blender.core.codec import open_stream

    return open_stream(data)


def _new_prefix(inputs: Inputs) -> Callable[[], object]:
    opened = _open(inputs.bytes_of("fine.npmesh"))

    def slide():
        opened._cache.clear()
        return opened.decode(opened.features // 2)

    return slide


def _seen_prefix(inputs: Inputs) -> Callable[[], object]:
    opened = _open(inputs.bytes_of("fine.npmesh"))
    opened.decode(opened.features // 2)
    return lambda: opened.decode(opened.features // 2)
