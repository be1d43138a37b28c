"""Runs a small mesh through everything that is compiled, so that the compiled code is on disk: `python -m tests.compile_all`."""
from npm_blender.core.codec import compress, receive
from npm_blender.core.evaluation import evaluate, measure_prefixes
from npm_blender.core.settings import CompressSettings, LodSettings
from tests.meshes.dirty_meshes import joined, klein, moved, soup
from tests.meshes.shapes import bumpy, grid, torus


def main() -> None:
    """Closed, open, with a handle, in parts, and damaged."""
    lod = LodSettings(base_faces=60, levels=2)
    receive(compress(bumpy(3), CompressSettings(lod, model="paper")).data)
    settings = CompressSettings(lod)
    for mesh in (bumpy(3), grid(24), torus(24, 16), joined(bumpy(2), moved(grid(12), by=(4, 0, 0))), soup(bumpy(2)), klein()):
        received = receive(compress(mesh, settings).data)
        measure_prefixes(received.open(), mesh)
        evaluate(received.open().decode(), mesh, 1000)


if __name__ == "__main__":
    main()
