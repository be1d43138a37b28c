"""Offsets: how they are fitted, with and without torch, and what the decoder does with them."""
import numpy as np
import pytest

from npm_blender.core.geometry.closest_point import ClosestPoints
from npm_blender.core.levels.lod_sequence import build_lod
from npm_blender.core.mesh.subdivision import hierarchy
from npm_blender.core.mesh.triangle_mesh import TriMesh, UnitFrame
from npm_blender.core.network.decoder import decode
from npm_blender.core.network.frames import edge_frames
from npm_blender.core.network.mesh_index import MeshIndex
from npm_blender.core.network.numpy_backend import NUMPY
from npm_blender.core.network.weights import load_weights
from npm_blender.core.refinement.descent import Target
from npm_blender.core.refinement.offset_fit import OffsetFit
from npm_blender.core.refinement.offset_trace import traced_offsets
from npm_blender.core.refinement.refiner import Refiner
from npm_blender.core.settings import LodSettings
from tests.meshes.shapes import bumpy, grid

pytestmark = pytest.mark.torch

PARAMS = load_weights().params
STEPS = np.array([1e-3, 1.4e-3], np.float32)


class Case:
    """A shape in the unit frame with a LoD sequence of two levels above 100 faces."""

    def __init__(self, mesh):
        self.unit = TriMesh(UnitFrame.of(mesh.V).to_unit(mesh.V), mesh.F)
        self.lod = build_lod(self.unit, LodSettings(base_faces=100, levels=2))
        self.levels = hierarchy(self.lod.F0, len(self.lod.V0), 2)
        self.meshes = [MeshIndex.of(NUMPY, level) for level in self.levels[:-1]]
        self.surface = ClosestPoints(self.unit)
        self.latents = [np.zeros((mesh.m, 8), np.float32) for mesh in self.meshes]
        self.none = [np.zeros(len(level.edges)) for level in self.levels[:-1]]

    def decode(self, offsets):
        V0, sent = NUMPY.array(self.lod.V0), [o.astype(np.float32)[:, None] for o in offsets]
        return decode(NUMPY, PARAMS, V0, self.latents, self.meshes, sent)

    def error(self, ints, steps=STEPS, before=None):
        offsets = [b + i * s for b, i, s in zip(before or self.none, ints, steps, strict=True)]
        return self.surface.closest(self.decode(offsets)[-1].astype(float))[0].mean()

    def trace(self, steps=STEPS, before=None):
        return traced_offsets(PARAMS, self.lod.V0, self.latents, self.meshes, self.surface, before or self.none, steps)

    def fit(self, effort=8, bit=1e-5, before=None, steps=STEPS):
        refiner = Refiner(PARAMS, Target(self.unit, self.surface, self.lod, self.levels), effort)
        return OffsetFit(refiner, self.lod.V0, self.latents, before or self.none, steps, bit)


@pytest.fixture(scope="module", params=["closed", "open"])
def case(request):
    return Case({"closed": bumpy(3), "open": grid(24)}[request.param])


def test_an_offset_moves_one_midpoint_along_the_normal_of_its_edge(case):
    plain = case.decode(case.none)[0]
    n = case.levels[0].n
    _, _, normal, _ = edge_frames(NUMPY, NUMPY.array(case.lod.V0), case.meshes[0])
    for edge in (0, 17, len(case.none[0]) - 1):
        offsets = [o.copy() for o in case.none]
        offsets[0][edge] = 0.01
        moved = case.decode(offsets)[0] - plain
        assert np.allclose(moved[n + edge], 0.01 * normal[edge], atol=1e-6)
        assert not np.delete(moved, n + edge, 0).any()


def test_no_offsets_and_zeros_are_the_same(case):
    V0 = NUMPY.array(case.lod.V0)
    for a, b in zip(case.decode(case.none), decode(NUMPY, PARAMS, V0, case.latents, case.meshes), strict=True):
        assert np.array_equal(a, b)


def test_offsets_move_with_the_frame(case):
    """Turning and scaling the base and scaling the offsets turns and scales every level."""
    turn, size = np.array([[0, -1, 0], [1, 0, 0], [0, 0, 1]], np.float32), np.float32(0.5)
    offsets = [np.random.default_rng(0).normal(0, 0.003, (len(o), 1)).astype(np.float32) for o in case.none]
    V0 = NUMPY.array(case.lod.V0)
    plain = decode(NUMPY, PARAMS, V0, case.latents, case.meshes, offsets)
    moved = decode(NUMPY, PARAMS, V0 @ turn.T * size, case.latents, case.meshes, [o * size for o in offsets])
    for a, b in zip(plain, moved, strict=True):
        assert np.allclose(a @ turn.T * size, b, atol=2e-5)


def test_traced_offsets_bring_the_mesh_nearer_and_finer_steps_nearer_still(case):
    none, coarse = case.error([0 * o for o in case.none]), case.trace()
    fine = case.trace(STEPS / 8)
    assert case.error(fine, STEPS / 8) < case.error(coarse) < none
    assert all(i.dtype == np.int32 and i.shape == o.shape for i, o in zip(coarse, case.none, strict=True))


def test_a_second_pass_goes_on_where_the_first_ended(case):
    first = case.trace()
    before = [i * s for i, s in zip(first, STEPS, strict=True)]
    second = case.trace(STEPS / 4, before)
    assert case.error(second, STEPS / 4, before) < case.error(first)
    assert np.abs(np.concatenate(second)).mean() < np.abs(np.concatenate(case.trace(STEPS / 4))).mean()


@pytest.mark.slow
def test_fitted_offsets_are_better_than_traced_ones(case):
    fit = case.fit(16, bit=0.0, steps=STEPS / 4)
    start = case.trace(STEPS / 4)
    fitted = fit.whole(start)
    assert fit.error(fitted) < 0.9 * fit.error(start)
    again = case.fit(16, bit=0.0, steps=STEPS / 4).whole(start)
    assert all(np.array_equal(a, b) for a, b in zip(fitted, again, strict=True))


@pytest.mark.slow
def test_dear_bits_make_offsets_few(case):
    count = [sum(np.count_nonzero(i) for i in case.fit(8, bit).whole(case.none)) for bit in (0.0, 1e-4, 1e-2)]
    assert count[0] > count[1] > count[2]


@pytest.mark.slow
def test_prefixes_of_the_staged_fit_bring_the_mesh_nearer(case):
    fit = case.fit(16)
    start = fit.whole(case.none)
    ranks = [np.where(np.arange(len(o)) % 3 == 0, 2.0, np.linspace(0, 1, len(o))) for o in case.none]
    staged = fit.staged(start, ranks)
    assert all(not s[r == 2].any() for s, r in zip(staged, ranks, strict=True))
    half = [s * (r < 0.5) for s, r in zip(staged, ranks, strict=True)]
    assert case.error(staged) < case.error(half) < case.error([0 * s for s in staged])


def test_offsets_that_do_not_help_are_left_out(case):
    """With steps as large as the mesh no offset brings it nearer."""
    fit = case.fit(4, bit=0.0, steps=np.array([1.0, 1.0], np.float32))
    start = [np.ones(len(o), int) for o in case.none]
    fit.descent.steps = 0
    assert not any(s.any() for s in fit.staged(start, [0 * o for o in case.none]))
