import json
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from benchmarks import losses, tables
from benchmarks.methods.case import BUDGETS
from benchmarks.results import COLUMNS, FLOOR, LEAST, Results, write_json
from corpus.meshes import Entry

NAMES = {"ours": "ours", "ours_sized": "sized", "ours_paper": "the paper's model", "qslim_draco": "QSlim + Draco",
         "qslim": "QSlim"}


def line(mesh, table, d_pm, **more):
    rows = []
    for at, value in d_pm.items():
        rows.append({"table": table, "at": at, "d_pm": value, "d_reverse": value, "d_p99": 4 * value, "d_normal": 5.0,
                     "d_max": 9 * value, "bytes": 900, "cr": 10.0} | more)
    return {"name": mesh, "rows": rows, "seconds": 2.0, "stages": {}}


def results(**methods):
    lines = {m: {x["name"]: x for x in found} for m, found in methods.items()}
    return Results.of(lines, NAMES, ["a", "b", "c"])


@pytest.fixture
def made():
    ours = [line("a", "bytes", {1000: 2.0, 2000: 1.0}), line("b", "bytes", {1000: 8.0, 2000: 4.0}),
            line("c", "bytes", {2000: 1.0})]
    peer = [line("a", "bytes", {1000: 4.0, 2000: 0.5}), line("b", "bytes", {1000: 4.0, 2000: 1.0}),
            {"name": "c", "error": "MeshError: torn"}]
    return results(ours=ours, qslim_draco=peer)


def test_the_mean_is_geometric_and_over_the_meshes_that_both_have(made):
    assert made.ratio("ours", "qslim_draco", "bytes", 1000) == pytest.approx((1.0, 2))
    assert made.ratio("ours", "qslim_draco", "bytes", 2000) == pytest.approx((np.sqrt(8), 2))
    assert made.ratio("ours", "qslim_draco", "bytes", 4000)[1] == 0


def test_the_worse_way_is_the_larger_distance_and_counts_from_its_floor_on():
    ours = line("a", "bytes", {1000: 2.0, 2000: 0.01}, d_reverse=4.0)
    peer = line("a", "bytes", {1000: 2.0, 2000: 0.1}, d_reverse=0.05)
    found = results(ours=[ours], qslim_draco=[peer])
    assert found.ratio("ours", "qslim_draco", "bytes", 1000) == pytest.approx((2.0, 1))
    assert found.ratio("ours", "qslim_draco", "bytes", 1000, "d_pm") == pytest.approx((1.0, 1))
    assert found.ratio("ours", "qslim_draco", "bytes", 2000)[0] == pytest.approx(4.0 / FLOOR)
    assert found.ratio("ours", "qslim_draco", "bytes", 2000, least=LEAST)[0] == pytest.approx(4.0 / 0.1)


def test_wins_and_losses_are_counted_by_mesh(made):
    assert made.wins("ours", "qslim_draco", "bytes", 1000) == (1, 1)
    assert made.wins("ours", "qslim_draco", "bytes", 2000) == (0, 2)
    assert made.wins("ours", "qslim_draco", "bytes", 2000, "d_normal") == (0, 0)


def test_a_failure_is_listed_and_is_no_figure(made):
    assert made.errors == [("qslim_draco", "c", "MeshError: torn")]
    assert "c" not in made.values("qslim_draco", "bytes", 2000)


def test_the_paragraph_says_where_we_lose(made):
    text = losses.paragraph(made)
    assert "1 kB 50 % and 0 % (our error is 1.00 of its); 2 kB 100 % and 0 % (our error is 2.83 of its)" in text


def test_the_paragraph_compares_files_made_for_their_size(made):
    assert losses.sized(made) == ""
    sized = [line("a", "bytes", {1000: 2.0}), line("b", "bytes", {1000: 2.0})]
    peer = [line("a", "bytes", {1000: 4.0}), line("b", "bytes", {1000: 1.0})]
    found = results(ours_sized=sized, qslim_draco=peer)
    assert "1 kB 1.00 of QSlim + Draco's, farther on 50 % of 2 meshes" in losses.sized(found)


