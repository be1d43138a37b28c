import os
import subprocess
import sys
import tracemalloc

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from npm_blender.core.errors import DependencyError, FileError, MeshError, NpmError
from npm_blender.core.geometry.welding import weld
from npm_blender.core.mesh.triangle_mesh import TriMesh
from npm_blender.core.meshio.mesh_files import FORMATS, read_mesh, write_mesh

WRITTEN = [suffix for suffix, form in FORMATS.items() if form.write]
CUBE_V = np.array([[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1)], float)
CUBE_Q = np.array([[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]])
CUBE = TriMesh.from_arrays(CUBE_V, np.concatenate([CUBE_Q[:, :3], CUBE_Q[:, [0, 2, 3]]]))


def volume(mesh):
    a, b, c = mesh.V[mesh.F].swapaxes(0, 1)
    return np.einsum("nx,nx->", a, np.cross(b, c)) / 6


def ply_text(vertices, faces, extra=""):
    rows = [" ".join(map(str, v)) for v in vertices] + [" ".join(map(str, [len(f), *f])) for f in faces]
    return ("ply\nformat ascii 1.0\ncomment made by hand\n" f"element vertex {len(vertices)}\n"
            "property float x\nproperty float y\nproperty float z\n" f"{extra}element face {len(faces)}\n"
            "property list uchar int vertex_indices\nend_header\n" + "\n".join(rows) + "\n").encode()


@pytest.fixture
def given_file(tmp_path):
    def make(name, data):
        (tmp_path / name).write_bytes(data)
        return tmp_path / name
    return make


@pytest.mark.parametrize("suffix", [*WRITTEN, ".PLY"])
def test_what_is_written_is_read_back(tmp_path, suffix):
    path = tmp_path / f"cube{suffix}"
    write_mesh(path, CUBE)
    back = read_mesh(path)
    assert volume(back) == pytest.approx(1) and back.V.shape == (8, 3)
    np.testing.assert_allclose(back.V[back.F], CUBE.V[CUBE.F])  # same faces, same order; vertices may be renumbered
    assert os.listdir(tmp_path) == [path.name]


@pytest.mark.parametrize("suffix", WRITTEN)
@given(st.integers(0, 2**31), st.integers(3, 60))
@settings(max_examples=15, deadline=None)
def test_any_mesh_survives_a_round_trip(tmp_path_factory, suffix, seed, n):
    random = np.random.default_rng(seed)
    V = random.normal(size=(n, 3)).astype(np.float32).astype(np.float64)
    F = np.array([random.choice(n, 3, replace=False) for _ in range(2 * n)])
    path = tmp_path_factory.mktemp("m") / f"m{suffix}"
    write_mesh(path, TriMesh.from_arrays(V, F))
    back = read_mesh(path)
    np.testing.assert_array_equal(back.V[back.F].astype(np.float32), V[F])


def test_ply_keeps_millimetres_far_from_the_origin(tmp_path):
    moved = TriMesh(CUBE.V * 0.01 + 5e5, CUBE.F)
    write_mesh(tmp_path / "far.ply", moved)
    np.testing.assert_allclose(read_mesh(tmp_path / "far.ply").V, moved.V, rtol=0, atol=1e-9)


@pytest.mark.parametrize("order", ["little", "big"])
def test_binary_ply_with_colours_quads_triangles_and_other_elements(given_file, order):
    e = {"little": "<", "big": ">"}[order]
    vertices = np.zeros(8, [("r", "u1"), ("x", e + "f8"), ("q", e + "i2"), ("y", e + "f4"), ("z", e + "f4")])
    vertices["x"], vertices["y"], vertices["z"] = CUBE_V.T
    faces = b"".join(np.array([4], e + "u2").tobytes() + np.array(q, e + "u4").tobytes() + b"\x07" for q in CUBE_Q[:5])
    for t in ([1, 3, 7], [1, 7, 5]):
        faces += np.array([3], e + "u2").tobytes() + np.array(t, e + "u4").tobytes() + b"\x07"
    header = (f"ply\nformat binary_{order}_endian 1.0\nobj_info x\nelement vertex 8\nproperty uchar red\n"
              "property double x\nproperty short q\nproperty float y\nproperty float z\n"
              "element skip 2\nproperty list uchar float values\nelement face 7\n"
              "property list ushort uint vertex_index\nproperty uchar flags\nend_header\n").encode()
    skip = b"\x01" + np.array([1.5], e + "f4").tobytes() + b"\x00"
    mesh = read_mesh(given_file("cube.ply", header + vertices.tobytes() + skip + faces))
    assert mesh.F.shape == (12, 3) and volume(mesh) == pytest.approx(1)


