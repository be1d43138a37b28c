"""Makers of damaged meshes and of what they are made from."""
import numpy as np

from npm_blender.core.mesh.subdivision import Level, midpoints
from npm_blender.core.mesh.topology import opposite_halfedges
from npm_blender.core.mesh.triangle_mesh import TriMesh


def mesh(V, F):
    return TriMesh.from_arrays(np.asarray(V, float), np.asarray(F))


def box(n=3, at=(0, 0, 0), size=1.0):
    """A closed cube of n x n quads a side, outward: 12 n^2 faces."""
    V = np.array([[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1)], float)
    quads = np.array([[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]])
    t = np.linspace(0, 1, n + 1)
    u, v = (a.reshape(-1, 1) for a in np.meshgrid(t, t, indexing="ij"))
    points, faces = [], []
    for q in quads:
        a, b, d = V[q[0]], V[q[1]], V[q[3]]
        faces.append(plane(n).F + len(points) * (n + 1) ** 2)
        points.append(a + u * (b - a) + v * (d - a))
    P = np.round(np.concatenate(points), 12)
    unique, back = np.unique(P, axis=0, return_inverse=True)
    return mesh(unique * size + at, back.reshape(-1)[np.concatenate(faces)])


def plane(n=4):
    """An open grid of n x n quads in the plane z = 0, facing up: 2 n^2 faces."""
    t = np.arange(n + 1) / n
    V = np.array([[x, y, 0] for x in t for y in t])
    i, j = (a.ravel() for a in np.meshgrid(np.arange(n), np.arange(n), indexing="ij"))
    a, b, c, d = i * (n + 1) + j, (i + 1) * (n + 1) + j, (i + 1) * (n + 1) + j + 1, i * (n + 1) + j + 1
    return mesh(V, np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)]))


def sphere(levels=2, at=(0, 0, 0), size=1.0):
    g = (1 + 5**0.5) / 2
    V = np.array([[-1, g, 0], [1, g, 0], [-1, -g, 0], [1, -g, 0], [0, -1, g], [0, 1, g], [0, -1, -g], [0, 1, -g],
                  [g, 0, -1], [g, 0, 1], [-g, 0, -1], [-g, 0, 1]])
    level = Level.of(np.array([[0, 11, 5], [0, 5, 1], [0, 1, 7], [0, 7, 10], [0, 10, 11], [1, 5, 9], [5, 11, 4],
                               [11, 10, 2], [10, 7, 6], [7, 1, 8], [3, 9, 4], [3, 4, 2], [3, 2, 6], [3, 6, 8],
                               [3, 8, 9], [4, 9, 5], [2, 4, 11], [6, 2, 10], [8, 6, 7], [9, 8, 1]]), 12)
    for _ in range(levels):
        V, level = midpoints(V, level), level.subdivided()
    return mesh(V / np.linalg.norm(V, axis=1, keepdims=True) * size + at, level.F)


def joined(*meshes):
    offsets = np.cumsum([0] + [len(m.V) for m in meshes])
    return mesh(np.concatenate([m.V for m in meshes]),
                np.concatenate([m.F + o for m, o in zip(meshes, offsets, strict=False)]))


def soup(m):
    return mesh(m.V[m.F].reshape(-1, 3), np.arange(m.F.size).reshape(-1, 3))


def glued(*meshes, digits=9):
    """Join, and make vertices at the same place one, whatever comes of it."""
    m = joined(*meshes)
    V, back = np.unique(np.round(m.V, digits), axis=0, return_inverse=True)
    return mesh(V, back.reshape(-1)[m.F])


def volume(m):
    a, b, c = m.V[m.F].swapaxes(0, 1)
    return np.einsum("nx,nx->", a, np.cross(b, c)) / 6


def turn(m, faces):
    F = m.F.copy()
    F[faces] = F[faces][:, ::-1]
    return mesh(m.V, F)


def more(m, V=(), F=()):
    V, F = np.reshape(V, (-1, 3)), np.reshape(F, (-1, 3)).astype(int)
    return mesh(np.concatenate([m.V, V]), np.concatenate([m.F, F]))


