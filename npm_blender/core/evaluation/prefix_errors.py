"""What a stream's prefixes are worth: errors against the original, measured at the stream's own stops.

Measured where the original is at hand, that is, when a mesh is compressed; kept beside the stream as text. Between two
stops nothing is claimed but what was measured at both.
"""
import json
from bisect import bisect_left, bisect_right
from dataclasses import astuple, dataclass

import numpy as np

from ..codec import ProgressiveMesh
from ..errors import StreamError
from ..mesh import TriMesh, UnitFrame
from ..progress import Progress, no_progress

MOST_STOPS = 16  # that are measured
SAMPLES = 8_000  # points each way; the mean distance of a stop is then good to about 1 %
_FIELDS = ("d_pm", "d_p99", "d_normal", "d_reverse")
_LIMIT = 1_000_000  # characters of a text that is worth reading


@dataclass(frozen=True)
class StopErrors:
    """The errors of one stop, as in `Metrics`: distances in 1e-4 of `PrefixErrors.size`, the angle in degrees."""

    d_pm: float
    d_p99: float
    d_normal: float
    d_reverse: float

    @property
    def worse(self) -> float:
        """The larger of d_pm and d_reverse: how far off a prefix is said to be (`Metrics.worse`)."""
        return max(self.d_pm, self.d_reverse)


@dataclass(frozen=True)
class PrefixErrors:
    """Errors of a stream's prefixes.

    size: longest side of the original's box, object units; features: (s,) ascending numbers of features, the first 0
    and the last all; bytes: (s,) of the shortest prefixes that hold them; errors: for each level, for each of
    `features`, the errors.

    >>> from npm_blender.core.evaluation import PrefixErrors
    >>> from npm_blender.core.evaluation.prefix_errors import StopErrors
    >>> coarse, fine = StopErrors(90.0, 300.0, 8.0, 95.0), StopErrors(20.0, 80.0, 4.0, 22.0)
    >>> errors = PrefixErrors(2.0, features=(0, 40), bytes=(700, 900), errors=((coarse, coarse), (coarse, fine)))
    >>> [stop.worse for stop in errors.around(20, level=1)], [stop.worse for stop in errors.around(40, level=1)]
    ([95.0, 22.0], [22.0])
    """

    size: float
    features: tuple[int, ...]
    bytes: tuple[int, ...]
    errors: tuple[tuple[StopErrors, ...], ...]

    def around(self, features: int, level: int) -> tuple[StopErrors, ...]:
        """What was measured at `features`, as one entry, or else at the stops before and after, as two.

        One entry, the last, beyond the last stop. Raises IndexError for a level that the stream does not have.
        """
        before = max(bisect_right(self.features, features) - 1, 0)
        after = min(bisect_left(self.features, features), len(self.features) - 1)
        return tuple(self.errors[level][k] for k in sorted({before, after}))

    def to_text(self) -> str:
        """As JSON; four digits, which is more than the measure is good for."""
        rows = [[[float(f"{value:.4g}") for value in astuple(m)] for m in stops] for stops in self.errors]
        said = {"size": self.size, "features": self.features, "bytes": self.bytes, "errors": rows}
        return json.dumps(said, separators=(",", ":"))


def prefix_errors_from_text(text: str) -> PrefixErrors:
    """The inverse of `PrefixErrors.to_text`. Raises StreamError if the text is damaged.

    >>> from npm_blender.core.evaluation import PrefixErrors, prefix_errors_from_text
    >>> from npm_blender.core.evaluation.prefix_errors import StopErrors
    >>> coarse, fine = StopErrors(90.0, 300.0, 8.0, 95.0), StopErrors(20.0, 80.0, 4.0, 22.0)
    >>> errors = PrefixErrors(2.0, features=(0, 40), bytes=(700, 900), errors=((coarse, coarse), (coarse, fine)))
    >>> prefix_errors_from_text(errors.to_text()) == errors
    True
    """
    try:
        if len(text) > _LIMIT:
            raise ValueError(f"{len(text)} characters")
        said = json.loads(text)
        features, sizes = tuple(said["features"]), tuple(said["bytes"])
        errors = tuple(tuple(StopErrors(*map(float, row)) for row in stops) for stops in said["errors"])
        size = float(said["size"])
        values = np.array([[astuple(m) for m in stops] for stops in errors])
        fits = (values.shape == (len(errors), len(features), len(_FIELDS)) and values.size
                and np.isfinite(values).all() and (values >= 0).all() and 0 < size < np.inf
                and all(isinstance(k, int) and k >= 0 for k in features + sizes) and len(sizes) == len(features)
                and list(features) == sorted(set(features)))
        if not fits:
            raise ValueError("numbers that do not fit together")
    except (ValueError, TypeError, KeyError, AttributeError, RecursionError) as error:
        raise StreamError(f"Expected measured errors as JSON, found damaged text ({error}); "
                          "compress the original again") from error
    return PrefixErrors(size, features, sizes, errors)


def thinned(stops: tuple[int, ...], most: int) -> tuple[int, ...]:
    """At most so many of ascending stops, evenly along their list, the first and the last among them.

    >>> from npm_blender.core.evaluation import thinned
    >>> thinned((0, 80, 320, 1300, 5200, 20800), most=3), thinned((0, 80), most=16)
    ((0, 320, 20800), (0, 80))
    """
    if len(stops) <= most:
        return stops
    places = np.rint(np.linspace(0, len(stops) - 1, most)).astype(int)
    return tuple(stops[k] for k in places.tolist())


def measure_prefixes(stream: ProgressiveMesh, original: TriMesh, progress: Progress = no_progress) -> PrefixErrors:
    """Errors of all levels at the stops of the stream, at most MOST_STOPS of them. original: what was compressed, same frame.

    Takes some 20 ms a stop and level beside the decoding. Raises MeshError if the original has no area, Cancelled
    (from `progress`).

    >>> from npm_blender.core import CompressSettings, LodSettings, TriMesh, compress, open_stream
    >>> from npm_blender.core.evaluation import measure_prefixes
    >>> V = [[x, y, x * y / 8] for y in range(5) for x in range(5)]
    >>> F = [f for i in range(19) if i % 5 < 4 for f in ([i, i + 1, i + 5], [i + 1, i + 6, i + 5])]
    >>> mesh = TriMesh.from_arrays(V, F)
    >>> settings = CompressSettings(LodSettings(base_faces=8, levels=1))
    >>> errors = measure_prefixes(open_stream(compress(mesh, settings, progress=lambda *_: None).data), mesh)
    >>> errors.features[0], len(errors.errors), errors.size
    (0, 2, 4.0)
    """
    from .metrics import Original  # only here: this import loads or compiles the search for closest points

    progress(0.0, "Measuring")
    reference = Original(original, SAMPLES)
    stops = thinned(stream.stops, MOST_STOPS)
    errors: list[list[StopErrors]] = [[] for _ in range(stream.levels + 1)]
    for k, features in enumerate(stops):
        for level, measured in enumerate(errors):
            found = reference.evaluate(stream.decode(features, level))
            measured.append(StopErrors(*(getattr(found, name) for name in _FIELDS)))
        progress((k + 1) / len(stops), "Measuring")
    sizes = tuple(stream.bytes_for(features) for features in stops)
    return PrefixErrors(UnitFrame.of(original.V).size, stops, sizes, tuple(map(tuple, errors)))
