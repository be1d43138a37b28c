"""Base vertex positions on a lattice: expected from the vertices before, and coded as decisions about where they are.

Vertices come in the order in which `connectivity` met them. For each vertex, in this order:

    look_around         its known neighbours and flaps                          `vertex_surroundings`
    expect              two predictions, linear in vectors, which learn         `position_guess`
    find_spreads        how far off they may be, in the plane and across        `position_spread`
    list_candidates     places where it may be exactly                          `position_candidates`
    code_value          each coordinate, given those before                     `position_value`

and then all of them learn from what it was. Integers throughout, and every number begins as `position_priors` says.
"""
from typing import NamedTuple

import numpy as np

from ..errors import MeshError, StreamError
from ..jit import njit
from .fixed_point import exp2
from .mixing import Mixer
from .position_candidates import Candidates, learn_candidates, list_candidates, most_likely, new_candidates, weigh
from .position_guess import PREDICTORS, Guess, expect, learn_to_guess, new_guess
from .position_priors import MIX, PREDICTION, SERVED, SPREAD, SPREAD_OF_CANDIDATES
from .position_spread import Spread, find_features, find_spreads, given_before, learn_spreads, new_spread
from .position_value import BEFORE, LIMIT, LOOK, PLACE, Scene, code_value, new_scene, new_value_mixer
from .range_coder import Coder, finish_encoding, new_contexts, new_weights, range_decoder, range_encoder
from .vertex_surroundings import (
    Memory,
    Surface,
    Surroundings,
    look_around,
    new_memory,
    new_surroundings,
    remember,
    surface_of,
)

_REACH = 4                  # coordinates stay within +-4 of the unit frame
_MOST_BYTES = 3 * 80         # of a vertex: 24 buckets of 12 bits at most and 24 halves


class _Model(NamedTuple):
    """All that a coder of positions holds, in the order in which it is used."""

    surface: Surface
    memory: Memory
    room: Surroundings
    guess: Guess
    spread: Spread
    candidates: Candidates
    scene: Scene
    mixer: Mixer


def _new_model(F: np.ndarray, n: int) -> _Model:
    return _Model(surface_of(F, n), new_memory(n), new_surroundings(), new_guess(PREDICTION), new_spread(SPREAD),
                  new_candidates(SERVED, SPREAD_OF_CANDIDATES), new_scene(), new_value_mixer(MIX))


@njit(inline="always")
def _look(surface, memory, guess, at, v, axis):
    """How even the known neighbours of v are on an axis: a context of 64."""
    least, most, exact, count = 1 << 40, -(1 << 40), 0, 0
    for i in range(surface.start[v], surface.start[v + 1]):
        h = surface.corner[i]
        f = h // 3
        u = surface.F[f, (h - 3 * f + 1) % 3]
        if u < v:
            least, most = min(least, at[u, axis]), max(most, at[u, axis])
            exact += memory.exact[u, axis]
            count += 1
    if count == 0:
        return 63
    apart, wide = abs(guess.means[0, axis] - guess.means[1, axis]), most - least
    look = 0 if wide == 0 else (1 if wide < 4 else (2 if wide < 16 else 3))
    look = 4 * look + (0 if exact == 0 else (2 if exact == count else 1))
    return 4 * look + (0 if apart < 64 else (1 if apart < 256 else (2 if apart < 1024 else 3)))


@njit(inline="always")
def _code_vertex(coder, mixer, scene, model, at, v):
    """Code the three coordinates of vertex v, which is expected already."""
    guess, spread, candidates, memory = model.guess, model.spread, model.candidates, model.memory
    farthest = 0
    for axis in range(3):
        for p in range(PREDICTORS):
            scene.inverse[p] = (1 << 48) // exp2(given_before(spread, guess, scene.centre, at, v, p, axis))
        scene.now[PLACE] = 4 * axis + spread.class_[0]
        scene.now[LOOK] = _look(model.surface, memory, guess, at, v, axis)
        start = (candidates.places[axis, most_likely(candidates)] + 128) >> 8
        value = code_value(coder, mixer, scene, candidates, axis, start, at[v, axis])
        at[v, axis] = value
        for p in range(PREDICTORS):
            off = min(abs((value << 8) - scene.centre[p]), 1 << 30) * scene.inverse[p] >> 24
            spread.excess[p] += min(off, 4096) * min(off, 4096) >> 8
        weigh(candidates, axis, value)
        memory.exact[v, axis] = 1 if scene.reach[0] == 0 else 0
        scene.now[BEFORE] = scene.reach[0]
        farthest = max(farthest, scene.reach[0])
    scene.now[BEFORE] = 8 + farthest


@njit
def _code_positions(coder, model, at):
    """Code all rows of `at` (n, 3) int64 in place."""
    surface, memory, room, guess, spread, candidates = (model.surface, model.memory, model.room, model.guess, model.spread,
                                                        model.candidates)
    for v in range(len(at)):
        look_around(surface, memory, room, at, v)
        expect(guess, surface, memory, room, at, v)
        find_features(spread, guess, surface, room, v)
        find_spreads(spread, guess)
        list_candidates(candidates, guess, spread, room)
        _code_vertex(coder, model.mixer, model.scene, model, at, v)
        learn_to_guess(guess, at, v)
        learn_spreads(spread, guess, memory.errors, at, v)
        learn_candidates(candidates, spread.class_[0], memory.errors, at, v)
        remember(surface, memory, at, v)


def _no_contexts() -> tuple[np.ndarray, np.ndarray]:
    return new_contexts(0), new_weights(0)


def _encoder(n: int) -> Coder:
    return range_encoder(*_no_contexts(), capacity=64 + _MOST_BYTES * n)


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
    >>> F = np.array([[0, 1, 2], [3, 1, 0]])
    >>> data = encode_positions(np.array([[0, 0, 0], [8, 0, 0], [0, 8, 0], [8, -8, 0]]), F)
    >>> decode_positions(data, F).tolist()
    [[0, 0, 0], [8, 0, 0], [0, 8, 0], [8, -8, 0]]
    """
    at = np.array(ints, dtype=np.int64)
    if (np.abs(at) >= LIMIT).any():
        raise MeshError(f"Expected lattice positions below {LIMIT}, found {np.abs(at).max()}; use fewer position bits")
    coder = _encoder(len(at))
    _code_positions(coder, _new_model(F, len(at)), at)
    return finish_encoding(coder)


def decode_positions(data: bytes, F: np.ndarray) -> np.ndarray:
    """Lattice positions (n, 3) int64 of base faces F (m, 3), from the bytes of `encode_positions`.

    Raises StreamError if a position leaves the range that can be written.

    >>> import numpy as np
    >>> from npm_blender.core.bitstream import decode_positions, encode_positions
    >>> F = np.array([[0, 1, 2], [3, 1, 0]])
    >>> data = encode_positions(np.array([[0, 0, 0], [8, 0, 0], [0, 8, 0], [8, -8, 0]]), F)
    >>> decode_positions(data, F)[3].tolist()
    [8, -8, 0]
    """
    n = int(F.max()) + 1
    at = np.zeros((n, 3), np.int64)
    coder = range_decoder(*_no_contexts(), data)
    _code_positions(coder, _new_model(F, n), at)
    if (np.abs(at) >= LIMIT).any():
        raise StreamError("Expected base positions near the unit frame, found others; the file is corrupted")
    return at
