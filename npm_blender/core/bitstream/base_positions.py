"""Base vertex positions on a lattice: predicted from the faces already placed, residuals entropy coded.

Vertices come in the order in which `connectivity` met them. A vertex v is predicted from every face (v, x, y) whose
edge x-y has a face (y, x, z) on its other side, with x, y, z already known. The parallelogram rule (Touma and Gotsman 1998)
mirrors z through the middle of x-y; here it is damped, 3/4 as far beyond the middle, which fits decimated meshes better
(the damping is ours), and the predictions of all n such faces are averaged:

    p(v) = 1/n sum ((x + y) / 2 + 3/4 ((x + y) / 2 - z)) = sum (7 (x + y) - 6 z) / (8 n), rounded

Where there is no such face, p(v) is the mean of the known neighbours. The size of residuals follows the size of the
triangles, so contexts are exponents relative to the local edge length. Integers throughout.
"""
from typing import NamedTuple

import numpy as np

from ..errors import MeshError, StreamError
from ..jit import njit
from ..mesh import opposite_halfedges
from .header import MAX_BITS
from .range_coder import code_bit, code_raw, finish_encoding, new_contexts, new_weights, range_decoder, range_encoder

_REACH = 4                  # coordinates stay within +-4 of the unit frame
_LIMIT = 1 << MAX_BITS + 2   # so lattice positions stay below this
_BITS = MAX_BITS + 4        # longest residual
_RELATIVE = 40              # contexts for half-octaves relative to a scale
_MID = 20
_SIZE, _PREVIOUS, _RECENT = 0, _RELATIVE, 2 * _RELATIVE
_CONTEXTS, _MIXERS = 3 * _RELATIVE, _RELATIVE


class _Neighbours(NamedTuple):
    """What is known about vertex v when its turn comes, rows start[v]..start[v + 1] of each table.

    flaps (f, 3): x, y, z of the parallelograms; edges (e,): known neighbours.
    """

    flap_start: np.ndarray
    flaps: np.ndarray
    edge_start: np.ndarray
    edges: np.ndarray


def _neighbours(F: np.ndarray, n: int) -> _Neighbours:
    F = F.astype(np.int64)
    opposite = opposite_halfedges(F)
    x, y, apex = (np.roll(F, -k, axis=1).reshape(-1) for k in range(3))
    z = np.where(opposite == np.arange(F.size), n, apex[opposite])
    known = np.maximum(np.maximum(x, y), z) < apex
    order = np.argsort(apex[known], kind="stable")
    flaps = np.stack([x, y, z], 1)[known][order]
    flap_start = np.searchsorted(apex[known][order], np.arange(n + 1))
    ends = np.unique(np.sort(np.stack([x, y], 1), 1), axis=0)
    by_end = ends[np.argsort(ends[:, 1], kind="stable")]
    return _Neighbours(flap_start, np.ascontiguousarray(flaps), np.searchsorted(by_end[:, 1], np.arange(n + 1)),
                       np.ascontiguousarray(by_end[:, 0]))


@njit
def _half_octaves(value):
    """Floor of 2 log2 value, plus one; 0 for 0."""
    square, out = value * value, 0
    while square > 0:
        out += 1
        square >>= 1
    return out


@njit
def _code_residual(coder, value, scale, previous, recent):
    """One coordinate's residual; scale, previous, recent: sizes in half-octaves that it is measured against."""
    size, length = abs(value), 0
    while size >> length:
        length += 1
    t = 0
    while t < _BITS:
        i = min(max(2 * t - scale + _MID, 0), _RELATIVE - 1)
        j = min(max(2 * t - previous + _MID, 0), _RELATIVE - 1)
        k = min(max(2 * t - recent + _MID, 0), _RELATIVE - 1)
        if code_bit(coder, 1 if length > t else 0, _SIZE + i, _PREVIOUS + j, _RECENT + k, i) == 0:
            break
        t += 1
    if t == 0:
        return 0
    out = (1 << (t - 1)) | code_raw(coder, size, t - 1)
    return -out if code_raw(coder, 1 if value < 0 else 0, 1) else out


