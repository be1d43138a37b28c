"""Small targets and bases, made once, for the tests of the sender."""
from functools import cache

from npm_blender.core.codec.displaced_sender import more_stages
from npm_blender.core.codec.fitted_base import FreeBase
from npm_blender.core.codec.source_facts import SourceFacts, in_frame, lattice_frame
from npm_blender.core.codec.stages import Stages
from npm_blender.core.codec.target import Target
from npm_blender.core.mesh import TriMesh
from tests.core.codec.streams import SHAPES


def target_of(mesh: TriMesh) -> Target:
    """A mesh that is sent."""
    frame = lattice_frame(mesh.V)
    return Target(in_frame(mesh, frame), SourceFacts(frame, len(mesh.F), len(mesh.V)))


@cache
def target(name: str) -> Target:
    """A shape."""
    return target_of(SHAPES[name])


@cache
def free(name: str, faces: int = 60, levels: int = 2) -> FreeBase:
    """Its base."""
    return FreeBase(target(name), faces, levels)


@cache
def stages(name: str) -> Stages:
    """Its stages on a base of 60 faces."""
    made = Stages(target(name), free(name).rounded(0))
    more_stages(made, 10_000)
    return made
