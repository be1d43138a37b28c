"""The verbs on a real mesh through the real codec: what they print, what they write, what they refuse."""
import contextlib
import io
import json

import numpy as np
import pytest

from npm_blender.cli import evaluate, main
from npm_blender.core.codec import open_stream
from npm_blender.core.mesh.triangle_mesh import TriMesh
from npm_blender.core.meshio.mesh_files import FORMATS, read_mesh, write_mesh

from .conftest import bumpy_sphere

BASE, LEVELS = 100, 2
SETTINGS = ("--base-faces", BASE, "--levels", LEVELS)
STAGES = {"read", "clean", "fit", "write"}


@pytest.fixture(scope="module")
def made(sphere_file, tmp_path_factory):
    """(the .npmesh file, the JSON that compress printed)."""
    target = tmp_path_factory.mktemp("streams") / "sphere.npmesh"
    with contextlib.redirect_stdout(io.StringIO()) as out:
        assert main(["compress", str(sphere_file), str(target), *map(str, SETTINGS), "--json"]) == 0
    return target, json.loads(out.getvalue())


@pytest.fixture
def damaged_file(made, tmp_path):
    """(a file with one bit of its end changed, what is said about it after its name)."""
    data = made[0].read_bytes()
    path = tmp_path / "damaged.npmesh"
    path.write_bytes(data[:-1] + bytes([data[-1] ^ 4]))
    opened = open_stream(path.read_bytes())
    assert "found a wrong checksum" in opened.shortfall and 0 < opened.features < opened.total_features
    return path, opened.shortfall


@pytest.fixture
def few_samples(monkeypatch):
    """Measuring with a million points is for users."""
    monkeypatch.setattr(evaluate, "SAMPLES", 20_000)


def test_compress_reports_what_it_did(made):
    target, report = made
    assert report["faces"] == 2048
    assert (report["base_faces"], report["levels"]) == (BASE, LEVELS)
    assert report["bytes"] == target.stat().st_size
    assert isinstance(report["cleaning"], str) and report["cleaning"]
    assert set(report["seconds"]) >= STAGES and all(s >= 0 for s in report["seconds"].values())


def test_compress_prints_text_on_demand_and_the_same_bytes_again(run, made, sphere_file, tmp_path):
    outcome = run("compress", sphere_file, tmp_path / "again.npmesh", *SETTINGS)
    assert outcome.code == 0
    assert "2,048 faces" in outcome.out and f"{made[1]['bytes']:,} bytes" in outcome.out
    assert (tmp_path / "again.npmesh").read_bytes() == made[0].read_bytes()


@pytest.mark.parametrize("model", ["displaced", "paper"])
def test_settings_reach_the_codec(run, made, sphere_file, tmp_path, model):
    target = tmp_path / "other.npmesh"
    settings = ("--model", model, "--base-faces", 60, "--levels", 1, "--position-bits", 9, "--order", "magnitude")
    report = json.loads(run("compress", sphere_file, target, *settings, "--json").out)
    info = json.loads(run("info", target, "--json").out)
    assert (report["base_faces"], info["base_faces"], info["levels"], info["position_bits"]) == (60, 60, 1, 9)
    assert info["model"] == model and info["numbers"] == info["features"] * (8 if model == "paper" else 1)
    assert ("encode" in report["seconds"]) == (model == "paper")


@pytest.mark.slow
def test_what_is_not_told_suits_the_mesh(run, sphere_file, tmp_path):
    told = ("--base-faces", "auto", "--levels", "auto", "--position-bits", "auto")
    for name, arguments in (("silent", ()), ("told", told)):
        report = json.loads(run("compress", sphere_file, tmp_path / f"{name}.npmesh", *arguments, "--json").out)
        assert 20 <= report["base_faces"] <= 2048 and report["levels"] >= 1 and report["features"]
    assert (tmp_path / "silent.npmesh").read_bytes() == (tmp_path / "told.npmesh").read_bytes()


@pytest.mark.slow
def test_a_size_in_bytes_is_kept_and_chooses_what_is_not_told(run, sphere_file, tmp_path):
    target = tmp_path / "small.npmesh"
    report = json.loads(run("compress", sphere_file, target, "--bytes", 700, "--json").out)
    assert 500 < report["bytes"] == target.stat().st_size <= 700
    assert 100 < report["base_faces"] < 1000
    told = ("--bytes", 700, "--base-faces", 60, "--levels", 1)
    report = json.loads(run("compress", sphere_file, target, *told, "--json").out)
    assert (report["base_faces"], report["levels"]) == (60, 1) and report["bytes"] <= 700


