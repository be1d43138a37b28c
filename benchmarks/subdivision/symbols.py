"""Integers of all vertices, stage by stage, to bytes and back; any prefix of the bytes decodes.

A stage holds one integer per vertex, level by level; the step halves from stage to stage, so an integer starts out as
twice its value of the stage before and its change is coded. Contexts are the integers around: on the other edges of the
two faces at the parent edge (new ones where they came before, else those of the last stage), at the edge's ends and at
the apexes.
"""

import numpy as np

from npm_blender.core.bitstream import (
    DECODE,
    MODE,
    code_bit,
    code_signed,
    code_unsigned,
    new_contexts,
    new_weights,
    range_decoder,
    range_encoder,
)
from npm_blender.core.jit import compiled
from npm_blender.core.mesh import Level

_LIMIT = 14
_STRIDE = _LIMIT + 1
_LEVELS, _SIZES = 6, 8
_FRESH_J = _LEVELS * _SIZES
_FRESH_K = 2 * _LEVELS * _SIZES
_AGAIN = _FRESH_K + _SIZES * _SIZES
_SIGNS = (_AGAIN + 2 * _LEVELS * 4 + 4 * _SIZES) * _STRIDE
_SKIP = _SIGNS + _LEVELS * 9 + 3 * 27
_CONTEXTS = _SKIP + 1
_MIXERS = 2 * _STRIDE * _LEVELS + _LEVELS + 1


def neighbours(hierarchy: list[Level]) -> np.ndarray:
    """Vertices around each vertex of the finest level, (n, 8) int32, -1 where there is none.

    For a vertex on an edge: the four vertices on the other edges of the two faces at it, the ends of the edge, the
    apexes of the two faces. For a base vertex: up to eight of its neighbours.
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


@compiled
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


@compiled
def _sign(v):
    return 1 if v > 0 else (-1 if v < 0 else 0)


@compiled
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


@compiled(allocates=True)
def _code_stages(coder, table, near, first):
    """Code table (stages, n) in place."""
    stages, n = table.shape
    value = np.zeros(n, np.int64)
    for s in range(stages):
        value *= 2
        for level in range(len(first) - 1):
            still = 1
            if coder.rc[MODE] != DECODE:
                for v in range(first[level], first[level + 1]):
                    if table[s, v] != value[v]:
                        still = 0
                        break
            still = code_bit(coder, still, _SKIP, _SKIP, _SKIP, 2 * _STRIDE * _LEVELS + _LEVELS)
            for v in range(first[level], first[level + 1]):
                if still == 0:
                    value[v] = _code(coder, table[s, v], value, near, v, min(level, _LEVELS - 1), value[v])
                table[s, v] = value[v]


def _models() -> tuple[np.ndarray, np.ndarray]:
    return new_contexts(_CONTEXTS), new_weights(_MIXERS)


def encode(table: np.ndarray, near: np.ndarray, first: np.ndarray) -> bytes:
    """Bytes of table (stages, n) int64: integers of every stage; near from `neighbours`, first from `Scheme`."""
    table = np.array(table, np.int64)
    coder = range_encoder(*_models(), 64 + table.size * 9)
    _code_stages(coder, table, near, first)
    _, low, width, at, _ = map(int, coder.rc)
    end = (int.from_bytes(coder.buf[:at].tobytes(), "big") << 32) + low + width // 2
    return end.to_bytes(at + 4, "big")[: at + 2]  # whatever follows, the value stays in the interval: width >= 2**24


def decode(data: bytes, stages: int, near: np.ndarray, first: np.ndarray) -> tuple[np.ndarray, int]:
    """Integers (stages, n) int64 of `encode`'s bytes, or of a prefix of them, and how many of them are certain.

    What follows the data is assumed to be all zeros and then all ones: what both give is certain.
    """
    tables = []
    for fill in (b"\0", b"\xff"):
        table = np.zeros((stages, int(first[-1])), np.int64)
        coder = range_decoder(*_models(), data + fill * (64 + 4 * table.size))
        _code_stages(coder, table, near, first)
        tables.append(table.reshape(-1))
    differ = np.flatnonzero(tables[0] != tables[1])
    return tables[0].reshape(stages, -1), int(differ[0]) if len(differ) else len(tables[0])

