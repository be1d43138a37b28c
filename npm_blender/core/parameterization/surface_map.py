"""The map between the base mesh and the input, composed of the flattenings of all collapses (Liu et al. 2020).

A point is a face and barycentric coordinates. From coarse to fine, the collapses that touched the point's face are
undone, last one first; from fine to coarse they are repeated in order. Each step finds the point's place in the plane
and the face of the other side that holds it. Points of the border stay on it exactly.
"""
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ..jit import compiled
from .collapse_record import AT, FIRST, RING, S1, S2, SIDES, CollapseRecord
from .stencil import MAX_RING

_SNAP = 1e-10  # barycentric coordinates below this are zero


@compiled(inline="always")
def _patch(hist, c):
    """Collapse c in a few numbers: (AT, RING, SIDES, S1, S2), number of its faces before it."""
    at, r, t = hist.collapses[c, AT], hist.collapses[c, RING], hist.collapses[c, SIDES]
    s1, s2 = hist.collapses[c, S1], hist.collapses[c, S2]
    return (np.int64(at), np.int64(r), np.int64(t), np.int64(s1), np.int64(s2),
            np.int64(hist.collapses[c + 1, FIRST] - hist.collapses[c, FIRST]))


@compiled(inline="always")
def _triangle(patch, q, before):
    """Indices into uv of the corners (owner, next, next) of entry number q of a patch, before or after the collapse."""
    at, r, t, s1, s2, _ = patch
    i = at + r
    if q < t:
        owner = i + 2
        if before:
            owner = i + 1 if s1 <= q < s2 else i
        return owner, at + q, at + (q + 1 if q + 1 < r else 0)
    if q == t:
        return i, i + 1, at + (s2 if s2 < r else 0)
    return i + 1, i, at + s1


@compiled
def _on_border(patch, q, before, corner):
    """Whether the side opposite to a corner (0: owner) of entry number q of a patch is on the mesh's border."""
    _, r, t, s1, s2, faces = patch
    if r == t:
        return False
    anchored = faces == t + 2
    if q < t:
        if corner == 2 and q == 0:
            return not before or (s1 > 0 if anchored else s2 > 0)
        return corner == 1 and q == t - 1 and (not before or s2 < r - 1)
    if q == t:
        if corner == 1:
            return s2 == r - 1
        return not anchored and (corner == 2 or s2 == 0)
    return corner == 0 and s1 == 0


@compiled(inline="always")
def _count(patch, before):
    """Number of faces of a patch, before or after the collapse."""
    return patch[5] if before else patch[2]


@compiled
def _along_border(hist, first, patch, p, to_before, b):
    """Put p on the nearest border side of the other side of a patch; returns its entry, b (3,) gets barycentrics."""
    nearest, at, corner, share = np.inf, 0, 0, 0.0
    for q in range(_count(patch, to_before)):
        a0, a1, a2 = _triangle(patch, q, to_before)
        for s in range(3):
            if not _on_border(patch, q, to_before, s):
                continue
            u, v = hist.uv[a1 if s == 0 else (a2 if s == 1 else a0)], hist.uv[a2 if s == 0 else (a0 if s == 1 else a1)]
            d, e = v - u, p - u
            x = (d.real * e.real + d.imag * e.imag) / (d.real * d.real + d.imag * d.imag)
            x = 0.0 if x < _SNAP else (1.0 if x > 1.0 - _SNAP else x)
            gap = e - x * d
            gap2 = gap.real * gap.real + gap.imag * gap.imag
            if gap2 < nearest:
                nearest, at, corner, share = gap2, q, s, x
    k = (hist.faces[first + at] & 3) + corner
    b[k % 3], b[(k + 1) % 3], b[(k + 2) % 3] = 0.0, 1.0 - share, share
    return first + at


@compiled(inline="always")
def _cross(a, b):
    return a.real * b.imag - a.imag * b.real


@compiled(inline="always")
def _areas(hist, patch, q, before, p):
    """Twice the areas of the triangles of p with the sides opposite to the corners of entry number q of a patch."""
    a0, a1, a2 = _triangle(patch, q, before)
    u, v, w = hist.uv[a0] - p, hist.uv[a1] - p, hist.uv[a2] - p
    return _cross(v, w), _cross(w, u), _cross(u, v)


@compiled(inline="always")
def _holding(hist, patch, p, before, first):
    """The entry number of a patch whose triangle, before or after the collapse, holds p, and its `_areas`; -1 where rounding
    leaves none. first: the number that is tried first, that of the face which the point comes from."""
    count = _count(patch, before)
    if first < count:
        x, y, z = _areas(hist, patch, first, before, p)
        if x >= 0.0 and y >= 0.0 and z >= 0.0:
            return first, x, y, z
    for q in range(count - 1, -1, -1):  # the faces that vanish are the likeliest
        x, y, z = _areas(hist, patch, q, before, p)
        if x >= 0.0 and y >= 0.0 and z >= 0.0:
            return q, x, y, z
    return -1, 0.0, 0.0, 0.0


@compiled
def _nearest(hist, patch, p, before):
    """As `_holding`, for the triangle that p misses by the least share of its area; what is missed is zero."""
    best, number, x, y, z = -np.inf, 0, 1.0, 0.0, 0.0
    for q in range(_count(patch, before)):
        dx, dy, dz = _areas(hist, patch, q, before, p)
        least = min(dx, dy, dz) / (dx + dy + dz)
        if least > best:
            best, number, x, y, z = least, q, max(dx, 0.0), max(dy, 0.0), max(dz, 0.0)
    return number, x, y, z


