"""QSlim (Garland and Heckbert 1997) as libigl has it: the mesh of so many vertices, as it is."""

from npm_blender.core.mesh import TriMesh

from .case import Case

NAME = "QSlim"
TRIES = 5


def with_vertices(case: Case, vertices: int) -> TriMesh | None:
    """The largest qslim found of at most so many vertices; None if it cannot get there."""
    best, faces = None, len(case.mesh.F) - 2 * (len(case.mesh.V) - vertices)  # exact but where borders are collapsed
    for _ in range(TRIES):
        slim = case.qslim(max(faces, 4))
        left = vertices - len(slim.V)
        if left >= 0 and (best is None or len(slim.V) > len(best.V)):
            best = slim
        if left == 0 or faces >= len(case.mesh.F):
            break
        faces += 2 * left
    return best


def at_scalars(case: Case, counts: list[int]) -> list[TriMesh | None]:
    """Three numbers a vertex."""
    return [with_vertices(case, count // 3) for count in counts]
