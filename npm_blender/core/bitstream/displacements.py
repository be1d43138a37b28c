"""Integers of all vertices, stage by stage, to bytes and back; any prefix of the bytes decodes.

A stage holds one integer per vertex, level by level; the step halves from stage to stage, so an integer starts out as
twice its value of the stage before, and its change is coded. A level in which nothing changes in a stage is one bit.
Contexts are the integers around: on the other edges of the two faces at the parent edge (new ones where they came before,
else those of the last stage), at the edge's ends and at the apexes.
"""
from typing import NamedTuple

import numpy as np

from ..jit import njit
from ..mesh import Level
from .range_coder import (
    DECODE,
    END,
    LOW,
    MODE,
    POSITION,
    RANGE,
    Coder,
    code_bit,
    code_signed,
    code_unsigned,
    new_contexts,
    new_weights,
    range_decoder,
    range_encoder,
)

_AHEAD = 4  # bytes that a reader has looked at before it decides anything
GROUP = 32  # numbers between two entries of `Displacements.ends`
_LIMIT = 14
_STRIDE = _LIMIT + 1
_LEVELS, _SIZES = 9, 8  # levels 0..MAX_LEVELS of a stream; classes of sizes
_FRESH_J = _LEVELS * _SIZES
_FRESH_K = 2 * _LEVELS * _SIZES
_AGAIN = _FRESH_K + _SIZES * _SIZES
_SIGNS = (_AGAIN + 2 * _LEVELS * 4 + 4 * _SIZES) * _STRIDE
_SKIP = _SIGNS + _LEVELS * 9 + 3 * 27
_CONTEXTS = _SKIP + _LEVELS
_MIXERS = 2 * _STRIDE * _LEVELS + 2 * _LEVELS


class Coded(NamedTuple):
    """Integers as far as they have arrived.

    table (stages, n) int64: of every vertex after each stage, twice the value of the stage before where none has arrived;
    coded (stages, levels + 1) bool: the levels of a stage in which numbers are sent; numbers: how many of these have arrived,
    stage by stage, level by level; ends (g + 1,) int64: bytes that the first 0, `group`, 2 `group`, .. and all of them take.
    """

    table: np.ndarray
    coded: np.ndarray
    numbers: int
    ends: np.ndarray
    group: int = GROUP


def around(hierarchy: list[Level]) -> np.ndarray:
    """Vertices around each vertex of the finest level, (n, 8) int32, -1 where there is none.

    For a vertex on an edge: the four vertices on the other edges of the two faces at it, the ends of the edge, the
    apexes of the two faces. For a base vertex: up to eight of its neighbours, ascending.

    >>> import numpy as np
    >>> from npm_blender.core.bitstream import around
    >>> from npm_blender.core.mesh import hierarchy
    >>> around(hierarchy(np.array([[0, 1, 2]]), 3, 1))[3].tolist()  # on edge 0-1 of one face: it has no second one
    [5, 4, -1, -1, 0, 1, 2, -1]
    """
    out = [_ring(hierarchy[0])]
    for level in hierarchy[:-1]:
        left, right = level.edge_halfedge.T.astype(np.int64)
        flat = level.F.reshape(-1)
        table = np.full((len(left), 8), -1, np.int64)
        for side, h, there in ((0, left, left == left), (1, right, left != right)):
            after, before = h - h % 3 + (h + 1) % 3, h - h % 3 + (h + 2) % 3
            table[:, 2 * side] = np.where(there, level.n + level.edge_of[after], -1)
            table[:, 2 * side + 1] = np.where(there, level.n + level.edge_of[before], -1)
            table[:, 6 + side] = np.where(there, flat[before], -1)
        table[:, 4:6] = level.edges
        out.append(table)
    return np.concatenate(out).astype(np.int32)


def _ring(level: Level) -> np.ndarray:
    ends = np.concatenate([level.edges, level.edges[:, ::-1]])
    ends = ends[np.lexsort((ends[:, 1], ends[:, 0]))]
    place = np.arange(len(ends)) - np.searchsorted(ends[:, 0], ends[:, 0])
    out = np.full((level.n, 8), -1, np.int64)
    kept = place < 8
    out[ends[kept, 0], place[kept]] = ends[kept, 1]
    return out


@njit
def _size(v):
    """0, 1, 2, 3-4, 5-7, 8-13, 14-25, more."""
    if v < 3:
        return v
    if v < 5:
        return 3
    if v < 8:
        return 4
    if v < 14:
        return 5
    return 6 if v < 26 else 7


@njit
def _sign(v):
    return 1 if v > 0 else (-1 if v < 0 else 0)


@njit
def _code(coder, x, value, near, v, level, old):
    """One integer, given its old value (twice that of the stage before)."""
    around, ends, apexes, signed, signed_ends = 0, 0, 0, 0, 0
    for t in range(8):
        u = near[v, t]
        if u < 0:
            continue
        if t < 4 or level == 0:
            around += abs(value[u])
            signed += value[u]
        elif t < 6:
            ends += abs(value[u])
            signed_ends += value[u]
        else:
            apexes += abs(value[u])
    a, c = _size(around), _size((ends + apexes + 1) >> 1)
    w = level * _STRIDE
    if old == 0:
        i = (level * _SIZES + a) * _STRIDE
        j = (_FRESH_J + level * _SIZES + _size(ends)) * _STRIDE
        k = (_FRESH_K + a * _SIZES + c) * _STRIDE
        size = code_unsigned(coder, abs(x), i, j, k, w, _LIMIT)
        if size == 0:
            return 0
        s, e = _sign(signed) + 1, _sign(signed_ends) + 1
        i = _SIGNS + level * 9 + 3 * s + e
        j = _SIGNS + _LEVELS * 9 + (min(max(signed, -4), 4) + 4) * 3 + e
        k = _SIGNS + _LEVELS * 9 + 27 + (min(max(signed_ends, -4), 4) + 4) * 3 + s
        return -size if code_bit(coder, 1 if x < 0 else 0, i, j, k, 2 * _STRIDE * _LEVELS + level) else size
    turn = _sign(old)
    mine = min(abs(old) >> 1, 4) - 1
    i = (_AGAIN + level * 4 + mine) * _STRIDE
    j = (_AGAIN + _LEVELS * 4 + level * 4 + min(a >> 1, 3)) * _STRIDE
    k = (_AGAIN + _LEVELS * 8 + mine * _SIZES + a) * _STRIDE
    return old + turn * code_signed(coder, turn * (x - old), i, j, k, w + _STRIDE * _LEVELS, _LIMIT)


