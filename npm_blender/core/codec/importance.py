"""Order of importance of the features (paper section 3.3 and its appendix A).

Latents come first: a latent is one face's vector of 8 numbers at one level. Offsets follow: a feature of offsets is
what one face's edges are moved by. Faces of levels 0..L-1 are numbered one level after the other: number = first number
of the level + face.
"""

import numpy as np

from ..mesh import Level

LATENTS = 40  # that are sent at most; after them offsets save more for each byte


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


def offset_order(offsets: list[np.ndarray], errors: list[np.ndarray], levels: list[Level]) -> np.ndarray:
    """Numbers of the faces that have an offset to send, by what they save for each bit that they are about to cost.

    offsets: integers (e_i,) per level; errors: as for `measured_gains`, of decodes with the offsets of no level, of level
    0, of levels 0 and 1, ...
    """
    sizes = np.concatenate([np.abs(o)[level.edge_of].reshape(-1, 3) for o, level in zip(offsets, levels, strict=True)])
    bits = (1 + 2 * np.log2(1 + sizes)).sum(1)
    order = np.argsort(-measured_gains(errors, levels) / bits, kind="stable")
    return order[(sizes[order] > 0).any(1)]


def edge_ranks(order: np.ndarray, levels: list[Level]) -> list[np.ndarray]:
    """Rank of the first face of each edge in an order of faces, (e_i,) per level; len(order) where none has it."""
    rank = np.full(first_numbers(levels)[-1], len(order))
    rank[order] = np.arange(len(order))
    out = []
    for own, level in zip(np.split(rank, first_numbers(levels)[1:-1]), levels, strict=True):
        a, b = level.edge_halfedge.T
        out.append(np.minimum(own[a // 3], own[b // 3]))
    return out


def carriers(order: np.ndarray, offsets: list[np.ndarray], levels: list[Level]) -> np.ndarray:
    """`order` without the faces whose edges are zero, or are all on faces before them. offsets: as for `offset_order`."""
    rank = np.full(first_numbers(levels)[-1], len(order))
    rank[order] = np.arange(len(order))
    first = np.concatenate([r[level.edge_of] for r, level in zip(edge_ranks(order, levels), levels, strict=True)])
    sent = np.concatenate([o[level.edge_of] != 0 for o, level in zip(offsets, levels, strict=True)])
    brings = (sent & (first == np.repeat(rank, 3))).reshape(-1, 3).any(1)
    return order[brings[order]]


def offset_values(offsets: list[np.ndarray], levels: list[Level], channels: int) -> np.ndarray:
    """The features (k, channels) of the offsets of all faces: one number for each half-edge, then zeros."""
    edges = [o[level.edge_of].reshape(-1, 3) for o, level in zip(offsets, levels, strict=True)]
    return np.pad(np.concatenate(edges), ((0, 0), (0, channels - 3)))
