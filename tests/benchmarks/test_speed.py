"""Timing and memory beside peers: one group of operations on a small mesh, in real processes."""
import math

import pytest

from benchmarks import speed
from benchmarks.operations import GROUPS, operations

pytestmark = [pytest.mark.slow, pytest.mark.torch]


@pytest.fixture(scope="module")
def figures():
    """Opening a file, on a sphere of 1,280 faces."""
    return speed.measure(repeats=1, depth=3, slow=False, groups=("open",))


def test_every_row_has_seconds_memory_and_a_ratio_to_its_peer(figures):
    rows = figures["rows"]
    assert [row["method"] for row in rows] == [o.method for o in operations() if o.group == "open"]
    peer = next(row for row in rows if row["peer"])
    for row in rows:
        assert row["seconds"] > 0 and row["first_seconds"] > 0 and row["peak_mb"] >= row["start_mb"] > 10
        assert math.isclose(row["ratio"], row["seconds"] / peer["seconds"])


def test_memory_is_the_fresh_process_s_own(figures):
    """A process that only reads Draco holds less than one that runs our decoder, whatever started them."""
    draco, ours = (next(r for r in figures["rows"] if r["method"] == m) for m in ("Draco", "ours, finest level"))
    assert ours["peak_mb"] - ours["start_mb"] > draco["peak_mb"] - draco["start_mb"]


def test_stages_and_forward_passes_are_there(figures):
    assert {"decimate", "levels", "encode", "write"} <= set(figures["stages"])
    assert set(figures["forward"]) == {"numpy", "torch"}
    assert all(seconds > 0 for pair in figures["forward"].values() for seconds in pair.values())


def test_table_has_a_line_for_every_row(figures):
    lines = speed.table(figures)
    body = [line for line in lines if line.startswith("| " + GROUPS["open"])]
    assert len(body) == len(figures["rows"]) and sum("| peer |" in line for line in body) == 1
    assert f"{figures['stream_bytes']:,} bytes" in lines[-1]


def test_every_group_has_one_peer_and_names_are_unique():
    found = operations()
    assert len({o.name for o in found}) == len(found)
    for group in GROUPS:
        assert sum(o.peer for o in found if o.group == group) == 1


def test_calls_take_turns_and_the_first_does_not_count():
    order = []
    speed.medians({"a": lambda: order.append("a"), "b": lambda: order.append("b")}, repeats=2)
    assert "".join(order) == "ab" + "abab"


def test_a_process_that_fails_is_an_error():
    with pytest.raises(RuntimeError, match="exit code"):
        speed._child("--once", "no such operation", "no such folder")
