"""The map between the base mesh and the input, composed of the flattenings of all collapses (Liu et al. 2020).

A point is a face and barycentric coordinates. From coarse to fine, the collapses that touched the point's face are
undone, last one first; from fine to coarse they are repeated in order. Each step finds the point's place in the plane
and the face of the other side that holds it. Points of the border stay on it exactly.
"""
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ..jit import compiled
from .collapse_record import FIRST, SIDES, CollapseRecord
from .recorded_stencil import face_count, is_on_border, recorded_stencil, triangle_corners
from .stencil import MAX_RING, SPARE

_SNAP = 1e-10  # barycentric coordinates below this are zero


@compiled
def _along_border(record, first, stencil, p, to_before, b):
    """Put p on the nearest border edge of a stencil, before or after the collapse; returns the place of its face in
    `record.faces`, and b (3,) gets the barycentrics."""
    nearest, at, corner, share = np.inf, 0, 0, 0.0
    for q in range(face_count(stencil, to_before)):
        a0, a1, a2 = triangle_corners(stencil, q, to_before)
        for s in range(3):
            if not is_on_border(stencil, q, to_before, s):
                continue
            u, v = record.uv[a1 if s == 0 else (a2 if s == 1 else a0)], record.uv[a2 if s == 0 else (a0 if s == 1 else a1)]
            d, e = v - u, p - u
            x = (d.real * e.real + d.imag * e.imag) / (d.real * d.real + d.imag * d.imag)
            x = 0.0 if x < _SNAP else (1.0 if x > 1.0 - _SNAP else x)
            gap = e - x * d
            gap2 = gap.real * gap.real + gap.imag * gap.imag
            if gap2 < nearest:
                nearest, at, corner, share = gap2, q, s, x
    k = (record.faces[first + at] & 3) + corner
    b[k % 3], b[(k + 1) % 3], b[(k + 2) % 3] = 0.0, 1.0 - share, share
    return first + at


@compiled(inline="always")
def _cross(a, b):
    return a.real * b.imag - a.imag * b.real


@compiled(inline="always")
def _areas(record, stencil, q, before, p):
    """Twice the areas of the triangles of p with the sides opposite to the corners of face number q of a stencil."""
    a0, a1, a2 = triangle_corners(stencil, q, before)
    u, v, w = record.uv[a0] - p, record.uv[a1] - p, record.uv[a2] - p
    return _cross(v, w), _cross(w, u), _cross(u, v)


@compiled(inline="always")
def _holding(record, stencil, p, before, first):
    """The number of a stencil's face whose triangle, before or after the collapse, holds p, and its `_areas`; -1 where rounding
    leaves none. first: the number that is tried first, that of the face which the point comes from."""
    count = face_count(stencil, before)
    if first < count:
        x, y, z = _areas(record, stencil, first, before, p)
        if x >= 0.0 and y >= 0.0 and z >= 0.0:
            return first, x, y, z
    for q in range(count - 1, -1, -1):  # the faces that vanish are the likeliest
        x, y, z = _areas(record, stencil, q, before, p)
        if x >= 0.0 and y >= 0.0 and z >= 0.0:
            return q, x, y, z
    return -1, 0.0, 0.0, 0.0


@compiled
def _nearest(record, stencil, p, before):
    """As `_holding`, for the triangle that p misses by the least share of its area; what is missed is zero."""
    best, number, x, y, z = -np.inf, 0, 1.0, 0.0, 0.0
    for q in range(face_count(stencil, before)):
        dx, dy, dz = _areas(record, stencil, q, before, p)
        least = min(dx, dy, dz) / (dx + dy + dz)
        if least > best:
            best, number, x, y, z = least, q, max(dx, 0.0), max(dy, 0.0), max(dz, 0.0)
    return number, x, y, z


