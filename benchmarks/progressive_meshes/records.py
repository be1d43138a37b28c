"""Vertex splits as bits: which vertices, at which of their neighbours, and where the two vertices go.

A batch visits the vertices that are there when it begins. Neighbours of one that was split are not split in the same
batch and cost nothing. Places are coded against what the neighbours suggest, in a frame of the surface normal and of the
direction from one new vertex to the other; along the surface in steps `tangent` times as long. A batch with finer steps
than the one before corrects each vertex that it does not split along the normal.
"""

import numpy as np

from npm_blender.core.bitstream import ENCODE, MODE, code_bit, code_raw, code_signed, code_unsigned
from npm_blender.core.jit import compiled

from .mesh import MAX_RING, ring_of, split

FINEST = 20  # steps are 2**-exponent, exponent up to here
_VALENCES, _SIZES, _BITS = 12, 16, 24
_FLAG = 0
_CUT = _FLAG + 4 * _VALENCES * 4 + 64
_KIND = _CUT + 16 * 16 * 3 + 16 * 16 * 3 + _VALENCES * 3
_PLACE = _KIND + 2
_SIGN = _PLACE + 6 * (_SIZES + 2 * _SIZES + 4) * _BITS
_FIX = _SIGN + 6 * 9 * 2
CONTEXTS = _FIX + 3 * 4 * 8 + 8
MIXERS = 1 + 3 + 1 + 6 * _BITS + 6 + 16


@compiled
def _length(v):
    out = 0
    while v > 0:
        out += 1
        v >>= 1
    return min(out, _BITS - 1)


@compiled
def _code_number(coder, x, c, size, before, other, lean):
    """An integer: how many bits, contexts by component and sizes; then the bits; then the sign, by the lean."""
    base = _PLACE + c * (_SIZES + 2 * _SIZES + 4) * _BITS
    i = base + min(size, _SIZES - 1) * _BITS
    j = base + (_SIZES + min(before, _SIZES - 1)) * _BITS
    k = base + (2 * _SIZES + min(other, _SIZES - 1)) * _BITS
    w = 5 + c * _BITS
    magnitude = abs(x)
    bits, t = _length(magnitude), 0
    while t < _BITS - 2:
        if code_bit(coder, 1 if bits > t else 0, i + t, j + t, k + t, w + t) == 0:
            break
        t += 1
    if t == 0:
        return 0
    out = (1 << (t - 1)) | code_raw(coder, magnitude, t - 1)
    s = _SIGN + c * 18
    if code_bit(coder, 1 if x < 0 else 0, s + lean, s + 9 + lean, s + lean, 5 + 6 * _BITS + c):
        return -out
    return out


@compiled
def _code_cuts(coder, m, ring, count, border, p, q):
    """Neighbours p < q of the split; p = -1 where the new edge is on the border."""
    rest = 2
    if border:
        if code_bit(coder, 1 if p < 0 else 0, _KIND, _KIND, _KIND, 4):
            rest = 1
    one, two = -1, -1
    for k in range(count):
        left = count - k
        hit = 1
        if left > rest:
            valence = min(m.valence[ring[k]], _VALENCES) - 1
            near = min(k - one, 15) if one >= 0 else min(left, 15)
            i = _CUT + (near * 16 + min(left, 15)) * 3 + rest
            j = _CUT + 768 + (min(count, 15) * 16 + min(k, 15)) * 3 + rest
            hit = code_bit(coder, 1 if k == p or k == q else 0, i, j, _CUT + 1536 + valence * 3 + rest, 1 + rest)
        if hit:
            rest -= 1
            if rest == 0:
                two = k
                break
            one = k
    return one, two


@compiled
def _unit(x, y, z):
    length = np.sqrt(x * x + y * y + z * z)
    if not length > 1e-30:
        return 0.0, 0.0, 0.0, 0.0
    return x / length, y / length, z / length, length


@compiled
def _normal(m, v, ring, faces, border):
    """Normal of the faces at v, zero if they cancel out; and the mean length of the edges there."""
    nx = ny = nz = total = 0.0
    count = faces + (1 if border else 0)
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
    return min(max(int(np.floor(2 * np.log2(x))) + 1, 0), _SIZES - 1)


