"""A map of a stencil to the plane that always succeeds: the ring on a circle, what is inside at the mean of its neighbours."""
import numpy as np

from ..jit import compiled
from .stencil import ANCHORED, EDGE, INNER


@compiled
def place_convex(stencil, uv):
    """Positions uv with the stencil's boundary on a circle (Tutte 1963): always a bijection, but less conformal.

    Each of i and j inside the circle lies at the mean of its neighbours.

    Where the border edge allows it the border is a diameter with i, j and k on it; at an ear (a border vertex with one
    face) the straight part has three vertices, and k takes the place of the end that stays a corner.
    """
    r, kind, j_start, j_stop = stencil.ring_size, stencil.kind, stencil.j_start, stencil.j_stop
    i, j, k = r, r + 1, r + 2
    straight = kind == EDGE and 0 < j_stop < r - 1
    for q in range(r):
        if kind == INNER:
            angle = 2 * np.pi * q / r
        elif straight:
            angle = np.pi * q / (r - 1)
        else:
            angle = 2 * np.pi * (q + 1) / (r + 1)
        uv[q] = complex(np.cos(angle), np.sin(angle))
    if straight:
        uv[0], uv[r - 1] = 1.0, -1.0
        uv[i], uv[j], uv[k] = -1 / 3, 1 / 3, 0.0
    elif kind == EDGE and j_stop == 0:
        uv[j], uv[k] = 1.0, 1.0
        uv[i] = (uv[r - 1] + uv[j]) / 2
    elif kind == EDGE:
        uv[i], uv[k] = 1.0, 1.0
        uv[j] = (uv[0] + uv[i]) / 2
    else:
        at_j = complex(0.0, 0.0)
        for q in range(j_start, j_stop + 1):
            at_j += uv[q if q < r else 0]
        n_j = j_stop - j_start + 2
        if kind == ANCHORED:
            uv[i], uv[k] = 1.0, 1.0
            uv[j] = (at_j + uv[i]) / n_j
        else:
            at_i = uv[0]
            for q in range(j_stop, r):
                at_i += uv[q]
            n_i = r - j_stop + 2
            uv[i] = (n_j * at_i + at_j) / (n_i * n_j - 1)
            uv[j] = (at_j + uv[i]) / n_j
            uv[k] = 0.0
    origin, unit = uv[i], uv[j] - uv[i]
    for q in range(r + 3):
        uv[q] = (uv[q] - origin) / unit
    if straight:
        for q in (0, r - 1, i, j, k):
            uv[q] = uv[q].real
