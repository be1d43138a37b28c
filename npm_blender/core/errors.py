"""The one family of errors that a user can cause; the edges (command line, operators) print them as one line.

Every message says what was expected, what was found and what to do. Anything that is not an `NpmError` is our bug
and keeps its traceback.
"""


class NpmError(Exception):
    """Base of all errors that a user's input can cause. The message is one line, without a final period."""


class MeshError(NpmError):
    """The mesh cannot be compressed as it is: empty, not finite, non-manifold, ..."""


class FileError(NpmError):
    """A file cannot be read or written: missing, of another kind, of an unknown suffix, not permitted."""


class StreamError(NpmError):
    """The bytes are not an `.npmesh` stream, are from a newer version, are corrupted, or end before the base mesh."""


class WeightsError(NpmError):
    """The trained weights are missing, damaged, or not those that the file names."""


class SettingsError(NpmError):
    """A setting is out of its range, or would have no effect."""


class DependencyError(NpmError):
    """A package that this step needs is not installed; the message names it and the remedy."""


class Cancelled(NpmError):
    """The user cancelled; nothing was written."""
