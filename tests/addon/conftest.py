"""The extension, enabled from this source tree in whatever Blender runs the tests: the bpy module or a real one."""
import importlib
import os
import sys

import pytest

bpy = pytest.importorskip("bpy")

from .source_addon import enable  # noqa: E402 - needs bpy

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
    """A function that imports a module of the extension: part("core.codec.compression")."""
    return lambda name: importlib.import_module(f"{package}.{name}")


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


@pytest.fixture(scope="session")
def stream(package) -> bytes:
    """A small mesh, compressed once for all tests that only open it: 80 base faces, 2 levels."""
    codec = importlib.import_module(f"{package}.core.codec.compression")
    settings = importlib.import_module(f"{package}.core.settings")
    bridge = importlib.import_module(f"{package}.bridge")
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    mesh = bridge.mesh_of(add_object(), bpy.context.evaluated_depsgraph_get())
    lod = settings.LodSettings(base_faces=80, levels=2)
    return codec.compress(mesh, settings.CompressSettings(lod=lod, refine_steps=0)).data


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
def received(package, stream):
    """The compressed mesh as a worker returns it: read, and its errors measured."""
    import dataclasses

    read, quality, bridge = (importlib.import_module(f"{package}.{name}")
                             for name in ("core.codec.stored_stream", "core.evaluation.prefix_errors", "bridge"))
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    found = read.receive(stream)
    mesh = bridge.mesh_of(add_object(), bpy.context.evaluated_depsgraph_get())
    return dataclasses.replace(found, measured=quality.measure(found.open(), mesh).to_text())


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
