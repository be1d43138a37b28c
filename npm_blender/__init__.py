"""Neural Progressive Meshes: compress a mesh to a few kilobytes and open it detail by detail.

As a Python package, `npm_blender.core` does the work and knows nothing of Blender; as a Blender extension, this file
registers what `operators` and `panels` define. bpy is imported inside functions only, so that the core, the command
line and the worker process run in any Python.
"""

from .version import __version__  # noqa: F401 - npm_blender.__version__, as people look for it


def register() -> None:
    """Called by Blender when the extension is enabled."""
    from . import registration

    registration.register()


def unregister() -> None:
    """Called by Blender when the extension is disabled; leaves nothing running and nothing registered."""
    from . import registration

    registration.unregister()
