"""Settings of the pipeline: frozen, checked once when they are made, never a dict of strings."""
from dataclasses import dataclass, replace
from importlib.util import find_spec

from .errors import DependencyError, SettingsError

REFINE_STEPS = 24  # gradient steps per stage, where torch is installed and nothing else is asked for
AUTO = 0  # as base faces: chosen from the shape or the budget; as levels: from the base faces
LEAST_BUDGET = 300  # bytes; a base mesh of some dozen faces fits
CLEAN_MODES = ("auto", "off", "tetwild")
DEVICES = ("cpu", "gpu")
CACHE_VARIABLE = "NPMESH_CACHE"  # in the environment: the folder for what is kept between runs


def has_torch() -> bool:
    """Whether torch is installed for this Python; it is not loaded.

    >>> from importlib.util import find_spec
    >>> from npm_blender.core.settings import has_torch
    >>> has_torch() == (find_spec("torch") is not None)
    True
    """
    return find_spec("torch") is not None


def _in_range(name: str, value: int, low: int, high: int) -> None:
    if isinstance(value, bool) or not isinstance(value, int) or not low <= value <= high:
        raise SettingsError(f"Expected {name} to be a whole number from {low} to {high}, found {value!r}")


@dataclass(frozen=True)
class LodSettings:
    """How the LoD sequence is built.

    base_faces: faces of the base mesh M^0 (paper: 400), or AUTO; levels: midpoint subdivisions L (paper: 3), or AUTO;
    clean: 'auto' repairs what the checks find, 'off' refuses what does not qualify, 'tetwild' always re-meshes;
    variant: 0 collapses the cheapest edge; k > 0 seeds a random choice among the cheapest (training augmentation).

    >>> from npm_blender.core.settings import AUTO, LodSettings
    >>> LodSettings(base_faces=AUTO, levels=2)
    LodSettings(base_faces=0, levels=2, clean='auto', variant=0)
    """

    base_faces: int = 400
    levels: int = 3
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

    position_bits: bits per base coordinate, 9 to 14, at most: a mesh that is farther off anyway is sent with fewer;
    order: of the latents, 'gain' (measured reconstruction gain) or 'magnitude' (the paper's); refine_steps: gradient
    steps per stage that fit base and features to this mesh through the decoder (needs torch; 0 uses the encoder's output
    as it is; None: REFINE_STEPS where torch is installed, else 0, see `resolved`); budget: bytes that the stream may have,
    0 for as many as all features take; with it, AUTO base faces are those that show most in so many bytes (see
    `codec.rate_control`).

    >>> from npm_blender.core.settings import CompressSettings
    >>> CompressSettings(position_bits=20)
    Traceback (most recent call last):
    npm_blender.core.errors.SettingsError: Expected position bits to be a whole number from 9 to 14, found 20
    """

    lod: LodSettings = LodSettings()
    position_bits: int = 14
    order: str = "gain"
    refine_steps: int | None = None
    budget: int = 0

    def __post_init__(self) -> None:
        _in_range("position bits", self.position_bits, 9, 14)
        if self.budget != 0 or isinstance(self.budget, bool):
            _in_range("budget in bytes", self.budget, LEAST_BUDGET, 10**9)
        if self.refine_steps is not None:
            _in_range("refine steps", self.refine_steps, 0, 10_000)
        if self.order not in ("gain", "magnitude"):
            raise SettingsError(f"Expected order to be gain or magnitude, found {self.order!r}")

    def resolved(self, torch: bool) -> "CompressSettings":
        """These settings with a number of refine steps, whether torch is there or not.

        Raises DependencyError where steps are asked for and torch is missing.

        >>> from npm_blender.core.settings import CompressSettings
        >>> [CompressSettings().resolved(torch).refine_steps for torch in (True, False)]
        [24, 0]
        """
        if self.refine_steps and not torch:
            raise DependencyError("Expected torch for --refine-steps, found none; install torch or use 0 refine steps")
        if self.refine_steps is not None:
            return self
        return replace(self, refine_steps=REFINE_STEPS if torch else 0)

    def without_torch(self) -> "CompressSettings":
        """These settings as far as they go without torch: with no refine steps, even where some are asked for."""
        return replace(self, refine_steps=0)


@dataclass(frozen=True)
class ComputeSettings:
    """What refinement may use of the machine. A file made with other ones differs in details, and is as good.

    threads: of torch on the processor; 0 for half of the cores, at most four (the LoD builder's are `parallel.threads`,
    which change nothing in a file); device: 'cpu', or 'gpu' where torch finds one.

    >>> from npm_blender.core.settings import ComputeSettings
    >>> ComputeSettings().device
    'cpu'
    """

    threads: int = 0
    device: str = "cpu"

    def __post_init__(self) -> None:
        _in_range("threads", self.threads, 0, 1024)
        if self.device not in DEVICES:
            raise SettingsError(f"Expected device to be one of {', '.join(DEVICES)}, found {self.device!r}")
