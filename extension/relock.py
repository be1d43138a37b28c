"""Writes wheels.toml again after a version in it was changed: python -m extension.relock

Names, versions, reasons and `lacks` are yours to edit; the wheels and their hashes are asked of the package index.
"""
import tempfile
from pathlib import Path

from npm_blender.core.files import write_file

from .lock import LOCK, PLATFORMS, PYTHONS, TEST_PYTHONS, Package, Wheel, read_lock
from .wheels import digest_of, download

HEAD = """\
# The wheels that the extension's zips carry, unchanged from the package index, with their SHA-256.
# numpy is Blender's own and never among them; DracoPy would add 5 MB for each Python for .drc files on the command line
# only, which says so. numba has no wheels for Intel Macs any more. Versions are those of requirements/run.txt (a test compares).
# After changing a version: python -m extension.relock
"""


def relocked(package: Package, pythons: tuple[str, ...]) -> Package:
    """The package with the wheels that the index has for it now. Raises FetchError."""
    bare = Package(package.name, package.version, package.reason, package.lacks, ())
    with tempfile.TemporaryDirectory() as folder:
        for platform in PLATFORMS:
            for python in pythons if platform not in package.lacks else ():
                download(bare, platform, python, Path(folder))
        wheels = tuple(Wheel(path.name, digest_of(path)) for path in sorted(Path(folder).iterdir()))
    return Package(package.name, package.version, package.reason, package.lacks, wheels)


def as_toml(packages: list[Package]) -> str:
    """The text of the lock file."""
    lines = [HEAD]
    for package in packages:
        lines += ["[[package]]", f'name = "{package.name}"', f'version = "{package.version}"',
                  f'reason = "{package.reason}"']
        if package.lacks:
            lacks = ', '.join(f'"{p}"' for p in package.lacks)
            lines.append(f"lacks = [{lacks}]")
        lines += ["[package.wheels]", *(f'"{w.filename}" = "{w.sha256}"' for w in package.wheels), ""]
    return "\n".join(lines)


if __name__ == "__main__":
    every = tuple(sorted({*PYTHONS, *TEST_PYTHONS}))
    found = []
    for entry in read_lock():
        found.append(relocked(entry, every))
        print(f"{entry.name} {entry.version}: {len(found[-1].wheels)} wheels", flush=True)
    write_file(LOCK, as_toml(found).encode())