@pytest.mark.slow
def test_a_size_that_the_base_does_not_fit_into_is_bad_input(run, sphere_file, tmp_path):
    target = tmp_path / "small.npmesh"
    outcome = run("compress", sphere_file, target, "--bytes", 400, "--base-faces", 400)
    assert outcome.code == 2 and "Expected a base mesh of at most 400 bytes" in outcome.error_line
    assert not target.exists()


@pytest.mark.parametrize("suffix", [suffix for suffix, form in FORMATS.items() if form.write])
def test_decompress_writes_every_format(run, made, tmp_path, suffix):
    target = tmp_path / f"out{suffix}"
    outcome = run("decompress", made[0], target, "--json")
    assert outcome.code == 0
    report, mesh = json.loads(outcome.out), read_mesh(target)
    assert len(mesh.F) == report["faces"] == BASE * 4 ** LEVELS
    assert report["level"] == LEVELS and report["bytes"] == made[1]["bytes"]
    assert np.abs(mesh.V).max() == pytest.approx(1.1, abs=0.2)  # object space: as large as the source


@pytest.mark.parametrize("level", range(LEVELS + 1))
def test_decompress_levels(run, made, tmp_path, level):
    assert run("decompress", made[0], tmp_path / "out.ply", "--level", level, "--features", 0).code == 0
    assert len(read_mesh(tmp_path / "out.ply").F) == BASE * 4 ** level


def test_budget_of_bytes_is_the_file_cut_there(run, made, tmp_path):
    base = json.loads(run("info", made[0], "--json").out)["base_bytes"]
    budget = (base + made[1]["bytes"]) // 2
    report = json.loads(run("decompress", made[0], tmp_path / "budget.ply", "--bytes", budget, "--json").out)
    assert base < report["bytes"] <= budget and 0 < report["features"] < made[1]["features"]
    (tmp_path / "cut.npmesh").write_bytes(made[0].read_bytes()[:budget])
    outcome = run("decompress", tmp_path / "cut.npmesh", tmp_path / "cut.ply", "--json")
    assert "ends early" in outcome.err
    assert 0 <= json.loads(outcome.out)["features"] - report["features"] < 64  # numbers that came with the last bytes
    run("decompress", tmp_path / "cut.npmesh", tmp_path / "cut.ply", "--features", report["features"])
    assert (tmp_path / "cut.ply").read_bytes() == (tmp_path / "budget.ply").read_bytes()


def test_no_features_is_not_all_features(run, made, tmp_path):
    for name, features in (("none", 0), ("all", "all")):
        assert run("decompress", made[0], tmp_path / f"{name}.ply", "--features", features).code == 0
    assert (tmp_path / "none.ply").read_bytes() != (tmp_path / "all.ply").read_bytes()


def test_more_features_than_there_are_is_noted(run, made, tmp_path):
    outcome = run("decompress", made[0], tmp_path / "out.ply", "--features", 10**6, "--json")
    assert outcome.code == 0 and "1000000 features were asked for" in outcome.err
    assert json.loads(outcome.out)["features"] == made[1]["features"]


def test_info_of_a_whole_file(run, made):
    info = json.loads(run("info", made[0], "--json").out)
    assert info["faces"] == 2048 and info["levels"] == LEVELS
    assert info["faces_per_level"] == [BASE * 4 ** level for level in range(LEVELS + 1)]
    stops = list(info["bytes_at"].values())
    assert list(map(int, info["bytes_at"])) == list(open_stream(made[0].read_bytes()).stops)
    assert stops == sorted(stops) and stops[0] == info["base_bytes"] and stops[-1] == info["bytes"] == made[1]["bytes"]
    assert info["features"] == info["total_features"] and info["truncated"] is False
    assert info["model"] == "displaced" and info["base_faces"] == BASE and info["numbers"] == info["features"]
    text = run("info", made[0]).out
    assert "model displaced" in text and f"base: {BASE} faces" in text and f"{info['bytes']:,}" in text


