"""Shapes on which a surface is easily fitted to the wrong sheet, made in code; all oriented outward."""
import numpy as np

from npm_blender.core.mesh import TriMesh, opposite_halfedges
from tests.meshes.shapes import bumpy, icosphere


def joined(*meshes: TriMesh) -> TriMesh:
    """Several meshes as one."""
    first = np.cumsum([0, *(len(mesh.V) for mesh in meshes)])
    return TriMesh(np.concatenate([mesh.V for mesh in meshes]),
                   np.concatenate([mesh.F + at for mesh, at in zip(meshes, first)]).astype(np.int32))


def moved(mesh: TriMesh, by=(0, 0, 0), scale=1.0) -> TriMesh:
    """A mesh elsewhere, in another size."""
    return TriMesh(mesh.V * scale + np.array(by), mesh.F)


def slab(n, m, size, top, bottom) -> TriMesh:
    """A closed plate of 4 n m faces and a rim: heights top(x, y) and bottom(x, y) over a rectangle of this size."""
    x, y = (a.reshape(-1) for a in np.meshgrid(np.linspace(0, size[0], n + 1), np.linspace(0, size[1], m + 1), indexing="ij"))
    i = np.arange((n + 1) * (m + 1)).reshape(n + 1, m + 1)
    a, b, c, d = (q.reshape(-1) for q in (i[:-1, :-1], i[1:, :-1], i[1:, 1:], i[:-1, 1:]))
    up = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])
    h = np.arange(up.size)
    rim = h[opposite_halfedges(up) == h]
    start, end = up.reshape(-1)[rim], up.reshape(-1)[rim - rim % 3 + (rim + 1) % 3]
    under = i.size
    wall = np.concatenate([np.stack([end, start, start + under], 1), np.stack([end, start + under, end + under], 1)])
    V = np.concatenate([np.stack([x, y, x * 0 + top(x, y)], 1), np.stack([x, y, x * 0 + bottom(x, y)], 1)])
    return TriMesh(V, np.concatenate([up, up[:, ::-1] + under, wall]).astype(np.int32))


def revolved(profile, n: int) -> TriMesh:
    """A closed surface of revolution: profile (k, 2) of radius and height, its ends on the axis, n corners round it."""
    r, z = np.asarray(profile, float)[1:-1].T
    angle = np.arange(n) * 2 * np.pi / n
    V = np.stack([np.outer(r, np.cos(angle)), np.outer(r, np.sin(angle)), np.repeat(z[:, None], n, 1)], 2).reshape(-1, 3)
    i = np.arange(len(V)).reshape(len(r), n)
    a, b, c, d = i[:-1], np.roll(i[:-1], -1, 1), np.roll(i[1:], -1, 1), i[1:]
    first, last = np.full(n, len(V)), np.full(n, len(V) + 1)
    F = np.concatenate([np.stack(q, -1).reshape(-1, 3) for q in (
        (a, b, c), (a, c, d), (first, np.roll(i[0], -1), i[0]), (last, i[-1], np.roll(i[-1], -1)))])
    poles = [[0, 0, profile[0][1]], [0, 0, profile[-1][1]]]
    return TriMesh(np.concatenate([V, poles]), F.astype(np.int32))


def sole() -> TriMesh:
    """A bent sole over the plate that it stands on, 0.03 apart where they are nearest, as long as 2.4."""
    def bend(x, y):
        return 0.15 * np.sin(2.5 * x) ** 2 * (1 + 0.3 * y)

    over = slab(40, 16, (2.4, 0.9), lambda x, y: bend(x, y) + 0.08, bend)
    plate = slab(36, 16, (2.8, 1.3), lambda x, y: -0.03, lambda x, y: -0.08)
    return joined(over, moved(plate, (-0.2, -0.2, 0)))


def fin() -> TriMesh:
    """A swung fin, 0.02 thick at its edge and 0.06 in its middle, 2 long."""
    def middle(x, y):
        return 0.2 * np.sin(2 * x + y)

    def half(x, y):
        return 0.01 + 0.02 * np.sin(np.pi * x / 2) * np.sin(np.pi * y)

    return slab(44, 22, (2.0, 1.0), lambda x, y: middle(x, y) + half(x, y), lambda x, y: middle(x, y) - half(x, y))


def bowl() -> TriMesh:
    """A bowl of radius 1 and thickness 0.05."""
    t = np.linspace(0, np.pi / 2, 24)
    outer = np.stack([np.sin(t), -np.cos(t)], 1)
    return revolved(np.concatenate([outer, 0.95 * outer[::-1]]), 48)


def lattice(cells: int = 2, spacing: int = 4) -> TriMesh:
    """Bars along three axes, cells + 1 of them in each row, with rounded corners."""
    size = cells * spacing + 1
    on = [np.arange(size) % spacing == 0] * 3
    x, y, z = np.meshgrid(*on, indexing="ij")
    filled = np.pad(x.astype(int) + y + z >= 2, 1).repeat(2, 0).repeat(2, 1).repeat(2, 2)
    quads = []
    for axis in range(3):
        for sign in (1, -1):
            cube = np.argwhere(filled & ~np.roll(filled, -sign, axis))
            u, v = np.eye(3, dtype=int)[[(axis + 1) % 3, (axis + 2) % 3]]
            corner = cube + (sign > 0) * np.eye(3, dtype=int)[axis]
            quad = np.stack([corner, corner + u, corner + u + v, corner + v], 1)
            quads.append(quad if sign > 0 else quad[:, ::-1])
    V, index = np.unique(np.concatenate(quads).reshape(-1, 3), axis=0, return_inverse=True)
    q, V = index.reshape(-1, 4), V / (2.0 * size)
    F = np.concatenate([q[:, [0, 1, 2]], q[:, [0, 2, 3]]])
    edges = np.concatenate([F[:, [0, 1]], F[:, [1, 2]], F[:, [2, 0]]])
    for _ in range(4):
        mean = np.zeros_like(V)
        np.add.at(mean, edges[:, 0], V[edges[:, 1]])
        V = (V + mean / np.bincount(edges[:, 0])[:, None]) / 2
    return TriMesh(V, F.astype(np.int32))


def two_shells(gap: float = 0.03) -> TriMesh:
    """A shell within another, so far apart everywhere: one solid with a hole, its inside oriented inward."""
    outer, inner = icosphere(3), icosphere(3)
    return joined(outer, TriMesh(inner.V * (1 - gap), inner.F[:, ::-1]))


def neighbours(gap: float = 0.02) -> TriMesh:
    """Two bumpy balls side by side that nearly touch."""
    one = bumpy(3)
    reach = np.ptp(one.V[:, 0]) + gap
    return joined(one, moved(one, (reach, 0, 0)))


def pipe(length: float, around: int = 12, along: int = 60) -> TriMesh:
    """A closed tube of radius 0.5, so long."""
    z = np.linspace(0, length, along + 1)
    return revolved(np.concatenate([[[0, 0]], np.stack([np.full(len(z), 0.5), z], 1), [[0, length]]]), around)


def statue(faces: int = 3) -> TriMesh:
    """A bumpy ball on a square ground of two triangles, 20 times as large, that it does not touch."""
    ground = TriMesh(np.array([[-10, -10, -1.3], [10, -10, -1.3], [10, 10, -1.3], [-10, 10, -1.3]]),
                     np.array([[0, 1, 2], [0, 2, 3]], np.int32))
    return joined(ground, bumpy(faces))


TWO_SHEETS = {"a sole over a plate": sole, "a fin": fin, "a bowl": bowl, "a lattice": lattice, "two shells": two_shells,
              "neighbours": neighbours}
