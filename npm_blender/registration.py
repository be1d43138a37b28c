"""What the extension adds to Blender, in order; taken away in reverse."""
import bpy

from . import jobs, preferences, preview, properties
from .operators import (
    compress,
    decoded,
    export_gltf,
    export_stream,
    import_stream,
    lod_set,
    play,
    storage,
    upkeep,
)
from .panels import common as panel_parts
from .panels import compress as compress_panel
from .panels import preview as preview_panel

MODULES = (preferences, upkeep, properties, compress, export_stream, import_stream, decoded, storage, play, lod_set,
           export_gltf, preview_panel, compress_panel)

MENUS = (
    (bpy.types.TOPBAR_MT_file_import, import_stream.menu),
    (bpy.types.TOPBAR_MT_file_export, export_stream.menu),
    (bpy.types.VIEW3D_MT_object, compress.menu),
)

HANDLERS = (
    (bpy.app.handlers.undo_post, preview.refresh_all),
    (bpy.app.handlers.redo_post, preview.refresh_all),
    (bpy.app.handlers.save_pre, preview.before_save),
    (bpy.app.handlers.save_post, preview.after_save),
    (bpy.app.handlers.load_pre, preview.forget_all),
    (bpy.app.handlers.load_post, preview.after_load),
)

_command = None


def run_command(argv: list[str]) -> int:
    """`blender --command npmesh ARGS`: the command line of `python -m npm_blender`."""
    from .cli import main

    with preferences.worker_settings().in_this_process():
        return main(argv)


def register() -> None:
    """Register classes, then properties, menus, handlers and the `npmesh` command."""
    global _command
    for module in MODULES:
        for cls in module.CLASSES:
            bpy.utils.register_class(cls)
    bpy.types.Object.npmesh = bpy.props.PointerProperty(type=properties.NpmObject, name="Progressive Mesh")
    for owner, draw in MENUS:
        owner.append(draw)
    for handlers, function in HANDLERS:
        handlers.append(function)
    _command = bpy.utils.register_cli_command("npmesh", run_command)


def unregister() -> None:
    """Stop running jobs, then undo `register` in reverse."""
    global _command
    jobs.cancel_all()
    preview.forget_all()
    preview.restore_viewports()
    panel_parts.remove_icons()
    if _command is not None:
        bpy.utils.unregister_cli_command(_command)
        _command = None
    for handlers, function in reversed(HANDLERS):
        handlers.remove(function)
    for owner, draw in reversed(MENUS):
        owner.remove(draw)
    del bpy.types.Object.npmesh
    for module in reversed(MODULES):
        for cls in reversed(module.CLASSES):
            bpy.utils.unregister_class(cls)
