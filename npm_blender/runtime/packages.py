"""The packages that the extension uses: which are there, what each is for, what to do about one that is not.

`found` looks without loading any, for the preferences; `loaded` loads them, in the worker process.
"""
import importlib.util
from dataclasses import dataclass

AGAIN = "disable and enable the extension; if that does not help, install it again"


@dataclass(frozen=True)
class Package:
    """purpose: what it does here; remedy: what to do if it is missing; needed: without it nothing is compressed."""

    name: str
    purpose: str
    remedy: str
    needed: bool = False


@dataclass(frozen=True)
class Status:
    """version: "" where there is none; problem: why it cannot be used, "" if it can."""

    package: Package
    version: str
    problem: str


PACKAGES = (
    Package("numpy", "Computes; Blender's own", "reinstall Blender", needed=True),
    Package("numba", "Compiles what compressing needs", AGAIN, needed=True),
    Package("trimesh", "Reads .stl and .glb files for the command line", AGAIN),
    Package("pytetwild", "Remeshes damaged meshes", "use automatic cleaning; on Windows and Linux, " + AGAIN),
)


def remedy(name: str) -> str:
    """What to do about a package that is missing or does not load."""
    return next((package.remedy for package in PACKAGES if package.name == name), AGAIN)


def found() -> tuple[Status, ...]:
    """All packages, as the worker process will find them."""
    return tuple(map(_status, PACKAGES))


def _status(package: Package) -> Status:
    try:
        spec = importlib.util.find_spec(package.name)
    except (ImportError, ValueError):  # a broken parent, or a module that is being replaced
        spec = None
    if spec is None or spec.origin is None:
        return Status(package, "", "not found")
    from importlib import metadata  # here: it loads much

    try:
        version = metadata.version(package.name)
    except metadata.PackageNotFoundError:
        version = "unknown version"
    return Status(package, version, "")


def loaded() -> list[dict[str, str]]:
    """Load every package in this process: name, and version and path, or the problem."""
    out = []
    for package in PACKAGES:
        try:
            module = importlib.import_module(package.name)
        except ModuleNotFoundError as error:
            out.append({"name": package.name, "problem": "not found" if error.name == package.name else str(error)})
        except Exception as error:  # a package that is broken raises whatever it trips over
            out.append({"name": package.name, "problem": " ".join(f"{type(error).__name__}: {error}".split())[:200]})
        else:
            out.append({"name": package.name, "version": str(getattr(module, "__version__", "unknown version")),
                        "path": str(getattr(module, "__file__", ""))})
    return out