@compiled(allocates=True)
def _code_places(coder, m, v, ring, count, faces, border, p, q, step, tangent, apart, vx, tx, seen):
    """Places of v and of the new vertex, vx and tx (3,): from them when sending, into them always."""
    X = m.X
    nx, ny, nz, edge = _normal(m, v, ring, faces, border)
    mid, mine = np.zeros(3), np.zeros(3)
    a = b = 0
    for k in range(count):
        inside = p <= k <= q
        for c in range(3):
            if inside:
                mid[c] += X[ring[k], c]
            if not inside or k == q or (k == p and p >= 0):
                mine[c] += X[ring[k], c]
        a += inside
        b += not inside or k == q or (k == p and p >= 0)
    height = 0.0
    d = np.zeros(3)
    for c in range(3):
        mid[c], mine[c] = mid[c] / a, mine[c] / b
        d[c] = mid[c] - mine[c]
        height += (X[v, c] - (mid[c] + mine[c]) / 2) * (nx if c == 0 else (ny if c == 1 else nz))
    along = d[0] * nx + d[1] * ny + d[2] * nz
    ex, ey, ez, reach = _unit(d[0] - along * nx, d[1] - along * ny, d[2] - along * nz)
    frame = np.zeros((3, 3))
    if reach > 0 and nx * nx + ny * ny + nz * nz > 0.5:
        frame[0, 0], frame[0, 1], frame[0, 2] = nx, ny, nz
        frame[1, 0], frame[1, 1], frame[1, 2] = ex, ey, ez
        frame[2, 0], frame[2, 1], frame[2, 2] = ny * ez - nz * ey, nz * ex - nx * ez, nx * ey - ny * ex
    else:
        frame[0, 0] = frame[1, 1] = frame[2, 2] = 1.0
    lean = 1 if abs(height) < 0.02 * edge else (2 if height > 0 else 0)
    size, flat = _half_octaves(edge / step), _half_octaves(abs(height) / step)
    half, middle = np.zeros(3), np.zeros(3)
    before = 0
    for r in range(6):
        c = r % 3
        scale = step if c == 0 else step * tangent
        want = 0.0
        if coder.rc[MODE] == ENCODE:
            for k in range(3):
                if r < 3:
                    want += frame[c, k] * ((vx[k] + tx[k]) / 2 - X[v, k])
                else:
                    want += frame[c, k] * (tx[k] - vx[k] - apart * d[k]) / 2
        x = int(np.rint(want / scale))
        number = _code_number(coder, x, r, size, min(2 * before + (seen[r] > 3), _SIZES - 1), flat, lean)
        for k in range(3):
            if r < 3:
                middle[k] += number * scale * frame[c, k]
            else:
                half[k] += number * scale * frame[c, k]
        before = _length(abs(number))
        seen[r] += (8 * before - seen[r]) >> 2
    for k in range(3):
        vx[k] = X[v, k] + middle[k] - half[k] - apart * d[k] / 2
        tx[k] = X[v, k] + middle[k] + half[k] + apart * d[k] / 2