def rows(letter, numbers, end="\n"):
    return "".join(" ".join([letter, *(f"{x:g}" for x in row)]) + end for row in numbers)


OBJ = rows("v", CUBE_V)
OBJ_STYLES = {
    "quads": OBJ + rows("f", CUBE_Q + 1),
    "texture seams": OBJ + "vt 0 0\nvt 1 1\nvn 0 0 1\n" + "".join(
        "f " + " ".join(f"{c + 1}/{1 + i % 2}/1" for c in q) + "\n" for i, q in enumerate(CUBE_Q)),
    "normals only": OBJ + "vn 0 0 1\n" + "".join("f " + " ".join(f"{c + 1}//1" for c in q) + "\n" for q in CUBE_Q),
    "counted back": OBJ + rows("f", CUBE_Q - 8),
    "objects, materials, colours, windows lines": "mtllib a.mtl\r\no a\r\n" + rows("v", CUBE_V, " 1 0 0\r\n")
    + "usemtl red\r\ns off\r\n" + rows("f", CUBE_Q + 1, "\r\n") + "g b\r\nl 1 2\r\n",
    "lines continued": OBJ + "".join(f"f {a} {b} \\\n{c} {d}\n" for a, b, c, d in CUBE_Q + 1),
    "vertices after faces": rows("f", CUBE_Q + 1) + OBJ,
}


@pytest.mark.parametrize("style", OBJ_STYLES)
def test_obj_of_every_style_is_the_same_cube(given_file, style):
    mesh = read_mesh(given_file("cube.obj", OBJ_STYLES[style].encode()))
    assert mesh.V.shape == (8, 3) and mesh.F.shape == (12, 3) and volume(mesh) == pytest.approx(1)


def off_text(vertices=CUBE_V, faces=CUBE_Q, header="OFF\n", columns="", colour="", end="\n"):
    counts = f"{header}{len(vertices)} {len(faces)} 0{end}"
    return (counts + "".join(" ".join(f"{x:g}" for x in v) + columns + end for v in vertices)
            + "".join(" ".join(map(str, [len(f), *f])) + colour + end for f in faces)).encode()


OFF_STYLES = {
    "quads": off_text(),
    "triangles and quads": off_text(faces=[*CUBE_Q[:5], [1, 3, 7], [1, 7, 5]]),
    "no header": off_text(header=""),
    "counts in the line of the header": off_text(header="OFF "),
    "counts without a space": off_text(header="OFF"),
    "edges not counted": off_text().replace(b"8 6 0", b"8 6"),
    "comments and empty lines": b"# by hand\n\n" + off_text(colour=" # a face", columns="\t# a vertex\n\n")
    .replace(b"OFF\n", b"OFF # text\n# counts follow\n\n") + b"# end",
    "windows lines": off_text(header="OFF\r\n", end="\r\n"),
    "old mac lines": off_text(header="OFF\r", end="\r"),
    "no newline at the end": off_text().rstrip(),
    "colours of faces": off_text(colour=" 255 0 0"),
    "colours of faces, with opacity": off_text(colour="  0.5 0 0 1"),
    "COFF": off_text(header="COFF\n", columns=" 255 0 0"),
    "COFF, with opacity": off_text(header="COFF\n", columns=" 1 0 0 0.5"),
    "NOFF": off_text(header="NOFF\n", columns=" 0 0 1"),
    "CNOFF": off_text(header="CNOFF\n", columns=" 0 0 1 255 0 0 255"),
    "STOFF": off_text(header="STOFF\n", columns=" 0.5 0.5"),
    "STCNOFF, counts in its line": off_text(header="STCNOFF ", columns=" 0 0 1 1 0 0 1 0.5 0.5"),
    "points and lines among the faces": off_text(faces=[*CUBE_Q[:3], [0], [0, 1], *CUBE_Q[3:]]),
}


