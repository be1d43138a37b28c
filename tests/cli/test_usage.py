"""The argument tree: what is refused as bad usage, with exit code 2 and one line, before any work."""
import pytest

from npm_blender.cli import main

BAD_USAGE = {
    "no verb": [],
    "unknown verb": ["shrink", "a.ply"],
    "abbreviated option": ["compress", "a.ply", "a.npmesh", "--base", "400"],
    "missing output": ["compress", "a.ply"],
    "faces not a number": ["compress", "a.ply", "a.npmesh", "--base-faces", "many"],
    "base faces in words": ["compress", "a.ply", "a.npmesh", "--base-faces", "many"],
    "too few base faces": ["compress", "a.ply", "a.npmesh", "--base-faces", "3"],
    "levels below none": ["compress", "a.ply", "a.npmesh", "--levels=-1"],
    "no bytes": ["compress", "a.ply", "a.npmesh", "--bytes", "0"],
    "too few bytes": ["compress", "a.ply", "a.npmesh", "--bytes", "200"],
    "bytes of a file in words": ["compress", "a.ply", "a.npmesh", "--bytes", "4k"],
    "too many levels": ["compress", "a.ply", "a.npmesh", "--levels", "7"],
    "unknown cleaning": ["compress", "a.ply", "a.npmesh", "--clean", "maybe"],
    "unknown order": ["compress", "a.ply", "a.npmesh", "--order", "random"],
    "too few bits": ["compress", "a.ply", "a.npmesh", "--position-bits", "3"],
    "bits in words": ["compress", "a.ply", "a.npmesh", "--position-bits", "many"],
    "unknown model": ["compress", "a.ply", "a.npmesh", "--model", "draco"],
    "steps that are no more": ["compress", "a.ply", "a.npmesh", "--refine-steps", "4"],
    "both features and bytes": ["decompress", "a.npmesh", "a.ply", "--features", "40", "--bytes", "4000"],
    "features not a number": ["decompress", "a.npmesh", "a.ply", "--features", "some"],
    "negative features": ["decompress", "a.npmesh", "a.ply", "--features=-1"],
    "bytes not a number": ["decompress", "a.npmesh", "a.ply", "--bytes", "4k"],
    "negative level": ["decompress", "a.npmesh", "a.ply", "--level=-1"],
    "list for one": ["decompress", "a.npmesh", "a.ply", "--features", "0,40"],
    "hole in the list": ["evaluate", "a.npmesh", "a.ply", "--features", "0,,40"],
    "info of two": ["info", "a.npmesh", "b.npmesh"],
}


@pytest.mark.parametrize("arguments", BAD_USAGE.values(), ids=BAD_USAGE)
def test_bad_usage_is_one_line_and_exit_code_2(run, arguments, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    outcome = run(*arguments)
    assert outcome.code == 2
    assert outcome.out == ""
    assert len(outcome.err.splitlines()) == 1 and outcome.error_line
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("verb", ["", "compress", "decompress", "info", "evaluate", "demo"])
def test_help_goes_to_standard_output_under_the_name_that_was_typed(capfd, verb):
    assert main([*verb.split(), "--help"], prog="blender --command npmesh") == 0
    out, err = capfd.readouterr()
    assert out.startswith(f"usage: blender --command npmesh {verb}".rstrip())
    assert err == ""


def test_help_lists_all_verbs(run):
    out = run("--help").out
    assert all(verb in out for verb in ("compress", "decompress", "info", "evaluate", "demo"))
