"""The wheels that the extension carries: wheels.toml, read and checked.

A wheel's name says for which Python and which system it is:
`{name}-{version}-{python tag}-{abi tag}-{platform tag}.whl` (the binary distribution format of packaging.python.org).
"""
import re
import tomllib
from dataclasses import dataclass
from pathlib import Path

LOCK = Path(__file__).parent / "wheels.toml"
PYTHONS = ("3.11", "3.13")  # Blender 4.2 LTS to 5.0, and 5.1 to 5.2 LTS
TEST_PYTHONS = ("3.13", "3.14")  # what Debian builds Blender 4.3 and 5.2 with
PLATFORMS = ("windows-x64", "macos-arm64", "linux-x64")  # Blender's names; numba has no wheels for Intel Macs
ENDINGS = {"windows-x64": "win_amd64", "macos-arm64": "_arm64", "linux-x64": "linux_x86_64"}


class LockError(ValueError):
    """The lock file says something that cannot be."""


@dataclass(frozen=True)
class Wheel:
    """One file of a package. sha256: in hexadecimal."""

    filename: str
    sha256: str

    @property
    def tags(self) -> tuple[str, str, str]:
        """Python, ABI and platform tag."""
        return tuple(self.filename.removesuffix(".whl").split("-")[-3:])

    def fits_python(self, version: str) -> bool:
        """Whether Python `version` ("3.13") loads it: made for it, for the stable ABI of an older one, or for any."""
        python, abi, _ = self.tags
        if "py3" in python.split("."):
            return True
        found = re.fullmatch(r"cp3(\d+)", python)
        if found is None:
            return False
        minor = int(version.partition(".")[2])
        return minor >= int(found[1]) if abi == "abi3" else minor == int(found[1])

    def fits_platform(self, platform: str) -> bool:
        """Whether it is for `platform` ("linux-x64"), or for any."""
        tag = self.tags[2]
        if tag == "any":
            return True
        if platform == "linux-x64":
            return tag.startswith("manylinux") and tag.endswith("_x86_64")
        if platform == "macos-arm64":
            return tag.startswith("macosx_") and tag.endswith(("_arm64", "_universal2"))
        return tag == "win_amd64"


@dataclass(frozen=True)
class Package:
    """A pinned package. reason: why the extension carries it; lacks: platforms that it has no wheels for."""

    name: str
    version: str
    reason: str
    lacks: tuple[str, ...]
    wheels: tuple[Wheel, ...]

    def wheel_for(self, platform: str, python: str) -> Wheel | None:
        """The wheel for a platform and a Python, None where the package lacks it. Raises LockError if one is missing."""
        found = [w for w in self.wheels if w.fits_platform(platform) and w.fits_python(python)]
        exact = [w for w in found if w.tags[1] != "abi3"] or found
        if exact:
            return exact[0]
        if platform in self.lacks:
            return None
        raise LockError(f"Expected a wheel of {self.name} {self.version} for {platform} and Python {python} in "
                        f"{LOCK.name}, found none; run python -m extension.relock")


def read_lock(path: Path = LOCK) -> tuple[Package, ...]:
    """The packages of the lock file, in its order. Raises LockError."""
    packages = []
    for entry in tomllib.loads(path.read_text(encoding="utf-8"))["package"]:
        wheels = tuple(Wheel(name, digest) for name, digest in entry["wheels"].items())
        for wheel in wheels:
            if wheel.filename.count("-") != 4 or not re.fullmatch(r"[0-9a-f]{64}", wheel.sha256):
                raise LockError(f"Expected a wheel's name and its SHA-256 in {path.name}, found {wheel}; "
                                "run python -m extension.relock")
            if wheel.filename.split("-")[:2] != [entry["name"].lower(), entry["version"]]:
                raise LockError(f"Expected wheels of {entry['name']} {entry['version']} in {path.name}, found "
                                f"{wheel.filename}; run python -m extension.relock")
        packages.append(Package(entry["name"], entry["version"], entry["reason"], tuple(entry.get("lacks", ())), wheels))
    return tuple(packages)


def chosen(packages: tuple[Package, ...], platforms: tuple[str, ...], pythons: tuple[str, ...]) -> tuple[Wheel, ...]:
    """The wheels that zips for these platforms and Pythons need, each once. Raises LockError."""
    found = (p.wheel_for(platform, python) for p in packages for platform in platforms for python in pythons)
    return tuple(dict.fromkeys(wheel for wheel in found if wheel is not None))