def test_the_byte_table_has_every_method_and_says_of_how_few_meshes(made):
    text = "\n".join(tables.byte_ratios(made, "d_pm"))
    assert "| ours | 1.000 | 2.828 | - |" in text and "| QSlim + Draco itself (meshes) | 4 (2) | 0.707 (2) |" in text


def test_kinds_and_large_meshes_have_rows_of_their_own():
    found = results(
        ours=[line("a", "bytes", {BUDGETS[0]: 1.0}), line("b", "bytes", {BUDGETS[0]: 4.0})],
        qslim_draco=[line("a", "bytes", {BUDGETS[0]: 2.0}), line("b", "bytes", {BUDGETS[0]: 2.0})],
    )
    entries = [Entry("a", Path("a"), tables.LARGE, "scan"), Entry("b", Path("b"), 100, "cad")]
    text = "\n".join(tables.by_kind(found, entries))
    assert "| scan (1) | 0.500 |" in text and "| cad (1) | 2.000 |" in text
    assert f"| at least {tables.LARGE:,} faces (1) | 0.500 |" in text


def test_rows_that_are_no_compression_stay_out_of_the_curve():
    slim = [line("a", "scalars", {0: 4.0}), line("b", "scalars", {0: 1e-9}, cr=0.9)]
    ours = [line("a", "scalars", {0: 2.0}), line("b", "scalars", {0: 5.0}, cr=0.9)]
    found = results(ours=ours, qslim=slim)
    assert "| ours | 0.500 (1) |" in "\n".join(tables.cr_curve(found))


def test_the_paper_s_tables_show_its_model():
    model = line("a", "features", {0: 6.0, 40: 3.0}) | {"seconds": 1.0}
    model["rows"] += line("a", "levels, 400", {1: 7.0})["rows"]
    slim = line("a", "scalars", {0: 12.0, 40: 4.0})
    found = results(ours=[line("a", "features", {0: 99.0})], ours_paper=[model], qslim=[slim])
    text = "\n".join(tables.by_features(found))
    assert "| the paper's model, no latents | 10.0 | 900 | 6.00 | **0.500** |" in text and "99" not in text
    assert "| the paper's model, 40 latents |" in text and "100.0 % of meshes" in text
    assert "| 1 | 1,600 | 7.00 |" in "\n".join(tables.by_level(found))


def test_the_paragraph_says_where_numbers_are_better_spent_by_qslim():
    ours, model = line("a", "scalars", {400: 2.0}), line("a", "scalars", {0: 8.0, 400: 2.0})
    slim = line("a", "scalars", {0: 4.0, 400: 4.0})
    text = losses.losses_in_numbers(results(ours=[ours], ours_paper=[model], qslim=[slim]))
    assert "than ours 400 latents 0 % and 0 %, and than the paper's model 0 latents 100 % and 0 %; 400 latents 0 %" in text
    assert "a (8.0 against 4.0)" in text
    assert losses.losses_in_numbers(results(qslim=[slim])) == ""


def test_csv_has_a_line_for_every_row(made):
    lines = made.csv().splitlines()
    assert lines[0] == ",".join(COLUMNS) and len(lines) == 1 + 5 + 4


def test_json_has_no_nan(tmp_path):
    write_json(tmp_path / "x.json", {"a": float("nan"), 2: (1.23456789, np.inf)})
    assert json.loads((tmp_path / "x.json").read_text()) == {"a": None, "2": [1.2346, None]}


def test_every_plot_and_the_page_are_made_from_few_rows(made, tmp_path):
    pytest.importorskip("matplotlib")
    from benchmarks import plots, report

    assert all((tmp_path / name).stat().st_size > 1000 for name in plots.write(made, tmp_path))
    o = SimpleNamespace(corpus=None, split="test", samples=10, quick=True, limit=None, min_faces=0, report=None)
    page = report.page(made, o, None, "results", [])
    assert page.startswith("# Results\n\n**Where we lose.**")
    assert "## The verdict" in page and "Failed: 1. qslim_draco, c: MeshError: torn" in page
    assert report.figures(made, o, None)["bytes_ratio_to_qslim_draco"]["ours"][BUDGETS[1]]["ours_won_lost"] == (0, 0)
