"""Steps from a half-edge to its neighbours in the same face, compiled; numbering as in `mesh.topology`."""
from ..jit import compiled


@compiled(inline="always")
def next_halfedge(h):
    """The next half-edge in the face of h."""
    return h - 2 if h % 3 == 2 else h + 1


@compiled(inline="always")
def prev_halfedge(h):
    """The previous half-edge in the face of h."""
    return h + 2 if h % 3 == 0 else h - 1


@compiled
def end_of(flat, h):
    """The vertex at the end of half-edge h."""
    return flat[h - 2] if h % 3 == 2 else flat[h + 1]
