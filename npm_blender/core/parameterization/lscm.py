"""Least-squares conformal map (LSCM, Levy et al. 2002) of both sides of a collapse at once, in O(ring).

Planar positions are complex numbers; i = 0 and j = 1 are fixed. The energy of the triangles before and after, with the
ring shared, then couples a ring vertex only to its two ring neighbours and to k. Ring vertices 1..r-2 are eliminated
one after the other; what remains is a system of three: first and last ring vertex, and k.
"""
import numpy as np

from ..jit import compiled
from .stencil import ANCHORED, EDGE

SLIVER = 0.01  # triangles thinner than this (height over longest side) are flattened as if they were this thick


@compiled
def cotangents(ax, ay, az, bx, by, bz, cx, cy, cz):
    """Cotangents of the angles at a, b, c; thin triangles are thickened so that they stay those of a triangle."""
    ux, uy, uz = bx - ax, by - ay, bz - az
    vx, vy, vz = cx - ax, cy - ay, cz - az
    wx, wy, wz = cx - bx, cy - by, cz - bz
    l2 = ux * ux + uy * uy + uz * uz
    m2 = vx * vx + vy * vy + vz * vz
    n2 = wx * wx + wy * wy + wz * wz
    nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    twice = np.sqrt(nx * nx + ny * ny + nz * nz)
    longest = max(l2, m2, n2)
    if twice >= SLIVER * longest and longest > 1e-60:
        return 0.5 * (l2 + m2 - n2) / twice, 0.5 * (l2 + n2 - m2) / twice, 0.5 * (m2 + n2 - l2) / twice
    h = SLIVER
    if longest <= 1e-60:
        return 0.57735, 0.57735, 0.57735
    if longest == l2:
        x = min(max(0.5 * (l2 + m2 - n2) / l2, 0.0), 1.0)
        return x / h, (1 - x) / h, h - x * (1 - x) / h
    if longest == m2:
        x = min(max(0.5 * (l2 + m2 - n2) / m2, 0.0), 1.0)
        return x / h, h - x * (1 - x) / h, (1 - x) / h
    x = min(max(0.5 * (l2 + n2 - m2) / n2, 0.0), 1.0)
    return h - x * (1 - x) / h, x / h, (1 - x) / h


@compiled
def measure(X, ring, r, t, s1, s2, kind, i, j, x, y, z, cots):
    """Cotangents (2 t + 2, 3) of all triangles of the patch: ring faces before, faces on the edge, ring faces after.

    Corner order: owner, ring q, ring q + 1; (i, j, ring[s2]); (j, i, ring[s1]).
    """
    for q in range(t):
        a, b = ring[q], ring[q + 1 if q + 1 < r else 0]
        o = j if s1 <= q < s2 else i
        cots[q, 0], cots[q, 1], cots[q, 2] = cotangents(
            X[o, 0], X[o, 1], X[o, 2], X[a, 0], X[a, 1], X[a, 2], X[b, 0], X[b, 1], X[b, 2])
        cots[t + 2 + q, 0], cots[t + 2 + q, 1], cots[t + 2 + q, 2] = cotangents(
            x, y, z, X[a, 0], X[a, 1], X[a, 2], X[b, 0], X[b, 1], X[b, 2])
    c = ring[s2 if s2 < r else 0]
    cots[t, 0], cots[t, 1], cots[t, 2] = cotangents(
        X[i, 0], X[i, 1], X[i, 2], X[j, 0], X[j, 1], X[j, 2], X[c, 0], X[c, 1], X[c, 2])
    if kind != EDGE:
        c = ring[s1]
        cots[t + 1, 0], cots[t + 1, 1], cots[t + 1, 2] = cotangents(
            X[j, 0], X[j, 1], X[j, 2], X[i, 0], X[i, 1], X[i, 2], X[c, 0], X[c, 1], X[c, 2])


@compiled
def assemble(r, t, s1, s2, kind, cots, S):
    """Fill the system S (r, 6) complex: per ring vertex its diagonal, coupling to the next one, to the first, to the
    last, to k, and right-hand side. Returns the diagonal of k.

    The energy of a triangle is sum of conj(u_a) Q_ab u_b with Q_aa = cot b + cot c, Q_ab = -cot c + i for the
    counter-clockwise step a -> b: twice Dirichlet energy minus signed area.
    """
    for q in range(r):
        for s in range(6):
            S[q, s] = 0.0
    kk = 0.0
    for q in range(t):
        p = q + 1 if q + 1 < r else 0
        ca, cb, cc = cots[q, 0], cots[q, 1], cots[q, 2]  # owner, q, p
        S[q, 0] += ca + cc
        S[p, 0] += ca + cb
        S[q, 1] += complex(-ca, 1.0)
        if s1 <= q < s2:  # j = 1: owner -> q is ccw, p -> owner is ccw
            S[q, 5] -= complex(-cc, -1.0)
            S[p, 5] -= complex(-cb, 1.0)
        ca, cb, cc = cots[t + 2 + q, 0], cots[t + 2 + q, 1], cots[t + 2 + q, 2]
        S[q, 0] += ca + cc
        S[p, 0] += ca + cb
        S[q, 1] += complex(-ca, 1.0)
        S[q, 4] += complex(-cc, -1.0)
        S[p, 4] += complex(-cb, 1.0)
        kk += cb + cc
    p = s2 if s2 < r else 0  # face (i, j, p): j -> p ccw
    S[p, 0] += cots[t, 0] + cots[t, 1]
    S[p, 5] -= complex(-cots[t, 0], -1.0)
    if kind != EDGE:  # face (j, i, p): p -> j ccw
        S[s1, 0] += cots[t + 1, 0] + cots[t + 1, 1]
        S[s1, 5] -= complex(-cots[t + 1, 1], 1.0)
    if kind == ANCHORED:  # k is i, at 0
        for q in range(r):
            S[q, 4] = 0.0
    return kk


