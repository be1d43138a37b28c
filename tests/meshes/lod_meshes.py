"""Meshes made in code for the tests of the LoD builder: sphere, torus, sheet, tube with noise; a block, a gear, a grating."""
import numpy as np

from npm_blender.core.mesh.subdivision import hierarchy, midpoints
from npm_blender.core.mesh.triangle_mesh import TriMesh, UnitFrame


def _unit(V: np.ndarray, F: np.ndarray, noise: float = 0.0, seed: int = 0) -> TriMesh:
    V = UnitFrame.of(V).to_unit(V)
    V = V + np.random.default_rng(seed).normal(0, noise, V.shape) if noise else V
    return TriMesh.from_arrays(V, F)


def sphere(levels: int = 3, noise: float = 0.0, seed: int = 0) -> TriMesh:
    """An octahedron, subdivided and put on the sphere: 8 * 4^levels faces."""
    V = np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]], float)
    F = np.array([[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]])
    H = hierarchy(F, 6, levels)
    for level in H[:-1]:
        V = midpoints(V, level)
    return _unit(V / np.linalg.norm(V, axis=1, keepdims=True), H[-1].F, noise, seed)


def block(levels: int = 4) -> TriMesh:
    """A cube of 12 * 4^levels faces: flat sides, sharp edges."""
    V = np.stack(np.meshgrid([0.0, 1.0], [0.0, 1.0], [0.0, 1.0], indexing="ij"), -1).reshape(-1, 3)
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    F = np.array([t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))])
    H = hierarchy(F, 8, levels)
    for level in H[:-1]:
        V = midpoints(V, level)
    return _unit(V, H[-1].F)


def _grid_faces(rows: int, columns: int, wrap_rows: bool, wrap_columns: bool) -> np.ndarray:
    r, c = np.meshgrid(np.arange(rows - (not wrap_rows)), np.arange(columns - (not wrap_columns)), indexing="ij")
    at = lambda i, j: (i % rows) * columns + j % columns
    a, b, d, e = at(r, c), at(r, c + 1), at(r + 1, c), at(r + 1, c + 1)
    return np.stack([np.stack([a, b, e], -1), np.stack([a, e, d], -1)], -2).reshape(-1, 3)


def torus(rows: int = 24, columns: int = 40, noise: float = 0.0, seed: int = 0) -> TriMesh:
    """A torus of 2 * rows * columns faces."""
    v, u = np.meshgrid(np.arange(rows) * 2 * np.pi / rows, np.arange(columns) * 2 * np.pi / columns, indexing="ij")
    V = np.stack([(2 + np.cos(v)) * np.cos(u), (2 + np.cos(v)) * np.sin(u), np.sin(v)], -1).reshape(-1, 3)
    return _unit(V, _grid_faces(rows, columns, True, True), noise, seed)


def sheet(rows: int = 21, columns: int = 31, noise: float = 0.0, seed: int = 0, flat: bool = False) -> TriMesh:
    """A wavy (or flat) rectangle: a disk with a border of four corners."""
    y, x = np.meshgrid(np.linspace(0, 1, rows), np.linspace(0, 1.5, columns), indexing="ij")
    z = np.zeros_like(x) if flat else 0.1 * np.sin(5 * x) * np.cos(4 * y)
    return _unit(np.stack([x, y, z], -1).reshape(-1, 3), _grid_faces(rows, columns, False, False), noise, seed)


