"""Streams in files of their own: found by a path relative to the .blend, held to what they were by their digest.

Reading takes compiled code, so a worker process does it. That starts when a .blend with linked previews is opened, so
that it is done when the user moves a slider.
"""
import os
from pathlib import Path
from typing import TYPE_CHECKING

import bpy

from .. import jobs
from ..core.errors import NpmError, StreamError
from ..core.files import read_file
from ..preferences import worker_settings
from . import decoder_cache, storage
from .opening import open_received, receive

if TYPE_CHECKING:
    from ..core.codec import StoredStream

POLL_SECONDS = 0.1

_reading: dict[str, jobs.ReadJob] = {}  # by digest
_absolute: dict[int, str] = {}  # by session_uid, while the .blend is being saved


def path_of(obj: bpy.types.Object) -> Path:
    """Where the file of a linked stream is."""
    return Path(os.path.abspath(bpy.path.abspath(obj.npmesh.filepath, library=obj.library)))


def link(obj: bpy.types.Object, path: str | os.PathLike) -> None:
    """Let the stream of a preview be that of the file at `path` instead of a packed one.

    Raises FileError if it cannot be read, StreamError if it is another stream.
    """
    _checked(read_file(path), obj, Path(path))
    measured = storage.measured_text(obj)
    storage.unpack(obj)
    if measured:
        obj[storage.MEASURED] = measured
    obj.npmesh.filepath = _relative(str(path), bpy.data.filepath)


def read(obj: bpy.types.Object) -> "StoredStream":
    """The stream of a linked preview. Raises FileError or StreamError if it is missing, damaged or another one."""
    from ..core.codec import StoredStream

    path, digest = path_of(obj), obj.npmesh.digest
    _checked(read_file(path), obj, path)
    received = _result(_reading.pop(digest)) if digest in _reading else read_anew(path)
    return StoredStream(received.data, received.arrays, storage.measured_text(obj))


def read_anew(path: Path) -> "StoredStream":
    """The stream that is in a file now. Raises FileError or StreamError."""
    return receive(read_file(path)) if bpy.app.background else _result(_job(path))


def check_all() -> None:
    """After opening a .blend: name the files that are missing or were changed, and start reading the others."""
    for obj in [o for o in bpy.data.objects if o.npmesh.is_preview and storage.is_linked(o) and not storage.foreign(o)]:
        try:
            path = path_of(obj)
            _checked(read_file(path), obj, path)
            obj.npmesh.problem = ""
            if not bpy.app.background and obj.npmesh.digest not in _reading:
                _reading[obj.npmesh.digest] = _job(path)
        except NpmError as error:
            obj.npmesh.problem = str(error)
    if _reading and not bpy.app.timers.is_registered(_poll):
        bpy.app.timers.register(_poll, first_interval=POLL_SECONDS)


def before_save(path: str) -> None:
    """Paths become relative to where the .blend will be."""
    _absolute.clear()
    for obj in [o for o in bpy.data.objects if o.npmesh.filepath and not storage.foreign(o)]:
        _absolute[obj.session_uid] = str(path_of(obj))
        obj.npmesh.filepath = _relative(_absolute[obj.session_uid], path or bpy.data.filepath)


@bpy.app.handlers.persistent
def after_save(*_args: object) -> None:
    """Of a copy of the .blend the paths are not those of the .blend that stays open."""
    for obj in [o for o in bpy.data.objects if o.session_uid in _absolute]:
        obj.npmesh.filepath = _relative(_absolute[obj.session_uid], bpy.data.filepath)
    _absolute.clear()


def forget_all() -> None:
    """Stop reading."""
    for job in _reading.values():
        if job in jobs.running():
            job.cancel()
    _reading.clear()
    if bpy.app.timers.is_registered(_poll):
        bpy.app.timers.unregister(_poll)


def _checked(data: bytes, obj: bpy.types.Object, path: Path) -> bytes:
    if storage.digest_of(data) != obj.npmesh.digest:
        raise StreamError(f"Expected '{path.name}' as it was when it was linked, found another stream in that file; "
                          "bring the old one back, or reload it")
    return data


def _relative(path: str, blend: str) -> str:
    """`path` as seen from a .blend; as it is if that is not saved yet, or on another drive."""
    try:
        return bpy.path.relpath(path, start=os.path.dirname(blend)) if blend else path
    except ValueError:
        return path


def _job(path: Path) -> jobs.ReadJob:
    return jobs.ReadJob([path], bpy.app.tempdir, worker_settings())


def _result(job: jobs.ReadJob) -> "StoredStream":
    [received] = job.wait()
    if isinstance(received, NpmError):
        raise received
    return received


def _poll() -> float | None:
    """Open what has been read; called by Blender's timer until nothing is left."""
    for digest, job in list(_reading.items()):
        if job not in jobs.running():  # cancelled
            del _reading[digest]
        elif job.poll():
            del _reading[digest]
            try:
                decoder_cache.keep(digest, open_received(_result(job)))
            except NpmError:
                pass  # whoever needs it will read it again and say what is wrong
    return POLL_SECONDS if _reading else None
