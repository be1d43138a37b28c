"""How long compressing will take on this machine: a few rates, learned from the last run and kept beside compiled code."""
import json
import math
from dataclasses import asdict, dataclass, replace
from pathlib import Path

from ..core.codec import base_faces_for, level_count_for
from ..core.errors import FileError
from ..core.settings import AUTO, CompressSettings

AUTO_FACES = 600  # what an automatic base has, about
FILE = "rates.json"


@dataclass(frozen=True)
class Rates:
    """Seconds. start: until the worker process works; per_face: of the source, to clean and decimate it; per_fine_face:
    of the finest level, for everything else but refinement; per_step: and finest face, for one refinement step."""

    start: float = 3.0
    per_face: float = 1.5e-5
    per_fine_face: float = 4e-5
    per_step: float = 4e-5

    def seconds(self, faces: int, settings: CompressSettings) -> float:
        """What compressing a mesh of so many triangles takes, without the start. settings: resolved."""
        fine = finest_faces(settings)
        return self.per_face * faces + (self.per_fine_face + self.per_step * settings.refine_steps) * fine


def finest_faces(settings: CompressSettings) -> int:
    """Faces of the finest level; those of an automatic base are guessed."""
    base, levels = settings.lod.base_faces, settings.lod.levels
    if base == AUTO:
        base = base_faces_for(settings.budget) if settings.budget else AUTO_FACES
    return base * 4 ** (level_count_for(base) if levels == AUTO else levels)


def learned(rates: Rates, report: dict, settings: CompressSettings, start: float | None) -> Rates:
    """The rates after a run. report: the core's CompressReport as a dict; start: what the start took, None if unknown."""
    stages = report["seconds"]
    fine = report["base_faces"] * 4 ** report["levels"]
    rates = replace(
        rates,
        per_face=sum(stages.get(name, 0.0) for name in ("clean", "decimate", "levels")) / report["faces"],
        per_fine_face=sum(stages.get(name, 0.0) for name in ("encode", "order", "write")) / fine)
    if settings.refine_steps and "refine" in stages:  # not where torch is missing
        rates = replace(rates, per_step=stages["refine"] / (settings.refine_steps * fine))
    return rates if start is None else replace(rates, start=max(start, 0.0))


def remaining(estimate: float, fraction: float, elapsed: float) -> float:
    """Seconds that are left: at first by the estimate, and the further the job is, by what it has needed so far."""
    left = 1 - min(max(fraction, 0.0), 1.0)
    return left * (left * estimate + elapsed)


def text(seconds: float) -> str:
    """A duration as people say it: '5 s', '40 s', '3 min', '1.5 h'."""
    if seconds < 10:
        return f"{max(math.ceil(seconds), 1)} s"
    if seconds < 90:
        return f"{5 * math.ceil(seconds / 5)} s"
    return f"{math.ceil(seconds / 60)} min" if seconds < 5400 else f"{seconds / 3600:.1f} h"


def load(folder: str | None) -> Rates:
    """The rates kept in `folder`, or those of an ordinary machine."""
    try:
        return Rates(**{k: float(v) for k, v in json.loads(Path(folder or "", FILE).read_text(encoding="utf-8")).items()})
    except (OSError, ValueError, TypeError, AttributeError):
        return Rates()


def save(folder: str | None, rates: Rates) -> None:
    """Keep the rates in `folder`; a folder that cannot be written keeps nothing."""
    from ..core.files import write_file

    if folder is not None:
        try:
            write_file(Path(folder, FILE), json.dumps(asdict(rates)).encode())
        except FileError:
            pass  # then the next session starts with ordinary rates
