"""Tables of the logistic function, of its inverse and of reciprocals, in fixed point: part of the format."""
import numpy as np

MAX_COUNT = 1023            # of the bits that a context has seen

# 65536 / (1 + exp(-x / 256)) at x = -2048, -1920, .., 2048; part of the format.
_KNOTS = (22, 36, 60, 98, 162, 267, 439, 720, 1179, 1921, 3108, 4971, 7812, 11955, 17625, 24743, 32768, 40793, 47911,
          53581, 57724, 60565, 62428, 63615, 64357, 64816, 65097, 65269, 65374, 65438, 65476, 65500, 65514)


def _squash_table() -> np.ndarray:
    """squash(x) for x = -2048..2047, 16-bit probabilities (4096,) int64: the knots, joined by straight lines."""
    x = np.arange(4096, dtype=np.int64)
    knots = np.array(_KNOTS, dtype=np.int64)
    i, t = x >> 7, x & 127
    return (knots[i] * (128 - t) + knots[i + 1] * t + 64) >> 7


def _stretch_table(squash: np.ndarray) -> np.ndarray:
    """stretch(p) for the 4096 values of p >> 10: the least x with squash(x) >= the middle of the bin, -2048..2047."""
    middle = np.arange(4096, dtype=np.int64) * 16 + 8
    return np.minimum(np.searchsorted(squash, middle), 4095).astype(np.int64) - 2048


SQUASH = _squash_table()
STRETCH = _stretch_table(SQUASH)
RECIPROCAL = 65536 // (np.arange(MAX_COUNT + 1, dtype=np.int64) + 2)
