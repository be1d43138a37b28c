"""Timing and memory beside peers: one group of operations on small meshes, in real processes."""
import contextlib
import io
import json
import math
import sys

import pytest

from benchmarks import operations as operations_module
from benchmarks import speed
from benchmarks.methods import drc
from benchmarks.operations import GROUPS, PAIRS, Inputs, faces_of, operations, pairs, slim
from npm_blender.core.settings import LodSettings
from tests.few_points import compare_by_few_points
from tests.meshes.shapes import torus

pytestmark = [pytest.mark.slow, pytest.mark.torch]


@pytest.fixture(scope="module", autouse=True)
def quick_streams():
    """Coarser ones than those that are compared."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(operations_module, "FINE", LodSettings(base_faces=100, levels=2))
        compare_by_few_points(patch)
        yield


@pytest.fixture(scope="module")
def figures():
    """Opening a file, on tori of 1,024 and 2,304 faces; what runs once in a fresh process does so, the rest in this one."""
    child = speed._child

    def measured_here(*arguments):
        if arguments[0] != "--measure":
            return child(*arguments)
        patch.setattr(sys, "argv", ["speed", *arguments])
        with contextlib.redirect_stdout(io.StringIO()) as said:
            speed.main()
        return json.loads(said.getvalue())

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(speed, "_child", measured_here)
        return speed.measure(repeats=1, small=(32, 16), large=(48, 24), slow=False, groups=("open",))


def test_every_row_has_seconds_memory_and_a_ratio_to_its_peer(figures):
    assert [row["group"] for row in figures["rows"]] == ["open"]
    for row in figures["rows"]:
        ours, peer = figures["operations"][row["ours"]], figures["operations"][row["peer"]]
        for one in (ours, peer):
            assert one["seconds"] > 0 and one["first_seconds"] > 0 and one["peak_mb"] >= one["start_mb"] > 10
        assert math.isclose(row["ratio"], ours["seconds"] / peer["seconds"])


def test_memory_is_the_fresh_process_s_own(figures):
    """A process that only reads Draco holds less than one that runs our decoder, whatever started them."""
    draco, ours = figures["operations"]["open drc"], figures["operations"]["open"]
    assert ours["peak_mb"] - ours["start_mb"] > draco["peak_mb"] - draco["start_mb"]


def test_stages_and_forward_passes_are_there(figures):
    assert {"clean", "fit", "write"} <= set(figures["stages"])
    assert set(figures["forward"]) == {"numpy", "torch"}
    assert all(seconds > 0 for pair in figures["forward"].values() for seconds in pair.values())


def test_table_has_the_command_and_a_line_for_every_row(figures):
    lines = speed.table(figures)
    assert lines[0].startswith("`python -m benchmarks.speed`")
    body = [line for line in lines if line.startswith("| open the base, ")]
    assert len(body) == len(figures["rows"]) and f"{figures['facts']['base']:,} faces" in body[0]
    assert f"{figures['rows'][0]['ratio']:.2f}" in body[0]


def test_every_row_names_operations_that_there_are():
    names = [o.name for o in operations()]
    assert len(set(names)) == len(names) and {"meshoptimizer, as many faces"} >= {p.who for p in PAIRS} - {p.who for p in pairs()}
    assert {pair.group for pair in pairs()} == set(GROUPS)
    assert {pair.group for pair in pairs(slow=False)} == {"decode", "open", "slider"}
    assert {pair.group for pair in pairs(("sized", "large"))} == {"sized", "large"}


def test_what_is_compared_is_of_equal_size(tmp_path):
    small = torus(32, 16)
    inputs = Inputs.write(tmp_path, small, torus(48, 24))
    assert Inputs.read(tmp_path) == inputs
    calls = {o.name: o.prepare(inputs) for o in operations()}
    assert len(calls["open"]().F) == len(calls["open drc"]().F) == inputs.facts["base"]
    assert len(calls["decode"]().F) == len(calls["slide"]().F) == len(calls["seen"]().F) == inputs.facts["fine"]
    faces = faces_of(small, 900)
    assert abs(len(drc.encode(slim(small, faces), 11)) - 900) < 90
    assert (tmp_path / "written.npmesh").exists() is False
    assert calls["compress"]() == inputs.bytes_of("ours.npmesh") == (tmp_path / "written.npmesh").read_bytes()


def test_calls_take_turns_and_the_first_does_not_count():
    order = []
    speed.medians({"a": lambda: order.append("a"), "b": lambda: order.append("b")}, repeats=2)
    assert "".join(order) == "ab" + "abab"


def test_a_process_that_fails_is_an_error():
    with pytest.raises(RuntimeError, match="exit code"):
        speed._child("--once", "no such operation", "no such folder")
