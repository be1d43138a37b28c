"""`make extension`: one zip of the extension for each platform, with the wheels that it needs, built by Blender's tool.

    python -m extension.build            # dist/npm_blender-VERSION-PLATFORM.zip, for official Blenders
    python -m extension.build --debian   # dist/debian/..., for Debian's Blenders, which run on its own Python
"""
import argparse
import sys
from pathlib import Path

from . import blender, contents, staging, wheels
from .lock import PLATFORMS, PYTHONS, TEST_PYTHONS, LockError, Package, read_lock


def build(packages: tuple[Package, ...], platforms: tuple[str, ...], pythons: tuple[str, ...], files: list[Path],
          out: Path, tool: list[str], package: Path = staging.PACKAGE) -> list[Path]:
    """The zips, one for each platform, in `out`, which is inside the project; Blender's tool made and validated them.

    files: the wheels. Raises ToolError if the tool refuses, or if a zip does not hold what it should.
    """
    staged = staging.stage(staging.ROOT / "build" / "staged" / out.name, platforms, files, package)
    out.mkdir(parents=True, exist_ok=True)
    for old in out.glob("npm_blender-*.zip"):
        old.unlink()
    # relative paths: BLENDER may be a script that starts one with another root folder
    source, target = (str(path.relative_to(staging.ROOT)) for path in (staged, out))
    blender.run(tool, "build", "--split-platforms", f"--source-dir={source}", f"--output-dir={target}")
    made = []
    for platform in platforms:
        path = next(out.glob(f"npm_blender-*-{platform.replace('-', '_')}.zip"), None)
        wrong = ["there is none"] if path is None else contents.problems(path, packages, platform, pythons)
        if wrong:
            raise blender.ToolError(f"Expected a whole zip for {platform}, found: {'; '.join(wrong)}")
        blender.run(tool, "validate", str(path.relative_to(staging.ROOT)))
        made.append(path)
    return made


def main(arguments: list[str]) -> int:
    """The command line: exit code 0, or 1 after one line on what is wrong."""
    parser = argparse.ArgumentParser(prog="python -m extension.build", description=__doc__.partition("\n")[0])
    parser.add_argument("--debian", action="store_true",
                        help=f"for Debian's Blenders: Linux only, wheels for Python {' and '.join(TEST_PYTHONS)}")
    parser.add_argument("--blender", help="how to start the Blender that builds (default: the environment's BLENDER, "
                                          "else blender, else the bpy module)")
    options = parser.parse_args(arguments)
    platforms, pythons = (("linux-x64",), TEST_PYTHONS) if options.debian else (PLATFORMS, PYTHONS)
    out = staging.ROOT / "dist" / ("debian" if options.debian else "")
    try:
        tool, packages = blender.command(options.blender), read_lock()
        print("Fetching wheels into build/wheels (once)", flush=True)
        files = wheels.fetch(packages, platforms, pythons)
        made = build(packages, platforms, pythons, files, out, tool)
    except (blender.ToolError, wheels.FetchError, LockError) as error:
        print(error, file=sys.stderr)
        return 1
    for path in made:
        print(f"{path.relative_to(staging.ROOT)}: {path.stat().st_size / 1e6:.1f} MB, valid, Python {', '.join(pythons)}")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
