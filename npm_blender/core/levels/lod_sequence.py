"""The LoD sequence M^0..M^L of a mesh (paper section 3.2, "LoD preprocessing"): the result type and its builder."""
from dataclasses import dataclass

import numpy as np

from ..decimation.qem import Decimation, decimate
from ..geometry.geodesic_trace import Surface, points_on
from ..geometry.normals import normals_of, vertex_normals
from ..jit import compiled
from ..mesh.radix_order import order_of
from ..mesh.subdivision import Level, hierarchy
from ..mesh.triangle_mesh import TriMesh
from ..parallel import each, threads, together
from ..parameterization.surface_map import to_fine
from ..progress import Progress, no_progress, part
from ..settings import LodSettings
from ..untangling.rounds import relax
from .border_sampling import follow_border
from .surface_fit import fit, upright

MESSAGE = "Mapping the levels"
FEWEST, MOST = 6_000, 26_000  # points that a thread maps between two calls of `progress`


@dataclass(frozen=True)
class LodSequence:
    """A base mesh, and where the vertices of its subdivisions lie on the input surface. All in the unit frame.

    V0 (n0, 3) float64: QEM-optimal base positions; F0 (m0, 3) int32: base faces.
    V (nL, 3) float64: vertices of the finest level, fitted to the input (see `fit`), in the vertex order of `subdivide`;
    the first n_l rows are the vertices of level l (level 0 included: the base vertices in the place of the finest level).
    source_face (nL,) int32 and barycentric (nL, 3) float64: where the map puts them on the input, a face and a point of it.
    N (nL, 3) float64: unit normals of the input there (area-weighted vertex normals, interpolated).
    levels: L. message: '' or one line on what could not be reached ("Reached 412 of 400 base faces: ...").
    """

    V0: np.ndarray
    F0: np.ndarray
    V: np.ndarray
    N: np.ndarray
    source_face: np.ndarray
    barycentric: np.ndarray
    levels: int
    message: str = ""


@dataclass(frozen=True)
class BaseOrder:
    """A renumbering of the base mesh, the one in which the receiver will see it (see `connectivity.canonical_order`).

    vertices (n0,) int32: old index of each new vertex; faces (m0,) int32: old index of each new face;
    F (m0, 3) int32: the new faces in the new numbering. Corners may be rotated against the old face, never mirrored.
    """

    vertices: np.ndarray
    faces: np.ndarray
    F: np.ndarray


def level_corners(levels: int) -> np.ndarray:
    """Barycentric corners (4^levels, 3, 3) of the descendants of one face, in the order of `subdivide`."""
    out = np.eye(3)[None]
    for _ in range(levels):
        a, b, c = out.swapaxes(0, 1)
        ab, bc, ca = (a + b) / 2, (b + c) / 2, (c + a) / 2
        children = ((a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca))
        out = np.stack([np.stack(t, 1) for t in children], 1).reshape(-1, 3, 3)
    return out


def halfedges_with(level: Level) -> np.ndarray:
    """A half-edge that starts at each vertex of a level, then one that runs along each edge, (n + e,) int64."""
    ids = level.F.reshape(-1)
    owner = np.zeros(level.n, np.int64)
    owner[ids[::-1]] = np.arange(len(ids))[::-1]
    return np.concatenate([owner, level.edge_halfedge[:, 0]])


@compiled
def _start(halfedge, n, order, first, last, corners, old_face, turn, face, b):
    """Base face and barycentrics of points order[first:last] of a level, in face and b (last - first, 3); see `map_points`."""
    children = len(corners)
    for k in range(first, last):
        h = halfedge[order[k]]
        f, child, c = h // (3 * children), h // 3 % children, h % 3
        d = c + 1 if c < 2 else 0
        face[k - first] = old_face[f]
        for s in range(3):  # corner s of a face is corner turn + s of the old one
            x = corners[child, c, s]
            b[k - first, (turn[f] + s) % 3] = (x + corners[child, d, s]) / 2 if order[k] >= n else x


