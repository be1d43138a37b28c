"""A mesh that is sent, and how far what is sent is from it: the worse way, the larger of both mean distances."""
import numpy as np

from ..displacement import DisplacedSurface
from ..fitting import Source
from ..mesh import TriMesh
from .source_facts import SourceFacts

CHECKED = 20_000  # samples each way that errors are measured with


class Target:
    """mesh: in the unit frame, see `source_facts.lattice_frame`; facts: what its stream says of it; source: its surface."""

    def __init__(self, mesh: TriMesh, facts: SourceFacts) -> None:
        """Raises MeshError if the mesh has no area."""
        self.mesh, self.facts, self.source = mesh, facts, Source(mesh)

    def error(self, surface: DisplacedSurface, V0: np.ndarray, moves: np.ndarray) -> float:
        """How far the finest level is from the mesh, unit frame. V0 (n0, 3): base vertices; moves (n,): along normals."""
        return self.source.error(TriMesh(surface.build(V0, moves).X[-1], surface.hierarchy[-1].F), CHECKED)
