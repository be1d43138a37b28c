"""What every method gets and gives."""

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property

import igl
import numpy as np

from npm_blender.core.cleaning import clean
from npm_blender.core.decimation import decimate
from npm_blender.core.evaluation import Original
from npm_blender.core.mesh import TriMesh, UnitFrame, in_morton_order
from npm_blender.core.network import FEATURES as NUMBERS_IN_LATENT
from npm_blender.core.settings import PAPER_FACES, CompressSettings

BUDGETS = (1_000, 2_000, 4_000, 8_000, 16_000, 32_000)  # bytes
FEATURES = (0, 40, 400)  # latents of the paper's table 2
CURVE = (0, 40, 120, 400, 1200)  # latents whose numbers are the points of the CR curve
BASE_FACES = PAPER_FACES
SEARCH_SAMPLES = 10_000  # points each way that a search for the best setting measures with


@dataclass
class Case:
    """One mesh, cleaned, in the unit cube, with what methods share: made on first use, once.

    mesh: the input of every method; name: for progress; original: compares a decoded mesh with the input; settings: of
    our own codec.
    """

    name: str
    mesh: TriMesh
    samples: int = 50_000
    seconds: dict[str, float] = field(default_factory=dict)
    settings: CompressSettings = field(default_factory=CompressSettings)
    _made: dict = field(default_factory=dict)

    @staticmethod
    def of(name: str, mesh: TriMesh, samples: int = 50_000, settings: CompressSettings | None = None) -> "Case":
        """The case of a mesh as a file has it: repaired where it is no manifold. Raises MeshError if it is no surface."""
        cleaned, _ = clean(mesh, "auto")
        unit = in_morton_order(TriMesh(UnitFrame.of(cleaned.V).to_unit(cleaned.V), cleaned.F))
        return Case(name, unit, samples, settings=settings or CompressSettings())

    @cached_property
    def original(self) -> Original:
        """The input, ready to be compared with many decoded meshes."""
        return Original(self.mesh, self.samples)

    @cached_property
    def base_vertices(self) -> int:
        """Vertices of the paper's base, of 400 faces."""
        return len(decimate(self.mesh, BASE_FACES).V0)

    def once(self, key, make: Callable):
        """make(), kept under `key`: what one method shares between its calls, or with others."""
        if key not in self._made:
            self._made[key] = make()
        return self._made[key]

    def qslim(self, faces: int) -> TriMesh:
        """The input decimated by libigl's qslim to at most so many faces, where it can."""
        if faces >= len(self.mesh.F):
            return self.mesh

        def make() -> TriMesh:
            V, F, *_ = igl.qslim(np.asfortranarray(self.mesh.V), np.asfortranarray(self.mesh.F), int(faces))
            return TriMesh.from_arrays(V, F)

        return self.once(("qslim", int(faces)), make)

    def worse(self, decoded: TriMesh) -> float:
        """The error by which searches choose, the worse way, from fewer points than the tables'. MeshError without area."""
        return self.original.worse(decoded, SEARCH_SAMPLES)

    def scalars(self, latents: int) -> int:
        """Numbers that the paper's model spends on its base mesh, 3 a vertex, and so many latents, 8 each."""
        return 3 * self.base_vertices + NUMBERS_IN_LATENT * latents

    def cr(self, scalars: int) -> float:
        """The paper's compression ratio for so many numbers."""
        return 3 * len(self.mesh.V) / scalars


@dataclass(frozen=True)
class Coded:
    """A mesh that came out of real bytes. mesh: decoded from them, unit cube; bytes: all of them; label: the setting."""

    mesh: TriMesh
    bytes: int
    label: str


__all__ = ["BUDGETS", "CURVE", "FEATURES", "Case", "Coded"]
