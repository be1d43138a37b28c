"""Where the two vertices of a split go, as bits.

Places are coded against what the neighbours suggest, in a frame of the surface normal and of the direction from one new
vertex to the other; along the surface in steps TANGENT times as long.
"""

import numpy as np

from npm_blender.core.bitstream import ENCODE, MODE, code_bit, code_raw
from npm_blender.core.jit import compiled

from .contexts import BITS, MIX_PLACE, MIX_SIGN, PLACE, SIGN, SIZES

TANGENT = 2.5  # steps along the surface, in steps along the normal
APART = 0.5  # of the vector between the means of both sides' neighbours, the vector expected between the vertices


@compiled
def _length(v):
    out = 0
    while v > 0:
        out += 1
        v >>= 1
    return min(out, BITS - 1)


@compiled
def _code_number(coder, x, c, size, before, other, lean):
    """An integer: how many bits, contexts by component and sizes; then the bits; then the sign, by the lean."""
    base = PLACE + c * (SIZES + 2 * SIZES + 4) * BITS
    i = base + min(size, SIZES - 1) * BITS
    j = base + (SIZES + min(before, SIZES - 1)) * BITS
    k = base + (2 * SIZES + min(other, SIZES - 1)) * BITS
    w = MIX_PLACE + c * BITS
    magnitude = abs(x)
    bits, t = _length(magnitude), 0
    while t < BITS - 2:
        if code_bit(coder, 1 if bits > t else 0, i + t, j + t, k + t, w + t) == 0:
            break
        t += 1
    if t == 0:
        return 0
    out = (1 << (t - 1)) | code_raw(coder, magnitude, t - 1)
    s = SIGN + c * 18
    if code_bit(coder, 1 if x < 0 else 0, s + lean, s + 9 + lean, s + lean, MIX_SIGN + c):
        return -out
    return out


@compiled
def _unit(x, y, z):
    length = np.sqrt(x * x + y * y + z * z)
    if not length > 1e-30:
        return 0.0, 0.0, 0.0, 0.0
    return x / length, y / length, z / length, length


@compiled
def normal_at(m, site):
    """Normal of the faces at a vertex, zero if they cancel out; and the mean length of the edges there."""
    nx = ny = nz = total = 0.0
    v, ring, faces = site.v, site.ring, site.faces
    count = faces + (1 if site.border else 0)
    X = m.X
    for k in range(faces):
        a, b = ring[k], ring[k + 1 if k + 1 < count else 0]
        ux, uy, uz = X[a, 0] - X[v, 0], X[a, 1] - X[v, 1], X[a, 2] - X[v, 2]
        wx, wy, wz = X[b, 0] - X[v, 0], X[b, 1] - X[v, 1], X[b, 2] - X[v, 2]
        nx, ny, nz = nx + uy * wz - uz * wy, ny + uz * wx - ux * wz, nz + ux * wy - uy * wx
        total += np.sqrt(ux * ux + uy * uy + uz * uz)
    nx, ny, nz, _ = _unit(nx, ny, nz)
    return nx, ny, nz, total / max(faces, 1)


@compiled
def _half_octaves(x):
    """Size of a length in steps."""
    if not x > 1e-9:
        return 0
    return min(max(int(np.floor(2 * np.log2(x))) + 1, 0), SIZES - 1)


@compiled
def _side_means(X, site, p, q, new_side, kept_side):
    """Into new_side (3,) the mean of neighbours p..q, which the new vertex will have; into kept_side that of v's own.

    The neighbours p and q are on both sides.
    """
    a = b = 0
    for k in range(site.count):
        inside = p <= k <= q
        on_kept_side = not inside or k == q or (k == p and p >= 0)
        for c in range(3):
            if inside:
                new_side[c] += X[site.ring[k], c]
            if on_kept_side:
                kept_side[c] += X[site.ring[k], c]
        a += inside
        b += on_kept_side
    for c in range(3):
        new_side[c], kept_side[c] = new_side[c] / a, kept_side[c] / b


@compiled
def _set_frame(frame, nx, ny, nz, d):
    """Into the rows of frame (3, 3): the normal, the part of d along the surface, both of length 1, and their product.

    The axes of space where one of them is zero.
    """
    along = d[0] * nx + d[1] * ny + d[2] * nz
    ex, ey, ez, reach = _unit(d[0] - along * nx, d[1] - along * ny, d[2] - along * nz)
    if reach > 0 and nx * nx + ny * ny + nz * nz > 0.5:
        frame[0, 0], frame[0, 1], frame[0, 2] = nx, ny, nz
        frame[1, 0], frame[1, 1], frame[1, 2] = ex, ey, ez
        frame[2, 0], frame[2, 1], frame[2, 2] = ny * ez - nz * ey, nz * ex - nx * ez, nx * ey - ny * ex
    else:
        frame[0, 0] = frame[1, 1] = frame[2, 2] = 1.0


@compiled(allocates=True)
def code_places(coder, m, site, p, q, step, state):
    """Places of v and of the new vertex, kept and new of `state` (records.State): from them when sending, into them always."""
    X, v, kept, new, seen = m.X, site.v, state.kept, state.new, state.seen
    nx, ny, nz, edge = normal_at(m, site)
    new_side, kept_side, d, frame = np.zeros(3), np.zeros(3), np.zeros(3), np.zeros((3, 3))
    _side_means(X, site, p, q, new_side, kept_side)
    height = 0.0
    for c in range(3):
        d[c] = new_side[c] - kept_side[c]
        height += (X[v, c] - (new_side[c] + kept_side[c]) / 2) * (nx if c == 0 else (ny if c == 1 else nz))
    _set_frame(frame, nx, ny, nz, d)
    lean = 1 if abs(height) < 0.02 * edge else (2 if height > 0 else 0)
    size, flat = _half_octaves(edge / step), _half_octaves(abs(height) / step)
    half, middle = np.zeros(3), np.zeros(3)
    before = 0
    for r in range(6):
        c = r % 3
        scale = step if c == 0 else step * TANGENT
        want = 0.0
        if coder.rc[MODE] == ENCODE:
            for k in range(3):
                if r < 3:
                    want += frame[c, k] * ((kept[k] + new[k]) / 2 - X[v, k])
                else:
                    want += frame[c, k] * (new[k] - kept[k] - APART * d[k]) / 2
        x = int(np.rint(want / scale))
        number = _code_number(coder, x, r, size, min(2 * before + (seen[r] > 3), SIZES - 1), flat, lean)
        for k in range(3):
            if r < 3:
                middle[k] += number * scale * frame[c, k]
            else:
                half[k] += number * scale * frame[c, k]
        before = _length(abs(number))
        seen[r] += (8 * before - seen[r]) >> 2
    for k in range(3):
        kept[k] = X[v, k] + middle[k] - half[k] - APART * d[k] / 2
        new[k] = X[v, k] + middle[k] + half[k] + APART * d[k] / 2
