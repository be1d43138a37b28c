"""A budget in bytes: which base mesh and how many levels it pays for.

Most of a stream's bytes go best into the base: a face of it costs less than two bytes, and what it shows no feature shows
as cheaply where edges are sharp or parts thin. Measured on the validation split: docs/performance.md.
"""
from collections.abc import Callable
from typing import TypeVar

from ..errors import SettingsError
from ..settings import AUTO, CompressSettings, LodSettings

R = TypeVar("R")

HEAD = 100  # bytes of a stream that are neither base nor features
FACES = 0.47  # of the base for each byte; the features get what is left, a tenth to a quarter
FEWEST, MOST = 40, 40_000  # base faces
FINEST = 62_000  # faces of the finest level at most, if that leaves more than one
LEVELS = LodSettings.levels  # at most


def base_faces_for(budget: int) -> int:
    """Faces of the base mesh that shows most in a stream of `budget` bytes: FACES (budget - HEAD), within bounds (ours).

    >>> from npm_blender.core.codec import base_faces_for
    >>> [base_faces_for(budget) for budget in (300, 4000, 10**6)]
    [94, 1833, 40000]
    """
    return min(max(round(FACES * (budget - HEAD)), FEWEST), MOST)


def level_count_for(faces: int) -> int:
    """Levels above a base of so many faces: LEVELS, or fewer, at least one, where the finest would have over FINEST faces.

    The finest has faces * 4^levels.

    >>> from npm_blender.core.codec import level_count_for
    >>> [level_count_for(faces) for faces in (400, 2000, 10_000)]
    [3, 2, 1]
    """
    return next((count for count in range(LEVELS, 1, -1) if faces * 4**count <= FINEST), 1)


def fewer_faces(faces: int, size: int, budget: int) -> int:
    """Base faces to try next, where the base of so many took `size` bytes of `budget`."""
    return max(int(0.9 * faces * max(budget - HEAD, 1) / max(size - HEAD, 1)), FEWEST // 2)


class BaseTooLarge(SettingsError):
    """The base mesh alone takes more bytes than the budget. size: those bytes; faces: of the base."""

    def __init__(self, size: int, faces: int, budget: int) -> None:
        super().__init__(
            f"Expected a base mesh of at most {budget:,} bytes, found {size:,} for {faces:,} faces; "
            "allow more bytes, or ask for fewer base faces"
        )
        self.size, self.faces = size, faces


def within_budget(send: Callable[[int, bool], R], settings: CompressSettings) -> R:
    """send(base faces, room for handles); where the base turns out too large for the budget, again with fewer.

    Where the budget chooses their number, it does not pay for such room; else that is what is tried without.
    Raises BaseTooLarge where no fewer can be had.
    """
    faces, before = settings.lod.base_faces, None
    if not settings.budget or faces != AUTO:
        try:
            return send(faces, True)
        except BaseTooLarge as error:
            if error.faces <= faces:
                raise
            return send(faces, False)
    faces = base_faces_for(settings.budget)
    while True:
        try:
            return send(faces, False)
        except BaseTooLarge as error:
            if error.faces == before or faces <= FEWEST // 2:
                raise
            faces, before = fewer_faces(min(faces, error.faces), error.size, settings.budget), error.faces
