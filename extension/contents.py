"""What a zip of the extension must and must not hold, asked of the zip itself."""
import re
import tomllib
import zipfile
from pathlib import Path, PurePosixPath

from .lock import Package, Wheel
from .staging import MANIFEST

NEVER = {"numpy", "bpy", "scipy"}  # Blender's own, or of tests only
NEEDED = ("__init__.py", MANIFEST, "LICENSE", "jobs/worker.py", "core/codec/compression.py", "weights/npm1.npz")
UNWANTED = re.compile(r"(^|/)(__pycache__|tests?|training|benchmarks|corpus|\.[^/]+)/|\.(pyc|nbi|nbc|pt|pth|zip|blend)$|(^|/)\.")


def python_versions(names: list[str]) -> set[tuple[int, ...]]:
    """The Python versions that Blender derives from the names of wheels: (3, 11), or (3,) for any Python 3.

    Our statement of the rule in bl_pkg's `python_versions_from_wheels` (Blender 4.2 to 5.2). A wheel of the stable ABI
    counts as (3,), whichever Python it is made for; (3,) counts only where no wheel names a minor version. An extension
    is refused in a Blender whose Python is not among them.
    """
    found: set[tuple[int, ...]] = set()
    for name in names:
        python, abi = name.split("-")[-3:-1]
        stable = re.findall(r"abi(\d+)", abi)
        if stable:
            found |= {(int(digits),) for digits in stable}
            continue
        digits = (tag[2:] for tag in python.split("."))
        found |= {(int(d[0]), int(d[1:])) if len(d) > 1 else (int(d),) for d in digits}
    found = {version for version in found if version[0] > 2}
    minor = {version for version in found if len(version) == 2}
    return minor | {version for version in found if len(version) == 1 and not any(v[0] == version[0] for v in minor)}


def problems(path: Path, packages: tuple[Package, ...], platform: str, pythons: tuple[str, ...]) -> list[str]:
    """What is wrong with the zip for `platform`, one line each; empty if nothing is."""
    with zipfile.ZipFile(path) as archive:
        names = archive.namelist()
        manifest = tomllib.loads(archive.read(MANIFEST).decode())
    inside = [PurePosixPath(name).name for name in names if name.startswith("wheels/")]
    listed = [PurePosixPath(name).name for name in manifest["build"]["generated"]["wheels"]]
    out = [f"{name} is missing" for name in NEEDED if name not in names]
    out += [f"{name} has no place in it" for name in names if UNWANTED.search(name)]
    out += [f"{name} is no weights file that the package reads" for name in names
            if name.startswith("weights/") and not name.endswith(".npz")]
    out += [f"{name} is another's to bring" for name in inside if name.split("-")[0].lower() in NEVER]
    if sorted(inside) != sorted(listed) or len(set(inside)) != len(inside):
        out.append(f"its manifest names the wheels {sorted(listed)}, and it holds {sorted(inside)}")
    if manifest["build"]["generated"]["platforms"] != [platform]:
        out.append(f"its manifest is for {manifest['build']['generated']['platforms']}, not for {platform}")
    out += [f"{name} is for another platform" for name in inside if not Wheel(name, "").fits_platform(platform)]
    for package in packages:
        for python in pythons:
            wheel = package.wheel_for(platform, python)
            if wheel is not None and wheel.filename not in inside:
                out.append(f"{wheel.filename} is missing for Python {python}")
    expected = {tuple(map(int, python.split("."))) for python in pythons}
    if python_versions(inside) != expected:
        out.append(f"Blender would take it for Python {sorted(python_versions(inside))}, not {sorted(expected)}")
    return out
