"""The LoD sequence M^0..M^L of a mesh (paper section 3.2, "LoD preprocessing"): the result type and its builder."""
from dataclasses import dataclass

import numpy as np

from ..decimation import Decimation, decimate
from ..geometry import TraceMesh, normals_of, points_on, vertex_normals
from ..mesh import Renumbering, TriMesh, hierarchy
from ..parallel import together
from ..progress import Progress, no_progress, part
from ..settings import LodSettings
from ..untangling import untangle
from .border_sampling import follow_border
from .level_points import MESSAGE, level_corners, map_points
from .surface_fit import fit_to_surface, restore_orientation


@dataclass(frozen=True)
class LodSequence:
    """A base mesh, and where the vertices of its subdivisions lie on the input surface. All in the unit frame.

    V0 (n0, 3) float64: QEM-optimal base positions; F0 (m0, 3) int32: base faces.
    V (nL, 3) float64: vertices of the finest level, fitted to the input (see `surface_fit`), in the order of `subdivision`;
    the first n_l rows are the vertices of level l (level 0 included: the base vertices in the place of the finest level).
    source_face (nL,) int32 and barycentric (nL, 3) float64: where the map puts them on the input, a face and a point of it.
    N (nL, 3) float64: unit normals of the input there (area-weighted vertex normals, interpolated).
    level_count: L. message: '' or one line on what could not be reached ("Reached 412 of 400 base faces: ...").
    The sequence is that of the paper (section 3.2, "LoD preprocessing"); the fit of the finest level is ours.

    >>> from npm_blender.core.levels import build_lod
    >>> from npm_blender.core.mesh import TriMesh
    >>> from npm_blender.core.settings import LodSettings
    >>> V = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
    >>> tetrahedron = TriMesh.from_arrays(V, [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
    >>> lod = build_lod(tetrahedron, LodSettings(base_faces=4, levels=1))
    >>> lod.level_count, len(lod.V0), len(lod.V)  # four vertices, and one in the middle of each of six edges
    (1, 4, 10)
    """

    V0: np.ndarray
    F0: np.ndarray
    V: np.ndarray
    N: np.ndarray
    source_face: np.ndarray
    barycentric: np.ndarray
    level_count: int
    message: str = ""


def build_levels(decimation: Decimation, level_count: int, order: Renumbering | None = None, fitted: bool = True,
                 progress: Progress = no_progress) -> LodSequence:
    """Map the vertices of the level_count times subdivided base onto the input surface, and fit them to it.

    The map is the successive self-parameterization of Liu et al. 2020 ("Neural Subdivision"), as in the paper; the fit is ours.
    order, a Renumbering, renumbers the base first; fitted: False leaves the vertices where the map puts them. Vertices and
    faces are numbered as in `hierarchy`. Border vertices of the subdivided base lie on the border of the input, where they
    keep its length best (see `border_sampling`). Vertices are moved until no face that the sampling flipped is left, as far as
    that succeeds (see `untangle`), and the fit flips none. Raises whatever `progress` raises.

    >>> from npm_blender.core.decimation import decimate
    >>> from npm_blender.core.levels import build_levels
    >>> from npm_blender.core.mesh import TriMesh
    >>> triangle = TriMesh.from_arrays([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    >>> build_levels(decimate(triangle, 1), 1).V.tolist()  # a base that is the input: midpoints of its edges
    [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.5, 0.0, 0.0], [0.0, 0.5, 0.0], [0.5, 0.5, 0.0]]
    """
    progress(0.0, MESSAGE)
    mesh, V0, F0 = decimation.mesh, decimation.V0, decimation.F0
    old_face = np.arange(len(F0), dtype=np.int32)
    rotation = np.zeros(len(F0), np.int64)
    if order is not None:
        V0, F0, old_face = V0[order.vertices], order.F, order.faces
        rotation = (order.vertices[F0[:, :1]] == decimation.F0[old_face]).argmax(1)
    connectivity, normals = together(lambda: hierarchy(F0, len(V0), level_count), lambda: vertex_normals(mesh))
    finest = connectivity[-1]
    face, b = map_points(decimation, finest, level_corners(level_count), old_face, rotation, part(progress, 0.0, 0.6))
    n = finest.n
    follow_border(mesh, decimation.opposite, connectivity, face[:n], b[:n])
    surface = TraceMesh(mesh.V, mesh.F, decimation.opposite, normals)
    points = points_on(surface, face, b)
    untangle(surface, points, connectivity, V0, part(progress, 0.6, 0.65))
    planes = normals_of(mesh, points.face)
    V, middle = points.P[:n], points.P[n:]
    N = np.where(points.N[:n].any(1, keepdims=True), points.N[:n], planes[:n])
    if fitted:
        X = fit_to_surface(finest, V, planes[:n], middle, planes[n:], part(progress, 0.65, 1.0))
        V = restore_orientation(connectivity, V, X, N)
    progress(1.0, MESSAGE)
    return LodSequence(V0, F0, V, N, points.face[:n], points.b[:n], level_count, decimation.message)


def build_lod(mesh: TriMesh, settings: LodSettings, progress: Progress = no_progress) -> LodSequence:
    """Decimate a manifold mesh in the unit frame and map the levels of the base onto it.

    Section 3.2 of the paper, "LoD preprocessing": `decimate`, then `build_levels`. Of the settings base_faces, levels and
    variant count here; cleaning comes before. Raises as `decimate`.

    >>> from npm_blender.core.levels import build_lod
    >>> from npm_blender.core.mesh import TriMesh
    >>> from npm_blender.core.settings import LodSettings
    >>> triangle = TriMesh.from_arrays([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    >>> lod = build_lod(triangle, LodSettings(base_faces=4, levels=2))
    >>> len(lod.V), lod.message
    (15, 'Reached 1 of 4 base faces: the mesh has no more')
    """
    decimation = decimate(mesh, settings.base_faces, settings.variant, part(progress, 0.0, 0.9))
    return build_levels(decimation, settings.levels, progress=part(progress, 0.9, 1.0))