@pytest.mark.parametrize("style", OFF_STYLES)
def test_off_of_every_style_is_the_same_cube(given_file, style):
    mesh = read_mesh(given_file("cube.off", OFF_STYLES[style]))
    np.testing.assert_array_equal(mesh.V, CUBE_V)
    assert mesh.F.shape == (12, 3) and volume(mesh) == pytest.approx(1)


def test_concave_polygons_of_an_off_file_are_cut_inside(given_file):
    arrow = [[2, -1, 0], [0, 3, 0], [-2, -1, 0], [-1, -0.75, 0], [0, 0, 0]]  # a fan of its first corner leaves it
    mesh = read_mesh(given_file("arrow.off", off_text(arrow, [range(5)])))
    a, b, c = mesh.V[mesh.F].swapaxes(0, 1)
    assert mesh.F.shape == (3, 3) and (np.cross(b - a, c - a)[:, 2] > 0).all()


def test_off_is_written_with_header_counts_and_nine_digits(tmp_path):
    write_mesh(tmp_path / "a.off", TriMesh(np.eye(3) / 3, np.array([[0, 1, 2]], np.int32)))
    assert (tmp_path / "a.off").read_text() == "OFF\n3 1 0\n0.333333333 0 0\n0 0.333333333 0\n0 0 0.333333333\n3 0 1 2\n"


@pytest.mark.parametrize("lines", range(1, 15))
def test_an_off_file_cut_after_any_line_is_an_error(given_file, lines):
    cut = b"".join(off_text().splitlines(keepends=True)[:lines])
    with pytest.raises(FileError):
        read_mesh(given_file("cut.off", cut))


def test_gltf_scenes_are_placed_mirrored_and_joined(tmp_path):
    import trimesh
    scene = trimesh.Scene()
    cube = trimesh.Trimesh(CUBE.V, CUBE.F, process=False)
    place, mirror = np.eye(4), np.diag([-2.0, 1, 1, 1])
    place[:3, 3] = 5, 0, 0
    scene.add_geometry(cube, transform=place)
    scene.add_geometry(cube, transform=mirror)
    (tmp_path / "s.glb").write_bytes(scene.export(file_type="glb"))
    mesh = read_mesh(tmp_path / "s.glb")
    assert mesh.V.shape == (16, 3) and mesh.V[:, 0].min() == -2 and mesh.V[:, 0].max() == 6
    assert volume(mesh) == pytest.approx(1 + 2)  # the mirrored one is still counter-clockwise from outside


def test_draco_is_read(given_file):
    import DracoPy
    mesh = read_mesh(given_file("c.drc", DracoPy.encode(CUBE.V.astype(np.float32), CUBE.F.astype(np.uint32))))
    assert volume(mesh) == pytest.approx(1, rel=1e-3)


def test_draco_without_its_package_says_how_to_get_it(given_file, monkeypatch):
    monkeypatch.setitem(sys.modules, "DracoPy", None)
    with pytest.raises(DependencyError, match="pip install DracoPy"):
        read_mesh(given_file("c.drc", b"DRACO"))


def test_a_text_stl_of_two_solids_is_read(given_file):
    def solid(z):
        faces = [f"facet normal 0 0 0\nouter loop\n{rows('vertex', t + [0, 0, z])}endloop\nendfacet\n"
                 for t in CUBE.V[CUBE.F]]
        return "solid a\n" + "".join(faces) + "endsolid a\n"
    mesh = read_mesh(given_file("two.stl", (solid(0) + solid(3)).encode()))
    assert mesh.V.shape == (16, 3) and volume(mesh) == pytest.approx(2)


def binary(suffix):
    import tempfile
    from pathlib import Path
    with tempfile.TemporaryDirectory() as folder:
        write_mesh(Path(folder) / f"c{suffix}", CUBE)
        return (Path(folder) / f"c{suffix}").read_bytes()


