"""Half-edge adjacency of a triangle mesh, and what follows from it: borders, components, Euler characteristic.

Index conventions, binding for the whole core: half-edge h = 3 f + k runs from corner k to corner k + 1 of face f
(F[f, k] -> F[f, (k + 1) % 3]); `next` and `prev` stay in the face. `opposite[h]` is the half-edge on the other side
of the same edge, or h itself on the border, so it is always an involution and gathers need no special case.
"""
from dataclasses import dataclass

import numpy as np

from ..errors import MeshError
from .radix_order import radix_argsort


def directed_edges(F: np.ndarray) -> np.ndarray:
    """Start and end vertex of every half-edge, (3 m, 2) of F's dtype."""
    return np.stack([F, np.roll(F, -1, 1)], 2).reshape(-1, 2)


def paired_halfedges(F: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Half-edges by edge: order (3 m,) sorted by (smaller, larger) vertex; first (3 m,) bool: whether an edge starts at that
    place of the order; opposite (3 m,) int32, itself on the border.

    Raises MeshError if an edge has more than two faces or two faces that run the same way.
    """
    start, end = directed_edges(F).T
    key = np.minimum(start, end).astype(np.int64) * (int(F.max()) + 1) + np.maximum(start, end)
    order = radix_argsort(key)
    ranked = key[order]
    pair = ranked[1:] == ranked[:-1]
    h, o = order[:-1][pair], order[1:][pair]
    if (start[h] == start[o]).any() or (pair[1:] & pair[:-1]).any():
        _, uses = np.unique(key * 2 + (start < end), return_counts=True)
        raise MeshError(f"Expected an oriented manifold, found {(uses - 1).sum()} edges used twice in one direction; "
                        "clean the mesh first (--clean auto)")
    opposite = np.arange(F.size, dtype=np.int32)
    opposite[h], opposite[o] = o, h
    return order, np.concatenate([[True], ~pair]), opposite


def opposite_halfedges(F: np.ndarray) -> np.ndarray:
    """Opposite half-edge of each of the 3 m half-edges, (3 m,) int32; itself on the border. Raises as `paired_halfedges`."""
    return paired_halfedges(F)[2]


def vertex_fans(F: np.ndarray, opposite: np.ndarray, n: int) -> np.ndarray:
    """Number of face fans round each vertex, (n,) int32: 0 unused, 1 manifold, more than 1 pinched.

    The corners of a vertex are joined across interior edges; the parts that remain are its fans.
    """
    from .components import count_roots

    h = np.arange(F.size)
    inner = opposite != h
    # corner of the start of h, and the corner at the same vertex on the other side: the end of the opposite
    a, b = h[inner], (opposite // 3 * 3 + (opposite % 3 + 1) % 3)[inner]
    return count_roots(F.reshape(-1), a, b, n)


@dataclass(frozen=True)
class Topology:
    """Counts that a decimation must keep. components, border_loops, euler = V - E + F (used vertices only)."""

    vertices: int
    edges: int
    faces: int
    components: int
    border_loops: int
    border_edges: int

    @property
    def euler(self) -> int:
        """Euler characteristic V - E + F; 2 for a sphere, 2 - 2 g for closed genus g."""
        return self.vertices - self.edges + self.faces

    @property
    def genus(self) -> float:
        """Total genus of the components, (2 C - B - euler) / 2 with C components and B border loops."""
        return (2 * self.components - self.border_loops - self.euler) / 2


def topology_of(F: np.ndarray) -> Topology:
    """The topology of faces F (m, 3). Raises MeshError if F is not an oriented edge-manifold."""
    from .components import component_labels

    opposite = opposite_halfedges(F)
    h = np.arange(F.size)
    border = opposite == h
    n = int(F.max()) + 1
    parts = component_labels(len(F), h // 3, opposite // 3)
    start, end = directed_edges(F)[border].T
    loops = component_labels(n, start, end)
    return Topology(
        vertices=len(np.unique(F)), edges=int((F.size + border.sum()) // 2), faces=len(F),
        components=len(np.unique(parts)), border_loops=len(np.unique(loops[start])), border_edges=int(border.sum()))
