"""What a stream says of the mesh that it was made from."""
from dataclasses import dataclass

import numpy as np

from ..mesh import TriMesh, UnitFrame, in_morton_order


@dataclass(frozen=True)
class SourceFacts:
    """frame: its unit frame, as the header keeps it; faces, vertices: of the input."""

    frame: UnitFrame
    faces: int
    vertices: int


def lattice_frame(V: np.ndarray) -> UnitFrame:
    """The unit frame of a stream: its origin is the low corner of the box round V (n, 3), so that planes along the axes lie on
    the lattice; its unit the longest side, a float32. Raises MeshError if all of V coincide."""
    size = UnitFrame.of(V).size
    return UnitFrame(V.min(0), float(np.float32(size)))


def in_frame(mesh: TriMesh, frame: UnitFrame) -> TriMesh:
    """The mesh in the unit frame, in an order that suits memory."""
    return in_morton_order(TriMesh(frame.to_unit(mesh.V), mesh.F))
