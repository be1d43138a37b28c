"""Vertex splits as bits: which vertices, at which of their neighbours; where the two vertices go is in places.py.

A batch visits the vertices that are there when it begins. Neighbours of one that was split are not split in the same
batch and cost nothing. A batch with finer steps than the one before corrects each vertex that it does not split along
the normal.
"""

from typing import NamedTuple

import numpy as np

from npm_blender.core.bitstream import ENCODE, MODE, code_bit, code_signed, code_unsigned
from npm_blender.core.jit import compiled

from .contexts import (
    CUT,
    EXPONENT,
    FIX,
    FLAG,
    KIND,
    MIX_CUT,
    MIX_EXPONENT,
    MIX_FIX,
    MIX_FLAG,
    MIX_KIND,
    STREAK,
    VALENCES,
)
from .mesh import MAX_RING, VERTICES, Site, ring_of, split
from .places import code_places, normal_at
from .simplify import BEGIN, END, KEPT, REMOVED

FINEST = 20  # steps are 2**-exponent, exponent up to here


class SplitPlan(NamedTuple):
    """What the sender codes; a receiver's is never read.

    count, first (batches,) int64: how many splits a batch has, and its first row of ends, cuts and at.
    ends (c, 2) int64: input's numbers of the KEPT and the REMOVED vertex; cuts (c, 2) int64: those of the neighbours where
    the removed vertex's faces BEGIN and END, BEGIN -1 where the edge is on the border; at (c, 2, 3): where the ends go.
    name: number in the growing mesh of each input vertex, -1 until it is there; positions (n, 3): where the vertices of the
    growing mesh should be; row (n,) int64: the split that waits at each of them, or -1.
    """

    count: np.ndarray
    first: np.ndarray
    ends: np.ndarray
    cuts: np.ndarray
    at: np.ndarray
    name: np.ndarray
    positions: np.ndarray
    row: np.ndarray

    @staticmethod
    def empty() -> "SplitPlan":
        """A receiver's."""
        numbers, pairs = np.zeros(0, np.int64), np.zeros((0, 2), np.int64)
        return SplitPlan(numbers, numbers, pairs, pairs, np.zeros((0, 2, 3)), numbers, np.zeros((0, 3)), numbers)


class Batch(NamedTuple):
    """number; step: of its positions; jump: by how many halvings that is finer than the batch before."""

    number: int
    step: float
    jump: int


class State(NamedTuple):
    """What both sides remember.

    blocked (n,) int64: the last batch that split each vertex or a neighbour of it; seen (6,) int64: running means of the
    sizes of the six coded components, in eighths of a bit; kept, new (3,): where the two vertices of a split go; ring,
    spoke: room for those of a Site.
    """

    blocked: np.ndarray
    seen: np.ndarray
    kept: np.ndarray
    new: np.ndarray
    ring: np.ndarray
    spoke: np.ndarray


@compiled
def _code_cuts(coder, m, site, p, q):
    """Neighbours p < q of the split; p = -1 where the new edge is on the border."""
    count, rest = site.count, 2
    if site.border:
        if code_bit(coder, 1 if p < 0 else 0, KIND, KIND, KIND, MIX_KIND):
            rest = 1
    one, two = -1, -1
    for k in range(count):
        left = count - k
        hit = 1
        if left > rest:
            valence = min(m.valence[site.ring[k]], VALENCES) - 1
            near = min(k - one, 15) if one >= 0 else min(left, 15)
            i = CUT + (near * 16 + min(left, 15)) * 3 + rest
            j = CUT + 768 + (min(count, 15) * 16 + min(k, 15)) * 3 + rest
            hit = code_bit(coder, 1 if k == p or k == q else 0, i, j, CUT + 1536 + valence * 3 + rest, MIX_CUT + rest)
        if hit:
            rest -= 1
            if rest == 0:
                two = k
                break
            one = k
    return one, two


@compiled
def _take_split(plan, site, t, state):
    """The planned split of a vertex: its neighbours p and q, its places into `state`; notes that t is the new vertex.

    Where the collapse counted the other way round (p > q) the two vertices change their roles.
    """
    c, v = plan.row[site.v], site.v
    p, q = -1, -1
    for k in range(site.count):
        if plan.cuts[c, BEGIN] >= 0 and site.ring[k] == plan.name[plan.cuts[c, BEGIN]]:
            p = k
        if site.ring[k] == plan.name[plan.cuts[c, END]]:
            q = k
    kept, new = KEPT, REMOVED
    if p > q and not site.border:
        p, q = q, p
        kept, new = REMOVED, KEPT
    for k in range(3):
        state.kept[k], state.new[k] = plan.at[c, kept, k], plan.at[c, new, k]
        plan.positions[v, k], plan.positions[t, k] = state.kept[k], state.new[k]
    plan.name[plan.ends[c, kept]], plan.name[plan.ends[c, new]] = v, t
    plan.row[v] = -1
    return p, q


