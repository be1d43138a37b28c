import json
import os
from dataclasses import dataclass

from corpus import pool


@dataclass(frozen=True)
class Task:
    name: str
    number: int


def half(task):
    if task.number == 3:
        raise ValueError("no three")
    if task.number == 4:
        os._exit(9)
    return {"half": task.number / 2}


TASKS = [Task(f"t{i}", i) for i in range(6)]


def test_rows_of_all_tasks_whatever_happens_to_one(tmp_path, capsys):
    rows = pool.run(half, TASKS, tmp_path / "rows.jsonl", 2)
    assert [rows[f"t{i}"].get("half") for i in range(6)] == [0, 0.5, 1, None, None, 2.5]
    assert rows["t3"]["error"] == "ValueError: no three" and rows["t4"]["error"] == pool.DIED
    assert "6/6" in capsys.readouterr().err


def test_a_second_run_does_what_is_missing(tmp_path):
    path = tmp_path / "rows.jsonl"
    pool.append(path, {"name": "t1", "half": "kept"})
    path.write_text(path.read_text() + '{"name": "t2", "ha')  # killed while it wrote
    rows = pool.run(half, TASKS[1:3], path, 1)
    assert rows["t1"]["half"] == "kept" and rows["t2"]["half"] == 1
    assert pool.done(path) == rows


def test_errors_are_kept_unless_asked_for(tmp_path):
    path = tmp_path / "rows.jsonl"
    path.write_text(json.dumps({"name": "a", "error": "x"}) + "\n")
    assert "a" in pool.done(path) and "a" not in pool.done(path, retry=True)


def test_dropped_lines_are_made_anew_and_the_others_stay(tmp_path):
    path = tmp_path / "rows.jsonl"
    pool.drop(path, {"t1"})
    assert not path.exists()
    for name in ("t1", "t2"):
        pool.append(path, {"name": name, "half": "kept"})
    pool.drop(path, {"t1"})
    assert pool.done(path) == {"t2": {"name": "t2", "half": "kept"}}
    rows = pool.run(half, TASKS[1:3], path, 1)
    assert rows["t1"]["half"] == 0.5 and rows["t2"]["half"] == "kept"