def plate(n: int = 24, thickness: float = 0.008) -> TriMesh:
    """A wavy plate far thinner than the faces of its base: two sheets and a rim."""
    y, x = np.meshgrid(np.linspace(0, 1, n), np.linspace(0, 1, n), indexing="ij")
    z = 0.03 * np.sin(9 * x) * np.cos(8 * y)
    V = np.concatenate([np.stack([x, y, z + side * thickness / 2], -1).reshape(-1, 3) for side in (1, -1)])
    F = _grid_faces(n, n, False, False)
    edges = np.concatenate([F[:, [0, 1]], F[:, [1, 2]], F[:, [2, 0]]])
    known = set(map(tuple, edges.tolist()))
    a, b = np.array([e for e in edges.tolist() if (e[1], e[0]) not in known]).T
    k = n * n
    rim = np.concatenate([np.stack([b, a, a + k], 1), np.stack([b, a + k, b + k], 1)])
    return _unit(V, np.concatenate([F, F[:, ::-1] + k, rim]))


def tube(rows: int = 20, columns: int = 30, noise: float = 0.0, seed: int = 0) -> TriMesh:
    """A cylinder without lids: two border loops."""
    z, u = np.meshgrid(np.linspace(0, 2, rows), np.arange(columns) * 2 * np.pi / columns, indexing="ij")
    V = np.stack([np.cos(u), np.sin(u), z], -1).reshape(-1, 3)
    return _unit(V, _grid_faces(rows, columns, False, True), noise, seed)


def gear(teeth: int = 150) -> TriMesh:
    """A flat ring with square teeth, 32 faces a tooth, made of long thin triangles as CAD programs make them."""
    k = 4 * teeth
    angle = np.arange(k) * 2 * np.pi / k
    circle = np.stack([np.cos(angle), np.sin(angle)], 1)
    outline = circle * np.where(np.arange(k) % 4 < 2, 1.0, 0.85)[:, None]
    V = np.concatenate([np.c_[ring, np.full(k, z)] for z in (0.0, 0.2) for ring in (outline, 0.3 * circle)])
    i, low, low_in, high, high_in = np.arange(k), 0, k, 2 * k, 3 * k
    j = (i + 1) % k

    def quads(a, b, c, d):
        return np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])

    F = [quads(low + i, low + j, high + j, high + i), quads(low_in + j, low_in + i, high_in + i, high_in + j),
         quads(high + i, high + j, high_in + j, high_in + i), quads(low + j, low + i, low_in + i, low_in + j)]
    return _unit(V, np.concatenate(F))


def grating(n: int = 7, open_sheet: bool = False, levels: int = 1) -> TriMesh:
    """A wavy plate with n x n square holes, which are its handles; open_sheet: its upper side alone, with as many border
    loops and one more."""
    side = 2 * n + 2
    i, j = np.array([(i, j) for i in range(side - 1) for j in range(side - 1) if not (i % 2 and j % 2)]).T
    a, b, c, d = i * side + j, (i + 1) * side + j, (i + 1) * side + j + 1, i * side + j + 1
    F = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])
    x, y = np.divmod(np.arange(side * side), side)
    V = np.stack([x, y, 0 * x], 1).astype(float)
    if not open_sheet:
        known = set(map(tuple, np.stack([F, np.roll(F, -1, 1)], 2).reshape(-1, 2).tolist()))
        p, q = np.array([edge for edge in known if edge[::-1] not in known]).T
        low = len(V)
        walls = np.concatenate([np.stack([q, p, p + low], 1), np.stack([q, p + low, q + low], 1)])
        V, F = np.concatenate([V, V - [0, 0, 1]]), np.concatenate([F, F[:, ::-1] + low, walls])
    H = hierarchy(F, len(V), levels)
    for level in H[:-1]:
        V = midpoints(V, level)
    V[:, 2] += np.sin(5 * V[:, 0] / side) + np.cos(4 * V[:, 1] / side)
    return _unit(V, H[-1].F)


def joined(*meshes: TriMesh) -> TriMesh:
    """Several meshes side by side as one."""
    V = [m.V + [2.0 * k, 0, 0] for k, m in enumerate(meshes)]
    start = np.cumsum([0] + [len(m.V) for m in meshes])
    return _unit(np.concatenate(V), np.concatenate([m.F + s for m, s in zip(meshes, start[:-1], strict=True)]))
