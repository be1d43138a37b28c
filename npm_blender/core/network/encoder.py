"""The encoder (paper section 3.2): from the LoD sequence to the features f^0..f^(L-1), 8 numbers per face.

Level i -> i - 1: features pooled from level i + 1, the 13 geometry features of M^i and the details of M^i (the offsets
of the next level's midpoints, in edge frames) pass a face convolution, batch normalization, ReLU and average pooling;
a linear layer on the pooled features and on the details of M^(i-1) themselves gives f^(i-1). Levels that are finer
than those trained on reuse the finest trained network.
"""
from .backend import Array, Backend
from .frames import edge_frames
from .input_features import geometry_features
from .layers import average_pool, face_convolution
from .mesh_index import MeshIndex


def details(B: Backend, V: Array, V_next: Array, mesh: MeshIndex) -> Array:
    """Offsets of the next level's vertices V_next (n + e, 3) from the midpoints of V (n, 3), in half-edge frames.

    Returns (3 m, 3): along, across, up, as each half-edge sees them; twenty times, so that they are of order 1, and at
    most 10 (half an edge), so that slivers do not drown the rest. d = 20 (v - (a + b) / 2) / |b - a| in the axes of
    `edge_frames`. Ours.

    >>> import numpy as np
    >>> from npm_blender.core.mesh import Level, midpoints
    >>> from npm_blender.core.network import NUMPY, MeshIndex, details
    >>> level, V = Level.of(np.array([[0, 1, 2]]), 3), NUMPY.array([[0, 0, 0], [2, 0, 0], [0, 1, 0]])
    >>> V_next = midpoints(V, level)
    >>> V_next[3, 2] += 0.25  # lifts the middle of edge 0-1, of length 2, by an eighth of it
    >>> details(NUMPY, V, V_next, MeshIndex.of(NUMPY, level))[:, 2].tolist()
    [2.5, 0.0, 0.0]
    """
    x, y, z, length = edge_frames(B, V, mesh)
    middle = (B.take(V, mesh.edge_a) + B.take(V, mesh.edge_b)) / 2
    offset = (V_next[mesh.n :] - middle) / length
    seen = B.clip(B.concat([20 * (offset * axis).sum(1)[:, None] for axis in (x, y, z)], 1), 10)
    edge, sign = mesh.edge_of, mesh.side
    return B.concat([B.take(seen[:, :2], edge) * sign, B.take(seen[:, 2:], edge)], 1)


def features_of_slots(B: Backend, slots: Array) -> Array:
    """(3 m, 4) per slot -> (m, 8): the first two averaged over the face, the others per corner; see feature_slots."""
    m = len(slots) // 3
    y = slots.reshape(m, 3, 4)
    whole = y[:, :, :2].sum(1) / 3
    return B.concat([whole, y[:, :, 2:].reshape(m, 6)], 1)


def encode(B: Backend, params: dict, Vs: list[Array], meshes: list[MeshIndex],
           inputs: tuple[list[Array], list[Array]] | None = None) -> list[Array]:
    """Features of a LoD sequence.

    Vs: vertices of levels 0..L, each (n_i, 3) unit frame (level 0 as transmitted); meshes: MeshIndex of levels 0..L.
    inputs: geometry features of levels 1..L and details of levels 1..L-1, where the caller has them already.
    Returns [f^0, ..., f^(L-1)], each (m_i, 8). The paper's encoder (section 3.2), whose convolution and pooling are those of
    SubdivNet (Hu et al. 2022); frames and slots are ours.

    >>> import numpy as np
    >>> from npm_blender.core.mesh import hierarchy, midpoints
    >>> from npm_blender.core.network import NUMPY, MeshIndex, encode, load_weights
    >>> levels = hierarchy(np.array([[0, 1, 2], [0, 2, 3]]), 4, 1)
    >>> V0 = NUMPY.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    >>> Vs, meshes = [V0, midpoints(V0, levels[0])], [MeshIndex.of(NUMPY, level) for level in levels]
    >>> [f.shape for f in encode(NUMPY, load_weights().params, Vs, meshes)]
    [(2, 8)]
    """
    last = len(meshes) - 1
    geometry, detail = inputs or (
        [geometry_features(B, V, mesh) for V, mesh in zip(Vs[1:], meshes[1:], strict=True)],
        [details(B, Vs[i], Vs[i + 1], meshes[i]) for i in range(1, last)],
    )
    detail = [details(B, Vs[0], Vs[1], meshes[0]), *detail]
    steps = params["encoder"]
    features, pooled = [], None
    for i in range(last, 0, -1):
        step = steps[min(i - 1, len(steps) - 1)]
        g = geometry[i - 1]
        if pooled is None:
            # nothing lies above the finest level: its details and pooled features are zero
            unseen = len(step["conv"]["own"]) // 3 - g.shape[1]
            x = B.concat([g, B.concat([0 * g[:, :1]] * unseen)])
        else:
            x = B.concat([g, detail[i], pooled])
        pooled = average_pool(B, face_convolution(B, x, meshes[i].opposite, step["conv"]), step["pool"])
        slots = pooled @ step["features"] + detail[i - 1] @ step["direct"]
        features.append(features_of_slots(B, slots))
    return features[::-1]
