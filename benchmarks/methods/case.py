"""What every method gets and gives."""

from dataclasses import dataclass, field
from functools import cached_property

from npm_blender.core.decimate import decimate
from npm_blender.core.lod import LodSequence, levels
from npm_blender.core.mesh import TriMesh
from npm_blender.core.metrics import Original

BUDGETS = (1_000, 2_000, 4_000, 8_000, 16_000, 32_000)  # bytes
FEATURES = (0, 40, 400)  # of the paper's table 2
LEVELS = 3


@dataclass
class Case:
    """One mesh, cleaned, in the unit cube, with what methods share: made on first use, once.

    mesh: the input of every method; name: for progress; original: compares a decoded mesh with the input.
    """

    name: str
    mesh: TriMesh
    samples: int = 50_000
    seconds: dict[str, float] = field(default_factory=dict)

    @cached_property
    def original(self) -> Original:
        """The input, ready to be compared with many decoded meshes."""
        return Original(self.mesh, self.samples)

    @cached_property
    def lod(self) -> LodSequence:
        """The LoD sequence of 400 base faces."""
        return self.sequence(400)

    def sequence(self, base_faces: int) -> LodSequence:
        """The LoD sequence of another base."""
        return levels(decimate(self.mesh, base_faces), LEVELS)


@dataclass(frozen=True)
class Coded:
    """A mesh that came out of real bytes. mesh: decoded from them, unit cube; bytes: all of them; label: the setting."""

    mesh: TriMesh
    bytes: int
    label: str


__all__ = ["BUDGETS", "FEATURES", "LEVELS", "Case", "Coded"]