@compiled(inline="always")
def _step(record, first, stencil, number, b, to_before):
    """Move barycentrics b (3,) of face number `number` of a stencil to the other side of the collapse; returns where in
    `record.faces` the new face is. first: where the stencil's faces begin there."""
    k0 = np.int64(record.faces[first + number] & 3)
    k1 = k0 + 1 if k0 < 2 else 0
    k2 = k1 + 1 if k1 < 2 else 0
    a0, a1, a2 = triangle_corners(stencil, number, not to_before)
    u, v, w = record.uv[a0], record.uv[a1], record.uv[a2]
    p = complex(b[k0] * u.real + b[k1] * v.real + b[k2] * w.real, b[k0] * u.imag + b[k1] * v.imag + b[k2] * w.imag)
    sides = stencil.sides
    border_vertex = stencil.ring_size > sides and (to_before or stencil.face_count == sides + 1)
    if border_vertex and b[k0] == 1.0:
        return _along_border(record, first, stencil, p, to_before, b)
    for s in range(3):
        if b[k0 if s == 0 else (k1 if s == 1 else k2)] == 0.0 and is_on_border(stencil, number, not to_before, s):
            return _along_border(record, first, stencil, p, to_before, b)
    at, x, y, z = _holding(record, stencil, p, to_before, number)
    if at < 0:
        at, x, y, z = _nearest(record, stencil, p, to_before)
    total = x + y + z
    entry = first + at
    k0 = np.int64(record.faces[entry] & 3)
    k1 = k0 + 1 if k0 < 2 else 0
    b[k0], b[k1], b[k1 + 1 if k1 < 2 else 0] = x / total, y / total, z / total
    for s in range(3):
        if b[s] < _SNAP:
            b[s] = 0.0
        elif b[s] > 1.0 - 2 * _SNAP:
            b[s] = 1.0
    return entry


@compiled(inline="always")
def _move(record, c, to_before, face, b, on, link, waiting):
    """Undo (to_before) or repeat collapse c for all points on its faces at once; see `_undo_all`."""
    first = record.collapses[c, FIRST]
    count = record.collapses[c, SIDES] if to_before else record.collapses[c + 1, FIRST] - first
    some = False
    for q in range(count):
        p = on[record.faces[first + q] >> 2]
        waiting[q] = p
        some |= p >= 0
    if not some:
        return
    for q in range(count):
        on[record.faces[first + q] >> 2] = -1
    stencil = recorded_stencil(record, c)
    for q in range(count):
        p = waiting[q]
        while p >= 0:
            f = record.faces[_step(record, first, stencil, q, b[p], to_before)] >> 2
            p_next = link[p]
            link[p] = on[f]
            on[f] = p
            face[p] = f
            p = p_next


@compiled
def _undo_all(record, face, b, on, link, waiting):
    """Move points, face (k,) and barycentrics b (k, 3), through all collapses, last one first.

    on (m,): the first point on each input face, or -1; link (k,): the next one on the same face; waiting: work space.
    """
    for c in range(len(record.collapses) - 2, -1, -1):
        _move(record, c, True, face, b, on, link, waiting)


@compiled
def _repeat_all(record, face, b, on, link, waiting):
    """The inverse of `_undo_all`."""
    for c in range(len(record.collapses) - 1):
        _move(record, c, False, face, b, on, link, waiting)


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

    >>> import numpy as np
    >>> from npm_blender.core.decimation import decimate
    >>> from npm_blender.core.mesh import TriMesh
    >>> V = np.array([[x, y, 0.0] for y in (0, 1, 2) for x in (0, 1, 2)])
    >>> quads = [[0, 1, 4, 3], [1, 2, 5, 4], [3, 4, 7, 6], [4, 5, 8, 7]]
    >>> mesh = TriMesh.from_arrays(V, [t for a, b, c, d in quads for t in ([a, b, c], [a, c, d])])
    >>> base = decimate(mesh, 2)  # a square of eight faces, and its two halves
    >>> face, b = base.surface_map.coarse_to_fine([0, 1], [[1/3, 1/3, 1/3], [1/3, 1/3, 1/3]])
    >>> face, b = base.surface_map.fine_to_coarse(face, b)  # the map is a bijection: there and back is the identity
    >>> face.tolist(), bool(np.allclose(b, 1/3))
    ([0, 1], True)
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
        way(self.record, face, b, on, link, np.empty(MAX_RING + SPARE, np.int32))
