"""The decoder (paper section 3.2): from the base mesh and whatever features arrived to the mesh of any level.

Level i -> i + 1: hidden features h^i (upsampled from level i - 1), the 13 geometry features of the mesh decoded so far
and the transmitted features f^i (zero where none arrived) pass a face convolution; one linear layer on the features of
an edge's two faces displaces its midpoint, in the edge's local frame and in units of its length; the mean over both
sides makes the result independent of the order of the two faces. The same layer moves the old vertices, by the mean
over their corners, so that a base vertex that stands off the surface for the good of the coarse mesh leaves no spike.
Levels from 3 on reuse the network of level 2.
"""
from typing import NamedTuple

from .backend import Array, Backend
from .frames import corner_frames, edge_frames
from .input_features import geometry_features
from .layers import bilinear_upsample, face_convolution, two_face_linear
from .mesh_index import MeshIndex

FEATURES = 8  # numbers in a latent feature
SLOT_FEATURES = 4


def feature_slots(B: Backend, f: Array) -> Array:
    """Transmitted features in slots: (m, 8) -> (3 m, 4). Two belong to the whole face, two to each of its corners."""
    m = len(f)
    whole = B.concat([f[:, None, :2]] * 3, 1)
    return B.concat([whole, f[:, 2:].reshape(m, 3, 2)], 2).reshape(3 * m, SLOT_FEATURES)


def network_level(params: dict, level: int) -> dict:
    """The decoder's parameters for a step from `level` to the next; the last trained one serves all finer levels."""
    steps = params["decoder"]
    return steps[min(level, len(steps) - 1)]


class Step(NamedTuple):
    """What the network says of the next level: V (n + e, 3) float32, the old vertices and then those in the middles of edges;
    hidden (3 m, C) float32, of the corner slots of this level's faces.

    >>> from npm_blender.core.network import NUMPY, Step
    >>> step = Step(V=NUMPY.array([[0, 0, 0], [2, 0, 0], [1, 0, 0.5]]), hidden=NUMPY.array([[0.0]] * 3))
    >>> step.V.shape
    (3, 3)
    """

    V: Array
    hidden: Array


def predict(B: Backend, params: dict, level: int, V: Array, hidden: Array | None, f: Array, mesh: MeshIndex) -> Step:
    """From a level to the next: V (n, 3), f (m, 8) and mesh of the level; hidden (3 m, C): what `handed_down` made of the
    step before, None for the first.

    With x = (hidden, geometry features g, slots s of f): y = conv2(conv1(x)) + x skip; the displacement of every half-edge
    and corner is a linear map of (y, g, s) of its two faces. After the paper's decoder (section 3.2).

    >>> import numpy as np
    >>> from npm_blender.core.mesh import Level
    >>> from npm_blender.core.network import NUMPY, MeshIndex, load_weights, predict
    >>> mesh = MeshIndex.of(NUMPY, Level.of(np.array([[0, 1, 2], [0, 2, 3]]), 4))  # 2 faces, 4 vertices, 5 edges
    >>> V = NUMPY.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    >>> step = predict(NUMPY, load_weights().params, 0, V, None, NUMPY.array(np.zeros((2, 8))), mesh)
    >>> step.V.shape  # 4 old vertices and 5 new ones
    (9, 3)
    """
    step = network_level(params, level)
    g = geometry_features(B, V, mesh)
    s = feature_slots(B, f)
    x = B.concat([g, s] if hidden is None else [hidden, g, s], 1)
    y = face_convolution(B, x, mesh.opposite, step["conv1"])
    y = face_convolution(B, y, mesh.opposite, step["conv2"]) + B.product(x, step["skip"])
    offset = two_face_linear(B, B.concat([y, g, s], 1), mesh.opposite, step["displace"])
    middle, corner = B.split(offset, [3, 3])
    return Step(B.concat([moved_vertices(B, V, corner, mesh), displaced_midpoints(B, V, middle, mesh)], 0), y)


