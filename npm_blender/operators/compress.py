"""Compress: the selected objects, modifiers applied, into streams that are kept on them, and preview them."""
import bpy
from bpy.props import BoolProperty

from .. import bridge, jobs, preview
from ..core.errors import NpmError
from ..properties import SETTING_NAMES, CompressionProperties, PresetArgument
from .batch import BatchOperator
from .job_operator import one_line
from .target import chosen_settings, poll_selected, sources_of

MAX_SCALE = 1.5  # ratio of an object's scales beyond which the report speaks of it


def store(obj: bpy.types.Object, result: jobs.CompressedFile, made_from: str) -> None:
    """Keep a compressed stream and its report on `obj`."""
    preview.pack(obj, result.stream)
    obj.npmesh.fingerprint = made_from
    lines = [result.report["cleaning"], *result.report["messages"]]
    dropped = bridge.not_kept(obj)
    if dropped:
        lines.append(f"not kept: {dropped}")
    scales = sorted(abs(s) for s in obj.matrix_world.to_scale())
    if scales[2] > MAX_SCALE * scales[0]:
        lines.append("detail is spread as if the object had one scale for all axes; apply the scale for better results")
    obj.npmesh.report = "\n".join(line[0].upper() + line[1:] for line in lines if line)


class OBJECT_OT_npmesh_compress(PresetArgument, CompressionProperties, BatchOperator, bpy.types.Operator):
    """Compress the selected objects, each with its modifiers applied, and show the results in their place. \
All get the settings of the active one; the objects themselves stay as they are"""

    bl_idname = "object.npmesh_compress"
    bl_label = "Compress Progressively"
    bl_options = {"UNDO"}  # noqa: RUF012 - Blender's own form

    make_preview: BoolProperty(
        name="Preview", default=True, options={"SKIP_SAVE"},
        description="Hide the originals and show the compressed meshes in their place")

    @classmethod
    def poll(cls, context):
        if jobs.running():
            cls.poll_message_set("Expected no running job, found one; wait for it or cancel it")
            return False
        return poll_selected(cls, context)

    def execute(self, context):
        try:
            sources, refused = sources_of(context)
            active = context.active_object
            leader = active.npmesh.source if active is not None and active.npmesh.is_preview else active
            leader = leader if leader in sources else sources[0]
            settings = chosen_settings(self, leader)
            for obj in sources:
                for name in SETTING_NAMES:
                    setattr(obj.npmesh, name, getattr(leader.npmesh, name))
            for line in refused:
                self.report({"WARNING"}, line)
            self._active, self._shown, self._faces, self._bytes = leader.session_uid, [], 0, 0
            return self.compress(context, sources, settings)
        except (NpmError, OSError) as error:
            self.report({"ERROR"}, one_line(error))
            return {"CANCELLED"}

    def prepare(self, context, result):
        if self.make_preview and context.mode == "OBJECT":
            yield from preview.open_ahead(result.stream)

    def store_and_show(self, context, obj, result, made_from):
        store(obj, result, made_from)
        self._faces += result.report["faces"]
        self._bytes += len(result.stream.data)
        if self.make_preview and context.mode == "OBJECT":  # else the user went on working: nothing moves then
            shown = preview_of(context, obj)
            self._shown.append(shown.session_uid)

    def summarize(self, context, done, total):
        if not done:
            return
        what = f"'{done[0].name}'" if total == 1 else f"{len(done)} of {total} objects"
        said = f"Compressed {what}: {self._faces:,} faces to {self._bytes:,} bytes"
        if self.make_preview and not self._shown:
            said += "; to see it, leave this mode and press Show Preview"
        self.report({"INFO"}, said)
        if context.mode != "OBJECT":
            return
        for shown in [o for o in context.view_layer.objects if o.session_uid in self._shown]:
            shown.select_set(True)
            if shown.npmesh.source.session_uid == self._active:
                context.view_layer.objects.active = shown


def preview_of(context: bpy.types.Context, obj: bpy.types.Object) -> bpy.types.Object:
    """Show the stream that is kept on `obj`: in its preview if it has one, else in a new one.

    Raises StreamError, WeightsError or DependencyError.
    """
    shown = preview.find(obj, context.view_layer)
    received = preview.packed(obj)
    if shown is None:
        return preview.make(context, received, f"{obj.name} Preview", obj)
    preview.set_stream(shown, received)
    shown.npmesh.report = obj.npmesh.report
    return shown


class OBJECT_OT_npmesh_cancel(bpy.types.Operator):
    """Stop compressing; nothing is changed"""

    bl_idname = "object.npmesh_cancel"
    bl_label = "Cancel Compressing"
    bl_options = {"INTERNAL"}  # noqa: RUF012

    @classmethod
    def poll(cls, context):
        return bool(jobs.running())

    def execute(self, context):
        jobs.cancel_all()
        return {"FINISHED"}


def menu(self, context):
    """Entry of the Object menu."""
    self.layout.separator()
    self.layout.operator(OBJECT_OT_npmesh_compress.bl_idname, icon="MOD_DECIM")


CLASSES = (OBJECT_OT_npmesh_compress, OBJECT_OT_npmesh_cancel)
