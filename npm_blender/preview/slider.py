"""The number of features, as an artist sets it: as a share of the way from the base to all, or as bytes to spend.

Every step along the way multiplies the bytes by the same factor: twice the bytes leave about the same share of the error,
wherever the slider stands, while as many features or bytes change much at the start and nothing that shows at the end. The bytes
of a later base do not count: nothing changes until all of them are there.
"""
from typing import TYPE_CHECKING

from .streams import progressive_of

if TYPE_CHECKING:
    from ..core.codec import ProgressiveMesh

KILOBYTE = 1000


def get_detail(state) -> float:
    """How far the features are along the way, as a percentage; what was set, while the features are those that it gave."""
    import math

    if state.features == state.detail_features:
        return state.kept_detail
    if state.features in (0, state.arrived_features) or state.arrived_bytes <= state.base_bytes:
        return 100.0 if state.features == state.arrived_features else 0.0
    bases = _later_bases(state)
    way = math.log(_without(bases, state.arrived_bytes) / state.base_bytes)
    return 100 * min(max(math.log(max(_without(bases, state.shown_bytes), 1) / state.base_bytes) / way, 0.0), 1.0)


def set_detail(state, percent: float) -> None:
    """The inverse of `get_detail`."""
    progressive = _opened(state)
    if progressive is None:
        return
    share, bases = min(max(percent / 100, 0.0), 1.0), _later_bases(state)
    most = _without(bases, progressive.bytes_for(progressive.features))
    size = _with(bases, progressive.base_bytes * (most / progressive.base_bytes) ** share)
    features = progressive.features if share == 1 else progressive.features_for(max(int(size), progressive.base_bytes))
    state.kept_detail, state.detail_features = 100 * share, features
    state.features = features


def _later_bases(state) -> list[tuple[int, int]]:
    """From which byte to which each later base arrives: nothing changes meanwhile, so the slider leaves that out."""
    return [(int(begin), int(end)) for begin, end in (text.split("-") for text in state.later_bases.split())]


def _without(bases: list[tuple[int, int]], size: float) -> float:
    """Bytes without those of later bases."""
    return size - sum(min(max(size - begin, 0), end - begin) for begin, end in bases)


def _with(bases: list[tuple[int, int]], size: float) -> float:
    """The inverse of `_without`: where a later base begins, all of it has arrived."""
    for begin, end in bases:
        if size >= begin:
            size += end - begin
    return size


def get_budget(state) -> float:
    """The budget that was set, in kB, while the features are those that it paid for; else what they take."""
    return (state.budget_bytes if state.features == state.budget_features else state.shown_bytes) / KILOBYTE


def set_budget(state, kilobytes: float) -> None:
    """As many features as fit into a number of kB; none if not even the base does."""
    progressive = _opened(state)
    if progressive is None:
        return
    size = max(round(KILOBYTE * kilobytes), progressive.base_bytes)
    features = progressive.features_for(size)
    state.budget_bytes, state.budget_features = size, features
    state.features = features


def _opened(state) -> "ProgressiveMesh | None":
    """The stream of a preview; None if it cannot be opened, and then the panel says why."""
    from ..core.errors import NpmError

    try:
        return progressive_of(state.id_data)
    except NpmError as error:
        state.problem = str(error)
        return None
