"""Order of importance of the features (paper section 3.3 and its appendix A).

A feature is one face's vector of 8 numbers at one level. Features of levels 0..L-1 are numbered one level after the
other: number = offset of the level + face.
"""

import numpy as np

from .subdivide import Level

STAGES = (40, 400, 1500)  # features at the ends of the stages in which they are ordered and fitted; the last has the rest
ROUNDS = 2  # of the mean over a face and its neighbours, which makes regions of base faces


def offsets(levels: list[Level]) -> np.ndarray:
    """Number of the first feature of each level, and the total, (L + 1,) int64, for levels 0..L-1."""
    return np.concatenate([[0], np.cumsum([len(level.F) for level in levels])])


def split(number: np.ndarray, levels: list[Level]) -> tuple[np.ndarray, np.ndarray]:
    """Level (k,) uint8 and face (k,) int32 of feature numbers (k,)."""
    first = offsets(levels)
    level = np.searchsorted(first, number, side="right") - 1
    return level.astype(np.uint8), (number - first[level]).astype(np.int32)


def magnitude_order(values: np.ndarray) -> np.ndarray:
    """Numbers of the features (k, 8) that are not zero, the largest Euclidean norm first; ties in order of number."""
    norm = np.linalg.norm(values.astype(np.float64), axis=1)
    order = np.argsort(-norm, kind="stable")
    return order[norm[order] > 0]


def gain_order(values: np.ndarray, gains: np.ndarray) -> np.ndarray:
    """Numbers of the features (k, 8) that are not zero, the largest measured gain (k,) first; ties in order of number."""
    order = np.argsort(-gains, kind="stable")
    return order[(values[order] != 0).any(1)]


def _regional(values: np.ndarray, level: Level) -> np.ndarray:
    """Values of faces (m,), averaged over their neighbourhood."""
    neighbours = level.opposite.reshape(-1, 3) // 3
    for _ in range(ROUNDS):
        values = (values + values[neighbours].sum(1)) / 4
    return values


def measured_gains(errors: list[np.ndarray], levels: list[Level]) -> np.ndarray:
    """Reconstruction gain of every feature, (k,) float64, from decodes of growing sets of features.

    errors: per face of the finest level, error times area of the decode with the features of no level, of level
    0, of levels 0 and 1, ... (L + 1 arrays of (m_L,)). A feature moves the surface over its own face, so its gain is what the
    features of its level save there; a parent counts at least as much as its best child, which builds on it.
    """
    gains = []
    for i, level in enumerate(levels):
        gains.append((errors[i] - errors[i + 1]).reshape(len(level.F), -1).sum(1))
    for i in range(len(gains) - 2, -1, -1):
        gains[i] = np.maximum(gains[i], gains[i + 1].reshape(len(gains[i]), 4).max(1) * (1 + 1e-9))
    return np.concatenate(gains)


def staged_order(values: np.ndarray, errors: list[np.ndarray], levels: list[Level]) -> np.ndarray:
    """Numbers of the features (k, 8) that are not zero, by measured gain, and region by region within the second stage.

    Neighbours are fitted together, and half of them alone can be worse than none. The second stage holds most base
    faces, so those come region by region: first where all features together save most on a base face and round it.
    """
    first, second = STAGES[:2]
    order = gain_order(values, measured_gains(errors, levels))
    saved = _regional((errors[0] - errors[-1]).reshape(len(levels[0].F), -1).sum(1), levels[0])
    level, face = split(order[first:second], levels)
    by_region = np.argsort(-saved[face // 4 ** level.astype(np.int64)], kind="stable")
    return np.concatenate([order[:first], order[first:second][by_region], order[second:]])