def test_info_of_a_truncated_file(run, made, tmp_path):
    (tmp_path / "cut.npmesh").write_bytes(made[0].read_bytes()[:-10])
    info = json.loads(run("info", tmp_path / "cut.npmesh", "--json").out)
    assert info["truncated"] is True and info["features"] < info["total_features"] == made[1]["features"]
    assert "ends early" in run("info", tmp_path / "cut.npmesh").out


def test_info_of_a_damaged_file(run, damaged_file):
    path, reason = damaged_file
    info = json.loads(run("info", path, "--json").out)
    assert info["truncated"] is False and "found a wrong checksum" in info["corrupt"]
    outcome = run("info", path)
    assert outcome.code == 0 and f"the file {reason}" in outcome.out.splitlines()
    assert f"features: {info['features']:,} of {info['total_features']:,}" in outcome.out.splitlines()


def test_info_of_a_file_with_bytes_after_its_end(run, made, tmp_path):
    (tmp_path / "long.npmesh").write_bytes(made[0].read_bytes() + b"more")
    outcome = run("info", tmp_path / "long.npmesh")
    assert outcome.code == 0 and "found 4 bytes more; opened with" in outcome.out
    assert f"features: {made[1]['features']:,}" in outcome.out.splitlines()
    outcome = run("decompress", tmp_path / "long.npmesh", tmp_path / "out.ply", "--features", 10**6)
    assert outcome.code == 0 and "the file has no more" in outcome.err and "is damaged after" in outcome.err


def test_info_of_a_whole_file_has_no_line_of_damage(run, made):
    assert not [line for line in run("info", made[0]).out.splitlines() if line.startswith("the file")]


def test_decompress_notes_damage(run, damaged_file, tmp_path):
    path, reason = damaged_file
    outcome = run("decompress", path, tmp_path / "out.ply")
    assert outcome.code == 0 and f"note: {path} {reason}" in outcome.err.splitlines()
    assert len(read_mesh(tmp_path / "out.ply").F) == BASE * 4 ** LEVELS


def test_more_features_than_a_damaged_file_has_are_noted(run, made, damaged_file, tmp_path):
    outcome = run("decompress", damaged_file[0], tmp_path / "out.ply", "--features", 10**6, "--json")
    used = json.loads(outcome.out)["features"]
    assert outcome.code == 0 and used < made[1]["features"]
    assert (f"note: 1000000 features were asked for, {used} are used: the file is damaged, "
            f"{made[1]['features']} were written") in outcome.err.splitlines()


def test_evaluate_notes_damage(run, damaged_file, sphere_file, few_samples):
    path, reason = damaged_file
    outcome = run("evaluate", path, sphere_file, "--features", "all", "--json")
    assert outcome.code == 0 and f"note: {path} {reason}" in outcome.err.splitlines()
    assert len(json.loads(outcome.out)) == 1


def test_evaluate_notes_a_file_that_ends_early(run, made, sphere_file, few_samples, tmp_path):
    (tmp_path / "cut.npmesh").write_bytes(made[0].read_bytes()[:-10])
    outcome = run("evaluate", tmp_path / "cut.npmesh", sphere_file, "--features", "all", "--json")
    assert outcome.code == 0 and f"note: {tmp_path / 'cut.npmesh'} ends early: opened with" in outcome.err


def test_evaluate_rows(run, made, sphere_file, few_samples):
    rows = json.loads(run("evaluate", made[0], sphere_file, "--json").out)
    assert [row["features"] for row in rows] == list(open_stream(made[0].read_bytes()).stops)
    for row in rows:
        assert list(row) == ["features", "level", "bytes", "cr", "d_pm", "d_normal", "d_reverse", "worse"]
        assert row["level"] == LEVELS
        assert row["worse"] == max(row["d_pm"], row["d_reverse"])
        assert 0 < row["d_pm"] < 500 and 0 < row["d_reverse"] < 500 and 0 < row["d_normal"] < 60
    assert rows[0]["cr"] == pytest.approx(3 * 1026 / (3 * 52))  # no features: vertices before over those of the base
    assert rows[0]["cr"] > rows[1]["cr"] > rows[-1]["cr"]
    assert rows[-1]["bytes"] == made[1]["bytes"]


