"""Run by a Blender (check_install.py): installs the zip that fits it into a user folder of its own, and uses it there.

Packages that the system gives this Blender, as Debian does with numba, are hidden from the Blenders that it
starts: another folder is mounted in the place of theirs, in a mount namespace of their own. That needs root on Linux.
"""
import os
import shutil
import subprocess
import sys
import tempfile
import time
from importlib.util import find_spec
from pathlib import Path

import bpy

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

from extension.contents import python_versions  # noqa: E402 - found in the folder above

OURS = ("numba", "llvmlite", "trimesh", "pytetwild")  # what must come from the zip
SECONDS = 900


def fitting_zip() -> Path:
    """The built zip for this system and Python. Ends the check with a line if there is none."""
    import zipfile

    system = {"linux": "linux", "darwin": "macos", "win32": "windows"}[sys.platform]
    for path in sorted([*ROOT.glob("dist/*.zip"), *ROOT.glob("dist/debian/*.zip")]):
        names = [Path(name).name for name in zipfile.ZipFile(path).namelist() if name.endswith(".whl")]
        if f"-{system}_" in path.name and sys.version_info[:2] in python_versions(names):
            return path
    sys.exit(f"Expected a zip for {system} and Python {sys.version_info[0]}.{sys.version_info[1]} in dist, found none; "
             "run make extension, or make extension DEBIAN=1 for a Blender of Debian's")


def hidden(scratch: Path) -> list[str]:
    """Words that start a program which does not see the system's own packages."""
    folders = {str(Path(spec.origin).parents[1]) for name in OURS if (spec := find_spec(name)) and spec.origin}
    if not folders:
        return []
    if sys.platform != "linux" or os.geteuid() or shutil.which("unshare") is None:
        sys.exit(f"Expected a Blender without {', '.join(OURS)}, found some in {', '.join(sorted(folders))}; "
                 "to hide them, run this as root")
    lines, wholes = ["set -e"], []
    for k, folder in enumerate(sorted(folders)):
        whole, shown = _elsewhere(scratch / f"whole{k}", Path(folder)), scratch / f"shown{k}"
        wholes.append(whole)
        shown.mkdir()
        for entry in os.listdir(folder):
            if entry.lower().split("-")[0].split(".")[0] not in OURS:
                (shown / entry).symlink_to(whole / entry)
        lines += [f"mount --bind '{folder}' '{whole}'", f"mount --bind '{shown}' '{folder}'"]
    # where the root is no mount, as after chroot, its propagation cannot be changed; it is private then, or the trial fails
    trial = subprocess.run(["unshare", "--mount", "true"], capture_output=True)
    own = ["unshare", "--mount"] if trial.returncode == 0 else ["unshare", "--mount", "--propagation", "unchanged"]
    wrapper = [*own, "sh", "-c", "\n".join([*lines, 'exec "$@"']), "sh"]
    subprocess.run([*wrapper, "true"], check=True)
    if os.listdir(wholes[0]):
        for folder, whole in zip(sorted(folders), wholes, strict=True):
            subprocess.run(["umount", folder, str(whole)])
        sys.exit("Expected mounts to stay in a namespace of their own, found that they do not here; run this elsewhere")
    return wrapper


def _elsewhere(scratch: Path, folder: Path) -> Path:
    """An empty folder for all that is in `folder`, among links to what is beside it: relative links in it still lead there."""
    for level in (folder.parents[1], folder.parent):
        scratch.mkdir()
        for entry in os.listdir(level):
            if level / entry not in (folder, folder.parent):
                (scratch / entry).symlink_to(level / entry)
        scratch /= (folder.parent if level == folder.parents[1] else folder).name
    scratch.mkdir()
    return scratch


def run(what: str, command: list[str], environment: dict[str, str]) -> str:
    """What a command says; ends the check if it fails. Prints how long it took."""
    start = time.monotonic()
    done = subprocess.run(command, env=environment, cwd=ROOT, capture_output=True, text=True, timeout=SECONDS)
    said = done.stdout + done.stderr
    failed = done.returncode or "Traceback" in said
    print(f"{'FAILED' if failed else 'ok'}: {what} ({time.monotonic() - start:.1f} s)", flush=True)
    for line in said.splitlines():
        if failed or line.startswith("  "):
            print(line, flush=True)
    if failed:
        sys.exit(1)
    return said


def main() -> None:
    """Validate, install, use, and the command line."""
    path = fitting_zip()
    print(f"Blender {bpy.app.version_string}, Python {sys.version.split()[0]}, {path.relative_to(ROOT)}", flush=True)
    with tempfile.TemporaryDirectory() as folder:
        scratch = Path(folder)
        blender = [*hidden(scratch), bpy.app.binary_path]
        environment = {key: value for key, value in os.environ.items() if not key.startswith(("PYTHON", "NUMBA", "NPMESH"))}
        environment["BLENDER_USER_RESOURCES"] = str(scratch / "user")
        (scratch / "user").mkdir()
        run("validate", [*blender, "--command", "extension", "validate", str(path)], environment)
        run("install", [*blender, "--command", "extension", "install-file", "-r", "user_default", "-e", str(path)],
            environment)
        use = [*blender, "-b", "--python-exit-code", "1", "-P", str(ROOT / "extension" / "use_installed.py"), "--"]
        run("use", [*use, str(scratch)], environment)
        run("use again, compiled", [*use, str(scratch)], environment)
        run("command line", [*blender, "--command", "npmesh", "info", str(scratch / "shape.npmesh")], environment)
    print("all checks passed")


main()
