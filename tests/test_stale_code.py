"""Compiled code goes when what it calls has changed, and stays when only words have."""
import pytest

from tests import stale_code

CALLEE = 'def callee():\n    """Says one."""\n    return 1\n'
FILES = {"npm_blender/__init__.py": "", "npm_blender/room/__init__.py": "from .callee import callee\n",
         "npm_blender/jit.py": "", "npm_blender/room/callee.py": CALLEE,
         "npm_blender/caller.py": "from .jit import njit\nfrom .room import callee\n",
         "npm_blender/other.py": "from .jit import njit\n"}


@pytest.fixture
def tree(tmp_path, monkeypatch):
    """A package in which `caller` calls `room.callee` and `other` does not; both are compiled, and that is on record."""
    monkeypatch.setattr(stale_code, "ROOT", tmp_path)
    monkeypatch.setattr(stale_code, "RECORD", tmp_path / "cache" / "record.json")
    for name, text in FILES.items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(text)
    stale_code.remove_stale_code()
    (tmp_path / "npm_blender/__pycache__").mkdir()
    for name in ("caller", "other"):
        for suffix in ("nbi", "1.nbc"):
            (tmp_path / f"npm_blender/__pycache__/{name}.f-1.py311.{suffix}").touch()
    return tmp_path


def compiled(tree):
    return sorted(path.name.split(".")[0] for path in (tree / "npm_blender/__pycache__").glob("*.nbi"))


def test_a_change_behind_the_rooms_door_removes_its_callers_code(tree):
    assert stale_code.remove_stale_code() == [] and compiled(tree) == ["caller", "other"]
    (tree / "npm_blender/room/callee.py").write_text(CALLEE.replace("1", "2"))
    assert stale_code.remove_stale_code() == ["npm_blender/caller.py"]
    assert compiled(tree) == ["other"] and not list(tree.rglob("caller.*.nbc"))
    assert stale_code.remove_stale_code() == []


def test_comments_and_docstrings_do_not_count(tree):
    (tree / "npm_blender/room/callee.py").write_text("# one\n" + CALLEE.replace("Says", "Tells"))
    assert stale_code.remove_stale_code() == [] and compiled(tree) == ["caller", "other"]


def test_without_a_record_nothing_is_trusted(tree):
    stale_code.RECORD.unlink()
    assert stale_code.remove_stale_code() == ["npm_blender/caller.py", "npm_blender/other.py"] and compiled(tree) == []
