"""Fetching wheels: pip downloads from the package index, by exact pin, and nothing is taken whose hash is not locked."""
import hashlib
import subprocess
import sys
import tempfile
from pathlib import Path

from .lock import Package, Wheel

FOLDER = Path(__file__).parents[1] / "build" / "wheels"

# What pip is told that a platform takes: the systems that Blender 4.2 LTS and later run on
PIP_TAGS = {
    "windows-x64": ("win_amd64",),
    "macos-arm64": ("macosx_11_0_arm64", "macosx_12_0_arm64", "macosx_11_0_universal2", "macosx_10_9_universal2"),
    "linux-x64": ("manylinux_2_28_x86_64", "manylinux_2_27_x86_64", "manylinux_2_24_x86_64", "manylinux_2_17_x86_64",
                  "manylinux2014_x86_64"),
}


class FetchError(RuntimeError):
    """A wheel could not be fetched, or is another one than was locked."""


def digest_of(path: Path) -> str:
    """SHA-256 of a file, in hexadecimal."""
    with open(path, "rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def download(package: Package, platform: str, python: str, folder: Path) -> None:
    """Let pip put the package's wheel for a platform and a Python into `folder`; with wheels known, only one of them.

    Raises FetchError with pip's last line.
    """
    hashes = "".join(f" --hash=sha256:{wheel.sha256}" for wheel in package.wheels)
    with tempfile.TemporaryDirectory() as scratch:
        requirement = Path(scratch, "requirement.txt")
        requirement.write_text(f"{package.name}=={package.version}{hashes}\n", encoding="utf-8")
        tags = [word for tag in PIP_TAGS[platform] for word in ("--platform", tag)]
        done = subprocess.run(
            [sys.executable, "-m", "pip", "--disable-pip-version-check", "download", "--quiet", "--no-deps",
             "--only-binary=:all:", "--implementation", "cp", "--python-version", python, *tags,
             "--dest", str(folder), "--requirement", str(requirement)], capture_output=True, text=True)
    if done.returncode:
        said = (done.stderr.strip() or f"exit code {done.returncode}").splitlines()[-1]
        raise FetchError(f"Expected pip to find {package.name} {package.version} for {platform} and Python {python}, "
                         f"found: {said}")


def fetch(packages: tuple[Package, ...], platforms: tuple[str, ...], pythons: tuple[str, ...],
          folder: Path = FOLDER) -> list[Path]:
    """The locked wheels for these platforms and Pythons as files in `folder`; those that are there are checked and kept.

    Raises LockError and FetchError.
    """
    folder.mkdir(parents=True, exist_ok=True)
    paths: dict[Wheel, Path] = {}
    for package in packages:
        for platform in platforms:
            for python in pythons:
                wheel = package.wheel_for(platform, python)
                if wheel is None or wheel in paths:
                    continue
                path = paths[wheel] = folder / wheel.filename
                if not path.exists():
                    download(package, platform, python, folder)
                if not path.exists():
                    raise FetchError(f"Expected pip to fetch {wheel.filename}, found another file; "
                                     "run python -m extension.relock")
                if digest_of(path) != wheel.sha256:
                    raise FetchError(f"Expected the locked content in {path}, found other bytes; delete the file")
    return list(paths.values())