@compiled(inline="always")
def _step(hist, first, patch, number, b, to_before):
    """Move barycentrics b (3,) of the face of entry number `number` of a patch, whose entries begin at `first`, to the other
    side of the collapse; returns the new face's entry."""
    k0 = np.int64(hist.faces[first + number] & 3)
    k1 = k0 + 1 if k0 < 2 else 0
    k2 = k1 + 1 if k1 < 2 else 0
    a0, a1, a2 = _triangle(patch, number, not to_before)
    u, v, w = hist.uv[a0], hist.uv[a1], hist.uv[a2]
    p = complex(b[k0] * u.real + b[k1] * v.real + b[k2] * w.real, b[k0] * u.imag + b[k1] * v.imag + b[k2] * w.imag)
    _, ring, sides, _, _, faces = patch
    border_vertex = ring > sides and (to_before or faces == sides + 1)
    if border_vertex and b[k0] == 1.0:
        return _along_border(hist, first, patch, p, to_before, b)
    for s in range(3):
        if b[k0 if s == 0 else (k1 if s == 1 else k2)] == 0.0 and _on_border(patch, number, not to_before, s):
            return _along_border(hist, first, patch, p, to_before, b)
    at, x, y, z = _holding(hist, patch, p, to_before, number)
    if at < 0:
        at, x, y, z = _nearest(hist, patch, p, to_before)
    total = x + y + z
    entry = first + at
    k0 = np.int64(hist.faces[entry] & 3)
    k1 = k0 + 1 if k0 < 2 else 0
    b[k0], b[k1], b[k1 + 1 if k1 < 2 else 0] = x / total, y / total, z / total
    for s in range(3):
        if b[s] < _SNAP:
            b[s] = 0.0
        elif b[s] > 1.0 - 2 * _SNAP:
            b[s] = 1.0
    return entry


@compiled(inline="always")
def _move(hist, c, to_before, face, b, on, link, waiting):
    """Undo (to_before) or repeat collapse c for all points on its faces at once; see `_undo_all`."""
    first = hist.collapses[c, FIRST]
    count = hist.collapses[c, SIDES] if to_before else hist.collapses[c + 1, FIRST] - first
    some = False
    for q in range(count):
        p = on[hist.faces[first + q] >> 2]
        waiting[q] = p
        some |= p >= 0
    if not some:
        return
    for q in range(count):
        on[hist.faces[first + q] >> 2] = -1
    patch = _patch(hist, c)
    for q in range(count):
        p = waiting[q]
        while p >= 0:
            f = hist.faces[_step(hist, first, patch, q, b[p], to_before)] >> 2
            p_next = link[p]
            link[p] = on[f]
            on[f] = p
            face[p] = f
            p = p_next


@compiled
def _undo_all(hist, face, b, on, link, waiting):
    """Move points, face (k,) and barycentrics b (k, 3), through all collapses, last one first.

    on (m,): the first point on each input face, or -1; link (k,): the next one on the same face; waiting: work space.
    """
    for c in range(len(hist.collapses) - 2, -1, -1):
        _move(hist, c, True, face, b, on, link, waiting)


@compiled
def _repeat_all(hist, face, b, on, link, waiting):
    """The inverse of `_undo_all`."""
    for c in range(len(hist.collapses) - 1):
        _move(hist, c, False, face, b, on, link, waiting)


@compiled
def _list_by_face(face, on, link):
    """Fill on and link, as `_undo_all` wants them, for points on these faces."""
    for p in range(len(face)):
        link[p] = on[face[p]]
        on[face[p]] = p


@dataclass(frozen=True)
class SurfaceMap:
    """The bijection between a base mesh and the input mesh that successive collapses define (Liu et al. 2020).

    record: the collapses; faces (m0,) int32 ascending: the number in the record of each base face, whose corners come in the
    same order; input_faces: number of faces of the input.
    """

    record: CollapseRecord
    faces: np.ndarray
    input_faces: int

    def coarse_to_fine(self, face: np.ndarray, barycentric: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Points of the base, face (k,) and barycentric (k, 3) in 0..1, as points of the input: (k,) int32, (k, 3) float64."""
        at = self.faces[np.asarray(face)]
        b = np.array(barycentric, dtype=np.float64, order="C")
        self._through(_undo_all, at, b)
        return at, b

    def fine_to_coarse(self, face: np.ndarray, barycentric: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Points of the input, face (k,) and barycentric (k, 3), as points of the base: the inverse of `coarse_to_fine`."""
        at = np.array(face, dtype=np.int32)
        b = np.array(barycentric, dtype=np.float64, order="C")
        self._through(_repeat_all, at, b)
        return np.searchsorted(self.faces, at).astype(np.int32), b

    def _through(self, way: Callable, face: np.ndarray, b: np.ndarray) -> None:
        """Move points by `_undo_all` or `_repeat_all`; changes face (k,) int32 and b (k, 3)."""
        on, link = np.full(self.input_faces, -1, np.int32), np.empty(len(face), np.int32)
        _list_by_face(face, on, link)
        way(self.record, face, b, on, link, np.empty(MAX_RING + 8, np.int32))
