"""Exports that load their module when they are first asked for (PEP 562): so the receiver's way loads no numba and no torch."""
import sys
from collections.abc import Callable
from importlib import import_module


def lazy_exports(package: str, modules: dict[str, tuple[str, ...]]) -> tuple[Callable[[str], object], Callable[[], list[str]]]:
    """`__getattr__` and `__dir__` of a package that exports these names of its modules.

    >>> from npm_blender.core.lazy import lazy_exports
    >>> __getattr__, __dir__ = lazy_exports("npm_blender.core", {"errors": ("NpmError",)})
    >>> __getattr__("NpmError").__name__
    'NpmError'
    """
    where = {name: module for module, names in modules.items() for name in names}

    def get(name: str) -> object:
        if name not in where:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        value = getattr(import_module(f".{where[name]}", package), name)
        setattr(sys.modules[package], name, value)  # found at once from now on
        return value

    return get, lambda: sorted({*vars(sys.modules[package]), *where})
