"""Least-squares conformal map (LSCM, Levy et al. 2002) of both sides of a collapse at once, in O(ring).

Positions in the plane are complex numbers; i = 0 and j = 1 are fixed. A triangle a, b, c with cotangents cot a, cot b, cot c
of its angles has the energy sum over its corners of conj(u_a) Q_ab u_b with Q_aa = cot b + cot c and Q_ab = -cot c + i for
the counter-clockwise step a -> b. That is 4 (D - A), with D = 1/2 integral |grad u|^2 its Dirichlet energy and A its signed
area in the plane, and zero where the map of the triangle is a similarity. Summed over the triangles before and after the
collapse, which share the ring, it couples a ring vertex only to its two ring neighbours and to k. The ring vertices between
the first and the last are eliminated one after the other; what remains is a system of three: first and last, and k.
"""
import numpy as np

from ..jit import compiled
from .stencil import ANCHORED, EDGE, is_of_j, next_on_ring, third_vertex

SLIVER = 0.01  # triangles thinner than this (height over longest side) are flattened as if they were this thick
DIAGONAL, NEXT, FIRST, LAST, K, RHS = range(6)  # columns of Workspace.ring_system, see `assemble`


@compiled
def angle_cotangents(ax, ay, az, bx, by, bz, cx, cy, cz):
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
def measure(X, stencil, point, cotangents):
    """Cotangents (2 sides + 2, 3) of all triangles: those on the ring before, on the edge, on the ring with k at `point`.

    Order of corners: owner, ring vertex q, the next one; (i, j, ring[j_stop]); (j, i, ring[j_start]).
    """
    ring, sides, i, j = stencil.ring, stencil.sides, stencil.i, stencil.j
    x, y, z = point
    for q in range(sides):
        a, b = ring[q], ring[next_on_ring(stencil, q)]
        o = j if is_of_j(stencil, q) else i
        cotangents[q, 0], cotangents[q, 1], cotangents[q, 2] = angle_cotangents(
            X[o, 0], X[o, 1], X[o, 2], X[a, 0], X[a, 1], X[a, 2], X[b, 0], X[b, 1], X[b, 2])
        cotangents[sides + 2 + q, 0], cotangents[sides + 2 + q, 1], cotangents[sides + 2 + q, 2] = angle_cotangents(
            x, y, z, X[a, 0], X[a, 1], X[a, 2], X[b, 0], X[b, 1], X[b, 2])
    c = ring[third_vertex(stencil)]
    cotangents[sides, 0], cotangents[sides, 1], cotangents[sides, 2] = angle_cotangents(
        X[i, 0], X[i, 1], X[i, 2], X[j, 0], X[j, 1], X[j, 2], X[c, 0], X[c, 1], X[c, 2])
    if stencil.kind != EDGE:
        c = ring[stencil.j_start]
        cotangents[sides + 1, 0], cotangents[sides + 1, 1], cotangents[sides + 1, 2] = angle_cotangents(
            X[j, 0], X[j, 1], X[j, 2], X[i, 0], X[i, 1], X[i, 2], X[c, 0], X[c, 1], X[c, 2])


@compiled
def assemble(stencil, cotangents, S):
    """Fill the system S (ring_size, 6) complex of the ring vertices; returns the diagonal entry of k.

    Columns: DIAGONAL; NEXT, FIRST, LAST, K: the coupling to the next ring vertex, to the first, to the last, to k; RHS: the
    right-hand side.
    """
    ring_size, sides = stencil.ring_size, stencil.sides
    for q in range(ring_size):
        for s in range(6):
            S[q, s] = 0.0
    diagonal_k = 0.0
    for q in range(sides):
        p = next_on_ring(stencil, q)
        ca, cb, cc = cotangents[q, 0], cotangents[q, 1], cotangents[q, 2]  # owner, q, p
        S[q, DIAGONAL] += ca + cc
        S[p, DIAGONAL] += ca + cb
        S[q, NEXT] += complex(-ca, 1.0)
        if is_of_j(stencil, q):  # j = 1: owner -> q is counter-clockwise, p -> owner is
            S[q, RHS] -= complex(-cc, -1.0)
            S[p, RHS] -= complex(-cb, 1.0)
        ca, cb, cc = cotangents[sides + 2 + q, 0], cotangents[sides + 2 + q, 1], cotangents[sides + 2 + q, 2]
        S[q, DIAGONAL] += ca + cc
        S[p, DIAGONAL] += ca + cb
        S[q, NEXT] += complex(-ca, 1.0)
        S[q, K] += complex(-cc, -1.0)
        S[p, K] += complex(-cb, 1.0)
        diagonal_k += cb + cc
    p = third_vertex(stencil)  # face (i, j, p): j -> p is counter-clockwise
    S[p, DIAGONAL] += cotangents[sides, 0] + cotangents[sides, 1]
    S[p, RHS] -= complex(-cotangents[sides, 0], -1.0)
    if stencil.kind != EDGE:  # face (j, i, p): p -> j is counter-clockwise
        p = stencil.j_start
        S[p, DIAGONAL] += cotangents[sides + 1, 0] + cotangents[sides + 1, 1]
        S[p, RHS] -= complex(-cotangents[sides + 1, 1], 1.0)
    if stencil.kind == ANCHORED:  # k is i, at 0
        for q in range(ring_size):
            S[q, K] = 0.0
    return diagonal_k