@njit
def _code_positions(coder, at, near, guess, recent):
    """Code all rows of `at` (n, 3) int64 in place; guess, recent (3,): room for one row, see `_new_rows`."""
    for v in range(len(at)):
        first, last = near.flap_start[v], near.flap_start[v + 1]
        count, reach = last - first, 0
        if count > 0:
            for axis in range(3):
                total = 0
                for f in range(first, last):
                    x, y, z = near.flaps[f, 0], near.flaps[f, 1], near.flaps[f, 2]
                    total += 7 * (at[x, axis] + at[y, axis]) - 6 * at[z, axis]
                    reach += abs(at[x, axis] - at[y, axis])
                guess[axis] = (total + 4 * count) // (8 * count)
            reach //= count
        else:
            first, last = near.edge_start[v], near.edge_start[v + 1]
            for axis in range(3):
                total = 0
                for e in range(first, last):
                    total += at[near.edges[e], axis]
                guess[axis] = total // (last - first) if last > first else 0
            reach = 1 << 8
        scale, previous = _half_octaves(reach), _half_octaves(reach)
        for axis in range(3):
            r = _code_residual(coder, at[v, axis] - guess[axis], scale, previous, recent[axis])
            at[v, axis] = min(max(guess[axis] + r, -_LIMIT), _LIMIT)
            previous = _half_octaves(abs(r))
            recent[axis] = (3 * recent[axis] + previous + 2) >> 2


def _new_rows() -> tuple[np.ndarray, np.ndarray]:
    """guess and recent of `_code_positions`: of each coordinate, the prediction, and a running mean of residuals' sizes."""
    return np.zeros(3, np.int64), np.full(3, 12, np.int64)


def quantize_positions(V0: np.ndarray, bits: int) -> tuple[np.ndarray, np.ndarray]:
    """V0 (n, 3) float64, unit frame, on the lattice of step 2**-bits: (ints (n, 3) int64, V0q (n, 3) float64).

    ints = round(V0 2^bits), V0q = ints 2^-bits. Raises MeshError if a coordinate is not finite or further than 4 from the
    origin.

    >>> import numpy as np
    >>> from npm_blender.core.bitstream import quantize_positions
    >>> ints, V0q = quantize_positions(np.array([[0.1, -0.25, 0.5]]), bits=4)
    >>> ints.tolist(), V0q.tolist()
    ([[2, -4, 8]], [[0.125, -0.25, 0.5]])
    """
    V0 = np.asarray(V0, dtype=np.float64)
    if not np.isfinite(V0).all() or (np.abs(V0) >= _REACH).any():
        raise MeshError(f"Expected base coordinates within {_REACH} of the unit frame's origin, found others; "
                        "the decimation failed, try another number of base faces")
    ints = np.rint(V0 * 2.0**bits).astype(np.int64)
    return ints, ints * 2.0**-bits


def encode_positions(ints: np.ndarray, F: np.ndarray) -> bytes:
    """Bytes of lattice positions ints (n, 3) of base faces F (m, 3) in canonical order.

    Each vertex is predicted by the damped parallelogram rule, see above; what it is off by is coded. Raises MeshError if an
    integer is out of range.

    >>> import numpy as np
    >>> from npm_blender.core.bitstream import decode_positions, encode_positions
    >>> F = np.array([[0, 1, 2], [1, 0, 3]])
    >>> data = encode_positions(np.array([[0, 0, 0], [8, 0, 0], [0, 8, 0], [8, -8, 0]]), F)
    >>> decode_positions(data, F).tolist()
    [[0, 0, 0], [8, 0, 0], [0, 8, 0], [8, -8, 0]]
    """
    at = np.array(ints, dtype=np.int64)
    if (np.abs(at) >= _LIMIT).any():
        raise MeshError(f"Expected lattice positions below {_LIMIT}, found {np.abs(at).max()}; use fewer position bits")
    coder = range_encoder(new_contexts(_CONTEXTS), new_weights(_MIXERS), 64 + 3 * 3 * _BITS * len(at))
    _code_positions(coder, at, _neighbours(F, len(at)), *_new_rows())
    return finish_encoding(coder)


def decode_positions(data: bytes, F: np.ndarray) -> np.ndarray:
    """Lattice positions (n, 3) int64 of base faces F (m, 3), from the bytes of `encode_positions`.

    Raises StreamError if a position leaves the range that can be written.

    >>> import numpy as np
    >>> from npm_blender.core.bitstream import decode_positions, encode_positions
    >>> F = np.array([[0, 1, 2], [1, 0, 3]])
    >>> data = encode_positions(np.array([[0, 0, 0], [8, 0, 0], [0, 8, 0], [8, -8, 0]]), F)
    >>> decode_positions(data, F)[3].tolist()
    [8, -8, 0]
    """
    n = int(F.max()) + 1
    at = np.zeros((n, 3), np.int64)
    coder = range_decoder(new_contexts(_CONTEXTS), new_weights(_MIXERS), data)
    _code_positions(coder, at, _neighbours(F, n), *_new_rows())
    if (np.abs(at) >= _LIMIT).any():
        raise StreamError("Expected base positions near the unit frame, found others; the file is corrupted")
    return at
