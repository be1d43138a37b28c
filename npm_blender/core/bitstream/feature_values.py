"""The quantized numbers of a feature, with contexts from what is known around it.

A latent feature is one number per channel; contexts come from the same vector, the parent and the neighbours. A feature
of offsets has one number for each edge of its face; an edge that a face across it sent before is known and costs
nothing. Contexts of a magnitude: what lies on the edges known in this face, and on those of the faces around and of the
parent; of a sign: the signs there, and on the half of the parent's edge that this one is a part of.
"""
from typing import NamedTuple

from ..jit import njit
from .range_coder import code_bit, code_signed, code_unsigned
from .significance import parent_row

LIMIT = 14                      # magnitudes by context up to here, above Exp-Golomb
STRIDE = LIMIT + 1
LEVELS, CHANNELS = 6, 32        # levels and channels that have contexts of their own
_OWN = LEVELS * CHANNELS
_AROUND = _OWN + 12 * CHANNELS
COUNT = _AROUND + 12 * 20       # row of the contexts of the counts of a packet
_EDGE = COUNT + LEVELS          # rows of the offsets: by level and kind of edge,
_EDGE_OWN = _EDGE + 2 * LEVELS  # by what is known in the face,
_EDGE_AROUND = _EDGE_OWN + 12 * LEVELS  # by what is known around it;
_SIGN = _EDGE_AROUND + 12 * 20  # three contexts by level and sign, one row per sixteen of them
ROWS = _SIGN + 12
CONTEXTS = ROWS * STRIDE
MIXERS = 4 * STRIDE             # latents, counts, offsets, their signs


class _Known(NamedTuple):
    """What is known of the offsets around a face before it is coded.

    carried: bit t is set if the face across edge t sent it; own, own_signed, count: sum of the magnitudes of those, of their
    values, and how many; around, signed, known: the same of all edges of the faces across and of the parent; parent: row of
    the parent's feature, or -1.
    """

    carried: int
    own: int
    own_signed: int
    count: int  # type: ignore[assignment]  # a field, which hides tuple.count
    around: int
    signed: int
    known: int
    parent: int


@njit
def _bits(value):
    """Length of value in binary, 0 for 0."""
    out = 0
    while value > 0:
        out += 1
        value >>= 1
    return out


@njit
def _sign(value):
    """0, 1, 2 for none, positive, negative."""
    return 0 if value == 0 else 1 if value > 0 else 2


@njit
def code_latent(coder, faces, sent, typical, value, group, g, row):
    """The integers of the latent feature of face g, value[row]."""
    own, lv = 0, min(group, LEVELS - 1)
    parent = parent_row(faces, sent, group, g)
    for c in range(value.shape[1]):
        around, known = 0, 0
        for t in range(3):
            o = sent.row[faces.twin[3 * g + t] // 3] - 1
            if o >= 0 and o < row:
                around += abs(value[o, c])
                known += 1
        if parent >= 0:
            around += abs(value[parent, c])
            known += 1
        # around: 0 nothing known, else 1 + size of the doubled mean
        near = min(1 + _bits(2 * around // known), 11) if known > 0 else 0
        i = (lv * CHANNELS + c) * STRIDE
        j = (_OWN + min(_bits(own), 11) * CHANNELS + c) * STRIDE
        k = (_AROUND + near * 20 + min(_bits(typical[group, c]), 19)) * STRIDE
        v = code_signed(coder, value[row, c], i, j, k, 0, LIMIT)
        value[row, c] = v
        own += abs(v)
        typical[group, c] += ((abs(v) << 8) - typical[group, c]) >> 4


@njit
def _known_offsets(faces, sent, value, group, g, row):
    """What is known before face g is coded; the offsets that faces across its edges sent before are put into value[row]."""
    around, signed, known = 0, 0, 0
    own, own_signed, count, carried = 0, 0, 0, 0
    for t in range(3):
        twin = faces.twin[3 * g + t]
        o = sent.row[twin // 3] - 1
        if twin != 3 * g + t and o >= 0 and o < row:
            carried |= 1 << t
            value[row, t] = value[o, twin % 3]
            own += abs(value[row, t])
            own_signed += value[row, t]
            count += 1
            for s in range(3):
                around += abs(value[o, s])
                signed += value[o, s]
            known += 3
    parent = parent_row(faces, sent, group, g)
    if parent >= 0:
        for s in range(3):
            around += abs(value[parent, s])
            signed += value[parent, s]
        known += 3
    return _Known(carried, own, own_signed, count, around, signed, known, parent)


@njit
def _place_in_parent(value, level, child, parent, t):
    """Kind of edge t of a face, 0 for a half of one of the parent's edges and 1 for one inside it; the offset of that edge.

    child: 0..3 in the parent, 3 the middle one; the offset is 0 where it is unknown, or there is none.
    """
    if level == 0 or child == 3 or t == 1:
        return 1, 0
    if parent < 0:
        return 0, 0
    return 0, value[parent, child if t == 0 else (child + 2) % 3]


@njit
def code_offsets(coder, faces, sent, typical, value, group, g, row):
    """The integers on the three edges of face g, value[row]; what the faces across them sent before is filled in."""
    level, again = group % faces.levels, group >= 2 * faces.levels
    lv = min(level, 2) + 3 * again  # three levels of the first pass, three of later ones
    known = _known_offsets(faces, sent, value, group, g, row)
    own, own_signed, count = known.own, known.own_signed, known.count
    near = min(1 + _bits(4 * known.around // known.known), 11) if known.known > 0 else 0
    for t in range(3):
        if known.carried >> t & 1:
            continue
        kind, above = _place_in_parent(value, level, (g - faces.first[group]) % 4, known.parent, t)
        within = min(1 + _bits(4 * own // count), 11) if count > 0 else 0
        i = (_EDGE + 2 * lv + kind) * STRIDE
        j = (_EDGE_OWN + 12 * lv + within) * STRIDE
        k = (_EDGE_AROUND + near * 20 + min(_bits(typical[group, 0]), 19)) * STRIDE
        size = code_unsigned(coder, abs(value[row, t]), i, j, k, 2 * STRIDE, LIMIT)
        v = size
        if size > 0:
            a, b, c = 3 * lv + _sign(own_signed), 3 * lv + _sign(known.signed), 3 * lv + _sign(above)
            first = _SIGN * STRIDE
            if code_bit(coder, 1 if value[row, t] < 0 else 0, first + a, first + 20 + b, first + 40 + c, 3 * STRIDE):
                v = -size
        value[row, t] = v
        own += size
        own_signed += v
        count += 1
        typical[group, 0] += ((size << 8) - typical[group, 0]) >> 5
    for t in range(3, value.shape[1]):
        value[row, t] = 0