def test_evaluate_table_of_one_level(run, made, sphere_file, few_samples):
    outcome = run("evaluate", made[0], sphere_file, "--level", 0, "--features", "0,all")
    lines = outcome.out.splitlines()
    assert len(lines) == 3 and lines[0].split()[:3] == ["features", "level", "bytes"]
    assert [line.split()[1] for line in lines[1:]] == ["0", "0"]


def test_level_that_the_file_has_not(run, made, sphere_file, tmp_path):
    for command in (["decompress", made[0], tmp_path / "out.ply"], ["evaluate", made[0], sphere_file]):
        outcome = run(*command, "--level", LEVELS + 1)
        assert outcome.code == 2 and f"0 to {LEVELS}" in outcome.error_line
    assert not (tmp_path / "out.ply").exists()


def test_budget_below_the_base(run, made, tmp_path):
    outcome = run("decompress", made[0], tmp_path / "out.ply", "--bytes", 50)
    assert outcome.code == 2 and "base mesh" in outcome.error_line
    assert list(tmp_path.iterdir()) == []


def flipped(data: bytes) -> bytes:
    """One bit changed in the middle of the base."""
    return data[:100] + bytes([data[100] ^ 4]) + data[101:]


DAMAGE = {"cut in the base": lambda data: data[:100], "cut in the magic": lambda data: data[:3],
          "flipped bit in the base": flipped, "foreign": lambda data: b"PK\x03\x04" + data[4:]}


@pytest.mark.parametrize("damage", DAMAGE.values(), ids=DAMAGE)
@pytest.mark.parametrize("verb", ["info", "decompress", "evaluate"])
def test_damaged_file(run, made, sphere_file, tmp_path, damage, verb):
    (tmp_path / "bad.npmesh").write_bytes(damage(made[0].read_bytes()))
    more = {"info": [], "decompress": [tmp_path / "out.ply"], "evaluate": [sphere_file]}[verb]
    outcome = run(verb, tmp_path / "bad.npmesh", *more)
    assert outcome.code == 2 and outcome.error_line and outcome.out == ""
    assert [path.name for path in tmp_path.iterdir()] == ["bad.npmesh"]


SQUARE = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"
BAD_MESHES = {
    "empty file": ("", "auto"),
    "no vertices": ("# nothing here\n", "auto"),
    "no faces": (SQUARE, "auto"),
    "one triangle": (SQUARE + "f 1 2 3\n", "auto"),
    "NaN coordinate": (SQUARE.replace("v 1 1 0", "v 1 nan 0") + "f 1 2 3\nf 1 3 4\n", "auto"),
    "infinite coordinate": (SQUARE.replace("v 1 1 0", "v 1 inf 0") + "f 1 2 3\nf 1 3 4\n", "auto"),
    "index out of range": (SQUARE + "f 1 2 3\nf 1 3 9\n", "auto"),
    "all points in one place": ("v 1 1 1\n" * 4 + "f 1 2 3\nf 1 3 4\n", "auto"),
    "three faces at an edge": (SQUARE + "v 0 0 1\nf 1 2 3\nf 1 3 4\nf 1 3 5\n", "off"),
    "two components": (SQUARE + SQUARE.replace(" 0\n", " 5\n") + "f 1 2 3\nf 1 3 4\nf 5 6 7\nf 5 7 8\n", "off"),
}


@pytest.mark.parametrize("text, clean", BAD_MESHES.values(), ids=BAD_MESHES)
def test_bad_mesh(run, tmp_path, text, clean):
    (tmp_path / "bad.obj").write_text(text)
    outcome = run("compress", tmp_path / "bad.obj", tmp_path / "out.npmesh", "--clean", clean)
    assert outcome.code == 2 and outcome.error_line and outcome.out == ""
    assert [path.name for path in tmp_path.iterdir()] == ["bad.obj"]


def test_far_away_and_tiny_meshes_come_back_in_place(run, tmp_path):
    ball = bumpy_sphere(3)
    write_mesh(tmp_path / "far.ply", TriMesh(ball.V * 0.01 + (5, -7, 2), ball.F))
    assert run("compress", tmp_path / "far.ply", tmp_path / "far.npmesh", *SETTINGS).code == 0
    assert run("decompress", tmp_path / "far.npmesh", tmp_path / "back.ply").code == 0
    back = read_mesh(tmp_path / "back.ply").V
    assert np.abs(back - (5, -7, 2)).max() < 0.02
