"""The lock file: every wheel that a zip needs is pinned and hashed, and agrees with what the project runs on."""
import re
from itertools import product
from pathlib import Path

import pytest

from extension.lock import PLATFORMS, PYTHONS, TEST_PYTHONS, LockError, Package, Wheel, chosen, read_lock
from extension.relock import as_toml

PACKAGES = read_lock()
REQUIREMENTS = Path(__file__).parents[2] / "requirements" / "run.txt"
EVERY = sorted({*PYTHONS, *TEST_PYTHONS})


def pinned() -> dict[str, str]:
    """Versions by name in requirements/run.txt."""
    return dict(re.findall(r"(?m)^([\w.-]+)==([\w.]+)", REQUIREMENTS.read_text(encoding="utf-8")))


@pytest.mark.parametrize("package", PACKAGES, ids=lambda p: p.name)
def test_versions_are_those_of_the_requirements(package):
    assert pinned().get(package.name, package.version) == package.version and package.reason


def test_what_the_requirements_run_on_is_carried_or_left_out_for_a_reason():
    assert set(pinned()) - {p.name for p in PACKAGES} == {"numpy", "DracoPy"}
    assert {p.name for p in PACKAGES} - set(pinned()) == {"llvmlite"}  # numba's own


@pytest.mark.parametrize("package", PACKAGES, ids=lambda p: p.name)
@pytest.mark.parametrize("platform, python", list(product(PLATFORMS, EVERY)))
def test_there_is_a_wheel_for_every_platform_and_python(package, platform, python):
    wheel = package.wheel_for(platform, python)
    if wheel is None:
        assert platform in package.lacks
    else:
        assert wheel.fits_platform(platform) and wheel.fits_python(python)


def test_compressing_lacks_no_platform():
    assert all(not p.lacks for p in PACKAGES if p.name in ("numba", "llvmlite", "trimesh"))


def test_no_wheel_is_what_others_bring():
    names = {wheel.filename.split("-")[0].lower() for wheel in chosen(PACKAGES, PLATFORMS, tuple(EVERY))}
    assert names == {"numba", "llvmlite", "trimesh", "pytetwild"}


@pytest.mark.parametrize("name, python, platform, fits", [
    ("a-1-cp311-cp311-win_amd64.whl", "3.11", "windows-x64", (True, True)),
    ("a-1-cp311-cp311-win_amd64.whl", "3.13", "linux-x64", (False, False)),
    ("a-1-cp312-abi3-manylinux2014_x86_64.manylinux_2_17_x86_64.whl", "3.14", "linux-x64", (True, True)),
    ("a-1-cp312-abi3-manylinux2014_x86_64.whl", "3.11", "windows-x64", (False, False)),
    ("a-1-cp313-cp313-macosx_12_0_arm64.whl", "3.13", "macos-arm64", (True, True)),
    ("a-1-cp313-cp313-macosx_12_0_x86_64.whl", "3.13", "macos-arm64", (True, False)),
    ("a-1-cp313-cp313-macosx_12_0_universal2.whl", "3.13", "macos-arm64", (True, True)),
    ("a-1-cp313-cp313-musllinux_1_2_x86_64.whl", "3.13", "linux-x64", (True, False)),
    ("a-1-py3-none-any.whl", "3.13", "linux-x64", (True, True)),
    ("a-1-pp310-pypy310_pp73-win_amd64.whl", "3.10", "windows-x64", (False, True)),
])
def test_what_a_wheel_fits(name, python, platform, fits):
    wheel = Wheel(name, "")
    assert (wheel.fits_python(python), wheel.fits_platform(platform)) == fits


def test_a_missing_wheel_is_an_error_unless_it_is_known():
    package = Package("a", "1", "why", ("macos-arm64",), (Wheel("a-1-cp311-cp311-win_amd64.whl", "0" * 64),))
    assert package.wheel_for("macos-arm64", "3.11") is None
    with pytest.raises(LockError, match=r"Expected a wheel of a 1 for linux-x64 and Python 3.11"):
        package.wheel_for("linux-x64", "3.11")


@pytest.mark.parametrize("wheels, message", [
    ('"a-1-py3-none-any.whl" = "00"', "SHA-256"), ('"a-1.whl" = "%s"' % ("0" * 64), "SHA-256"),
    ('"a-2-py3-none-any.whl" = "%s"' % ("0" * 64), "wheels of a 1"),
    ('"b-1-py3-none-any.whl" = "%s"' % ("0" * 64), "wheels of a 1")])
def test_a_damaged_lock_file_is_refused(tmp_path, wheels, message):
    path = tmp_path / "wheels.toml"
    path.write_text(f'[[package]]\nname = "a"\nversion = "1"\nreason = "why"\n[package.wheels]\n{wheels}\n')
    with pytest.raises(LockError, match=message):
        read_lock(path)


def test_the_lock_file_is_as_it_is_written(tmp_path):
    path = tmp_path / "wheels.toml"
    path.write_text(as_toml(list(PACKAGES)), encoding="utf-8")
    assert read_lock(path) == PACKAGES
