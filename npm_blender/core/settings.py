"""Settings of the pipeline: frozen, checked once when they are made, never a dict of strings."""
from dataclasses import dataclass

from .errors import SettingsError

DISPLACED, PAPER = MODELS = ("displaced", "paper")  # how a stream refines its base
AUTO = 0  # as base faces: chosen from the shape or the budget; as levels: from the base faces
PAPER_FACES, PAPER_LEVELS = 400, 3
LEAST_BUDGET = 300  # bytes; a base mesh of some dozen faces fits
CLEAN_MODES = ("auto", "off", "tetwild")
CACHE_VARIABLE = "NPMESH_CACHE"  # in the environment: the folder for what is kept between runs


def _in_range(name: str, value: int, low: int, high: int) -> None:
    if isinstance(value, bool) or not isinstance(value, int) or not low <= value <= high:
        raise SettingsError(f"Expected {name} to be a whole number from {low} to {high}, found {value!r}")


@dataclass(frozen=True)
class LodSettings:
    """How the LoD sequence is built.

    base_faces: faces of the base mesh M^0 (paper: 400), or AUTO; levels: subdivisions L (paper: 3), or AUTO;
    clean: 'auto' repairs what the checks find, 'off' refuses what does not qualify, 'tetwild' always re-meshes;
    variant: 0 collapses the cheapest edge; k > 0 seeds a random choice among the cheapest (training augmentation).

    >>> from npm_blender.core.settings import AUTO, LodSettings
    >>> LodSettings(base_faces=AUTO, levels=2)
    LodSettings(base_faces=0, levels=2, clean='auto', variant=0)
    """

    base_faces: int = AUTO
    levels: int = AUTO
    clean: str = "auto"
    variant: int = 0

    def __post_init__(self) -> None:
        if self.base_faces != AUTO or isinstance(self.base_faces, bool):
            _in_range("base faces", self.base_faces, 4, 100_000)
        if self.levels != AUTO or isinstance(self.levels, bool):
            _in_range("levels", self.levels, 1, 6)
        _in_range("variant", self.variant, 0, 2**31 - 1)
        if self.clean not in CLEAN_MODES:
            raise SettingsError(f"Expected clean to be one of {', '.join(CLEAN_MODES)}, found {self.clean!r}")


@dataclass(frozen=True)
class CompressSettings:
    """How a mesh is compressed: `lod`, plus

    position_bits: bits per base coordinate, 4 to 20, or AUTO: as many as the mesh's error asks for; model: 'displaced', or
    'paper' for the paper's own stream (its AUTO base has PAPER_FACES faces, and PAPER_LEVELS levels); order: of the latents of
    'paper', 'gain' (measured reconstruction gain) or 'magnitude' (the paper's); budget: bytes that the stream may have, 0 for as
    many as help; with it, what is AUTO is what shows most in so many bytes (see `codec.size_search`).

    >>> from npm_blender.core.settings import CompressSettings
    >>> CompressSettings(position_bits=30)
    Traceback (most recent call last):
    npm_blender.core.errors.SettingsError: Expected position bits to be a whole number from 4 to 20, found 30
    """

    lod: LodSettings = LodSettings()
    position_bits: int = AUTO
    model: str = DISPLACED
    order: str = "gain"
    budget: int = 0

    def __post_init__(self) -> None:
        if self.position_bits != AUTO or isinstance(self.position_bits, bool):
            _in_range("position bits", self.position_bits, 4, 20)
        if self.budget != 0 or isinstance(self.budget, bool):
            _in_range("budget in bytes", self.budget, LEAST_BUDGET, 10**9)
        if self.model not in MODELS:
            raise SettingsError(f"Expected model to be one of {', '.join(MODELS)}, found {self.model!r}")
        if self.order not in ("gain", "magnitude"):
            raise SettingsError(f"Expected order to be gain or magnitude, found {self.order!r}")
