"""Local relaxation of the vertices of M^1..M^L on the input surface: unfolds faces that the sampling has turned over.

The map is a bijection, but a face through three of its points can still oppose the surface where the map is strongly
bent. Such a face's vertices walk over the surface towards the middle of their neighbours; a step is kept only if it
leaves fewer turned faces round the vertex, over all levels that hold it, or as many and the worst of them less turned.
"""
from typing import NamedTuple

import numpy as np

from .jit import compiled
from .mesh import TriMesh
from .subdivide import Level

PASSES = 12
LIMIT = 0.0  # cosine between face and surface below which the vertices of a face are relaxed
_STEPS = 200  # faces that one walk may cross


class Surface(NamedTuple):
    """The input: V (n, 3), F (m, 3) int32, opposite (3 m,) int32, vertex normals N (n, 3)."""

    V: np.ndarray
    F: np.ndarray
    opposite: np.ndarray
    N: np.ndarray


class Rings(NamedTuple):
    """Levels 1..L in one: faces F and opposite half-edges, concatenated; first face of each level (and the end);
    out (L, n): a half-edge that leaves each vertex in each level, or -1; fixed (n,): vertices that do not move."""

    F: np.ndarray
    opposite: np.ndarray
    first: np.ndarray
    out: np.ndarray
    fixed: np.ndarray


def rings_of(levels: list[Level]) -> Rings:
    """The rings of levels 1..L of a hierarchy; border vertices are fixed."""
    levels = levels[1:]
    first = np.cumsum([0] + [len(level.F) for level in levels])
    out = np.full((len(levels), levels[-1].n), -1, np.int64)
    opposite = []
    for k, level in enumerate(levels):
        out[k, level.F.reshape(-1)] = np.arange(level.F.size) + 3 * first[k]
        opposite.append(level.opposite.astype(np.int64) + 3 * first[k])
    fixed = np.zeros(levels[-1].n, bool)
    last = levels[-1]
    border = np.flatnonzero(last.opposite == np.arange(last.F.size))
    fixed[last.F.reshape(-1)[border]] = True
    return Rings(np.concatenate([level.F for level in levels]), np.concatenate(opposite), first, out, fixed)


@compiled
def _cosine(F, P, N, f):
    """Cosine between face f of points P and the sum of its corners' normals N."""
    a, b, c = F[f, 0], F[f, 1], F[f, 2]
    ux, uy, uz = P[b, 0] - P[a, 0], P[b, 1] - P[a, 1], P[b, 2] - P[a, 2]
    vx, vy, vz = P[c, 0] - P[a, 0], P[c, 1] - P[a, 1], P[c, 2] - P[a, 2]
    nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    sx, sy, sz = N[a, 0] + N[b, 0] + N[c, 0], N[a, 1] + N[b, 1] + N[c, 1], N[a, 2] + N[b, 2] + N[c, 2]
    size = np.sqrt((nx * nx + ny * ny + nz * nz) * (sx * sx + sy * sy + sz * sz))
    return (nx * sx + ny * sy + nz * sz) / size if size > 1e-30 else 0.0


