"""The number of features, as an artist sets it: as a share that is fine at the start, or as bytes to spend."""
from .streams import progressive_of

# Detail d uses the share d ** DETAIL_POWER of all features: the first hundred change more than the next thousand.
DETAIL_POWER = 3
KILOBYTE = 1000


def get_detail(state) -> float:
    """The number of features as a percentage that is fine at the start; see DETAIL_POWER."""
    return 100 * (state.features / max(state.total_features, 1)) ** (1 / DETAIL_POWER)


def set_detail(state, percent: float) -> None:
    """The inverse of `get_detail`."""
    state.features = round(state.total_features * (percent / 100) ** DETAIL_POWER)


def get_budget(state) -> float:
    """The budget that was set, in kB, while the features are those that it paid for; else what they take."""
    return (state.budget_bytes if state.features == state.budget_features else state.shown_bytes) / KILOBYTE


def set_budget(state, kilobytes: float) -> None:
    """As many features as fit into a number of kB; none if not even the base does."""
    from ..core.errors import NpmError

    try:
        progressive = progressive_of(state.id_data)
    except NpmError as error:
        state.problem = str(error)
        return
    size = round(KILOBYTE * kilobytes)
    features = progressive.features_for(max(size, progressive.base_bytes))
    state.budget_bytes, state.budget_features = max(size, progressive.base_bytes), features
    state.features = features