def moebius(n=30):
    t = np.arange(n) * np.pi / n
    one = np.column_stack([np.cos(2 * t), np.sin(2 * t), 0 * t])
    across = 0.3 * np.column_stack([np.cos(t) * np.cos(2 * t), np.cos(t) * np.sin(2 * t), np.sin(t)])
    V = np.concatenate([one - across, one + across])
    F = []
    for i in range(n):
        a, b = i, n + i
        c, d = (i + 1, n + i + 1) if i < n - 1 else (n, 0)
        F += [[a, c, b], [b, c, d]]
    return mesh(V, F)


def klein(n=12, k=8):
    """A tube glued to itself with a reflection: closed and one-sided."""
    index = np.arange(n * k).reshape(n, k)
    F = []
    for i in range(n):
        for j in range(k):
            a, b = index[i, j], index[i, (j + 1) % k]
            c, d = index[i + 1, [j, (j + 1) % k]] if i < n - 1 else index[0, [-j % k, -(j + 1) % k]]
            F += [[a, c, b], [b, c, d]]
    return mesh(np.random.default_rng(0).normal(size=(n * k, 3)), F)


def with_cap(m):
    """A vertex on an edge's middle, used by one side only: a face without area fills the gap."""
    opposite = opposite_halfedges(m.F)
    a, b, c = m.F[0]
    assert opposite[0] != 0
    middle = len(m.V)
    F = np.concatenate([m.F[1:], [[a, middle, c], [middle, b, c], [a, b, middle]]])
    return mesh(np.concatenate([m.V, [(m.V[a] + m.V[b]) / 2]]), F)


def collapsed_edge(m):
    V = m.V.copy()
    V[m.F[0, 1]] = V[m.F[0, 0]]
    return mesh(V, m.F)


def pinched_spheres():
    a, b = sphere(), sphere(at=(2, 0, 0))
    top, bottom = a.V[:, 0].argmax(), b.V[:, 0].argmin()
    m = joined(mesh(a.V - a.V[top], a.F), mesh(b.V - b.V[bottom], b.F))
    F = m.F.copy()
    F[F == bottom + len(a.V)] = top
    return mesh(m.V, F)


def book(pages):
    """Sheets that share one edge."""
    angles = np.arange(pages) * 2 * np.pi / pages + 0.1
    return glued(*[mesh(plane().V @ np.array([[0, 0, 1], [np.cos(w), np.sin(w), 0], [0, 0, 0]]), plane().F)
                   for w in angles])


def tube(rows=8, columns=24):
    """A cylinder of radius 1 and length 4 without lids."""
    z, w = np.meshgrid(np.linspace(0, 4, rows + 1), np.arange(columns) * 2 * np.pi / columns, indexing="ij")
    V = np.stack([np.cos(w), np.sin(w), z], 2).reshape(-1, 3)
    i, j = (a.ravel() for a in np.meshgrid(np.arange(rows), np.arange(columns), indexing="ij"))
    a, b = i * columns + j, i * columns + (j + 1) % columns
    c, d = b + columns, a + columns
    return mesh(V, np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)]))


def bipyramid(sides):
    """A closed double cone; two vertices belong to `sides` faces each."""
    w = np.arange(sides) * 2 * np.pi / sides
    V = np.concatenate([np.column_stack([np.cos(w), np.sin(w), 0 * w]), [[0, 0, 1], [0, 0, -1]]])
    i = np.arange(sides)
    j, top, bottom = (i + 1) % sides, 0 * i + sides, 0 * i + sides + 1
    return mesh(V, np.concatenate([np.stack([i, j, top], 1), np.stack([j, i, bottom], 1)]))


def tetrahedron(at=(0, 0, 0), size=1.0):
    V = np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]], float)
    return mesh(V * size + at, [[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]])


def moved(m, scale=1.0, by=(0, 0, 0)):
    return mesh(m.V * scale + by, m.F)


def flipped(m):
    return turn(m, slice(None))


def wave(n=12):
    """An open sheet of 2 n^2 faces that is not flat."""
    m = plane(n)
    return mesh(m.V + np.sin(6 * m.V[:, [1, 0, 0]]) * [0, 0, 0.1] + np.cos(5 * m.V[:, [1, 1, 1]]) * [0, 0, 0.1], m.F)