STL_TEXT = b"solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n"
HEADER = b"ply\nformat ascii 1.0\nelement vertex %s\nproperty float x\nproperty float y\nproperty float z\nend_header\n"
BAD_FILES = {
    "unknown suffix": ("a.fbx", b"x", FileError, "found 'a.fbx'"),
    "no suffix": ("mesh", b"x", FileError, "Expected a mesh file"),
    "empty ply": ("a.ply", b"", FileError, "empty file"),
    "empty stl": ("a.stl", b"", FileError, "empty file"),
    "empty glb": ("a.glb", b"", FileError, "empty file"),
    "garbage ply": ("a.ply", b"\x00\x01garbage" * 50, FileError, "starts with 'ply'"),
    "garbage obj": ("a.obj", b"\x00\x01garbage" * 50, FileError, "found neither"),
    "garbage stl": ("a.stl", b"\x00\x01garbage" * 50, FileError, "a.stl"),
    "one byte stl": ("a.stl", b"x", FileError, "a.stl"),
    "garbage glb": ("a.glb", b"glTF" + b"\x03garbage" * 50, FileError, "damaged or foreign"),
    "garbage gltf": ("a.gltf", b"{not json", FileError, "damaged or foreign"),
    "gltf without its buffer": ("a.gltf",
                                b'{"asset": {"version": "2.0"}, "buffers": [{"uri": "b.bin", "byteLength": 9}]}',
                                FileError, "damaged or foreign"),
    "garbage drc": ("a.drc", b"\x00\x01garbage" * 50, FileError, "damaged or foreign"),
    "stl named ply": ("a.ply", binary(".stl"), FileError, "starts with 'ply'"),
    "ply named stl": ("a.stl", binary(".ply"), FileError, "a.stl"),
    "obj named glb": ("a.glb", OBJ.encode(), FileError, "damaged or foreign"),
    "truncated ply": ("a.ply", binary(".ply")[:-5], FileError, "cut short"),
    "truncated ply vertices": ("a.ply", binary(".ply")[:-200], FileError, "cut short"),
    "truncated ply header": ("a.ply", binary(".ply")[:60], FileError, "end_header"),
    "truncated text ply": ("a.ply", ply_text(CUBE_V, CUBE_Q)[:-12], FileError, "cut short"),
    "truncated text ply vertices": ("a.ply", ply_text(CUBE_V, CUBE_Q)[:-120], FileError, "cut short"),
    "truncated stl": ("a.stl", binary(".stl")[:300], FileError, "cut short"),
    "truncated text stl": ("a.stl", STL_TEXT * 4, FileError, "endsolid"),
    "truncated glb": ("a.glb", binary(".glb")[:-100], FileError, "damaged or foreign"),
    "truncated drc": ("a.drc", b"DRACO\x02\x02\x01\x01", FileError, "damaged or foreign"),
    "obj cut in a vertex": ("a.obj", b"v 0 0 0\nv 1 0", FileError, "three numbers"),
    "obj face beyond its vertices": ("a.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n", FileError, "found vertex 9"),
    "obj vertex number zero": ("a.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 0 1 2\n", FileError, "found 0"),
    "obj words for numbers": ("a.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf a b c\n", FileError, "found others"),
    "empty off": ("a.off", b"", FileError, "empty file"),
    "comments alone off": ("a.off", b"# nothing\n\n", FileError, "comments alone"),
    "garbage off": ("a.off", b"\x00\x01garbage" * 50, FileError, "start with 'OFF'"),
    "obj named off": ("a.off", OBJ.encode(), FileError, "start with 'OFF'"),
    "header alone off": ("a.off", b"OFF\n", FileError, "start with 'OFF'"),
    "off of four dimensions": ("a.off", off_text(header="4OFF\n", columns=" 1"), FileError, "found '4OFF'"),
    "off of n dimensions": ("a.off", b"nOFF\n3\n" + off_text(header=""), FileError, "found 'nOFF'"),
    "off of n dimensions, with colours": ("a.off", b"C4nOFF 3\n1 0 0\n0 0 0\n", FileError, "found 'C4nOFF 3'"),
    "binary off": ("a.off", b"OFF BINARY\n" + bytes(range(100)), FileError, "found a binary one"),
    "binary off with normals": ("a.off", b"NOFF BINARY\n\0\0\0\x08", FileError, "found a binary one"),
    "truncated off": ("a.off", off_text()[:-3], FileError, "cut short"),
    "truncated off faces": ("a.off", off_text()[:-20], FileError, "cut short"),
    "truncated off vertices": ("a.off", off_text()[:30], FileError, "cut short"),
    "off of a billion vertices": ("a.off", b"OFF 1000000000 1 0\n0 0 0\n", FileError, "cut short"),
    "off of a billion faces": ("a.off", b"OFF 1 1000000000 0\n0 0 0\n3 0 0 0\n", FileError, "cut short"),
    "off of minus one vertex": ("a.off", b"OFF -1 1 0\n0 0 0\n3 0 0 0\n", FileError, "start with 'OFF'"),
    "off of fewer faces than lines": ("a.off", off_text() + b"3 0 1 2\n", FileError, "found 15 lines"),
    "off face of a billion corners": ("a.off", off_text(faces=[[0, 1, 2]]).replace(b"3 0 1", b"1000000000 0 1"),
                                      FileError, "1000000000 corners"),
    "off face of minus three corners": ("a.off", off_text(faces=[[0, 1, 2]]).replace(b"3 0 1", b"-3 0 1"),
                                        FileError, "-3 corners"),
    "off face beyond its vertices": ("a.off", off_text(faces=[[0, 1, 99]]), FileError, "0..99"),
    "off negative face": ("a.off", off_text(faces=[[0, 1, -1]]), FileError, "-1..1"),
    "off index beyond 64 bits": ("a.off", off_text(faces=[[0, 1, 10**30]]), FileError, "vertex numbers"),
    "off words for vertices": ("a.off", off_text().replace(b"\n0 0 0\n", b"\nx y z\n"), FileError, "found others"),
    "off words for faces": ("a.off", off_text(faces=[["a", "b", "c"]]), FileError, "vertex numbers"),
    "off with columns that its header lacks": ("a.off", off_text(columns=" 1 0 0"), FileError, "hold 3 numbers, found 6"),
    "noff without normals": ("a.off", off_text(header="NOFF\n"), FileError, "hold 6 numbers, found 3"),
    "coff without colours": ("a.off", off_text(header="COFF\n"), FileError, "hold 6 or 7 numbers, found 3"),
    "point cloud off": ("a.off", off_text(faces=[]), MeshError, "8 points without faces"),
    "lines only off": ("a.off", off_text(faces=[[0, 1], [2, 3]]), MeshError, "without faces"),
    "NaN off": ("a.off", off_text().replace(b"\n0 0 0\n", b"\n0 0 nan\n"), MeshError, "1 vertices with NaN"),
    "ply face beyond its vertices": ("a.ply", ply_text(CUBE_V, [[0, 1, 99]]), FileError, "0..99"),
    "ply negative face": ("a.ply", ply_text(CUBE_V, [[0, 1, -1]]), FileError, "-1..1"),
    "ply of a billion vertices": ("a.ply", HEADER % b"1000000000", FileError, "cut short"),
    "ply of minus one vertex": ("a.ply", HEADER % b"-1", FileError, "negative"),
    "ply unknown type": ("a.ply", (HEADER % b"1").replace(b"float x", b"quux x"), FileError, "quux"),
    "ply without coordinates": ("a.ply", (HEADER % b"1").replace(b"float x", b"float u") + b"0 0 0", FileError, "x, y"),
    "point cloud ply": ("a.ply", HEADER % b"2" + b"0 0 0\n1 1 1\n", MeshError, "2 points without faces"),
    "point cloud obj": ("a.obj", b"v 0 0 0\nv 1 1 1\n", MeshError, "2 points without faces"),
    "lines only obj": ("a.obj", b"v 0 0 0\nv 1 1 1\nl 1 2\n", MeshError, "without faces"),
    "NaN ply": ("a.ply", ply_text([[0, 0, "nan"], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]]), MeshError, "1 vertices with"),
    "infinite obj": ("a.obj", b"v 0 0 inf\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", MeshError, "1 vertices with NaN"),
    "no vertices and no faces": ("a.ply", ply_text([], []), MeshError, "with vertices, found none"),
}


