"""How long compressing will take on this machine: a few rates, learned from the last run and kept beside compiled code."""
import json
import math
from dataclasses import asdict, dataclass, replace
from pathlib import Path

from ..core.errors import FileError
from ..core.settings import AUTO, PAPER, PAPER_FACES, PAPER_LEVELS, CompressSettings

AUTO_FACES, MOST_LEVELS = 800, 4  # of a displaced surface whose base and levels are chosen, about
WHOLE, COARSER = 1600, 6          # a source of so few faces is its own base, of others it has so many times fewer at least
FINEST, FINER = 260_000, 12       # its finest level has at most so many faces, and so many times those of the source
SMALL = 20_000                    # or these, for a small source
BYTES_PER_FACE = 2.1              # of a file of limited size
FILE = "rates.json"
# seconds of an ordinary machine: whatever the mesh, for each of its faces, for each face of the finest level
_WORK = {"displaced": (1.0, 3e-5, 8e-5), "sized": (4.0, 1.2e-4, 2e-4), "paper": (0.2, 3e-5, 1e-5)}


@dataclass(frozen=True)
class Rates:
    """start: seconds until the worker process works; displaced, sized, paper: how many times as long as an ordinary machine
    this one takes for a displaced surface, for one of a limited size, and for the paper's model."""

    start: float = 3.0
    displaced: float = 1.0
    sized: float = 1.0
    paper: float = 1.0

    def seconds(self, faces: int, settings: CompressSettings) -> float:
        """What compressing a mesh of so many triangles takes, without the start."""
        kind = _kind(settings)
        return getattr(self, kind) * _work(kind, faces, finest_faces(faces, settings))


def _kind(settings: CompressSettings) -> str:
    """Which of the rates counts."""
    return PAPER if settings.model == PAPER else "sized" if settings.budget else settings.model


def _work(kind: str, faces: int, fine: int) -> float:
    """Seconds of an ordinary machine."""
    whole, per_face, per_fine_face = _WORK[kind]
    return whole + per_face * faces + per_fine_face * fine


def finest_faces(faces: int, settings: CompressSettings) -> int:
    """Faces of the finest level for a source of so many; what the core chooses is guessed, which would load much to ask."""
    base, levels = settings.lod.base_faces, settings.lod.levels
    if settings.model == PAPER:
        return (base or PAPER_FACES) * 4 ** (levels or PAPER_LEVELS)
    if base == AUTO:
        base = max(int(settings.budget / BYTES_PER_FACE) if settings.budget else _base_faces(faces), 1)
    if levels == AUTO:
        levels = next((k for k in range(MOST_LEVELS - bool(settings.budget), 1, -1)
                       if base * 4**k <= min(max(FINER * faces, SMALL), FINEST)), 1)
    return base * 4**levels


def _base_faces(faces: int) -> int:
    """Faces of the first base for a source of so many, 0 if that is not known."""
    return faces if 0 < faces <= WHOLE else min(AUTO_FACES, faces // COARSER or AUTO_FACES)


def learned(rates: Rates, report: dict, settings: CompressSettings, start: float | None) -> Rates:
    """The rates after a run. report: the core's CompressReport as a dict; start: what the start took, None if unknown."""
    kind = _kind(settings)
    fine = finest_faces(report["faces"], settings) if settings.budget else report["base_faces"] * 4 ** report["levels"]
    rates = replace(rates, **{kind: sum(report["seconds"].values()) / _work(kind, report["faces"], fine)})
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
