"""The order of a mesh in memory: what is near on the surface is near in memory, so that loops over it find it cached."""
import numpy as np

from .mesh import TriMesh

BITS = 10  # per coordinate


def _spread(x: np.ndarray) -> np.ndarray:
    """Bits of x (n,) int64 below 2^BITS, two zeros between each and the next."""
    for shift, mask in ((16, 0x030000FF), (8, 0x0300F00F), (4, 0x030C30C3), (2, 0x09249249)):
        x = (x | (x << shift)) & mask
    return x


def in_morton_order(mesh: TriMesh) -> TriMesh:
    """The same mesh, its vertices along a Morton curve and its faces by their first vertex; corners keep their order."""
    if len(mesh.V) == 0:
        return mesh
    low, extent = mesh.V.min(0), max(float(np.ptp(mesh.V, axis=0).max()), 1e-300)
    cell = ((mesh.V - low) / extent * (2**BITS - 1)).astype(np.int64)
    code = _spread(cell[:, 0]) | (_spread(cell[:, 1]) << 1) | (_spread(cell[:, 2]) << 2)
    order = np.argsort(code, kind="stable")
    place = np.empty(len(order), np.int32)
    place[order] = np.arange(len(order), dtype=np.int32)
    F = place[mesh.F]
    return TriMesh(mesh.V[order], np.ascontiguousarray(F[np.argsort(F.min(1), kind="stable")]))


def boxes(P: np.ndarray, most: int) -> np.ndarray:
    """Points P (n, 3) divided into boxes of at most `most` points, by halves along the longest side: box (n,) int32."""
    out = np.zeros(len(P), np.int32)
    groups, found = [np.arange(len(P))], 0
    while groups:
        group = groups.pop()
        if len(group) <= most:
            out[group] = found
            found += 1
            continue
        side = np.ptp(P[group], axis=0).argmax()
        order = group[np.argpartition(P[group, side], len(group) // 2)]
        groups += [order[len(group) // 2:], order[:len(group) // 2]]
    return out