@njit
def _beyond(coder):
    """Whether a reader's last decision took bytes that have not arrived."""
    return coder.rc[MODE] == DECODE and coder.rc[POSITION] > coder.rc[END]


@njit
def _code_stages(coder, table, near, first, value, coded, ends):
    """Code table (stages, n) in place; value (n,): room. Returns how many numbers were coded, or have arrived."""
    numbers, whole = 0, True
    for s in range(len(table)):
        for v in range(len(value)):
            value[v] *= 2
        for level in range(len(first) - 1):
            if not whole:
                break
            if coder.rc[MODE] != DECODE:
                coded[s, level] = 0
                for v in range(first[level], first[level + 1]):
                    if table[s, v] != value[v]:
                        coded[s, level] = 1
                        break
            c = _SKIP + level
            sent = code_bit(coder, coded[s, level], c, c, c, 2 * _STRIDE * _LEVELS + _LEVELS + level)
            if _beyond(coder):
                whole = False
                break
            coded[s, level] = sent
            if sent == 0:
                continue
            for v in range(first[level], first[level + 1]):
                x = _code(coder, table[s, v], value, near, v, level, value[v])
                if _beyond(coder):
                    whole = False
                    break
                value[v] = x
                numbers += 1
                if numbers % GROUP == 0:
                    ends[numbers // GROUP - 1] = coder.rc[POSITION]
        for v in range(len(value)):
            table[s, v] = value[v]
    return numbers


def _coded(coder: Coder, table: np.ndarray, near: np.ndarray, first: np.ndarray, ahead: int) -> Coded:
    """What `_code_stages` codes into or from table (stages, n); ahead: bytes that a reader has looked at before the coder."""
    coded = np.zeros((len(table), len(first) - 1), np.int64)
    ends = np.zeros(table.size // GROUP + 1, np.int64)
    count = int(_code_stages(coder, table, near, first, np.zeros(table.shape[1], np.int64), coded, ends))
    ends = ends[: count // GROUP] + ahead
    last = [int(coder.rc[POSITION]) + ahead] if count % GROUP else []
    return Coded(table, coded.astype(bool), count, np.concatenate([[0], ends, last]).astype(np.int64))


def encode_displacements(table: np.ndarray, near: np.ndarray, first: np.ndarray) -> tuple[bytes, Coded]:
    """Bytes of table (stages, n) int64, integers of every stage, and what their reader will have (`Coded`).

    near (n, 8) int32: from `around`; first (levels + 2,) int64: vertices first[i]..first[i + 1] - 1 are new at level i. Ours.

    >>> import numpy as np
    >>> from npm_blender.core.bitstream import around, encode_displacements
    >>> from npm_blender.core.mesh import hierarchy
    >>> near = around(hierarchy(np.array([[0, 1, 2]]), 3, 1))
    >>> data, coded = encode_displacements(np.array([[0, 0, 0, 1, 0, -2]]), near, np.array([0, 3, 6]))
    >>> coded.numbers, coded.coded.tolist()  # level 0 has none but zeros: one bit for all of it
    (3, [[False, True]])
    """
    table = np.array(table, np.int64)
    coder = range_encoder(new_contexts(_CONTEXTS), new_weights(_MIXERS), 64 + table.size * 9)
    found = _coded(coder, table, near, first, _AHEAD)
    if not len(table):
        return b"", found._replace(ends=np.zeros(1, np.int64))
    at = int(coder.rc[POSITION])
    # the last bytes of the interval, as many as a reader has looked at by then
    end = (int.from_bytes(coder.buf[:at].tobytes(), "big") << 32) + int(coder.rc[LOW]) + int(coder.rc[RANGE]) // 2
    return end.to_bytes(at + _AHEAD, "big"), found


def decode_displacements(data: bytes, stages: int, near: np.ndarray, first: np.ndarray) -> Coded:
    """What has arrived (`Coded`) of the bytes of `encode_displacements`, or of a prefix of them; near, first: as there.

    >>> import numpy as np
    >>> from npm_blender.core.bitstream import around, decode_displacements, encode_displacements
    >>> from npm_blender.core.mesh import hierarchy
    >>> near, first = around(hierarchy(np.array([[0, 1, 2]]), 3, 1)), np.array([0, 3, 6])
    >>> data, _ = encode_displacements(np.array([[0, 0, 0, 1, 0, -2]]), near, first)
    >>> decode_displacements(data, 1, near, first).table.tolist(), decode_displacements(b"", 1, near, first).numbers
    ([[0, 0, 0, 1, 0, -2]], 0)
    """
    table = np.zeros((stages, int(first[-1])), np.int64)
    coder = range_decoder(new_contexts(_CONTEXTS), new_weights(_MIXERS), data)
    found = _coded(coder, table, near, first, 0)
    found.ends[-1] = min(found.ends[-1], len(data))
    return found
