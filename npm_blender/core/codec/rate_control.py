"""A budget in bytes: which base mesh and how many levels it pays for.

Most of a stream's bytes go best into the base: a face of it costs less than two bytes, and what it shows no feature shows
as cheaply where edges are sharp or parts thin. Measured on the validation split: docs/performance.md.
"""
from ..settings import LodSettings

HEAD = 100  # bytes of a stream that are neither base nor features
FACES = 0.47  # of the base for each byte; the features get what is left, a tenth to a quarter
FEWEST, MOST = 40, 40_000  # base faces
FINEST = 62_000  # faces of the finest level at most, if that leaves more than one
LEVELS = LodSettings.levels  # at most


def base_faces(budget: int) -> int:
    """Faces of the base mesh that shows most in a stream of `budget` bytes."""
    return min(max(round(FACES * (budget - HEAD)), FEWEST), MOST)


def levels(faces: int) -> int:
    """Levels above a base of so many faces: LEVELS, or fewer, at least one, where the finest would have over FINEST faces."""
    return next((count for count in range(LEVELS, 1, -1) if faces * 4**count <= FINEST), 1)


def fewer_faces(faces: int, size: int, budget: int) -> int:
    """Base faces to try next, where the base of so many took `size` bytes of `budget`."""
    return max(int(0.9 * faces * max(budget - HEAD, 1) / max(size - HEAD, 1)), FEWEST // 2)
