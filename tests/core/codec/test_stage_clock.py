"""Stages of a run: their seconds, and their shares of one progress bar."""
import pytest

from npm_blender.core.codec.stage_clock import StageClock


def test_each_stage_has_its_share_of_the_bar():
    seen = []
    clock = StageClock(lambda fraction, message: seen.append(fraction), {"a": 1, "b": 2, "c": 1})
    for name in "abc":
        with clock.stage(name) as progress:
            progress(0.0, name)
            progress(1.0, name)
    assert seen == [0, 0.25, 0.25, 0.75, 0.75, 1]


def test_the_bar_never_falls_back_where_a_stage_comes_again():
    seen = []
    clock = StageClock(lambda fraction, message: seen.append(fraction), {"a": 1, "b": 1})
    for name in "aba":
        with clock.stage(name) as progress:
            progress(0.5, name)
    assert seen == [0.25, 0.75, 0.75]


def test_seconds_add_up_also_where_a_stage_raises():
    clock = StageClock(lambda fraction, message: None, {"a": 1, "b": 1})
    with pytest.raises(KeyError), clock.stage("a"):
        raise KeyError
    first = clock.seconds["a"]
    with clock.stage("a"):
        sum(range(1000))
    assert clock.seconds["a"] > first >= 0 and "b" not in clock.seconds
