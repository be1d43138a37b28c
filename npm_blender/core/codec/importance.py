"""Order of importance of the features (paper section 3.3 and its appendix A).

A feature is a latent: one face's vector of 8 numbers at one level. Faces of levels 0..L-1 are numbered one level after the
other: number = first number of the level + face.
"""

import numpy as np

from ..mesh import Level


def first_numbers(levels: list[Level]) -> np.ndarray:
    """Number of the first feature of each level, and the total, (L + 1,) int64, for levels 0..L-1."""
    return np.concatenate([[0], np.cumsum([len(level.F) for level in levels])])


def split_numbers(number: np.ndarray, levels: list[Level]) -> tuple[np.ndarray, np.ndarray]:
    """Level (k,) uint8 and face (k,) int32 of feature numbers (k,)."""
    first = first_numbers(levels)
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
