"""The cache folder: counted and cleared, and nothing of the user's with it."""
import os

import pytest

from npm_blender.runtime import caches


@pytest.fixture
def folder(tmp_path):
    """A cache of three files with 10, 20 and 30 bytes, among files that are not its own."""
    root = tmp_path / "cache"
    for name, size in (("compiled/core_1/a.nbi", 10), ("compiled/core_1/a.1.nbc", 20), ("tetwild/b.npz", 30),
                       ("compiled/mine.txt", 40), ("other/c.nbi", 50), ("d.npz", 60), ("rates.json", 70)):
        (root / name).parent.mkdir(parents=True, exist_ok=True)
        (root / name).write_bytes(b"x" * size)
    return root


def test_size_and_clear(folder):
    assert caches.size(folder) == 60
    assert caches.clear(folder) == (60, 0)
    assert caches.size(folder) == 0
    left = sorted(str(p.relative_to(folder)) for p in folder.rglob("*") if p.is_file())
    assert left == ["compiled/mine.txt", "d.npz", "other/c.nbi", "rates.json"]


def test_a_folder_that_is_not_there(tmp_path):
    assert caches.size(tmp_path / "none") == 0 and caches.clear(tmp_path / "none") == (0, 0)


@pytest.mark.skipif(os.name != "posix", reason="links need rights elsewhere")
def test_links_are_not_followed(folder, tmp_path):
    outside = tmp_path / "outside"
    outside.mkdir()
    (outside / "e.nbi").write_bytes(b"precious")
    (folder / "compiled" / "link").symlink_to(outside, target_is_directory=True)
    (folder / "compiled" / "f.nbi").symlink_to(outside / "e.nbi")
    assert caches.clear(folder) == (60, 0) and (outside / "e.nbi").read_bytes() == b"precious"


def test_files_that_cannot_be_removed_are_counted(folder, monkeypatch):
    def refuse(path):
        raise PermissionError(13, "in use", path)

    monkeypatch.setattr(caches.os, "unlink", refuse)
    assert caches.clear(folder) == (0, 3)
