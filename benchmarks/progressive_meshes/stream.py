"""Progressive Meshes in bytes: varints of base bits, batches, vertices, lengths; connectivity; positions; the splits."""

from dataclasses import dataclass

import numpy as np

from npm_blender.core.bitstream import (
    canonical_order,
    decode_connectivity,
    decode_positions,
    encode_connectivity,
    encode_positions,
    new_contexts,
    new_weights,
    range_decoder,
    range_encoder,
    read_varint,
    write_varint,
)
from npm_blender.core.errors import StreamError
from npm_blender.core.mesh import TriMesh

from .contexts import CONTEXTS, MIXERS
from .mesh import Growing
from .records import FINEST, SplitPlan, code_batches
from .simplify import Collapses

FINENESS = 2.2  # error of the mesh over the step of positions
_MAX = 1 << 22


@dataclass(frozen=True)
class Encoded:
    """data: the whole stream; base: bytes up to the base mesh; mesh: what all of it decodes to; vertices (batches + 1,):
    vertices before each batch and at the end."""

    data: bytes
    base: int
    mesh: TriMesh
    vertices: np.ndarray


def encode(collapses: Collapses, fineness: float = FINENESS) -> Encoded:
    """The stream of a simplified mesh (unit frame)."""
    used, F0 = np.unique(collapses.F, return_inverse=True)
    order = canonical_order(F0.reshape(-1, 3), len(used))
    old = used[order.vertices]
    exponents, count, first = _schedule(collapses, fineness)
    bits = min(int(exponents[0]) + 1, 16) if len(exponents) else 12
    ints = np.rint(collapses.X[old] * 2.0**bits).astype(np.int64)
    connectivity, positions = encode_connectivity(order.F), encode_positions(ints, order.F)
    splits = len(collapses.ends)
    head = b"".join(map(write_varint, (bits, len(exponents), splits, len(connectivity), len(positions))))
    m = Growing.of(ints * 2.0**-bits, order.F, splits)
    name = np.full(len(collapses.X), -1, np.int64)
    name[old] = np.arange(len(old))
    wanted = np.zeros_like(m.X)
    wanted[: len(old)] = collapses.X[old]
    plan = SplitPlan(count, first, collapses.ends.astype(np.int64), collapses.cuts.astype(np.int64), collapses.at, name, wanted,
                     np.full(len(m.X), -1, np.int64))
    coder = range_encoder(new_contexts(CONTEXTS), new_weights(MIXERS), 4096 + 64 * splits + 8 * len(exponents) * len(m.X) // 8)
    trace = np.zeros(len(exponents) * len(m.X) + 1, np.int64)
    code_batches(coder, m, exponents, len(m.X), plan, len(trace), trace)
    _, low, width, at, _ = map(int, coder.rc)
    end = (int.from_bytes(coder.buf[:at].tobytes(), "big") << 32) + low + width // 2
    base = head + connectivity + positions
    vertices = len(old) + np.concatenate([[0], np.cumsum(count)])
    return Encoded(base + end.to_bytes(at + 4, "big")[: at + 2], len(base), TriMesh(m.vertices(), m.faces()), vertices)


def _schedule(collapses: Collapses, fineness: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Exponents, numbers of splits and first rows of collapses, each (batches,) int64; the last collapses come first."""
    count = np.bincount(collapses.batch, minlength=1) if len(collapses.batch) else np.zeros(0, np.int64)
    first = np.concatenate([[0], np.cumsum(count)])[:-1].astype(np.int64)
    error = np.cumsum(collapses.cost)
    area = _area(collapses)
    used = np.flatnonzero(count)[::-1]
    exponents, last = np.zeros(len(used), np.int64), 0
    for i, b in enumerate(used):
        reached = np.sqrt(max(error[first[b]], 1e-14) / area)
        last = int(np.clip(np.rint(np.log2(fineness / reached)), max(last, 6), FINEST))
        exponents[i] = last
    return exponents, count[used], first[used]


def _area(collapses: Collapses) -> float:
    return max(float(TriMesh(collapses.X, collapses.F).face_areas().sum()), 1e-12)


def decode(data: bytes) -> TriMesh:
    """The mesh of a stream, or of any prefix past its base mesh.

    Raises StreamError if the data end before, or are no such stream.
    """
    try:
        numbers, at = [], 0
        for _ in range(5):
            value, at = read_varint(data, at)
            numbers.append(value)
    except EOFError:
        raise StreamError("Expected a progressive mesh, found the end of the data in its header; get more of it") from None
    bits, batches, splits, connectivity, positions = numbers
    if bits > 20 or batches > _MAX or splits > _MAX:
        raise StreamError(f"Expected the header of a progressive mesh, found {numbers}; this is other data")
    base = at + connectivity + positions
    if len(data) < base:
        raise StreamError(f"Expected at least {base} bytes (the base mesh), found {len(data)}; get more of it")
    F = decode_connectivity(data[at : at + connectivity])
    V = decode_positions(data[at + connectivity : base], F) * 2.0**-bits
    payload = data[base:]
    room = batches * (len(V) + splits) + 1
    traces, visits = np.zeros((2, room), np.int64), [0, 0]
    for k, fill in enumerate((b"\0", b"\xff")):
        _, visits[k] = _run(payload + fill * (16 + len(payload) // 4), V, F, batches, splits, room, traces[k])
    both = min(visits)
    differ = np.flatnonzero(traces[0, :both] != traces[1, :both])
    certain = int(differ[0]) if len(differ) else both
    m, _ = _run(payload, V, F, batches, splits, certain, traces[0])
    return TriMesh(m.vertices(), m.faces())


def _run(payload, V, F, batches, splits, limit, trace):
    m = Growing.of(V, F, splits)
    coder = range_decoder(new_contexts(CONTEXTS), new_weights(MIXERS), payload)
    visits = code_batches(coder, m, np.zeros(batches, np.int64), len(m.X), SplitPlan.empty(), limit, trace)
    return m, visits
