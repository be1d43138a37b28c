"""Levels, positions and parameters that several tests of the network take."""
import numpy as np

from npm_blender.core.mesh import hierarchy, midpoints
from npm_blender.core.network import (
    MeshIndex,
    NetworkConfig,
    flatten_tree,
    initial_parameters,
    map_tree,
    unflatten_tree,
)
from tests.meshes.shapes import grid, icosphere, torus

SHAPES = {"sphere": icosphere(1), "torus": torus(8, 6), "open": grid(4)}


def busy_parameters(seed=0):
    """Parameters in which every path carries something, also those that start at zero."""
    random = np.random.default_rng(seed)
    tree = initial_parameters(NetworkConfig((6, 5), (5, 4)), seed)
    noise = map_tree(lambda x: (x + 0.02 * random.normal(size=x.shape)).astype(np.float32), tree)
    return unflatten_tree({k: np.abs(v) if k.endswith("var") else v for k, v in flatten_tree(noise).items()})


def sequence(mesh, levels, seed=0):
    """Levels, and positions of each: midpoints moved a little."""
    random = np.random.default_rng(seed)
    lods, V = hierarchy(mesh.F, len(mesh.V), levels), [mesh.V.astype(np.float32)]
    for level in lods[:-1]:
        P = midpoints(V[-1], level)
        P[level.n:] += 0.02 * random.normal(size=(len(P) - level.n, 3))
        V.append(P.astype(np.float32))
    return lods, V


def indices(B, lods):
    return [MeshIndex.of(B, level) for level in lods]


def layer(random, *widths, names=("own", "other")):
    rows, columns = widths
    return {**{n: random.normal(size=(3 * rows, columns)).astype(np.float32) for n in names},
            "bias": random.normal(size=columns).astype(np.float32)}


def rotated_corners(F, turns):
    """Faces with corner `turns` first, and the half-edges in their old numbering, in the new order."""
    k = (np.arange(3) + turns[:, None]) % 3
    return np.take_along_axis(F, k, 1), (3 * np.arange(len(F))[:, None] + k).reshape(-1)
