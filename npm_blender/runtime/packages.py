"""The packages that the extension uses: which are there, what each is for, what to do about one that is not.

`found` looks without loading any, for the preferences; `loaded` loads them, in the worker process.
"""
import importlib.util
import re
import sys
from dataclasses import dataclass
from pathlib import Path

VERSION = f"{sys.version_info.major}.{sys.version_info.minor}"
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
    """version: "" where there is none; problem: why it cannot be used, "" if it can; path: the folder it is in."""

    package: Package
    version: str
    problem: str
    path: str


PACKAGES = (
    Package("numpy", "Computes; Blender's own", "reinstall Blender", needed=True),
    Package("numba", "Compiles what compressing needs", AGAIN, needed=True),
    Package("trimesh", "Reads .stl and .glb files for the command line", AGAIN),
    Package("pytetwild", "Remeshes damaged meshes", "use automatic cleaning; on Windows and Linux, " + AGAIN),
)
TORCH = Package(
    "torch", "Fits base and features to each mesh: about a third less error with the same number of features",
    f"run 'python{VERSION} -m pip install --target FOLDER torch', and choose that folder as PyTorch Folder")


def remedy(name: str) -> str:
    """What to do about a package that is missing or does not load."""
    return next((package.remedy for package in (*PACKAGES, TORCH) if package.name == name), AGAIN)


def found(torch_folder: str = "") -> tuple[Status, ...]:
    """All packages, torch last, as the worker process will find them. torch_folder: see `torch_in`."""
    torch = _status(TORCH)
    if torch_folder and not torch.version:
        torch = torch_in(torch_folder)
    return (*map(_status, PACKAGES), torch)


def _status(package: Package) -> Status:
    try:
        spec = importlib.util.find_spec(package.name)
    except (ImportError, ValueError):  # a broken parent, or a module that is being replaced
        spec = None
    if spec is None or spec.origin is None:
        return Status(package, "", "not found", "")
    folder = Path(spec.origin).parents[1]
    if package is TORCH:
        return _torch_at(folder)
    from importlib import metadata  # here: it loads much

    try:
        version = metadata.version(package.name)
    except metadata.PackageNotFoundError:
        version = "unknown version"
    return Status(package, version, "", str(folder))


def places(chosen: str) -> list[Path]:
    """The folders that hold packages if `chosen` is one, a virtual environment, a Python program, or torch's own."""
    path = Path(chosen)
    root = path.parents[1] if path.is_file() and len(path.parents) > 1 else path
    return [root, root / "site-packages", root / "lib" / f"python{VERSION}" / "site-packages",
            root / "Lib" / "site-packages", root.parent]


def torch_in(chosen: str) -> Status:
    """torch in a folder that the user chose; see `places`. Its path is what the worker must search."""
    for folder in places(chosen):
        status = _torch_at(folder)
        if status.version:
            return status
    others = Path(chosen).glob("lib/python*/site-packages/torch/version.py")
    other = next((path.parents[2].name for path in others), None)
    return Status(TORCH, "", f"{chosen} holds it for {other}, not for python{VERSION}" if other else f"not in {chosen}", "")


def _torch_at(folder: Path) -> Status:
    """torch in `folder`, read from its files: version, whether it drives GPUs, whether it is made for this Python."""
    try:
        text = (folder / "torch" / "version.py").read_text(encoding="utf-8", errors="replace")
        library = [path.name for path in (folder / "torch").glob("_C.*") if path.suffix in (".so", ".pyd")]
    except OSError:
        return Status(TORCH, "", "not found", "")
    version = re.search(r"""__version__\s*(?::[^=]*)?=\s*["']([^"']+)""", text)
    tag = VERSION.replace(".", "")
    if library and not any(re.search(rf"\.(abi3|cpython-{tag}|cp{tag})\b", name) for name in library):
        made = re.search(r"cp(?:ython-)?3(\d+)", library[0])
        other = f"Python 3.{made[1]}" if made else "another Python"
        return Status(TORCH, version[1] if version else "unknown version", f"made for {other}, not for Python {VERSION}",
                      str(folder))
    return Status(TORCH, version[1] if version else "unknown version", "", str(folder))


def loaded() -> list[dict[str, str]]:
    """Load every package in this process: name, and version and path, or the problem; for torch, its GPU."""
    out = []
    for package in (*PACKAGES, TORCH):
        try:
            module = importlib.import_module(package.name)
        except ModuleNotFoundError as error:
            out.append({"name": package.name, "problem": "not found" if error.name == package.name else str(error)})
        except Exception as error:  # a package that is broken raises whatever it trips over
            out.append({"name": package.name, "problem": " ".join(f"{type(error).__name__}: {error}".split())[:200]})
        else:
            entry = {"name": package.name, "version": str(getattr(module, "__version__", "unknown version")),
                     "path": str(getattr(module, "__file__", ""))}
            out.append(entry | ({"gpu": _gpu(module)} if package is TORCH else {}))
    return out


def _gpu(torch) -> str:
    """The name of the GPU that torch uses; "" for none."""
    if torch.cuda.is_available():
        return torch.cuda.get_device_name(0)
    return "Apple GPU" if torch.backends.mps.is_available() else ""
