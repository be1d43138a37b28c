"""The worker as a process of the system: its command, its environment and its group; how it starts and ends."""
import os
import signal
import subprocess
import sys
from pathlib import Path

from ..core.errors import DependencyError
from .machine import WorkerSettings

PACKAGE_FOLDER = Path(__file__).parents[1]
PACKAGE = __package__.rpartition(".")[0]

# The worker imports the package under the name that it has here, bl_ext.<repository>.npm_blender when installed: numba
# keeps module names in what it caches, so both processes can share a cache only under one name. Arguments: the name,
# the package's folder, the job's folder.
BOOTSTRAP = """
import os, runpy, sys, types
name, folder = sys.argv[1:3]
parents = name.split(".")[:-1]
for k in range(len(parents)):
    module = sys.modules[".".join(parents[:k + 1])] = types.ModuleType(".".join(parents[:k + 1]))
    module.__path__ = [os.path.dirname(folder)]
if not parents:
    sys.path.insert(0, os.path.dirname(folder))
sys.argv[:] = sys.argv[2:]
runpy.run_module(name + ".jobs.worker", run_name="__main__")
"""


def start(folder: Path, machine: WorkerSettings) -> subprocess.Popen:
    """Start a worker on the job in `folder`, where its output goes to the files `out` and `err`.

    Raises DependencyError if there is no Python to start.
    """
    with open(folder / "out", "wb") as out, open(folder / "err", "wb") as err:
        return subprocess.Popen(command(folder), cwd=folder, env=environment(folder, machine), stdin=subprocess.PIPE,
                                stdout=out, stderr=err, **_own_group())


def end(process: subprocess.Popen) -> None:
    """End a worker at once, with every process that it started."""
    if process.poll() is None:
        if os.name == "posix":
            os.killpg(process.pid, signal.SIGKILL)
        else:
            process.kill()
        process.wait()
    process.stdin.close()


def command(folder: Path) -> list[str]:
    """The command that runs the worker: this Python, this package."""
    if not sys.executable or not os.path.exists(sys.executable):
        raise DependencyError(f"Expected Blender's Python program, found {sys.executable or 'none'}; "
                              "reinstall Blender, or start it from its own folder")
    # -P: the current folder is no source of modules
    return [sys.executable, "-P", "-c", BOOTSTRAP, PACKAGE, str(PACKAGE_FOLDER), str(folder)]


def environment(folder: Path, machine: WorkerSettings) -> dict[str, str]:
    """The worker's environment: the packages that this process sees, and temporary files in the job's folder."""
    packages = [p for p in sys.path if os.path.basename(p) in ("site-packages", "dist-packages")]
    env = {k: v for k, v in os.environ.items() if not k.startswith("PYTHON") or k == "PYTHONDONTWRITEBYTECODE"}
    env["PYTHONPATH"] = os.pathsep.join(packages)
    env.update(dict.fromkeys(("TMPDIR", "TEMP", "TMP"), str(folder)))
    if sys.flags.no_user_site:
        env["PYTHONNOUSERSITE"] = "1"
    env.update(machine.variables())
    return env


def _own_group() -> dict:
    """Arguments of Popen that put the worker into a group of its own, without a console window; on Windows behind the
    window in priority, which the worker sees to itself elsewhere."""
    if os.name == "posix":
        return {"start_new_session": True}
    flags = subprocess.CREATE_NO_WINDOW | subprocess.CREATE_NEW_PROCESS_GROUP | subprocess.BELOW_NORMAL_PRIORITY_CLASS
    return {"creationflags": flags}
