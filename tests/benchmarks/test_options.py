import sys

import pytest

from benchmarks import options


def parsed(monkeypatch, *arguments):
    monkeypatch.setattr(sys, "argv", ["compare", *map(str, arguments)])
    return options.parse("Test.")


def test_a_folder_of_files_is_taken_smallest_first(tmp_path, monkeypatch):
    for name, size in (("b.ply", 30), ("a.OBJ", 10), ("c.stl", 20), ("notes.txt", 5)):
        (tmp_path / name).write_bytes(bytes(size))
    o = parsed(monkeypatch, tmp_path)
    assert [e.name for e in options.meshes(o)] == ["a.OBJ", "c.stl", "b.ply"]
    o = parsed(monkeypatch, tmp_path, "--limit", 2)
    assert [e.name for e in options.meshes(o)] == ["a.OBJ", "b.ply"]


def test_quick_takes_six_of_moderate_size_from_a_manifest(tmp_path, monkeypatch):
    rows = "\n".join(f"m{i:02},m{i:02}.ply,{'train' if i == 3 else 'test'},{2000 * i}" for i in range(1, 21))
    (tmp_path / "manifest.csv").write_text("name,file,split,faces\n" + rows + "\n")
    found = options.meshes(parsed(monkeypatch, tmp_path, "--quick"))
    assert len(found) == 6 and all(4_000 <= e.faces <= 20_000 and e.name != "m03" for e in found)


def test_a_quick_run_leaves_out_what_is_slow_unless_it_is_told(tmp_path, monkeypatch):
    (tmp_path / "a.ply").write_bytes(b"")
    assert parsed(monkeypatch, tmp_path).methods == options.METHODS
    quick = parsed(monkeypatch, tmp_path, "--quick").methods
    assert set(options.METHODS) - set(quick) == set(options.SLOW)
    assert parsed(monkeypatch, tmp_path, "--quick", "--methods", "ours_sized").methods == ("ours_sized",)


def test_small_meshes_can_be_left_out(tmp_path, monkeypatch):
    (tmp_path / "manifest.csv").write_text("name,file,split,faces\na,a.ply,test,100\nb,b.ply,test,200\n")
    assert [e.name for e in options.meshes(parsed(monkeypatch, tmp_path, "--min-faces", 200))] == ["b"]


def test_faces_are_asked_of_a_manifest_alone(tmp_path, monkeypatch, capsys):
    (tmp_path / "a.ply").write_bytes(b"x")
    with pytest.raises(SystemExit):
        parsed(monkeypatch, tmp_path, "--min-faces", 200)
    assert "Expected a manifest.csv" in capsys.readouterr().err


def test_lines_are_kept_apart_by_samples_and_tag(tmp_path, monkeypatch):
    (tmp_path / "a.ply").write_bytes(b"x")
    runs = [("--samples", 10), ("--samples", 20), ("--tag", "x")]
    assert len({options.lines(parsed(monkeypatch, tmp_path, *run), "qslim") for run in runs}) == 3


def test_only_the_lines_of_the_paper_s_model_depend_on_the_weights(tmp_path, monkeypatch):
    (tmp_path / "a.ply").write_bytes(b"x")
    o, digest = parsed(monkeypatch, tmp_path), options.load_weights().digest.hex()
    assert [m for m in options.METHODS if digest in options.lines(o, m).name] == ["ours_paper"]


MISTAKES = [("--methods", "ours,nonsense"), ("--methods", "ours", "--redo", "qslim"), ("/nowhere",)]


@pytest.mark.parametrize("arguments", MISTAKES)
def test_a_mistake_is_one_line_and_code_2(arguments, monkeypatch, capsys):
    with pytest.raises(SystemExit) as stop:
        parsed(monkeypatch, *arguments)
    assert stop.value.code == 2 and capsys.readouterr().err.splitlines()[-1].startswith("compare: error: Expected")