@compiled(allocates=True)
def code_batches(coder, m, exponents, target, plan, ends, cuts, at, name, known, tangent, apart, limit, trace):
    """Code batches until `limit` vertices were visited; returns the visits.

    m: grows; exponents (batches,): steps, read from or written to; target: vertices at the end.
    Sender: plan (batches, c + 1): how many splits, then which rows of ends, cuts, at (see Collapses), or -1; name: number
    in m of each input vertex; known: the positions (n, 3) that the vertices of m should have.
    apart: of the vector between the means of both sides' neighbours, the vector expected between the vertices.
    trace (visits,): a hash of what was coded at each visit.
    """
    sending = coder.rc[MODE] == ENCODE
    ring, spoke = np.zeros(MAX_RING + 400_000, np.int32), np.zeros(MAX_RING + 400_000, np.int32)
    room = len(m.X)
    row, blocked, seen = np.full(room, -1, np.int64), np.full(room, -1, np.int64), np.zeros(6, np.int64)
    vx, tx = np.zeros(3), np.zeros(3)
    visits, last = 0, 0
    for b in range(len(exponents)):
        if sending:
            for k in range(plan[b, 0]):
                row[name[ends[plan[b, 1] + k, 0]]] = plan[b, 1] + k
        exponent = last + code_unsigned(coder, exponents[b] - last, _FIX + 96, _FIX + 96, _FIX + 96, 5 + 6 * _BITS + 6, 4)
        exponents[b] = min(exponent, FINEST)
        finer = b > 0 and exponents[b] > last
        last = exponents[b]
        step = 2.0**-last
        present = m.counts[0]
        streak = 0
        for v in range(present):
            if visits >= limit:
                return visits
            note = 0
            chosen = 0
            count = faces = 0
            border = False
            if blocked[v] != b and m.counts[0] < target and m.valence[v] < MAX_RING:
                count, faces, border = ring_of(m, v, ring, spoke)
                chosen = 1 if sending and row[v] >= 0 else 0
                if count >= (2 if border else 3):
                    valence = min(m.valence[v], _VALENCES) - 1
                    free = 0
                    for k in range(count):
                        free += ring[k] > v or blocked[ring[k]] != b
                    share = min(3, 4 * free // (count + 1))
                    f = _FLAG + ((2 if border else 0) * _VALENCES + valence) * 4 + share
                    g = _FLAG + 4 * _VALENCES * 4 + min(streak, 15)
                    chosen = code_bit(coder, chosen, f, g, _FLAG + 4 * _VALENCES * 4 + 16 + valence, 0)
                    streak = 0 if chosen else streak + 1
                else:
                    chosen = 0
            if chosen:
                c, p, q, turned = 0, -1, -1, False
                if sending:
                    c = row[v]
                    for k in range(count):
                        if cuts[c, 0] >= 0 and ring[k] == name[cuts[c, 0]]:
                            p = k
                        if ring[k] == name[cuts[c, 1]]:
                            q = k
                    turned = p > q and not border
                    if turned:
                        p, q = q, p
                    for k in range(3):
                        vx[k], tx[k] = at[c, 1 if turned else 0, k], at[c, 0 if turned else 1, k]
                p, q = _code_cuts(coder, m, ring, count, border, p, q)
                if sending:
                    i, j = (1, 0) if turned else (0, 1)
                    for k in range(3):
                        known[v, k], known[m.counts[0], k] = vx[k], tx[k]
                    name[ends[c, i]], name[ends[c, j]] = v, m.counts[0]
                    row[v] = -1
                _code_places(coder, m, v, ring, count, faces, border, p, q, step, tangent, apart, vx, tx, seen)
                t = split(m, v, ring, spoke, faces, border, p, q)
                for k in range(3):
                    m.X[v, k], m.X[t, k] = vx[k], tx[k]
                for k in range(count):
                    blocked[ring[k]] = b
                blocked[v] = blocked[t] = b
                note = 7 + p + 64 * q + 4096 * int(np.rint((vx[0] + 2 * vx[1] + 3 * vx[2] + tx[0]) / step))
            elif finer:
                count, faces, border = ring_of(m, v, ring, spoke)
                nx, ny, nz, _ = _normal(m, v, ring, faces, border)
                want = 0.0
                if sending:
                    want = nx * (known[v, 0] - m.X[v, 0]) + ny * (known[v, 1] - m.X[v, 1]) + nz * (known[v, 2] - m.X[v, 2])
                i = _FIX + min(exponents[b] - exponents[b - 1], 3) * 8
                move = code_signed(coder, int(np.rint(want / step)), i, i, i, 5 + 6 * _BITS + 6 + 4, 6)
                m.X[v, 0] += nx * step * move
                m.X[v, 1] += ny * step * move
                m.X[v, 2] += nz * step * move
                note = 8 * move + 1
            trace[visits] = note
            visits += 1
    return visits
