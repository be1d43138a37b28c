"""Creases and corners of a base, given its faces and positions: a decision for each edge and for each vertex of a line.

Contexts are the angle at which the faces of an edge meet and the creases so far at its ends; of a vertex, the angle by which
its line turns, and whether it is a border. Angles are found in float64 by + - * / and square roots alone, one element at a
time, which IEEE 754 fixes; sums over a vertex are in the order of its edges.
"""
import numpy as np

from ..jit import njit
from ..mesh import Level, Sharp, turns
from .range_coder import Coder, code_bit, finish_encoding, new_contexts, new_weights, range_decoder, range_encoder

_FOLDS = (0.9962, 0.9848, 0.9397, 0.866, 0.766, 0.5736, 0.1736)  # cosines of 5, 10, 20, 30, 40, 55, 80 degrees
_TURNS = (0.0685, 0.1874, 0.4679, 1.0, 1.653)  # 4 sin(a / 2)^2 of 15, 25, 40, 60, 80 degrees
_ENDS = 9
_BY_BOTH, _BY_ENDS = len(_FOLDS) + 1, (len(_FOLDS) + 1) * (1 + _ENDS)
_CORNERS = _BY_ENDS + _ENDS
_ROWS = _CORNERS + 2 * (len(_TURNS) + 1)
_REMEMBER = 60


def _folds(grid: np.ndarray, level: Level) -> np.ndarray:
    """Class (e,) int64 of the angle between the faces at each edge; 0 for flat ones and borders."""
    X = grid.astype(np.float64)
    a, b, c = (X[level.F[:, k]] for k in range(3))
    u, v = b - a, c - a
    x = u[:, 1] * v[:, 2] - u[:, 2] * v[:, 1]
    y = u[:, 2] * v[:, 0] - u[:, 0] * v[:, 2]
    z = u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]
    length = np.maximum(np.sqrt(x * x + y * y + z * z), 1e-300)
    x, y, z = x / length, y / length, z / length
    left, right = level.edge_halfedge[:, 0] // 3, level.edge_halfedge[:, 1] // 3
    cosine = x[left] * x[right] + y[left] * y[right] + z[left] * z[right]
    return (cosine[:, None] < np.array(_FOLDS)).sum(1)


@njit
def _code_edges(coder, edges, border, fold, met, sharp):
    """Whether each inner edge is a crease, into or from sharp (e,); met (n,): creases so far at each vertex."""
    for e in range(len(edges)):
        if border[e]:
            continue
        a, b = edges[e, 0], edges[e, 1]
        ends = 3 * min(met[a], 2) + min(met[b], 2)
        i, j, k = fold[e], _BY_BOTH + fold[e] * _ENDS + ends, _BY_ENDS + ends
        sharp[e] = code_bit(coder, sharp[e], i, j, k, 0)
        met[a] += sharp[e]
        met[b] += sharp[e]


@njit
def _code_corners(coder, vertices, row, corner):
    """Whether each vertex of a line is a corner, into or from corner (n,); row (n,): its context."""
    for v in vertices:
        c = row[v]
        corner[v] = code_bit(coder, corner[v], c, c, c, 1)


def _code(coder: Coder, grid: np.ndarray, level: Level, edges: np.ndarray, corners: np.ndarray) -> Sharp:
    border = level.edge_halfedge[:, 0] == level.edge_halfedge[:, 1]
    _code_edges(coder, level.edges.astype(np.int64), border.astype(np.int64), _folds(grid, level), np.zeros(level.n, np.int64),
                edges)
    found = Sharp(edges.astype(bool), corners.astype(bool))
    ends = level.edges[found.lines(level)]
    at_border = np.zeros(level.n, np.int64)
    at_border[level.edges[border].reshape(-1)] = 1
    row = _CORNERS + 2 * (turns(grid, ends)[:, None] > np.array(_TURNS)).sum(1) + at_border
    _code_corners(coder, np.flatnonzero(np.bincount(ends.reshape(-1), minlength=level.n) == 2), row, corners)
    return found._replace(corners=corners.astype(bool))


def encode_sharp(sharp: Sharp | None, grid: np.ndarray, level: Level) -> bytes:
    """Bytes of the creases and corners of a base; none where nothing is sharp.

    level: the base; grid (n0, 3) int64: its lattice positions. Corners are those of vertices where two lines meet.

    >>> import numpy as np
    >>> from npm_blender.core.bitstream import decode_sharp, encode_sharp
    >>> from npm_blender.core.mesh import Level, Sharp
    >>> roof, grid = Level.of(np.array([[0, 1, 2], [0, 3, 1]]), 4), np.array([[0, 9, 4], [9, 9, 4], [0, 0, 0], [0, 18, 0]])
    >>> data = encode_sharp(Sharp(np.array([True, False, False, False, False]), np.zeros(4, bool)), grid, roof)
    >>> decode_sharp(data, grid, roof).edges.tolist()
    [True, False, False, False, False]
    """
    if sharp is None or not (sharp.edges.any() or sharp.corners.any()):
        return b""
    coder = range_encoder(new_contexts(_ROWS, _REMEMBER), new_weights(2), 64 + 2 * (len(sharp.edges) + level.n))
    _code(coder, grid, level, sharp.edges.astype(np.int64), sharp.corners.astype(np.int64))
    return finish_encoding(coder) or b"\0"  # all sharp may leave no byte, but none says that nothing is


def decode_sharp(data: bytes, grid: np.ndarray, level: Level) -> Sharp | None:
    """Creases and corners from the bytes of `encode_sharp`; grid, level: as there.

    >>> import numpy as np
    >>> from npm_blender.core.bitstream import decode_sharp
    >>> from npm_blender.core.mesh import Level
    >>> decode_sharp(b"", np.zeros((3, 3), np.int64), Level.of(np.array([[0, 1, 2]]), 3)) is None
    True
    """
    if not data:
        return None
    coder = range_decoder(new_contexts(_ROWS, _REMEMBER), new_weights(2), data)
    return _code(coder, grid, level, np.zeros(len(level.edges), np.int64), np.zeros(level.n, np.int64))