def unequal_sides(n=4):
    """A cube whose top has twice as many vertices along its edges as the sides below: T-junctions all round."""
    m = box(n)
    top = (m.V[m.F][:, :, 2] == 1).all(1)
    lid = mesh(plane(2 * n).V + [0, 0, 1], plane(2 * n).F)
    return glued(mesh(m.V, m.F[~top]), lid)


def without(m, faces):
    return mesh(m.V, np.delete(m.F, faces, 0))


def many_parts(count, at=3.0):
    """A sphere of 1280 faces and `count` tiny tetrahedra and single triangles beside it."""
    parts = [sphere(3)]
    for k in range(count):
        small = moved(tetrahedron() if k % 2 else mesh(np.eye(3), [[0, 1, 2]]), 0.01)
        parts.append(moved(small, by=(at + 0.1 * (k % 10), 0.1 * (k // 10), 0.0)))
    return joined(*parts)


def needles(width=1e-6):
    """A cube of 5 x 5 quads a side whose first row and column are only `width` wide."""
    m = box(5)
    return mesh(np.where(np.isclose(m.V, 0.2), width, m.V), m.F)


def cells(n=2):
    """n^3 cubes side by side with shared walls, as a voxel or finite-element export has them."""
    at = [(x, y, z) for x in range(n) for y in range(n) for z in range(n)]
    return glued(*[box(2, at=a) for a in at])


def polygons_as_obj(points, polygons, extra=""):
    """OBJ text of points (n, 3) and lists of vertex numbers from 0."""
    lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in np.asarray(points, float).tolist()]
    return "\n".join(lines + ["f " + " ".join(str(i + 1) for i in p) for p in polygons] + [extra, ""])


def prism_of_star(arms=10):
    """A closed star-shaped prism as polygons: concave lids of 2 * arms corners, one of them not planar; sides of quads."""
    k = 2 * arms
    w = np.arange(k) * 2 * np.pi / k
    r = np.where(np.arange(k) % 2, 0.4, 1.0)
    ring = np.column_stack([r * np.cos(w), r * np.sin(w)])
    top = np.column_stack([ring, 1 + 0.05 * (np.arange(k) % 3)])
    points = np.concatenate([np.column_stack([ring, np.zeros(k)]), top])
    sides = [[i, (i + 1) % k, k + (i + 1) % k, k + i] for i in range(k)]
    return points, [list(range(k))[::-1], [k + i for i in range(k)], *sides]


def noisy_soup():
    """A triangle soup whose copies of a vertex differ in the last digits of single precision."""
    m = soup(sphere())
    return mesh(m.V + np.random.default_rng(0).uniform(-2e-7, 2e-7, m.V.shape), m.F)


def shelf():
    """A box without its lid, and in it a shelf whose two sides are faces on the same vertices."""
    m = box()
    tray = without(m, np.flatnonzero((m.V[m.F][:, :, 2] == 1).all(1)))
    board = mesh(plane(3).V + [0, 0, 1 / 3], plane(3).F)
    return glued(tray, board, flipped(board))


def fins(rows=12):
    """A cube of rows^2 quads a side with a sheet, three quads long, on every second edge line of its top."""
    m = box(rows)
    t = np.arange(4) / rows
    parts = [m]
    for k in range(rows):
        x, y = (k % 6 * 2 + 1) / rows, k // 6 * 6 / rows
        V = np.array([[x, y + s, 1 + h] for h in (0, 0.1) for s in t])
        parts.append(mesh(V, [f for i in range(3) for f in ([i, i + 1, i + 5], [i, i + 5, i + 4])]))
    return glued(*parts)


def far_soup():
    """A sphere of radius 10, far away, as triangles whose corners differ by a unit in the last place of single precision."""
    m = moved(soup(sphere()), 10.0, (3e4, 2e4, 0))
    away = np.random.default_rng(0).integers(-1, 2, m.V.shape)
    V = m.V.astype(np.float32)
    return mesh(np.where(away > 0, np.nextafter(V, np.float32(np.inf)), V), m.F)


def street():
    """Two walls, 0.4 units apart, 300 long, in double precision and coordinates as surveyors have them."""
    wall = mesh(plane(4).V @ np.array([[300, 0, 0], [0, 0, 90], [0, 0, 0]]), plane(4).F)
    return joined(moved(wall, by=(5.1e6 + 0.1, 4e6, 0)), moved(wall, by=(5.1e6 + 0.1, 4e6 + 0.4, 0)))