@compiled
def eliminate(r, t, kk, S, B):
    """Eliminate ring vertices 1..r-2; B (3, 4) becomes the system of the first, the last and k, right-hand last."""
    last = r - 1
    for a in range(3):
        for b in range(4):
            B[a, b] = 0.0
    B[0, 0], B[1, 1], B[2, 2] = S[0, 0].real, S[last, 0].real, kk
    B[0, 2], B[1, 2] = S[0, 4], S[last, 4]
    B[0, 3], B[1, 3] = S[0, 5], S[last, 5]
    if t == r:  # closed: last -> first
        B[1, 0] += S[last, 1]
    if r == 2:
        B[1, 0] += S[0, 1].conjugate()
    else:
        S[1, 2] += S[0, 1].conjugate()
        S[last - 1, 3] += S[last - 1, 1]
        for q in range(1, last):
            d = S[q, 0].real
            f, g, h, w = S[q, 2] / d, S[q, 3] / d, S[q, 4] / d, S[q, 5] / d
            fc, gc, hc = S[q, 2].conjugate(), S[q, 3].conjugate(), S[q, 4].conjugate()
            if q + 1 < last:
                nc = S[q, 1].conjugate()
                S[q + 1, 0] -= nc * (S[q, 1] / d)
                S[q + 1, 2] -= nc * f
                S[q + 1, 3] -= nc * g
                S[q + 1, 4] -= nc * h
                S[q + 1, 5] -= nc * w
            B[0, 0] -= fc * f
            B[1, 1] -= gc * g
            B[2, 2] -= hc * h
            B[1, 0] -= gc * f
            B[0, 2] -= fc * h
            B[1, 2] -= gc * h
            B[0, 3] -= fc * w
            B[1, 3] -= gc * w
            B[2, 3] -= hc * w
    B[0, 1] = B[1, 0].conjugate()
    B[2, 0] = B[0, 2].conjugate()
    B[2, 1] = B[1, 2].conjugate()


@compiled
def _solve_border(B, flat, k_at, A):
    """Solve B for (first, last, k) with the flagged ones real and k fixed if k_at >= 0; A (6, 7) is work space."""
    for a in range(3):
        for b in range(3):
            re, im = B[a, b].real, B[a, b].imag
            A[2 * a, 2 * b], A[2 * a, 2 * b + 1], A[2 * a + 1, 2 * b], A[2 * a + 1, 2 * b + 1] = re, -im, im, re
        A[2 * a, 6], A[2 * a + 1, 6] = B[a, 3].real, B[a, 3].imag
    for v in range(6):
        fixed, value = flat[v // 2] and v % 2 == 1, 0.0
        if v // 2 == 2 and k_at >= 0:
            fixed, value = True, (k_at if v == 4 else 0.0)
        if fixed:
            for w in range(6):
                A[w, 6] -= A[w, v] * value
                A[w, v] = 0.0
                A[v, w] = 0.0
            A[v, v], A[v, 6] = 1.0, value
    for v in range(6):  # symmetric positive definite: no pivoting
        d = A[v, v]
        if not d > 1e-14:
            return False
        for w in range(v + 1, 6):
            s = A[w, v] / d
            if s != 0.0:
                for c in range(v + 1, 7):
                    A[w, c] -= s * A[v, c]
    for v in range(5, -1, -1):
        s = A[v, 6]
        for c in range(v + 1, 6):
            s -= A[v, c] * A[c, 6]
        A[v, 6] = s / A[v, v]
    return True


@compiled
def place(r, S, B, flat, k_at, A, uv):
    """Positions uv (r + 3,) of ring, i, j, k from the eliminated system; False if it is singular."""
    if not _solve_border(B, flat, k_at, A):
        return False
    first, last, k = complex(A[0, 6], A[1, 6]), complex(A[2, 6], A[3, 6]), complex(A[4, 6], A[5, 6])
    uv[0], uv[r - 1], uv[r], uv[r + 1], uv[r + 2] = first, last, 0.0, 1.0, k
    for q in range(r - 2, 0, -1):
        s = S[q, 5] - S[q, 2] * first - S[q, 3] * last - S[q, 4] * k
        if q + 1 < r - 1:
            s -= S[q, 1] * uv[q + 1]
        uv[q] = s / S[q, 0].real
    return True
