"""Small meshes of every topology, and synthetic features, for the tests of the stream."""
import numpy as np

from npm_blender.core.mesh.topology import opposite_halfedges, vertex_fans

TETRAHEDRON = np.array([[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]])


def grid(rows, columns, wrap_rows=False, wrap_columns=False):
    """Faces of a grid of quads cut in two; wrapped both ways it is a torus, one way a tube."""
    high, wide = rows + (not wrap_rows), columns + (not wrap_columns)
    i, j = (a.reshape(-1) for a in np.meshgrid(np.arange(rows), np.arange(columns), indexing="ij"))
    a, b = i * wide + j, (i + 1) % high * wide + j
    c, d = (i + 1) % high * wide + (j + 1) % wide, i * wide + (j + 1) % wide
    return np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])


def double_torus():
    """Surface of a plate of 5 x 3 cubes with two of them cut out: genus 2."""
    filled = np.zeros((7, 5, 3), bool)
    filled[1:6, 1:4, 1] = True
    filled[2, 2, 1] = filled[4, 2, 1] = False
    quads = []
    for axis in range(3):
        for cube in np.argwhere(filled):
            for side in (0, 1):
                beside = cube.copy()
                beside[axis] += 2 * side - 1
                if not filled[tuple(beside)]:
                    u, v = np.eye(3, dtype=int)[[(axis + 1) % 3, (axis + 2) % 3]]
                    origin = cube + side * np.eye(3, dtype=int)[axis]
                    corners = [origin, origin + u, origin + u + v, origin + v]
                    quads.append(corners if side else corners[::-1])
    _, index = np.unique(np.array(quads).reshape(-1, 3), axis=0, return_inverse=True)
    q = index.reshape(-1, 4)
    return np.concatenate([q[:, [0, 1, 2]], q[:, [0, 2, 3]]])


def compact(F):
    """F with its vertices renumbered without gaps."""
    return np.unique(F, return_inverse=True)[1].reshape(F.shape)


def punched(F, rng, holes):
    """F without random faces, as long as it stays a manifold."""
    for _ in range(holes):
        fewer = compact(np.delete(F, rng.integers(len(F)), 0)) if len(F) > 1 else F
        if (vertex_fans(fewer, opposite_halfedges(fewer), int(fewer.max()) + 1) == 1).all():
            F = fewer
    return F


def shuffled(F, rng):
    """The same mesh: faces permuted, corners rotated, vertices renumbered."""
    F = rng.permutation(int(F.max()) + 1)[F][rng.permutation(len(F))]
    turn = (np.arange(3) + rng.integers(3, size=(len(F), 1))) % 3
    return np.take_along_axis(F, turn, 1)


def sphere(faces_across=10):
    """Vertices (n, 3), longest side about 1, and faces of a sphere: a tube with two caps."""
    k = faces_across
    F = grid(k, 2 * k, wrap_columns=True)
    n, ring = (k + 1) * 2 * k, np.arange(2 * k)
    caps = [np.stack([np.full(2 * k, n), ring, (ring + 1) % (2 * k)], 1),
            np.stack([np.full(2 * k, n + 1), k * 2 * k + (ring + 1) % (2 * k), k * 2 * k + ring], 1)]
    t, p = np.repeat(np.arange(1, k + 2) / (k + 2) * np.pi, 2 * k), np.tile(ring / k * np.pi, k + 1)
    V = np.stack([np.sin(t) * np.cos(p), np.sin(t) * np.sin(p), np.cos(t)], 1)
    return np.concatenate([V, [[0, 0, 1], [0, 0, -1]]]) / 2, np.concatenate([F, *caps])


def some_features(base_faces, levels, count, rng, channels=8):
    """Level, face, value of distinct features, larger ones first: heavy-tailed, most numbers zero."""
    first = base_faces * (4 ** np.arange(levels + 1) - 1) // 3
    number = rng.permutation(first[-1])[:count]
    count = len(number)
    level = np.searchsorted(first, number, side="right") - 1
    value = np.rint(rng.laplace(0, 0.8, (count, channels)) * np.linspace(3, 0.3, count)[:, None]).astype(int)
    return level, number - first[level], value
