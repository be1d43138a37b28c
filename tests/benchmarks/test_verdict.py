"""The verdict counts both sides only where both have a file, the larger of both distances, and errors from the floor on."""

from pathlib import Path

import numpy as np
import pytest

from benchmarks import verdict
from benchmarks.results import FLOOR, LEAST, Results
from benchmarks.tables import LARGE
from corpus.meshes import Entry

NAMES = {"ours": "ours", "ours_sized": "sized", "ours_paper": "the paper's model", "qslim_draco": "QSlim + Draco"}
KB = 1000


def line(mesh, errors, code="abc"):
    """A mesh's line; errors: by budget, (d_pm, d_reverse, d_normal, bytes)."""
    rest = {"table": "bytes", "d_p99": 1.0, "d_max": 9.0}
    rows = [
        rest | {"at": at, "bytes": size, "d_pm": there, "d_reverse": back, "d_normal": normal}
        for at, (there, back, normal, size) in errors.items()
    ]
    return {"name": mesh, "rows": rows, "seconds": 1.0, "stages": {}, "faces": 100, "code": code}


def results(**methods):
    lines = {m: {x["name"]: x for x in found} for m, found in methods.items()}
    return Results.of(lines, NAMES, ["a", "b", "c"])


@pytest.fixture
def made():
    return results(
        ours=[
            line("a", {KB: (2.0, 8.0, 4.0, 900), 2 * KB: (0.1, 0.02, 1.0, 2000)}),
            line("b", {KB: (4.0, 2.0, 6.0, 1000), 2 * KB: (0.15, 0.15, 1.0, 1000)}),
            line("c", {2 * KB: (1.0, 1.0, 1.0, 2000)}),
        ],
        ours_sized=[line("a", {KB: (4.0, 4.0, 1.0, 1000)})],
        ours_paper=[line("a", {KB: (12.0, 4.0, 1.0, 1000)})],
        qslim_draco=[
            line("a", {KB: (4.0, 4.0, 8.0, 1000), 2 * KB: (0.05, 0.05, 1.0, 2000)}),
            line("b", {KB: (1.0, 2.0, 2.0, 1000), 2 * KB: (0.3, 0.1, 1.0, 2000)}),
            line("c", {KB: (1.0, 1.0, 1.0, 1000), 2 * KB: (2.0, 2.0, 1.0, 2000)}),
        ],
    )


def cells(lines, start):
    """The cells of 1 and 2 kB of the row whose title begins so."""
    row = next(x for x in lines if x.startswith(f"| {start}"))
    return row.split(" | ")[1:3]


def test_the_mean_is_of_the_larger_distance_where_both_have_a_file(made):
    lines = verdict.table(made)
    assert cells(lines, "worse way, ours over") == ["2.000 (2)", f"{(1 * 0.2 / 0.3 * 0.5) ** (1 / 3):.3f} (3)"]
    assert cells(lines, "the worst mesh") == ["2.00 a", "1.00 a"]
    assert cells(lines, "d_normal") == ["5.00 / 5.00", "1.00 / 1.00"]
    assert cells(lines, "meshes without") == ["1 / 0", "0 / 0"]


def test_without_the_floor_errors_count_as_they_are(made):
    lines = verdict.without_floor(made)
    assert cells(lines, "worse way, ours over") == ["2.000 (2)", f"{(2 * 0.15 / 0.3 * 0.5) ** (1 / 3):.3f} (3)"]
    assert cells(lines, "the worst mesh") == ["2.00 a", "2.00 a"]
    assert not any("d_normal" in x for x in lines)


def test_a_ratio_of_one_way_to_the_other_is_never_below_one(made):
    with_floor, without = (cells(verdict.table(made, least), "ours, worse way over better")[0] for least in (FLOOR, LEAST))
    assert with_floor == without == f"{np.sqrt(4 * 2):.3f}"


def test_the_one_stream_stands_beside_the_file_made_for_the_size(made):
    assert cells(verdict.table(made), "one stream over") == ["2.000 (1)", "-"]
    assert cells(verdict.table(made), "made for its size over") == ["1.000 (1)", "-"]


def test_the_paper_s_model_has_a_row(made):
    assert cells(verdict.table(made), "the paper's model over") == ["3.000 (1)", "-"]


def test_how_much_of_the_budget_is_used(made):
    assert cells(verdict.table(made), "bytes used")[0] == "95.0 % / 100.0 %"


def test_large_meshes_have_a_table_of_their_own(made):
    entries = [Entry("a", Path("a"), LARGE, ""), Entry("b", Path("b"), LARGE - 1, ""), Entry("c", Path("c"), 5, "")]
    large, everything = "\n".join(verdict.tables(made, entries)).split("### All meshes")
    measured = "ours 1, ours made for the size 1, the paper's model 1, QSlim + Draco 1; code of ours: abc (1)."
    assert f"Measured, of 1 meshes: {measured}" in large
    assert "2.000 (1)" in large and "2.000 (2)" in everything


def test_faces_of_a_folder_without_manifest_are_those_that_were_measured():
    found = results(ours=[line("a", {}) | {"faces": LARGE}], qslim_draco=[line("a", {})])
    text = "\n".join(verdict.tables(found, [Entry("a", Path("a"), 0, "")]))
    assert "Measured, of 1 meshes: ours 1" in text.split("### All meshes")[0]


def test_what_failed_and_what_was_not_measured_is_said():
    found = results(ours=[line("a", {KB: (1.0, 1.0, 1.0, 900)}, ""), {"name": "b", "error": "MeshError: torn"}])
    assert verdict.measured(found) == (
        "Measured, of 3 meshes: ours 1 (failed: 1), ours made for the size 0, the paper's model 0, QSlim + Draco 0; "
        "code of ours: unknown (1)."
    )
    assert not any(x.startswith("|") for x in verdict.tables(found, []))
