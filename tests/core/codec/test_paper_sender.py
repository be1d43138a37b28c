"""The paper's own stream: latents, the most important first, and nothing else."""
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from npm_blender.core.bitstream import read_stream
from npm_blender.core.codec import compress, open_stream
from npm_blender.core.codec.paper_sender import _most
from npm_blender.core.settings import PAPER, CompressSettings
from tests.core.codec.streams import SHAPES, SMALL_PAPER, made, opened, silent


@given(st.integers(0, 200), st.integers(0, 200))
def test_the_most_that_fits_is_found(count, fits):
    assert _most(count, lambda k: k <= fits) == min(count, fits)


def test_no_latent_of_zeros_is_sent_and_none_twice():
    read = read_stream(made("torus", SMALL_PAPER).data, strict=True)
    assert read.details.value.any(1).all()
    assert len(set(zip(read.details.level.tolist(), read.details.face.tolist()))) == read.features


def test_numbers_are_eight_a_latent():
    stream = opened("torus", SMALL_PAPER)
    assert [stream.numbers(k) for k in (0, 3)] == [0, 24] and stream.stops[:3] == (0, 20, 40)


def test_a_budget_is_kept_by_leaving_out_the_last_latents():
    whole = opened("torus", SMALL_PAPER)
    size = (whole.base_bytes + whole.total_bytes) // 2
    done = compress(SHAPES["torus"], CompressSettings(SMALL_PAPER.lod, model=PAPER, budget=max(size, 300)), silent)
    cut = open_stream(done.data)
    assert len(done.data) <= max(size, 300) and 0 < cut.features < whole.features
    assert np.array_equal(cut.decode_positions(0, 1), whole.decode_positions(0, 1))


@pytest.mark.parametrize("name", SHAPES)
def test_it_needs_no_torch(name, monkeypatch):
    import sys
    monkeypatch.setitem(sys.modules, "torch", None)
    assert open_stream(made(name, SMALL_PAPER).data).model == PAPER
