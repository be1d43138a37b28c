"""What is installed is pinned, with its reason, and said in one way."""
import re
from pathlib import Path

import pytest

from npm_blender.demo.blender import DEBIAN_PACKAGES

FOLDER = Path(__file__).parent.parent / "requirements"
FILES = sorted(FOLDER.glob("*.txt"))


def pins(path: Path) -> list[str]:
    """The lines of a requirements file that name packages, without comments."""
    lines = (line.split("#")[0].strip() for line in path.read_text(encoding="utf-8").splitlines())
    return [line for line in lines if line and not line.startswith("-r ")]


@pytest.mark.parametrize("path", FILES, ids=lambda p: p.name)
def test_every_pin_is_exact(path):
    assert pins(path)
    assert all(re.fullmatch(r"[\w.-]+==[\w.]+", pin) for pin in pins(path))


def test_no_package_is_pinned_twice():
    names = [re.split("==", pin)[0].lower() for path in FILES for pin in pins(path)]
    assert len(names) == len(set(names))


def test_system_libraries_are_the_same_in_both_places():
    assert f'packages="{DEBIAN_PACKAGES}"' in (FOLDER / "system.sh").read_text(encoding="utf-8")
