"""Which way a face looks against the surface that it lies on: the one place that calls a face flipped."""
import numpy as np

from ..jit import compiled
from .normals import triangle_normal

MARGIN = 0.05  # cosine between face and surface up to which a face counts as turned: the fit still moves it


@compiled
def orientation_cosine(F, P, N, f):
    """Cosine between face f of points P and the sum of its corners' normals N."""
    a, b, c = F[f, 0], F[f, 1], F[f, 2]
    nx, ny, nz = triangle_normal(P, a, b, c)
    sx, sy, sz = N[a, 0] + N[b, 0] + N[c, 0], N[a, 1] + N[b, 1] + N[c, 1], N[a, 2] + N[b, 2] + N[c, 2]
    size = np.sqrt((nx * nx + ny * ny + nz * nz) * (sx * sx + sy * sy + sz * sz))
    return (nx * sx + ny * sy + nz * sz) / size if size > 1e-30 else 0.0


@compiled
def not_flipped(product, size):
    """Whether a cosine is above MARGIN: product (of the vectors) over the root of size (the product of their squares)."""
    return product > 0.0 and size > 1e-60 and product * product > MARGIN * MARGIN * size


@compiled
def is_flipped(F, P, N, f):
    """Whether the cosine of face f (see `orientation_cosine`) is at most MARGIN."""
    a, b, c = F[f, 0], F[f, 1], F[f, 2]
    nx, ny, nz = triangle_normal(P, a, b, c)
    sx, sy, sz = N[a, 0] + N[b, 0] + N[c, 0], N[a, 1] + N[b, 1] + N[c, 1], N[a, 2] + N[b, 2] + N[c, 2]
    return not not_flipped(nx * sx + ny * sy + nz * sz,
                       (nx * nx + ny * ny + nz * nz) * (sx * sx + sy * sy + sz * sz))


@compiled
def orientation_measures(P, N, a, b, c):
    """Of the face a, b, c: product and size (see `upright`), and its bulge: how far its middle is from the planes of the
    surface at its corners, times its area (times 6). The product is its area projected on the surface at its corners (times 6),
    negative if it is turned."""
    ux, uy, uz = P[b, 0] - P[a, 0], P[b, 1] - P[a, 1], P[b, 2] - P[a, 2]
    vx, vy, vz = P[c, 0] - P[a, 0], P[c, 1] - P[a, 1], P[c, 2] - P[a, 2]
    nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    sx, sy, sz = N[a, 0] + N[b, 0] + N[c, 0], N[a, 1] + N[b, 1] + N[c, 1], N[a, 2] + N[b, 2] + N[c, 2]
    area = nx * nx + ny * ny + nz * nz
    height = (abs(N[a, 0] * (ux + vx) + N[a, 1] * (uy + vy) + N[a, 2] * (uz + vz))
              + abs(N[b, 0] * (vx - 2 * ux) + N[b, 1] * (vy - 2 * uy) + N[b, 2] * (vz - 2 * uz))
              + abs(N[c, 0] * (ux - 2 * vx) + N[c, 1] * (uy - 2 * vy) + N[c, 2] * (uz - 2 * vz))) / 3
    return nx * sx + ny * sy + nz * sz, area * (sx * sx + sy * sy + sz * sz), height * np.sqrt(area)