@compiled
def _put(order, first, last, face, b, out, out_b):
    """Put face and b of points order[first:last] at their places in out and out_b."""
    for k in range(first, last):
        out[order[k]] = face[k - first]
        for s in range(3):
            out_b[order[k], s] = b[k - first, s]


def map_points(decimation: Decimation, level: Level, corners: np.ndarray, old_face: np.ndarray, turn: np.ndarray,
               progress: Progress = no_progress) -> tuple[np.ndarray, np.ndarray]:
    """Where the map puts the vertices and edge midpoints of a level: input face (n + e,) and barycentric (n + e, 3).

    corners: `level_corners`; old_face, turn (m0,): the base face of the decimation that each face of level 0 is, and
    the corner of it that comes first here. Neighbours are mapped one after the other, through the same collapses.
    """
    halfedge = halfedges_with(level)
    order = order_of(halfedge)
    face, b = np.empty(len(order), np.int32), np.empty((len(order), 3))
    size = min(max(-(-len(order) // threads()), FEWEST), MOST)

    def task(first: int) -> None:
        last = min(first + size, len(order))
        at, at_b = np.empty(last - first, np.int32), np.empty((last - first, 3))
        _start(halfedge, level.n, order, first, last, corners, old_face, turn, at, at_b)
        at, at_b = to_fine(decimation, at, at_b)
        _put(order, first, last, at, at_b, face, b)

    each(task, range(0, len(order), size), progress, MESSAGE)
    return face, b


def levels(decimation: Decimation, levels: int, order: BaseOrder | None = None, fitted: bool = True,
           progress: Progress = no_progress) -> LodSequence:
    """Map the vertices of the `levels` times subdivided base onto the input surface, and fit them to it.

    order renumbers the base first; fitted: False leaves the vertices where the map puts them. Vertices and faces are
    numbered as in `subdivide.hierarchy`. Border vertices of the subdivided base lie on the border of the input, where they
    keep its length best (see `border`). Faces that the sampling turned over are relaxed (see `relax`), and the fit turns
    over no more. Raises whatever `progress` raises.
    """
    progress(0.0, MESSAGE)
    mesh, V0, F0 = decimation.mesh, decimation.V0, decimation.F0
    old_face = np.arange(len(F0), dtype=np.int32)
    turn = np.zeros(len(F0), np.int64)
    if order is not None:
        V0, F0, old_face = V0[order.vertices], order.F, order.faces
        turn = (order.vertices[F0[:, :1]] == decimation.F0[old_face]).argmax(1)
    connectivity, normals = together(lambda: hierarchy(F0, len(V0), levels), lambda: vertex_normals(mesh))
    finest = connectivity[-1]
    face, b = map_points(decimation, finest, level_corners(levels), old_face, turn, part(progress, 0.0, 0.6))
    n = finest.n
    follow_border(mesh, decimation.opposite, connectivity, face[:n], b[:n])
    surface = Surface(mesh.V, mesh.F, decimation.opposite, normals)
    points = points_on(surface, face, b)
    relax(surface, points, connectivity, V0, part(progress, 0.6, 0.65))
    planes = normals_of(mesh, points.face)
    V, middle = points.P[:n], points.P[n:]
    N = np.where(points.N[:n].any(1, keepdims=True), points.N[:n], planes[:n])
    if fitted:
        X = fit(finest, V, planes[:n], middle, planes[n:], part(progress, 0.65, 1.0))
        V = upright(connectivity, V, X, N)
    progress(1.0, MESSAGE)
    return LodSequence(V0, F0, V, N, points.face[:n], points.b[:n], levels, decimation.message)


def build_lod(mesh: TriMesh, settings: LodSettings, progress: Progress = no_progress) -> LodSequence:
    """Decimate a manifold mesh in the unit frame and map the levels of the base onto it.

    Of the settings base_faces, levels and variant count here; cleaning comes before. Raises as `decimate`.
    """
    decimation = decimate(mesh, settings.base_faces, settings.variant, part(progress, 0.0, 0.9))
    return levels(decimation, settings.levels, progress=part(progress, 0.9, 1.0))
