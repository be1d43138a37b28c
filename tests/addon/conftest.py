"""The extension, enabled from this source tree in whatever Blender runs the tests: the bpy module or a real one."""
import importlib
import os
import sys

import pytest

bpy = pytest.importorskip("bpy")

from npm_blender.core.codec import compress, receive  # noqa: E402 - after the check for bpy
from npm_blender.core.evaluation import measure_prefixes  # noqa: E402
from npm_blender.core.mesh import TriMesh  # noqa: E402
from npm_blender.core.settings import CompressSettings, LodSettings  # noqa: E402

from .forked_workers import POSSIBLE, Workers  # noqa: E402
from .source_addon import ROOT, enable  # noqa: E402

_status = [0]


def pytest_sessionfinish(exitstatus):
    """Remember how the tests ended, for `pytest_unconfigure`."""
    _status[0] = int(exitstatus)


@pytest.hookimpl(trylast=True)
def pytest_unconfigure():
    """Skip the destructors of the bpy module, which now and then wait for each other without end."""
    if not bpy.app.binary_path:
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(_status[0])


@pytest.fixture(scope="session")
def package() -> str:
    """The name under which Blender knows the enabled extension."""
    return enable()


@pytest.fixture
def part(package):
    """A function that imports a module of the extension: part("core.codec")."""
    return lambda name: importlib.import_module(f"{package}.{name}")


@pytest.fixture
def as_installed():
    """Asks for workers as they are in a user's Blender, see `worker_of_the_library`."""


@pytest.fixture
def own_process():
    """Asks for workers that are started as a user's are, see `worker_of_the_library`."""


@pytest.fixture(scope="session")
def forked_workers():
    """Workers that start at once."""
    workers = Workers()
    yield workers
    workers.close()


@pytest.fixture(autouse=True)
def worker_of_the_library(request, part, monkeypatch, forked_workers):
    """Workers import the package as `npm_blender`, as all other tests do, and so find its compiled code.

    A worker imports it under the name that Blender gives it, and keeps what it compiles in a folder of the user. This
    would compile the whole core once more. Tests of just that take the fixture `as_installed`. Nor does each load compiled
    code anew, for seconds, but in tests of the process itself, which take the fixture `own_process`.
    """
    if "as_installed" in request.fixturenames:
        return
    process, variable = part("jobs.process"), "NUMBA_CACHE_DIR"
    environment = process.environment

    def with_the_librarys_cache(*arguments):
        changed = {k: v for k, v in environment(*arguments).items() if k != variable}
        return {**changed, variable: os.environ[variable]} if variable in os.environ else changed

    monkeypatch.setattr(process, "environment", with_the_librarys_cache)
    monkeypatch.setattr(process, "PACKAGE", "npm_blender")
    monkeypatch.setattr(process, "PACKAGE_FOLDER", ROOT / "npm_blender")
    if POSSIBLE and "own_process" not in request.fixturenames:
        monkeypatch.setattr(process, "start", lambda folder, machine: forked_workers.start(
            folder, process.environment(folder, machine)))


@pytest.fixture(autouse=True)
def empty_scene(package):
    """An empty file round each test; no job and no decoder is left over."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    yield
    assert sys.modules[f"{package}.jobs"].running() == ()
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)


def add_object(name: str = "Shape", subdivisions: int = 5):
    """A bumpy closed surface without symmetry, selected and active; 20 * 4**(subdivisions - 1) faces."""
    import numpy as np

    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=subdivisions, radius=1)
    obj = bpy.context.active_object
    obj.name = name
    V = np.zeros((len(obj.data.vertices), 3), dtype=np.float32)
    obj.data.vertices.foreach_get("co", V.reshape(-1))
    V *= 1 + 0.2 * np.sin(5 * V[:, :1]) + 0.1 * np.sin(9 * V[:, 1:2] + 2 * V[:, 2:])
    obj.data.vertices.foreach_set("co", V.reshape(-1))
    obj.data.update()
    return obj


def triangles(obj) -> TriMesh:
    """An object's mesh of triangles, as the library takes it: only Blender's own copy of the package knows `bridge`."""
    corners = [list(face.vertices) for face in obj.data.polygons]
    return TriMesh.from_arrays(positions(obj), corners)


@pytest.fixture(scope="session")
def compressed(package):
    """A small mesh and its stream, for all tests that only open it: 80 base faces, 2 levels."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    mesh = triangles(add_object())
    return mesh, compress(mesh, CompressSettings(lod=LodSettings(base_faces=80, levels=2))).data


@pytest.fixture(scope="session")
def stream(compressed) -> bytes:
    """The compressed mesh's bytes."""
    return compressed[1]


@pytest.fixture
def stream_file(stream, tmp_path):
    """The compressed mesh as a file."""
    path = tmp_path / "shape.npmesh"
    path.write_bytes(stream)
    return path


@pytest.fixture
def opened(stream_file):
    """The file, imported: the preview object."""
    bpy.ops.import_scene.npmesh(filepath=str(stream_file))
    return bpy.context.active_object


@pytest.fixture(scope="session")
def received(package, compressed):
    """The compressed mesh as a worker returns it: read, and its errors measured."""
    mesh, data = compressed
    found = receive(data)
    stored = importlib.import_module(f"{package}.core.codec.stored_stream").StoredStream
    return stored(found.data, found.arrays, measure_prefixes(found.open(), mesh).to_text())


@pytest.fixture
def previewed(part, received):
    """A preview beside the object that it was compressed from, as Compress leaves them."""
    preview = part("preview")
    source = add_object()
    preview.pack(source, received)
    return preview.make(bpy.context, received, "Shape Preview", source)


def positions(obj):
    """Vertices of an object's mesh, (n, 3) float32."""
    import numpy as np

    V = np.zeros((len(obj.data.vertices), 3), dtype=np.float32)
    obj.data.vertices.foreach_get("co", V.reshape(-1))
    return V


def refusal(operator, **arguments) -> str:
    """The message with which an operator refuses; fails the test if it does not."""
    with pytest.raises(RuntimeError) as caught:
        operator(**arguments)
    return str(caught.value)
