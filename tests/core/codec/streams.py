"""Small meshes and their streams, made once for all tests of the codec."""
from functools import cache

import numpy as np

from npm_blender.core.codec import Compressed, ProgressiveMesh, compress, open_stream
from npm_blender.core.mesh import TriMesh
from npm_blender.core.network import load_weights
from npm_blender.core.settings import PAPER, CompressSettings, LodSettings
from tests.core.bitstream.samples import Sample, latent_sample
from tests.meshes.dirty_meshes import box
from tests.meshes.shapes import bumpy, grid, torus


def cylinder(n: int = 8) -> TriMesh:
    """A closed cylinder with flat lids: a box whose sides are bent round. 12 n^2 faces."""
    V, F = box(n).V - 0.5, box(n).F
    x, y = V[:, 0], V[:, 1]
    shrink = np.maximum(np.abs(x), np.abs(y)) / np.maximum(np.hypot(x, y), 1e-12)
    return TriMesh(np.stack([x * shrink, y * shrink, V[:, 2]], 1), F)


SHAPES = {"closed": bumpy(3), "open": grid(20), "torus": torus(30, 16)}
SMALL = CompressSettings(lod=LodSettings(base_faces=60, levels=2))
SMALL_PAPER = CompressSettings(lod=LodSettings(base_faces=60, levels=2), model=PAPER)


def silent(fraction: float, message: str) -> None:
    """Progress that nobody sees, so that no warning says that code is compiled."""


@cache
def made(name: str, settings: CompressSettings = SMALL) -> Compressed:
    """The stream of a shape."""
    return compress(SHAPES[name], settings, silent)


def opened(name: str, settings: CompressSettings = SMALL) -> ProgressiveMesh:
    """It, newly opened."""
    return open_stream(made(name, settings).data)


def mesh_of(name: str) -> TriMesh:
    """The shape."""
    return SHAPES[name]


@cache
def known_latents(features: int = 100) -> Sample:
    """A stream of random latents for the weights that ship."""
    model = load_weights()
    return latent_sample(features, model_id=model.model_id, weights_hash=model.digest)
