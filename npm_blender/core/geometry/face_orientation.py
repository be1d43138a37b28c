"""Which way a face looks against the surface that it lies on: the one place that calls a face flipped.

A face is flipped where the cosine between its normal and that of the surface is small. Where the surface has a normal at each
corner, N_a, N_b, N_c, it is their sum s = N_a + N_b + N_c that the face's normal n is compared with:
cos = n . s / (|n| |s|). The thresholds differ by what is done about a flipped face.
"""
import numpy as np

from ..jit import compiled
from .normals import triangle_normal

FLIPPED_FIT = 0.3  # what the fit makes of a face, against its mapped normal: well before it folds over, its springs get stiffer
FLIPPED_SURFACE = 0.05  # what untangling moves over the surface, against the corners' normals: the fit still moves it afterwards
OPPOSED = 0.0  # what the fit may not leave behind, against the corners' normals: nothing moves the face any more
_NONE = 1e-60  # square of the product of the normals' lengths up to which a face or its surface has no direction


@compiled
def orientation_cosine(product, size):
    """Cosine between two vectors, of their scalar product and the product of their squared lengths (see `orientation_measures`);
    0 where one has no length. Floats.

    >>> from npm_blender.core.geometry import orientation_cosine
    >>> orientation_cosine(2.0, 4.0 * 4.0), orientation_cosine(0.0, 0.0)
    (0.5, 0.0)
    """
    return product / np.sqrt(size) if size > _NONE else 0.0


@compiled
def not_flipped(product, size, threshold):
    """Whether the cosine of `orientation_cosine` is above a threshold >= 0. Squares instead of taking roots, for inner loops;
    false for faces without area.

    >>> from npm_blender.core.geometry import FLIPPED_FIT, FLIPPED_SURFACE, not_flipped
    >>> [not_flipped(0.2, 1.0, threshold) for threshold in (FLIPPED_SURFACE, FLIPPED_FIT)]
    [True, False]
    """
    return product > 0.0 and size > _NONE and product * product > threshold * threshold * size


@compiled
def is_flipped(F, P, N, f, threshold):
    """Whether the cosine between face f and the surface at its corners is at most a threshold: FLIPPED_SURFACE or OPPOSED.

    F (m, 3) int32: faces; P (n, 3) float64: points; N (n, 3) float64: unit normals of the surface there. Faces without area are
    flipped.

    >>> import numpy as np
    >>> from npm_blender.core.geometry import OPPOSED, is_flipped
    >>> P, up = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]]), np.array([[0.0, 0, 1]] * 3)
    >>> [is_flipped(np.array([face], np.int32), P, up, 0, OPPOSED) for face in ((0, 1, 2), (0, 2, 1), (0, 1, 1))]
    [False, True, True]
    """
    a, b, c = F[f, 0], F[f, 1], F[f, 2]
    nx, ny, nz = triangle_normal(P, a, b, c)
    sx, sy, sz = N[a, 0] + N[b, 0] + N[c, 0], N[a, 1] + N[b, 1] + N[c, 1], N[a, 2] + N[b, 2] + N[c, 2]
    return not not_flipped(nx * sx + ny * sy + nz * sz,
                           (nx * nx + ny * ny + nz * nz) * (sx * sx + sy * sy + sz * sz), threshold)


@compiled
def is_flipped_from(F, P, normals, f, threshold):
    """Whether the cosine between face f of points P and row f of normals (m, 3), of length one, is below a threshold:
    FLIPPED_FIT.

    Unlike `is_flipped` it compares with one normal a face, and faces without area are not flipped: no spring can straighten them.

    >>> import numpy as np
    >>> from npm_blender.core.geometry import FLIPPED_FIT, is_flipped_from
    >>> F, P = np.array([[0, 1, 2]], np.int32), np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]])
    >>> [is_flipped_from(F, P, np.array([normal]), 0, FLIPPED_FIT) for normal in ([0.0, 0.6, 0.8], [0.0, 1.0, 0.0])]
    [False, True]
    """
    x, y, z = triangle_normal(P, F[f, 0], F[f, 1], F[f, 2])
    return x * normals[f, 0] + y * normals[f, 1] + z * normals[f, 2] < threshold * np.sqrt(x * x + y * y + z * z)


@compiled
def orientation_measures(P, N, a, b, c):
    """How the triangle of points a, b, c of P (n, 3) lies on a surface with unit normals N (n, 3) there: product, size and bulge.

    product: n . s, of the triangle's normal n, twice as long as its area, and the sum s of the three normals of the surface.
    It is 6 times the area projected on the surface, averaged over the corners; negative if the triangle is flipped. size:
    |n|^2 |s|^2, so that product / sqrt(size) is the cosine. bulge: how far the triangle's middle m is from the planes of the
    surface at its corners, times 6 times its area: sum_i |N_i . (m - P_i)| |n|. The measures are ours.

    >>> import numpy as np
    >>> from npm_blender.core.geometry import orientation_measures
    >>> P, up = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]]), np.array([[0.0, 0, 1]] * 3)
    >>> orientation_measures(P, up, 0, 1, 2), orientation_measures(P, up, 0, 2, 1)
    ((3.0, 9.0, 0.0), (-3.0, 9.0, 0.0))
    """
    ux, uy, uz = P[b, 0] - P[a, 0], P[b, 1] - P[a, 1], P[b, 2] - P[a, 2]
    vx, vy, vz = P[c, 0] - P[a, 0], P[c, 1] - P[a, 1], P[c, 2] - P[a, 2]
    nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    sx, sy, sz = N[a, 0] + N[b, 0] + N[c, 0], N[a, 1] + N[b, 1] + N[c, 1], N[a, 2] + N[b, 2] + N[c, 2]
    area = nx * nx + ny * ny + nz * nz
    height = (abs(N[a, 0] * (ux + vx) + N[a, 1] * (uy + vy) + N[a, 2] * (uz + vz))
              + abs(N[b, 0] * (vx - 2 * ux) + N[b, 1] * (vy - 2 * uy) + N[b, 2] * (vz - 2 * uz))
              + abs(N[c, 0] * (ux - 2 * vx) + N[c, 1] * (uy - 2 * vy) + N[c, 2] * (uz - 2 * vz))) / 3
    return nx * sx + ny * sy + nz * sz, area * (sx * sx + sy * sy + sz * sz), height * np.sqrt(area)
