"""How long compressing will take on this machine: its rates, loaded once and learned from every run."""
from collections.abc import Sequence

import bpy

from .. import bridge, jobs, preferences
from ..core.settings import CompressSettings
from ..jobs import estimate

_rates: list[estimate.Rates] = []  # of this machine, once they are known


def rates() -> estimate.Rates:
    """How fast this machine compresses."""
    if not _rates:
        _rates.append(estimate.load(preferences.cache_folder()))
    return _rates[0]


def learn(outcomes: list, settings: CompressSettings) -> None:
    """Take the rates of the last mesh that was compressed, unless code had to be compiled for it."""
    compressed = [o for o in outcomes if isinstance(o, jobs.CompressedFile)]
    if not compressed or compressed[-1].report["compiled"]:
        return
    first = outcomes[0]
    start = None
    if isinstance(first, jobs.CompressedFile) and not first.report["compiled"]:
        start = first.seconds - sum(first.report["seconds"].values())
    _rates[:] = [estimate.learned(rates(), compressed[-1].report, settings, start)]
    estimate.save(preferences.cache_folder(), _rates[0])


def expected_seconds(sources: Sequence[bpy.types.Object], settings: CompressSettings,
                     depsgraph: bpy.types.Depsgraph | None) -> list[float]:
    """What compressing each of the objects will take on this machine, without the start of the worker."""
    return [rates().seconds(bridge.triangle_count(obj, depsgraph), settings) for obj in sources]
