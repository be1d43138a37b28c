"""Bytes and time of our coder of a base mesh over Draco's for the same lattice mesh: `python -m benchmarks.basecoder CORPUS`.

The twenty largest meshes of the test split, decimated to 400, 1,600, 6,400 and 25,600 faces, at 9, 11 and 13 bits a
coordinate; and twenty source meshes of 5,000 to 100,000 faces as they are, at 11 and 13 bits. Draco at its best level gets
the integers, with a range that makes its own lattice the same. Geometric means; seconds are the processor's.
"""

import argparse
import time
from collections.abc import Callable
from pathlib import Path

import DracoPy
import numpy as np

from corpus.meshes import Entry, entries
from npm_blender.core.bitstream import decode_connectivity, decode_positions, encode_positions, order_connectivity
from npm_blender.core.decimation import decimate
from npm_blender.core.errors import NpmError

from .methods.drc import LEVEL

FACES = (400, 1_600, 6_400, 25_600)
BITS = (9, 11, 13)
SOURCE_BITS = (11, 13)
MESHES = 20
SOURCE_FACES = (5_000, 100_000)


def on_lattice(V: np.ndarray, bits: int) -> np.ndarray:
    """V (n, 3) as integers (n, 3) int64 of 0 .. 2^bits - 1, the longest side of the box over the whole range."""
    low = V.min(0)
    return np.rint((V - low) * ((2**bits - 1) / (V.max(0) - low).max())).astype(np.int64)


def draco_bytes(at: np.ndarray, F: np.ndarray, bits: int) -> bytes:
    """Draco's file of integer positions, whose lattice is theirs."""
    return DracoPy.encode(at.astype(np.float64), F.astype(np.uint32), quantization_bits=bits, compression_level=LEVEL,
                          quantization_range=float(2**bits - 1), quantization_origin=np.zeros(3))


def _seconds(call: Callable, repeats: int) -> float:
    """The least processor time of a call."""
    found = []
    for _ in range(repeats):
        begun = time.process_time()
        call()
        found.append(time.process_time() - begun)
    return min(found)


def compare(V: np.ndarray, F: np.ndarray, bits: int, repeats: int) -> tuple[float, float, float]:
    """Ours over Draco's: bytes, seconds to encode, seconds to decode."""
    order, connectivity = order_connectivity(F, len(V))
    at = on_lattice(V, bits)[order.vertices]
    positions, theirs = encode_positions(at, order.F), draco_bytes(at, order.F, bits)
    if not np.array_equal(decode_positions(positions, decode_connectivity(connectivity)), at):
        raise RuntimeError("Expected the positions back, found others")

    def encode() -> None:
        order_connectivity(F, len(V))
        encode_positions(at, order.F)

    def decode() -> None:
        decode_positions(positions, decode_connectivity(connectivity))

    slower = _seconds(encode, repeats) / _seconds(lambda: draco_bytes(at, order.F, bits), repeats)
    later = _seconds(decode, repeats) / _seconds(lambda: DracoPy.decode(theirs), repeats)
    return (len(connectivity) + len(positions)) / len(theirs), slower, later


def _chosen(found: list[Entry], count: int) -> list[Entry]:
    """So many of them, evenly over the sizes."""
    return [found[int((i + 0.5) * len(found) / count)] for i in range(min(count, len(found)))]


def _row(name: str, rows: list[tuple[float, float, float]]) -> str:
    bytes_, slower, later = np.exp(np.log(np.array(rows)).mean(0))
    return f"| {name} | {len(rows)} | {bytes_:.3f} | {slower:.1f} | {later:.1f} |"


def table(folder: Path, split: str = "test", meshes: int = MESHES, repeats: int = 3) -> list[str]:
    """Lines of Markdown; a mesh that cannot be decimated so far is left out of that row."""
    found = entries(folder, split)
    rows: dict[int, list[tuple[float, float, float]]] = {n: [] for n in FACES}
    for entry in found[-meshes:]:
        mesh = entry.read()
        for n in FACES:
            try:
                made = decimate(mesh, n)
                rows[n] += [compare(made.V0, made.F0, bits, repeats) for bits in BITS]
            except NpmError:
                continue
    lines = ["| faces | cases | bytes over Draco's | time to encode | time to decode |", "|---|---|---|---|---|"]
    lines += [_row(f"{n:,}", rows[n]) for n in FACES if rows[n]]
    sources = _chosen([e for e in found if SOURCE_FACES[0] <= e.faces <= SOURCE_FACES[1]], meshes)
    plain = []
    for entry in sources:
        mesh = entry.read()
        plain += [compare(mesh.V, mesh.F, bits, 1) for bits in SOURCE_BITS]
    return [*lines, _row("not decimated", plain)]


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("corpus", type=Path)
    parser.add_argument("--split", default="test")
    parser.add_argument("--meshes", type=int, default=MESHES)
    o = parser.parse_args()
    print("\n".join(table(o.corpus, o.split, o.meshes)))


if __name__ == "__main__":
    main()