@compiled
def _score(rings, P, N, v):
    """Number of turned faces round v over all levels, and the least cosine."""
    turned, least = 0, 1.0
    for level in range(rings.out.shape[0]):
        h = start = rings.out[level, v]
        if h < 0:
            continue
        while True:
            c = _cosine(rings.F, P, N, h // 3)
            turned += c <= 0.0
            least = min(least, c)
            h = rings.opposite[h + 2 if h % 3 == 0 else h - 1]
            if h == start:
                break
    return turned, least


@compiled
def _middle(rings, P, v, level):
    """Mean (x, y, z) of the neighbours of v at one level."""
    h = start = rings.out[level, v]
    x = y = z = 0.0
    count = 0
    while True:
        w = rings.F[h // 3, (h + 1) % 3]
        x, y, z = x + P[w, 0], y + P[w, 1], z + P[w, 2]
        count += 1
        h = rings.opposite[h + 2 if h % 3 == 0 else h - 1]
        if h == start:
            break
    return x / count, y / count, z / count


@compiled
def _axes(V, a, b, c):
    """Unit vector along the edge a -> b, and the unit normal to it in the plane of a, b, c, on the side of c."""
    ex, ey, ez = V[b, 0] - V[a, 0], V[b, 1] - V[a, 1], V[b, 2] - V[a, 2]
    r = 1.0 / (np.sqrt(ex * ex + ey * ey + ez * ez) + 1e-300)
    ex, ey, ez = ex * r, ey * r, ez * r
    ux, uy, uz = V[c, 0] - V[a, 0], V[c, 1] - V[a, 1], V[c, 2] - V[a, 2]
    along = ux * ex + uy * ey + uz * ez
    ux, uy, uz = ux - along * ex, uy - along * ey, uz - along * ez
    r = 1.0 / (np.sqrt(ux * ux + uy * uy + uz * uz) + 1e-300)
    return ex, ey, ez, ux * r, uy * r, uz * r


@compiled
def walk(surface, f, b, x, y, z):
    """Move the point (face f, barycentrics b) straight over the surface by (x, y, z), unfolding edges; b changes.

    Returns the new face. Stops at the border, at a face without area, and after _STEPS faces.
    """
    V, F = surface.V, surface.F
    for _ in range(_STEPS):
        i, j, k = F[f, 0], F[f, 1], F[f, 2]
        ex, ey, ez = V[j, 0] - V[i, 0], V[j, 1] - V[i, 1], V[j, 2] - V[i, 2]
        gx, gy, gz = V[k, 0] - V[i, 0], V[k, 1] - V[i, 1], V[k, 2] - V[i, 2]
        ee, eg, gg = ex * ex + ey * ey + ez * ez, ex * gx + ey * gy + ez * gz, gx * gx + gy * gy + gz * gz
        det = ee * gg - eg * eg
        if not det > 1e-12 * ee * gg:
            return f
        de, dg = x * ex + y * ey + z * ez, x * gx + y * gy + z * gz
        s, t = (gg * de - eg * dg) / det, (ee * dg - eg * de) / det
        x, y, z = s * ex + t * gx, s * ey + t * gy, s * ez + t * gz
        reach, side = 1.0, -1
        for c in range(3):
            step = -s - t if c == 0 else (s if c == 1 else t)
            if step < 0.0 and b[c] + step < 0.0 and -b[c] / step <= reach:
                reach, side = max(-b[c] / step, 0.0), c
        b[0], b[1], b[2] = max(b[0] - reach * (s + t), 0.0), max(b[1] + reach * s, 0.0), max(b[2] + reach * t, 0.0)
        if side >= 0:
            b[side] = 0.0
        total = b[0] + b[1] + b[2]
        b[0], b[1], b[2] = b[0] / total, b[1] / total, b[2] / total
        if side < 0:
            return f
        near, far = (side + 1) % 3, (side + 2) % 3
        h = 3 * f + near
        o = surface.opposite[h]
        if o == h:
            return f
        g, at = o // 3, o % 3
        ex, ey, ez, ux, uy, uz = _axes(V, F[f, near], F[f, far], F[f, side])
        _, _, _, vx, vy, vz = _axes(V, F[f, near], F[f, far], F[g, (at + 2) % 3])
        along, across = x * ex + y * ey + z * ez, -(x * ux + y * uy + z * uz)
        along, across = along * (1.0 - reach), across * (1.0 - reach)
        x, y, z = along * ex + across * vx, along * ey + across * vy, along * ez + across * vz
        c0, c1 = b[near], b[far]
        b[at], b[(at + 1) % 3], b[(at + 2) % 3] = c1, c0, 0.0
        f = g
    return f


@compiled
def _put(surface, f, b, P, N, v):
    """Set P[v] and N[v] to the point (face f, barycentrics b) and its normal."""
    i, j, k = surface.F[f, 0], surface.F[f, 1], surface.F[f, 2]
    size = 0.0
    for c in range(3):
        P[v, c] = b[0] * surface.V[i, c] + b[1] * surface.V[j, c] + b[2] * surface.V[k, c]
        N[v, c] = b[0] * surface.N[i, c] + b[1] * surface.N[j, c] + b[2] * surface.N[k, c]
        size += N[v, c] * N[v, c]
    size = 1.0 / (np.sqrt(size) + 1e-300)
    for c in range(3):
        N[v, c] *= size


@compiled
def _improve(surface, rings, face, b, P, N, v, level, w):
    """Try steps of vertex v towards the middle of its ring at a level; True if one was taken. w (3,) is work space."""
    turned, least = _score(rings, P, N, v)
    px, py, pz, nx, ny, nz = P[v, 0], P[v, 1], P[v, 2], N[v, 0], N[v, 1], N[v, 2]
    mx, my, mz = _middle(rings, P, v, level)
    for trial in range(3):
        share = 1.0 if trial == 0 else (0.5 if trial == 1 else 1.5)
        w[0], w[1], w[2] = b[v, 0], b[v, 1], b[v, 2]
        g = walk(surface, face[v], w, share * (mx - px), share * (my - py), share * (mz - pz))
        _put(surface, g, w, P, N, v)
        now, worst = _score(rings, P, N, v)
        if now < turned or (now == turned and worst > least + 1e-6):
            face[v] = g
            b[v, 0], b[v, 1], b[v, 2] = w[0], w[1], w[2]
            return True
        P[v, 0], P[v, 1], P[v, 2], N[v, 0], N[v, 1], N[v, 2] = px, py, pz, nx, ny, nz
    return False


@compiled
def _relax(surface, rings, face, b, P, N, passes, limit):
    """Relax the vertices of faces below the cosine `limit`, in place, until nothing moves or the passes are used up."""
    w = np.zeros(3)
    for _ in range(passes):
        moved = False
        for level in range(rings.out.shape[0]):
            for f in range(rings.first[level], rings.first[level + 1]):
                if _cosine(rings.F, P, N, f) > limit:
                    continue
                for c in range(3):
                    v = rings.F[f, c]
                    if not rings.fixed[v] and _improve(surface, rings, face, b, P, N, v, level, w):
                        moved = True
        if not moved:
            break


def relax(mesh: TriMesh, opposite: np.ndarray, normals: np.ndarray, levels: list[Level], face: np.ndarray,
          barycentric: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Relaxed points (face (n,) int32, barycentric (n, 3)) of the vertices of the finest of `levels` on the mesh.

    opposite (3 m,): opposite half-edges of the mesh; normals (n, 3): its vertex normals. Border vertices stay.
    """
    surface = Surface(mesh.V, mesh.F, opposite, normals)
    face, b = face.copy(), barycentric.copy()
    at = mesh.F[face]
    P = np.einsum("nk,nkd->nd", b, mesh.V[at])
    N = np.einsum("nk,nkd->nd", b, normals[at])
    N /= np.linalg.norm(N, axis=1, keepdims=True) + 1e-300
    _relax(surface, rings_of(levels), face, b, P, N, PASSES, LIMIT)
    return face, b
