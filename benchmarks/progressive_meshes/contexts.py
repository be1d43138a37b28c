"""Which rows of the coder's contexts and mixers belong to what: the first of each kind."""

VALENCES, SIZES, BITS = 12, 16, 24  # how many valences, sizes and lengths of numbers are told apart
# first contexts of each kind
FLAG = 0
STREAK = FLAG + 4 * VALENCES * 4
CUT = STREAK + 64
KIND = CUT + 16 * 16 * 3 + 16 * 16 * 3 + VALENCES * 3
PLACE = KIND + 2
SIGN = PLACE + 6 * (SIZES + 2 * SIZES + 4) * BITS
FIX = SIGN + 6 * 9 * 2
EXPONENT = FIX + 3 * 4 * 8
CONTEXTS = EXPONENT + 8
# first mixers of each kind
MIX_FLAG = 0
MIX_CUT = 1
MIX_KIND = 4
MIX_PLACE = 5
MIX_SIGN = MIX_PLACE + 6 * BITS
MIX_EXPONENT = MIX_SIGN + 6
MIX_FIX = MIX_EXPONENT + 4
MIXERS = MIX_FIX + 12
