"""How few faces a surface can have: what no decimation that keeps the topology gets below."""
import numpy as np

from .settings import AUTO
from .topology import directed_edges, opposite_halfedges
from .unionfind import labels


def least_faces(F: np.ndarray) -> tuple[int, int]:
    """Components of an oriented manifold F (m, 3), and a number of faces that all of them together cannot go below.

    A sphere needs 4 faces, a disk 1, a tube 6, a closed surface of genus g at least those of its smallest
    triangulation (Jungerman and Ringel 1980; 14 for the torus). Raises MeshError if F is not an oriented edge-manifold.
    """
    opposite = opposite_halfedges(F)
    h = np.arange(F.size)
    border = opposite == h
    n = int(F.max()) + 1
    _, part = np.unique(labels(len(F), h // 3, opposite // 3), return_inverse=True)
    part = part.reshape(-1)
    count = int(part.max()) + 1
    of_vertex = np.zeros(n, np.int64)
    of_vertex[F.reshape(-1)] = np.repeat(part, 3)
    used = np.unique(F)
    start, end = directed_edges(F)[border].T
    loops = labels(n, start, end)
    edges = (3 * np.bincount(part, minlength=count) + np.bincount(part[h[border] // 3], minlength=count)) // 2
    euler = np.bincount(of_vertex[used], minlength=count) - edges + np.bincount(part, minlength=count)
    holes = np.bincount(of_vertex[np.unique(loops[start])], minlength=count)
    genus = np.maximum((2 - holes - euler) // 2, 0)
    vertices = np.where(genus == 0, 4, np.ceil((7 + np.sqrt(1 + 48 * genus)) / 2).astype(np.int64) + (genus == 2))
    closed = 2 * vertices - 4 + 4 * genus
    opened = np.maximum(5 * holes + 4 * genus - 4, np.where(genus > 0, closed - holes, 1))
    return count, int(np.where(holes > 0, opened, closed).sum())


def too_many_parts(F: np.ndarray, base_faces: int) -> str:
    """'', or one line where the parts of an oriented manifold F (m, 3) need more than the base_faces asked for."""
    if len(F) <= base_faces or base_faces == AUTO:
        return ""
    parts, least = least_faces(F)
    if least <= base_faces:
        return ""
    what = f"the {parts:,} separate parts of the mesh need" if parts > 1 else "the handles and borders of the mesh need"
    return (f"{what} at least {least:,} base faces, more than the {base_faces:,} asked for; "
            "ask for more, or join or delete small parts")
