"""Stages: more numbers are never farther off at any level, and finer levels never farther than coarser ones."""
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from npm_blender.core.bitstream import read_stream
from npm_blender.core.codec.displaced_decoder import DisplacedDecoder
from npm_blender.core.codec.displaced_sender import default_faces
from npm_blender.core.codec.stages import SAME, Stages, _falling
from npm_blender.core.fitting import StageFit, default_rate
from npm_blender.core.mesh import TriMesh
from tests.core.codec.senders import free, stages, target
from tests.core.codec.streams import SHAPES, opened

NAMES = pytest.mark.parametrize("name", SHAPES)


@given(st.lists(st.floats(1e-6, 1), min_size=1, max_size=12))
def test_where_errors_stop_falling_a_level_stays(errors):
    end = _falling(np.array(errors))
    assert errors[end] == min(errors[: end + 1])
    assert all(b <= SAME * min(errors[: k + 1]) for k, b in enumerate(errors[1: end + 1]))


@NAMES
def test_every_stage_that_is_kept_helps(name):
    made = stages(name)
    assert made.errors == sorted(made.errors, reverse=True) and made.errors[-1] < 0.7 * made.errors[0]
    assert len(made.table) == len(made.errors) - 1 and made.errors[-1] < made.errors[-2]


@NAMES
def test_the_stream_holds_the_integers_and_the_receiver_is_as_near_as_the_sender_said(name):
    made = stages(name)
    made.ends = ()
    data, count = made.stream(made.table, made.step)
    read = read_stream(data, strict=True)
    assert np.array_equal(read.details.table, made.table) and read.features == count == read.header.total_features
    V = DisplacedDecoder(read).vertices(count, made.base.surface.levels)
    error = target(name).source.error(TriMesh(V, made.base.surface.hierarchy[-1].F), 20_000)
    assert error == pytest.approx(made.errors[-1], rel=1e-6)


def test_the_finest_level_of_a_stage_is_left_out_where_it_does_harm():
    made = Stages(target("closed"), free("closed", 60, 2).rounded(10))
    kept, first = np.zeros(len(made.near), np.int64), made.base.surface.first
    harm = kept.copy()
    harm[first[2]:] = 40
    steps = made.coding(made.step, 1, 0).steps(2, 0)
    found, error = made._without_finest(StageFit(harm, default_rate(2), np.inf), made.error(harm, steps), kept, steps)
    assert not found.value.any() and error == made.error(kept, steps)


def test_a_base_without_levels_has_no_stages():
    made = Stages(target("open"), free("open", 60, -1).rounded(10))
    data, count = made.stream(made.nothing(), 0)
    assert count == 0 and read_stream(data, strict=True).header.levels == 0


def test_a_mesh_of_few_faces_is_its_own_base():
    assert default_faces(len(target("closed").mesh.F)) == len(target("closed").mesh.F)
    assert default_faces(5_000) < 1_000 and default_faces(1_000_000) == default_faces(100_000) < 1_000


def errors_of(stream, source, seed=0):
    """The worse way, unit frame, of every level at every stop."""
    frame = stream.header.frame

    def shown(k, level):
        return TriMesh(frame.to_unit(stream.decode_positions(k, level)), stream.level_faces(level, k))

    return np.array([[source.error(shown(k, level), 20_000) for level in range(stream.levels + 1)] for k in stream.stops])


@pytest.mark.slow
@NAMES
def test_more_numbers_are_never_farther_off_at_any_level(name):
    errors = errors_of(opened(name), target(name).source)
    assert (errors[1:] <= 1.06 * np.minimum.accumulate(errors, 0)[:-1] + 1e-6).all()


@pytest.mark.slow
@NAMES
def test_a_finer_level_is_never_farther_off_than_a_coarser_one(name):
    errors = errors_of(opened(name), target(name).source)
    assert (errors[:, 1:] <= 1.06 * errors[:, :-1] + 1e-6).all()
