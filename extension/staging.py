"""The folder that Blender's build takes: the package, the wheels, and a manifest that names them."""
import re
import shutil
import tomllib
from pathlib import Path

ROOT = Path(__file__).parents[1]
PACKAGE = ROOT / "npm_blender"
LICENSE = ROOT / "LICENSE"
MANIFEST = "blender_manifest.toml"
LEFT_BEHIND = shutil.ignore_patterns("__pycache__", "*.py[co]", "*.nb[ic]", ".*")


def manifest_with(text: str, platforms: tuple[str, ...], names: list[str]) -> str:
    """The manifest `text` with `platforms` and wheels of these file names, put before its first table."""
    head, table, tail = re.split(r"(?m)^(\[)", text, maxsplit=1)
    wheels = "".join(f'  "./wheels/{name}",\n' for name in names)
    quoted = ", ".join(f'"{platform}"' for platform in platforms)
    out = f"{head}platforms = [{quoted}]\nwheels = [\n{wheels}]\n\n{table}{tail}"
    read = tomllib.loads(out)
    if read["platforms"] != list(platforms) or len(read["wheels"]) != len(names):
        raise ValueError(f"Expected {MANIFEST} to take platforms and wheels, found that its tables are in their way")
    return out


def stage(folder: Path, platforms: tuple[str, ...], wheels: list[Path], package: Path = PACKAGE) -> Path:
    """Make `folder` anew with the extension's source in it, and return it. wheels: files, for all platforms."""
    shutil.rmtree(folder, ignore_errors=True)
    shutil.copytree(package, folder, ignore=LEFT_BEHIND)
    shutil.copy(LICENSE, folder)
    (folder / "wheels").mkdir()
    for path in wheels:
        try:
            (folder / "wheels" / path.name).hardlink_to(path)
        except OSError:  # another disk
            shutil.copy(path, folder / "wheels")
    text = (package / MANIFEST).read_text(encoding="utf-8")
    (folder / MANIFEST).write_text(manifest_with(text, platforms, [path.name for path in wheels]), encoding="utf-8")
    return folder
