"""Offsets without torch: level by level, along the normal of each edge to the surface of the input.

Coarser than `offset_fit`, which knows what an offset does to the levels above; for senders that have no torch.
"""

import numpy as np

from ..geometry import ClosestPoints
from ..network import NUMPY, MeshIndex, decode, edge_frames

ROUNDS = 3  # steps to the nearest point of the surface, each as far as the normal goes
REACH = 0.5  # of the edge's length, at most


def traced_offsets(
    params: dict,
    V0: np.ndarray,
    latents: list[np.ndarray],
    meshes: list[MeshIndex],
    surface: ClosestPoints,
    before: list[np.ndarray],
    steps: np.ndarray,
) -> list[np.ndarray]:
    """Integers (e_i,) int32 per level, each level with the rounded ones below it in place.

    V0 (n0, 3), surface: unit frame; latents: (m_i, 8) per level; meshes: of levels 0..L-1; before: (e_i,) per level, the
    offsets of the pass before, unit frame; steps (L,): quantization steps, unit frame. Of an edge with midpoint m and normal n
    the offset goes to t, repeated ROUNDS times: t = (q - m) . n, where q is the point of the surface next to m + t n. Ours.

    >>> import numpy as np
    >>> from npm_blender.core import TriMesh
    >>> from npm_blender.core.geometry import ClosestPoints
    >>> from npm_blender.core.mesh import hierarchy
    >>> from npm_blender.core.network import NUMPY, MeshIndex, load_weights
    >>> from npm_blender.core.refinement import traced_offsets
    >>> V, F = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]
    >>> mesh, none = TriMesh.from_arrays(V, F), [np.zeros((4, 8), np.float32)]
    >>> meshes = [MeshIndex.of(NUMPY, hierarchy(mesh.F, 4, 0)[0])]
    >>> found = traced_offsets(load_weights().params, mesh.V, none, meshes, ClosestPoints(mesh), [np.zeros(6)], [0.01])
    >>> [(integers.shape, integers.dtype.name) for integers in found]
    [((6,), 'int32')]
    """
    V, out = NUMPY.array(V0), []
    sent: list[np.ndarray] = []
    for level, (mesh, base, step) in enumerate(zip(meshes, before, steps, strict=True)):
        _, _, normal, length = edge_frames(NUMPY, V, mesh)

        def finer(last: np.ndarray, level: int = level) -> np.ndarray:
            return decode(NUMPY, params, NUMPY.array(V0), latents[: level + 1], meshes[: level + 1], [*sent, last])[-1]

        middle = finer(base.astype(np.float32)[:, None])[len(V) :].astype(np.float64)
        along = np.zeros(len(middle))
        for _ in range(ROUNDS):
            _, point, _ = surface.closest(middle + normal * along[:, None])
            along = ((point - middle) * normal).sum(1)
            along = np.clip(along, -REACH * length[:, 0], REACH * length[:, 0])
        out.append(np.rint(along / step).astype(np.int32))
        sent.append((base + out[-1] * step).astype(np.float32)[:, None])
        V = finer(sent[-1])
    return out