def handed_down(B: Backend, params: dict, level: int, hidden: Array, mesh: MeshIndex) -> Array:
    """Hidden features (3 m, C) of the step from a level, with the level's mesh, for the step after it: (12 m, C').

    The bilinear upsampling of SubdivNet (Hu et al. 2022), as the paper's decoder uses it (section 3.2); see `layers`.

    >>> import numpy as np
    >>> from npm_blender.core.mesh import Level
    >>> from npm_blender.core.network import NUMPY, MeshIndex, NetworkConfig, handed_down, initial_parameters
    >>> mesh = MeshIndex.of(NUMPY, Level.of(np.array([[0, 1, 2], [0, 2, 3]]), 4))
    >>> params = initial_parameters(NetworkConfig(decoder=(8, 4), encoder=(4,)))
    >>> handed_down(NUMPY, params, 0, NUMPY.array(np.ones((6, 8))), mesh).shape  # 8 numbers a slot become 4, on 8 faces
    (24, 4)
    """
    return bilinear_upsample(B, hidden, mesh.opposite, network_level(params, level)["up"])


def displaced_midpoints(B: Backend, V: Array, offset: Array, mesh: MeshIndex) -> Array:
    """V (n, 3) and offsets (3 m, 3), one per half-edge in its own frame and in units of its length -> displaced midpoints
    (e, 3)."""
    x, y, z, length = edge_frames(B, V, mesh)
    left, right = B.take(offset, mesh.left), B.take(offset, mesh.right)
    # seen from the right half-edge x and y are negated; on the border left and right are the same half-edge
    sign = 1 - 2 * B.take(mesh.inner, mesh.left)
    along, across, up = ((left[:, k] + (sign[:, 0] if k < 2 else 1) * right[:, k])[:, None] / 2 for k in range(3))
    middle = (B.take(V, mesh.edge_a) + B.take(V, mesh.edge_b)) / 2
    return middle + length * (x * along + y * across + z * up)


def moved_vertices(B: Backend, V: Array, offset: Array, mesh: MeshIndex) -> Array:
    """V (n, 3) and offsets (3 m, 3), one per corner in its own frame -> V moved by their means (n, 3)."""
    x, y, z, length = corner_frames(B, V, mesh)
    step = length * (x * offset[:, :1] + y * offset[:, 1:2] + z * offset[:, 2:])
    return V + B.scatter_sum(step, mesh.F, mesh.n) * mesh.share


def decode(B: Backend, params: dict, V0: Array, features: list[Array], meshes: list[MeshIndex]) -> list[Array]:
    """Meshes of levels 1..L.

    V0 (n0, 3) unit frame; features: f^0..f^(L-1), each (m_i, 8); meshes: MeshIndex of levels 0..L-1. Returns the list of vertex
    arrays V^1..V^L, each (n_i, 3). The paper's decoder (section 3.2), with the changes that the module names.

    >>> import numpy as np
    >>> from npm_blender.core.mesh import hierarchy
    >>> from npm_blender.core.network import FEATURES, NUMPY, MeshIndex, decode, load_weights
    >>> meshes = [MeshIndex.of(NUMPY, level) for level in hierarchy(np.array([[0, 1, 2], [0, 2, 3]]), 4, 1)]
    >>> V0 = NUMPY.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    >>> none_arrived = [NUMPY.array(np.zeros((mesh.m, FEATURES))) for mesh in meshes]
    >>> [V.shape for V in decode(NUMPY, load_weights().params, V0, none_arrived, meshes)]  # 4 + 5, then 9 + 16 vertices
    [(9, 3), (25, 3)]
    """
    V, hidden, out = V0, None, []
    for i, (f, mesh) in enumerate(zip(features, meshes, strict=True)):
        if i:
            hidden = handed_down(B, params, i - 1, hidden, meshes[i - 1])
        V, hidden = predict(B, params, i, V, hidden, f, mesh)
        out.append(V)
    return out
