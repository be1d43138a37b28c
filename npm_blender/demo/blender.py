"""Is Blender at hand? One clear line if not."""

from ..core.errors import DependencyError

DEBIAN_PACKAGES = "libx11-6 libxrender1 libxfixes3 libxi6 libxkbcommon0 libsm6 libgl1"  # what bpy 4.5 links to (ldd)


def require_blender() -> None:
    """Import bpy. Raises DependencyError if there is none, or if a system library that it needs is missing."""
    try:
        import bpy  # noqa: F401 - only whether it can be imported
    except ModuleNotFoundError:
        raise DependencyError(
            "Expected Blender's Python module, found none; run this with 'make demo', inside Blender "
            "(blender --command npmesh demo), or after pip install -r requirements/demo.txt"
        ) from None
    except ImportError as error:  # the wheel is there, a system library is not
        raise DependencyError(
            f"Expected Blender's Python module to load, found: {error}; "
            f"on Debian run: apt-get install {DEBIAN_PACKAGES}"
        ) from None
