"""The encoder (paper section 3.2): from the LoD sequence to the features f^0..f^(L-1), 8 numbers per face.

Level i -> i - 1: features pooled from level i + 1, the 13 geometry features of M^i and the details of M^i (the offsets
of the next level's midpoints, in edge frames) pass a face convolution, batch normalization, ReLU and average pooling;
a linear layer on the pooled features and on the details of M^(i-1) themselves gives f^(i-1). Levels that are finer
than those trained on reuse the finest trained network.
"""
from .geometry import geometry_features
from .operators import MeshIndex, average_pool, edge_frames, face_convolution


def details(B, V, V_next, mesh: MeshIndex):
    """Offsets of the next level's midpoints V_next (n + e, 3) from those of V (n, 3), in half-edge frames over edge length.

    Returns (3 m, 3): along, across, up, as each half-edge sees them; twenty times, so that they are of order 1.
    """
    x, y, z, length = edge_frames(B, V, mesh)
    middle = (B.take(V, mesh.edge_a) + B.take(V, mesh.edge_b)) / 2
    offset = (V_next[mesh.n:] - middle) / length
    seen = B.concat([(offset * axis).sum(1)[:, None] for axis in (x, y, z)], 1)
    edge, sign = mesh.edge_of, mesh.side
    return 20 * B.concat([B.take(seen[:, :2], edge) * sign, B.take(seen[:, 2:], edge)], 1)


def features_of_slots(B, slots):
    """(3 m, 4) per slot -> (m, 8): the first two averaged over the face, the others per corner; see feature_slots."""
    m = len(slots) // 3
    y = slots.reshape(m, 3, 4)
    whole = y[:, :, :2].sum(1) / 3
    return B.concat([whole, y[:, :, 2:].reshape(m, 6)], 1)


def encode(B, params: dict, Vs: list, meshes: list):
    """Features of a LoD sequence.

    Vs: vertices of levels 0..L, each (n_i, 3) unit frame (level 0 as transmitted); meshes: MeshIndex of levels 0..L.
    Returns [f^0, ..., f^(L-1)], each (m_i, 8).
    """
    steps = params["encoder"]
    features, pooled = [], None
    for i in range(len(meshes) - 1, 0, -1):
        step = steps[min(i - 1, len(steps) - 1)]
        parts = [geometry_features(B, Vs[i], meshes[i])]
        if i + 1 < len(meshes):
            parts += [details(B, Vs[i], Vs[i + 1], meshes[i]), pooled]
        else:
            empty = step["conv"]["own"].shape[0] // 3 - parts[0].shape[1]
            parts.append(B.array([[0.0] * empty]) + 0 * parts[0][:, :1])
        y = face_convolution(B, B.concat(parts, 1), meshes[i].opposite, step["conv"])
        pooled = average_pool(B, y, step["pool"])
        direct = details(B, Vs[i - 1], Vs[i], meshes[i - 1])
        slots = pooled @ step["features"] + direct @ step["direct"]
        features.append(features_of_slots(B, slots))
    return features[::-1]
