"""The subdivision codec without a network as one stream of 400 base faces that is cut for each budget."""

from benchmarks.subdivision import search, stream
from npm_blender.core.errors import StreamError
from npm_blender.core.mesh import TriMesh

from .case import Case, Coded
from .subdivision_codec import FIRST, at_scalars, base

NAME = "Subdivision codec, one stream"


def whole(case: Case, most: int) -> bytes:
    """The stream, of `most` bytes or a little more."""
    return case.once(("subdivision stream", most), lambda: search.staged(base(case, *FIRST), search.COARSEST, most))


def at_bytes(case: Case, budgets: tuple[int, ...]) -> list[Coded | None]:
    """The stream, cut."""
    data = whole(case, max(budgets))
    return [_decoded(data[:budget]) for budget in budgets]


def _decoded(data: bytes) -> Coded | None:
    try:
        mesh: TriMesh = stream.read(data)
    except StreamError:  # shorter than the base mesh
        return None
    return Coded(mesh, len(data), f"{FIRST[0]} faces, cut")


__all__ = ["NAME", "at_bytes", "at_scalars"]
