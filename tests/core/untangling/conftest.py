import numpy as np
import pytest

from npm_blender.core.decimation.qem import decimate
from npm_blender.core.geometry.geodesic_trace import SurfacePoints
from npm_blender.core.levels.lod_sequence import build_levels
from npm_blender.core.mesh.subdivision import hierarchy
from npm_blender.core.untangling.one_rings import one_rings_of
from tests.meshes.lod_meshes import sheet, sphere


@pytest.fixture(params=[sphere, sheet], ids=["closed", "open"])
def case(request):
    """Levels, their rings, and points moved at random, so that many faces are flipped."""
    lod = build_levels(decimate(request.param(), 40), 2)
    H = hierarchy(lod.F0, len(lod.V0), 2)
    rng = np.random.default_rng(3)
    V = lod.V + rng.normal(scale=0.03, size=lod.V.shape)
    return H, one_rings_of(H), SurfacePoints(lod.source_face, lod.barycentric, V, lod.N)
