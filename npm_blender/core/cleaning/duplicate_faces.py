"""Faces that cover other faces: parts that lie on another part face for face, and walls between two solids."""
import numpy as np

from ..geometry import weld
from .edge_groups import EdgeGroups, face_parts, vertex_parts


def _keys(F: np.ndarray) -> np.ndarray:
    """The three vertices of each face in ascending order, (m, 3) float64."""
    a, b, c = F.T
    low, high = np.minimum(np.minimum(a, b), c), np.maximum(np.maximum(a, b), c)
    return np.stack([low, a.astype(np.int64) + b + c - low - high, high], 1).astype(np.float64)


def duplicates(F: np.ndarray) -> np.ndarray:
    """(m,) bool: faces with the same three vertices as an earlier one, in any order."""
    first, _ = weld(_keys(F))
    again = np.ones(len(F), bool)
    again[first] = False
    return again


def doubled_parts(V: np.ndarray, groups: EdgeGroups) -> np.ndarray:
    """(m,) bool: faces of parts all of whose faces lie exactly on faces of earlier parts, whichever way they look.

    A part of a single face is left to the steps that join parts. Some face on every place is kept.
    """
    F = groups.F
    _, place = weld(V)
    if place.max() + 1 == len(V):
        return np.zeros(len(F), bool)
    again = duplicates(place[F])
    if not again.any():
        return again
    part = face_parts(len(F), groups.halfedges, groups.starts)
    size, covered = np.bincount(part), np.bincount(part, again)
    return ((size == covered) & (size > 1))[part]


def inner_walls(F: np.ndarray) -> np.ndarray:
    """(m,) bool: faces of walls between two solids, which both solids' sides of the wall have; all of them.

    A wall is a region of faces that the mesh has as often one way round as the other, and whose rim lies on a closed
    surface that goes on to both sides: without the wall that surface is whole. So the two sides of a card are no wall,
    nor is a shelf in an open box.
    """
    keys = _keys(F)
    first, same = weld(keys)
    none = np.zeros(len(F), bool)
    if len(first) == len(F):
        return none
    even = (F == keys).sum(1) != 1  # the ascending order, from any corner on; not a mirror image
    net = np.bincount(same, np.where(even, 1, -1))
    candidate = (net == 0)
    if not candidate.any():
        return none
    kept = F[first]
    groups = EdgeGroups.of(kept, int(F.max()) + 1)
    of_halfedge = np.zeros(kept.size, np.int64)  # the edge of each half-edge
    of_halfedge[groups.halfedges] = np.repeat(np.arange(len(groups.sizes)), groups.sizes)
    face = np.arange(kept.size) // 3
    edges = len(groups.sizes)
    walls = np.bincount(of_halfedge, candidate[face], edges).astype(np.int64)
    others = groups.sizes - walls
    region = _joined(face, of_halfedge, candidate, len(kept), edges)
    rest = _joined(face, of_halfedge, ~candidate, len(kept), edges)
    leaky = np.zeros(len(kept), bool)  # parts of the rest that are not closed without the walls
    leaky[rest[face[(others[of_halfedge] != 2) & ~candidate[face]]]] = True
    touches = np.zeros(edges, bool)
    touches[of_halfedge[leaky[rest[face]] & ~candidate[face]]] = True
    refused, rim = np.zeros(len(kept), bool), np.zeros(len(kept), bool)
    ours = candidate[face]
    bad = ((others > 0) & (others != 2)) | ((others == 0) & (walls < 2)) | touches
    refused[region[face[ours & bad[of_halfedge]]]] = True
    rim[region[face[ours & (others == 2)[of_halfedge]]]] = True
    return (candidate & rim[region] & ~refused[region])[same]


def _joined(face: np.ndarray, of_halfedge: np.ndarray, which: np.ndarray, m: int, edges: int) -> np.ndarray:
    """Smallest face joined to each of m faces across edges that both have, among the faces `which` (m,) bool."""
    ours = which[face]
    f, e = face[ours], of_halfedge[ours]
    some = np.zeros(edges, np.int64)
    some[e] = f
    return vertex_parts(m, f, some[e])
