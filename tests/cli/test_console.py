"""Progress is sparse in a log and one rewritten line on a terminal; data is JSON or aligned columns."""
import io
import json

import pytest

from npm_blender.cli.console import ProgressLine, print_json, table


class Terminal(io.StringIO):
    """Standard error as a terminal."""

    def isatty(self) -> bool:
        return True


def test_log_gets_one_line_per_new_message(monkeypatch):
    log = io.StringIO()
    monkeypatch.setattr("sys.stderr", log)
    with ProgressLine() as progress:
        for k in range(1000):
            progress(k / 1000, "Decimating" if k < 500 else "Encoding")
    assert log.getvalue().splitlines() == ["Decimating ...", "Encoding ..."]


def test_terminal_gets_one_line_that_is_wiped(monkeypatch):
    screen = Terminal()
    monkeypatch.setattr("sys.stderr", screen)
    with ProgressLine() as progress:
        progress(0.25, "A long message")
        progress(0.5, "Short")
        progress(7.0, "Over")
    text = screen.getvalue()
    assert "\n" not in text
    frames = text.split("\r")
    assert frames[1] == " 25 %  A long message"
    assert frames[2].rstrip() == " 50 %  Short" and len(frames[2]) == len(frames[1])
    assert frames[3].startswith("100 %")
    assert frames[-2].strip() == "" and frames[-1] == ""


def test_terminal_is_not_flooded(monkeypatch):
    screen = Terminal()
    monkeypatch.setattr("sys.stderr", screen)
    progress = ProgressLine()
    for k in range(10_000):
        progress(k / 10_000, "Decimating")
    assert screen.getvalue().count("\r") < 100


def test_note_stays_above_the_progress_line(monkeypatch):
    screen = Terminal()
    monkeypatch.setattr("sys.stderr", screen)
    with ProgressLine() as progress:
        progress(0.5, "Working")
        progress.note("two holes were filled")
    assert screen.getvalue().endswith("\rnote: two holes were filled\n")


def test_json_is_one_line_that_parses(capsys):
    print_json({"faces": 400, "name": "é"})
    out = capsys.readouterr().out
    assert out.count("\n") == 1 and json.loads(out) == {"faces": 400, "name": "é"}


@pytest.mark.parametrize("value", [float("nan"), float("inf")])
def test_json_has_no_numbers_that_are_not_json(value):
    with pytest.raises(ValueError):
        print_json([value])


def test_table_aligns_and_groups():
    assert table(("features", "d_pm"), [(0, 14.564), (8400, 4.1)]).splitlines() == [
        "features   d_pm", "       0  14.56", "   8,400   4.10"]
