"""How few faces a surface can have: what no decimation that keeps the topology gets below, and what shows its handles."""
from dataclasses import dataclass
from enum import Enum, auto

import numpy as np

from ..mesh import component_labels, directed_edges, opposite_halfedges, topology_of
from ..settings import AUTO

HANDLE = 24  # faces of a base for each handle of the surface: with the least, about 10, its faces span tubes (docs/lod.md)


class Cause(Enum):
    """What keeps the number of faces of a base from being the one asked for."""

    NONE = auto()
    SMALL_INPUT = auto()  # the input has fewer
    EVEN = auto()  # a closed mesh has an even number
    SINGLE_FACE = auto()  # no collapse removes just one face
    NO_COLLAPSE = auto()  # none is left that keeps topology and shape
    PARTS = auto()  # its components, or the handles and borders of its one component, need more
    HANDLES = auto()  # its handles need more


@dataclass(frozen=True)
class FaceAdvice:
    """Why a base has more faces than asked for, or fewer, and with how many faces it would show its parts and handles.

    faces: with how many to decimate again, 0 where the base is to be left; needed: the faces that PARTS or HANDLES need at
    least; parts: components of the surface (with PARTS); handles: of all of them, and recognizable: the faces that they
    get to be recognizable, or 0 (with HANDLES).
    """

    faces: int = 0
    cause: Cause = Cause.NONE
    needed: int = 0
    parts: int = 0
    handles: int = 0
    recognizable: int = 0


def least_faces(F: np.ndarray) -> tuple[int, int]:
    """Components of an oriented manifold F (m, 3), and a number of faces that all of them together cannot go below.

    A sphere needs 4 faces, a disk 1, a tube 6, a closed surface of genus g at least those of its smallest
    triangulation (Jungerman and Ringel 1980; 14 for the torus): n = ceil((7 + sqrt(1 + 48 g)) / 2) vertices, one more for
    g = 2, and 2 n - 4 + 4 g faces. Raises MeshError if F is not an oriented edge-manifold.
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


def face_advice(F: np.ndarray, asked: int, most: int) -> FaceAdvice:
    """Whether the parts or handles of a base F (m, 3), decimated to its least, need more faces than the number asked for.

    Where the parts need more, the large ones are to get half as many as asked for on top; where handles keep that number from
    being reached, each is to get HANDLE faces, up to `most` in all. A number that was reached stays. AUTO: HANDLE faces
    a handle at least, without a cause. faces is 0 where there is no more room.
    """
    if len(F) <= asked:
        return FaceAdvice()
    topology = topology_of(F)
    handles = int(topology.genus)
    wanted = HANDLE * handles + 4 * (topology.components - 1) if handles else 0
    for_handles = min(wanted, most)
    if asked == AUTO:
        return FaceAdvice(faces=for_handles if for_handles > len(F) else 0)
    parts, least = least_faces(F)
    for_parts = least + asked // 2 if least > asked else 0
    faces = max(for_handles, for_parts)
    faces = faces if faces > len(F) else 0
    if wanted >= max(for_parts, len(F)):
        recognizable = for_handles if for_handles > len(F) else 0
        return FaceAdvice(faces, Cause.HANDLES, needed=len(F), handles=handles, recognizable=recognizable)
    if least > asked:
        return FaceAdvice(faces, Cause.PARTS, needed=least, parts=parts)
    return FaceAdvice(faces)