@compiled
def _code_flag(coder, m, site, batch, state, streak, chosen):
    """Whether a vertex is split; streak: how many before it were not."""
    valence = min(m.valence[site.v], VALENCES) - 1
    free = 0
    for k in range(site.count):
        free += site.ring[k] > site.v or state.blocked[site.ring[k]] != batch.number
    share = min(3, 4 * free // (site.count + 1))
    f = FLAG + ((2 if site.border else 0) * VALENCES + valence) * 4 + share
    return code_bit(coder, chosen, f, STREAK + min(streak, 15), STREAK + 16 + valence, MIX_FLAG)


@compiled(allocates=True)
def _code_split(coder, m, site, batch, plan, state):
    """Split a vertex; returns a hash of what was coded."""
    p, q = -1, -1
    if coder.rc[MODE] == ENCODE:
        p, q = _take_split(plan, site, m.counts[VERTICES], state)
    p, q = _code_cuts(coder, m, site, p, q)
    code_places(coder, m, site, p, q, batch.step, state)
    v, kept, new = site.v, state.kept, state.new
    t = split(m, v, site.ring, site.spoke, site.faces, site.border, p, q)
    for k in range(3):
        m.X[v, k], m.X[t, k] = kept[k], new[k]
    for k in range(site.count):
        state.blocked[site.ring[k]] = batch.number
    state.blocked[v] = state.blocked[t] = batch.number
    return 7 + p + 64 * q + 4096 * int(np.rint((kept[0] + 2 * kept[1] + 3 * kept[2] + new[0]) / batch.step))


@compiled
def _code_correction(coder, m, site, batch, plan):
    """Move a vertex along the normal, in steps of the batch; returns a hash of what was coded."""
    v, X = site.v, m.X
    nx, ny, nz, _ = normal_at(m, site)
    want = 0.0
    if coder.rc[MODE] == ENCODE:
        known = plan.positions
        want = nx * (known[v, 0] - X[v, 0]) + ny * (known[v, 1] - X[v, 1]) + nz * (known[v, 2] - X[v, 2])
    i = FIX + min(batch.jump, 3) * 8
    move = code_signed(coder, int(np.rint(want / batch.step)), i, i, i, MIX_FIX, 6)
    X[v, 0] += nx * batch.step * move
    X[v, 1] += ny * batch.step * move
    X[v, 2] += nz * batch.step * move
    return 8 * move + 1


@compiled(allocates=True)
def _code_batch(coder, m, target, plan, batch, state, limit, trace, visits):
    """One batch: splits, and corrections where its steps are finer; counts on from `visits`."""
    streak = 0
    for v in range(m.counts[VERTICES]):
        if visits >= limit:
            break
        note, chosen = 0, 0
        if state.blocked[v] != batch.number and m.counts[VERTICES] < target and m.valence[v] < MAX_RING:
            count, faces, border = ring_of(m, v, state.ring, state.spoke)
            if count >= (2 if border else 3):
                site = Site(v, state.ring, state.spoke, count, faces, border)
                wanted = 1 if coder.rc[MODE] == ENCODE and plan.row[v] >= 0 else 0
                chosen = _code_flag(coder, m, site, batch, state, streak, wanted)
                streak = 0 if chosen else streak + 1
                if chosen:
                    note = _code_split(coder, m, site, batch, plan, state)
        if chosen == 0 and batch.jump > 0:
            count, faces, border = ring_of(m, v, state.ring, state.spoke)
            note = _code_correction(coder, m, Site(v, state.ring, state.spoke, count, faces, border), batch, plan)
        trace[visits] = note
        visits += 1
    return visits


@compiled(allocates=True)
def code_batches(coder, m, exponents, target, plan, limit, trace):
    """Code batches until `limit` vertices were visited; returns the visits.

    m: grows; exponents (batches,): steps, read from or written to; target: vertices at the end; plan: see SplitPlan.
    trace (visits,): a hash of what was coded at each visit.
    """
    ring, spoke = np.zeros(len(m.corner) + 1, np.int32), np.zeros(len(m.corner) + 1, np.int32)
    state = State(np.full(len(m.X), -1, np.int64), np.zeros(6, np.int64), np.zeros(3), np.zeros(3), ring, spoke)
    visits, last = 0, 0
    for b in range(len(exponents)):
        if coder.rc[MODE] == ENCODE:
            for c in range(plan.first[b], plan.first[b] + plan.count[b]):
                plan.row[plan.name[plan.ends[c, KEPT]]] = c
        more = code_unsigned(coder, exponents[b] - last, EXPONENT, EXPONENT, EXPONENT, MIX_EXPONENT, 4)
        exponents[b] = min(last + more, FINEST)
        batch = Batch(b, 2.0 ** -exponents[b], exponents[b] - last if b > 0 else 0)
        last = exponents[b]
        visits = _code_batch(coder, m, target, plan, batch, state, limit, trace, visits)
        if visits >= limit:
            break
    return visits