@pytest.mark.parametrize("name", BAD_FILES)
def test_bad_file(given_file, name):
    file, data, kind, message = BAD_FILES[name]
    path = given_file(file, data)
    with pytest.raises(kind) as caught:
        read_mesh(path)
    text = str(caught.value)
    assert message in text and "\n" not in text and path.name in text and len(text) < 300


@given(st.sampled_from(WRITTEN), st.data())
@settings(max_examples=120, deadline=None)
def test_damaged_bytes_end_in_a_mesh_or_a_named_error(tmp_path_factory, suffix, data):
    content = bytearray(binary(suffix))
    for _ in range(data.draw(st.integers(1, 4))):
        content[data.draw(st.integers(0, len(content) - 1))] = data.draw(st.integers(0, 255))
    path = tmp_path_factory.mktemp("bad") / f"bad{suffix}"
    path.write_bytes(content[:data.draw(st.integers(1, len(content)))])
    try:
        mesh = read_mesh(path)
    except NpmError as error:
        assert "\n" not in str(error)
    else:
        assert np.isfinite(mesh.V).all() and mesh.F.min() >= 0 and mesh.F.max() < len(mesh.V)


def test_missing_file_folder_and_bad_path_are_named(tmp_path):
    (tmp_path / "folder.ply").mkdir()
    with pytest.raises(FileError, match="found none"):
        read_mesh(tmp_path / "missing.ply")
    with pytest.raises(FileError, match="found a folder"):
        read_mesh(tmp_path / "folder.ply")
    with pytest.raises(FileError, match="Expected a path"):
        read_mesh("nul\0.ply")