@compiled
def eliminate(stencil, diagonal_k, S, B):
    """Eliminate all ring vertices but the first and the last (Gauss, for Hermitian systems) from S of `assemble`.

    B (3, 4) complex becomes the system of the first, the last and k, with the right-hand side in its last column.
    """
    last = stencil.ring_size - 1
    for a in range(3):
        for b in range(4):
            B[a, b] = 0.0
    B[0, 0], B[1, 1], B[2, 2] = S[0, DIAGONAL].real, S[last, DIAGONAL].real, diagonal_k
    B[0, 2], B[1, 2] = S[0, K], S[last, K]
    B[0, 3], B[1, 3] = S[0, RHS], S[last, RHS]
    if stencil.sides == stencil.ring_size:  # closed: last -> first
        B[1, 0] += S[last, NEXT]
    if stencil.ring_size == 2:
        B[1, 0] += S[0, NEXT].conjugate()
    else:
        S[1, FIRST] += S[0, NEXT].conjugate()
        S[last - 1, LAST] += S[last - 1, NEXT]
        for q in range(1, last):
            d = S[q, DIAGONAL].real
            f, g, h, w = S[q, FIRST] / d, S[q, LAST] / d, S[q, K] / d, S[q, RHS] / d
            fc, gc, hc = S[q, FIRST].conjugate(), S[q, LAST].conjugate(), S[q, K].conjugate()
            if q + 1 < last:
                nc = S[q, NEXT].conjugate()
                S[q + 1, DIAGONAL] -= nc * (S[q, NEXT] / d)
                S[q + 1, FIRST] -= nc * f
                S[q + 1, LAST] -= nc * g
                S[q + 1, K] -= nc * h
                S[q + 1, RHS] -= nc * w
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
def _solve_ends(B, straight, k_at, A):
    """Solve B for (first, last, k), those of `straight` real and k fixed if k_at >= 0, by Gauss; A (6, 7): the real system."""
    for a in range(3):
        for b in range(3):
            re, im = B[a, b].real, B[a, b].imag
            A[2 * a, 2 * b], A[2 * a, 2 * b + 1], A[2 * a + 1, 2 * b], A[2 * a + 1, 2 * b + 1] = re, -im, im, re
        A[2 * a, 6], A[2 * a + 1, 6] = B[a, 3].real, B[a, 3].imag
    for v in range(6):
        fixed, value = straight[v // 2] and v % 2 == 1, 0.0
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
def place(ring_size, work, straight, k_at):
    """Positions work.uv of the ring, i, j and k from the eliminated system; False if it is singular.

    straight: for the first ring vertex, the last and k, whether it is to lie on the line through i and j; k_at: where k lies
    on that line, or negative where it is free.
    """
    S, A, uv = work.ring_system, work.real_system, work.uv
    if not _solve_ends(work.end_system, straight, k_at, A):
        return False
    first, last, k = complex(A[0, 6], A[1, 6]), complex(A[2, 6], A[3, 6]), complex(A[4, 6], A[5, 6])
    uv[0], uv[ring_size - 1], uv[ring_size], uv[ring_size + 1], uv[ring_size + 2] = first, last, 0.0, 1.0, k
    for q in range(ring_size - 2, 0, -1):
        s = S[q, RHS] - S[q, FIRST] * first - S[q, LAST] * last - S[q, K] * k
        if q + 1 < ring_size - 1:
            s -= S[q, NEXT] * uv[q + 1]
        uv[q] = s / S[q, DIAGONAL].real
    return True
