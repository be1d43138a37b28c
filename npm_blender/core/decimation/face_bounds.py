"""How few faces a surface can have: what no decimation that keeps the topology gets below, and what shows its handles."""
import numpy as np

from ..mesh import component_labels, directed_edges, opposite_halfedges, topology_of
from ..settings import AUTO

HANDLE = 24  # faces of a base for each handle of the surface: with the least, about 10, its faces span tubes (docs/lod.md)


def least_faces(F: np.ndarray) -> tuple[int, int]:
    """Components of an oriented manifold F (m, 3), and a number of faces that all of them together cannot go below.

    A sphere needs 4 faces, a disk 1, a tube 6, a closed surface of genus g at least those of its smallest
    triangulation (Jungerman and Ringel 1980; 14 for the torus). Raises MeshError if F is not an oriented edge-manifold.
    """
    opposite = opposite_halfedges(F)
    h = np.arange(F.size)
    border = opposite == h
    n = int(F.max()) + 1
    _, part = np.unique(component_labels(len(F), h // 3, opposite // 3), return_inverse=True)
    part = part.reshape(-1)
    count = int(part.max()) + 1
    of_vertex = np.zeros(n, np.int64)
    of_vertex[F.reshape(-1)] = np.repeat(part, 3)
    used = np.unique(F)
    start, end = directed_edges(F)[border].T
    loops = component_labels(n, start, end)
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


def roomier(F: np.ndarray, base_faces: int, most: int) -> tuple[int, str]:
    """With how many faces to decimate again, where the base F (m, 3) is pressed to its least, and one line that says why.

    base_faces: what was asked for. Where the parts need more, the large ones get half as many as asked for on top; where
    handles keep it from being reached, each gets HANDLE faces, up to `most` in all. A number that was reached stays. AUTO:
    HANDLE faces a handle at least, without a line. (0, '') where F is to be left, (0, line) where there is no more room.
    """
    if len(F) <= base_faces:
        return 0, ""
    topology = topology_of(F)
    holes = int(topology.genus)
    wanted = HANDLE * holes + 4 * (topology.components - 1) if holes else 0
    faces = min(wanted, most)
    if base_faces == AUTO:
        return (faces if faces > len(F) else 0), ""
    why = too_many_parts(F, base_faces)
    parts = least_faces(F)[1] + base_faces // 2 if why else 0
    if wanted >= max(parts, len(F)):
        got = f" and got {faces:,} to be recognizable" if faces > len(F) else ""
        why = (f"the handles of the mesh (holes through it: {holes:,}) need at least {len(F):,} base faces{got}; "
               f"ask for {len(F):,} or more, or close holes")
    faces = max(faces, parts)
    return (faces if faces > len(F) else 0), why
