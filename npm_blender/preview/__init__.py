"""Previews: objects whose mesh is decoded from a stream and follows the level and the number of features.

A level's mesh is built once; another level swaps `obj.data`, another number of features only moves vertices. Opened
streams are kept by their digest, never by object, and what a mesh holds is stamped on the mesh: after undo, redo or
loading, comparing stamp and properties says what is still to do.

    storage        the stream on an object: packed in the .blend, or linked from a file; linked reads that
    opening        a stream read and opened in this process; threads is where that is done while the window draws
    decoder_cache  opened streams, by digest; streams finds that of an object
    levels         the meshes of the levels, brought to what the properties say
    updates        when: at once, from a timer, after undo, before saving
    lifecycle      make, replace, apply, discard
    placement      in place of the original, or beside it
    smooth         shading as of the original
    slider         the number of features as detail, even in bytes, and as a budget of bytes
    lodset         all levels as ordinary objects, named for an engine
    playback       what has arrived over a line
    deviation      the distance to the original as colours; nearest measures it, viewport shows it (and the panels)
"""
from .decoder_cache import open_ahead, warm_up
from .levels import STAMP, show
from .lifecycle import apply, discard, find, make, set_stream
from .linked import after_save, link, path_of, read_anew
from .storage import STREAM, foreign, has_stream, is_linked, pack, packed, unpack
from .streams import progressive_of, received_of
from .updates import after_load, before_save, forget_all, is_busy, refresh_all
from .viewport import restore_viewports

__all__ = ["STAMP", "STREAM", "after_load", "after_save", "apply", "before_save", "discard", "find", "foreign",
           "forget_all", "has_stream", "is_busy", "is_linked", "link", "make", "open_ahead", "pack", "packed",
           "path_of", "progressive_of", "read_anew", "received_of", "refresh_all", "restore_viewports", "set_stream",
           "show", "unpack", "warm_up"]
