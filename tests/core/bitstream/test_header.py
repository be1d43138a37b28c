"""Limits of every field: a header that is no header is refused before anything is allocated."""
from dataclasses import replace

import numpy as np
import pytest

from npm_blender.core.bitstream.header import (
    GROWTH_UNIT,
    MAX_LEVELS,
    MAX_NUMBERS,
    MAX_STAGES,
    STEP_UNIT,
    DisplacedCoding,
    Header,
    LatentCoding,
    ParsedStream,
)
from npm_blender.core.errors import StreamError

CODING = DisplacedCoding(smooth=8, step=128, growth=22, stages=3, payload=1000, ends=(3, 2))
HEADER = Header(2, 12, 5000, 100, 52, (1.0, -2.0, 0.1), 2.5, CODING)
LATENTS = LatentCoding("default", bytes(8), (0.5, 1.0), 8)


@pytest.mark.parametrize("wrong", [
    {"smooth": 9}, {"smooth": -1}, {"step": 1024}, {"step": -1}, {"growth": 0}, {"growth": 65}, {"stages": MAX_STAGES + 1},
    {"payload": 1 << 30}, {"payload": -1}, {"ends": (MAX_STAGES + 1, 0)}, {"ends": (-1, 0)},
], ids=str)
def test_a_coding_of_numbers_has_limits(wrong):
    with pytest.raises(StreamError, match="the file is corrupted"):
        replace(CODING, **wrong)


@pytest.mark.parametrize("wrong", [
    {"model_id": ""}, {"model_id": "x" * 33}, {"model_id": "\n"}, {"model_id": "ü"}, {"weights_hash": b"1"}, {"channels": 0},
    {"channels": 33}, {"steps": (0.0, 1.0)}, {"steps": (float("nan"), 1.0)}, {"steps": (1.0, float("inf"))},
], ids=str)
def test_a_coding_of_latents_has_limits(wrong):
    with pytest.raises(StreamError, match="the file is corrupted"):
        replace(LATENTS, **wrong)


@pytest.mark.parametrize("wrong", [
    {"levels": MAX_LEVELS + 1}, {"levels": 1}, {"position_bits": 3}, {"position_bits": 21}, {"total_features": MAX_NUMBERS + 1},
    {"source_faces": -1}, {"source_vertices": 1 << 41}, {"low": (0.0, 0.0)}, {"low": (0.0, float("nan"), 0.0)}, {"size": 0.0},
    {"size": float("inf")}, {"coding": replace(CODING, ends=())}, {"coding": replace(LATENTS, steps=(1.0,))},
    {"levels": 0, "coding": replace(LATENTS, steps=())},
], ids=str)
def test_a_header_has_limits(wrong):
    with pytest.raises(StreamError, match="the file is corrupted"):
        replace(HEADER, **wrong)


def test_a_base_alone_is_a_stream_of_no_levels():
    assert Header(0, 12, 0, 100, 52, (0, 0, 0), 1, DisplacedCoding(0, 0, 22, 0, 0)).levels == 0


def test_steps_halve_from_stage_to_stage_and_grow_from_level_to_level():
    steps = np.array([CODING.steps(2, stage) for stage in range(3)])
    assert np.allclose(steps[0, 0], 2.0 ** (-128 / STEP_UNIT))
    assert (steps[1:] == steps[:-1] / 2).all() and np.allclose(steps[:, 1:] / steps[:, :-1], 22 / GROWTH_UNIT)


def test_floats_are_what_a_file_keeps_of_them():
    assert replace(HEADER, size=0.1).size == np.float32(0.1) and HEADER.low[2] == 0.1
    assert replace(LATENTS, steps=(0.1, 0.2)).steps == (np.float32(0.1), np.float32(0.2))
    assert HEADER.frame.to_object(np.zeros((1, 3))).tolist() == [[1.0, -2.0, 0.1]]


def test_positions_are_lattice_points_over_the_frame():
    ends = np.array([0]), np.array([99])
    parsed = ParsedStream(HEADER, np.array([[4096, 0, 2048]]), np.zeros((0, 3)), None, ends, 99, False, None)
    assert parsed.V0.tolist() == [[1.0, 0.0, 0.5]] and parsed.features == 0
