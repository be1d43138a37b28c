"""The quantized numbers of a feature, one per channel; contexts come from the same vector, the parent and the neighbours."""
from ..jit import njit
from .range_coder import code_signed
from .significance import parent_row

LIMIT = 14                      # magnitudes by context up to here, above Exp-Golomb
STRIDE = LIMIT + 1
LEVELS, CHANNELS = 6, 32        # levels and channels that have contexts of their own
_OWN = LEVELS * CHANNELS
_AROUND = _OWN + 12 * CHANNELS
COUNT = _AROUND + 12 * 20       # row of the contexts of the counts of a packet
CONTEXTS = (COUNT + LEVELS) * STRIDE
MIXERS = 2 * STRIDE             # latents, counts


@njit
def _bits(value):
    """Length of value in binary, 0 for 0."""
    out = 0
    while value > 0:
        out += 1
        value >>= 1
    return out


@njit
def code_latent(coder, faces, sent, typical, value, level, g, row):
    """The integers of the latent feature of face g, value[row]."""
    own, lv = 0, min(level, LEVELS - 1)
    parent = parent_row(faces, sent, level, g)
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
        k = (_AROUND + near * 20 + min(_bits(typical[level, c]), 19)) * STRIDE
        v = code_signed(coder, value[row, c], i, j, k, 0, LIMIT)
        value[row, c] = v
        own += abs(v)
        typical[level, c] += ((abs(v) << 8) - typical[level, c]) >> 4
