"""How many features, which level: argument types, and their meaning for one opened stream."""

import argparse

from ..core.errors import SettingsError

FEATURES_HELP = "number of features to use, or 'all'"


def features_type(text: str) -> int | None:
    """'all' -> None, 'N' -> N for a whole number N >= 0; anything else is a usage error."""
    if text == "all":
        return None
    if not (text.isascii() and text.isdigit()):
        raise argparse.ArgumentTypeError(f"expected a whole number of features or 'all', found {text!r}")
    return int(text)


def features_list_type(text: str) -> list[int | None]:
    """'0,40,all' -> [0, 40, None]."""
    return [features_type(part.strip()) for part in text.split(",")]


def count_type(text: str) -> int:
    """A whole number >= 0; anything else is a usage error."""
    if not (text.isascii() and text.isdigit()):
        raise argparse.ArgumentTypeError(f"expected a whole number, found {text!r}")
    return int(text)


def number_of_features(progressive, wanted: int | None, note) -> int:
    """How many features `wanted` (None: all) comes to: never more than have arrived; `note(message)` says if fewer."""
    if wanted is None:
        return progressive.features
    if wanted > progressive.features:
        why = "has no more"
        if progressive.features < progressive.total_features:
            what = "is damaged" if progressive.corrupt else "ends early"
            why = f"{what}, {progressive.total_features} were written"
        note(f"{wanted} features were asked for, {progressive.features} are used: the file {why}")
    return min(wanted, progressive.features)


def features_within(progressive, budget: int) -> int:
    """The most features whose prefix of the file fits into `budget` bytes. Raises SettingsError below the base."""
    if budget < progressive.base_bytes:
        raise SettingsError(
            f"Expected --bytes of at least {progressive.base_bytes} (the base mesh), found {budget}; raise it"
        )
    return progressive.features_for(budget)


def check_level(progressive, level: int | None) -> int:
    """The level to decode; None is the finest. Raises SettingsError above it."""
    if level is None:
        return progressive.levels
    if level > progressive.levels:
        raise SettingsError(f"Expected --level 0 to {progressive.levels} (the file's finest), found {level}; lower it")
    return level