def test_write_refuses_by_name_and_leaves_nothing(tmp_path):
    (tmp_path / "folder.ply").mkdir()
    for path, message in ((tmp_path / "a.drc", " ".join(WRITTEN)), (tmp_path / "no" / "a.ply", "create it first"),
                          (tmp_path / "folder.ply", "found the folder")):
        with pytest.raises(FileError, match=message):
            write_mesh(path, CUBE)
    assert os.listdir(tmp_path) == ["folder.ply"]


def test_a_failed_write_keeps_the_old_file(tmp_path, monkeypatch):
    write_mesh(tmp_path / "a.ply", CUBE)
    before = (tmp_path / "a.ply").read_bytes()

    def full(*_):
        raise OSError(28, "No space left on device")
    monkeypatch.setattr(os, "replace", full)
    with pytest.raises(FileError, match="No space left"):
        write_mesh(tmp_path / "a.ply", TriMesh(CUBE.V * 2, CUBE.F))
    assert (tmp_path / "a.ply").read_bytes() == before and os.listdir(tmp_path) == ["a.ply"]


@pytest.mark.parametrize("step", ["read_bytes", "write_bytes"])
def test_no_permission_is_named(tmp_path, monkeypatch, step):
    write_mesh(tmp_path / "a.ply", CUBE)

    def denied(*_):
        raise PermissionError(13, "Permission denied")
    monkeypatch.setattr("pathlib.Path." + step, denied)
    with pytest.raises(FileError, match="Permission denied; check"):
        read_mesh(tmp_path / "a.ply") if step == "read_bytes" else write_mesh(tmp_path / "b.ply", CUBE)


@pytest.mark.slow
def test_reading_and_writing_need_no_scipy_networkx_or_pillow(tmp_path):
    program = """
import sys
class Absent:
    def find_spec(self, name, path=None, target=None):
        if name.split(".")[0] in ("scipy", "networkx", "PIL", "requests", "lxml", "shapely", "torch"):
            raise ImportError(name)
sys.meta_path.insert(0, Absent())
import numpy as np
from npm_blender.core.mesh.triangle_mesh import TriMesh
from npm_blender.core.meshio.mesh_files import FORMATS, read_mesh, write_mesh
written = [suffix for suffix, form in FORMATS.items() if form.write]
assert ".ply" in written
for suffix in written:
    path = sys.argv[1] + "/a" + suffix
    write_mesh(path, TriMesh(np.eye(3), np.array([[0, 1, 2]], np.int32)))
    assert read_mesh(path).F.shape == (1, 3)
"""
    subprocess.run([sys.executable, "-c", program, str(tmp_path)], check=True)


@pytest.mark.parametrize("name, data", [
    ("a.ply", HEADER % b"90000000"), ("a.off", b"OFF 90000000 90000000 0\n0 0 0\n"),
    ("b.off", b"OFF 3 1 0\n0 0 0\n1 0 0\n0 1 0\n90000000 0 1 2\n")])
def test_a_count_that_lies_takes_no_memory(given_file, name, data):
    path = given_file(name, data)
    tracemalloc.start()
    with pytest.raises(FileError):
        read_mesh(path)
    assert tracemalloc.get_traced_memory()[1] < 5_000_000
    tracemalloc.stop()


def test_weld_joins_exactly_equal_places_only():
    V = np.array([[0, 0, 0], [1, 2, 3], [-0.0, 0, 0], [1, 2, np.nextafter(3, 4)], [1, 2, 3.0]])
    first, place = weld(V)
    assert first.tolist() == [0, 1, 3] and place.tolist() == [0, 1, 0, 2, 1]
