"""Vertices of the paper's stream: latents of faces through the network (paper section 3)."""
import numpy as np

from ..bitstream import LatentCoding, LatentFeatures, ParsedStream
from ..errors import WeightsError
from ..mesh import Level, hierarchy
from ..network import FEATURES, NUMPY, MeshIndex, Step, handed_down, load_weights, predict


class LatentDecoder:
    """The receiver's side of a stream of latents. Of each level's step it keeps what the network said last: another number of
    features changes only the levels that see those features."""

    def __init__(self, stream: ParsedStream) -> None:
        """stream: of `LatentCoding`. Raises WeightsError if its weights are not here."""
        coding, details = stream.header.coding, stream.details
        assert isinstance(coding, LatentCoding) and isinstance(details, LatentFeatures)
        model = load_weights(coding.model_id)
        if model.digest != coding.weights_hash:
            raise WeightsError(
                f"Expected weights '{coding.model_id}' {coding.weights_hash.hex()}, found {model.digest.hex()}; "
                "install the version of the extension that wrote this file"
            )
        self.features = stream.features  # that have arrived
        self._params, self._V0 = model.params, NUMPY.array(stream.V0)
        self.levels: list[Level] = hierarchy(stream.F0, len(stream.grid), stream.header.levels)
        self._meshes = [MeshIndex.of(NUMPY, level) for level in self.levels[:-1]]
        self._level, self._face = details.level, details.face
        self._value = details.value.astype(np.float32) * np.asarray(coding.steps, np.float32)[details.level][:, None]
        self._steps: list[tuple[tuple, Step] | None] = [None] * stream.header.levels

    @property
    def stops(self) -> tuple[int, ...]:
        """Numbers of latents at which errors are measured."""
        return tuple(k for k in (20, 40, 100, 200, 400, 800, 1500, 3000, 6000) if k < len(self._level)) + (len(self._level),)

    def scalars(self, features: int) -> int:
        """Numbers in the first features (paper section 4.1 counts them for CR)."""
        return FEATURES * features

    def vertices(self, features: int, level: int) -> np.ndarray:
        """Vertices (n, 3) of a level with the first latents, unit frame."""
        groups = np.bincount(self._level[:features], minlength=len(self._steps))
        out = [self._V0]
        for i in range(level):
            seen = tuple(groups[:i + 1])  # what the network sees: the latents of this level and the ones below
            known = self._steps[i]
            if known is None or known[0] != seen:
                before = self._steps[i - 1] if i else None
                below = before[1].hidden if before else None
                step = predict(NUMPY, self._params, i, out[i], below, self._latents(features, i), self._meshes[i])
                known = self._steps[i] = seen, step._replace(hidden=self._handed_down(i, step.hidden))
            out.append(known[1].V)
        return out[-1]

    def _handed_down(self, level: int, hidden: np.ndarray) -> np.ndarray | None:
        """What the step from `level` leaves for the next one, if there is one."""
        return handed_down(NUMPY, self._params, level, hidden, self._meshes[level]) if level + 1 < len(self._steps) else None

    def _latents(self, features: int, level: int) -> np.ndarray:
        """Latents (m, 8) of the faces of a level, zero where none is among the first `features`."""
        out = np.zeros((self._meshes[level].m, FEATURES), np.float32)
        mine = np.flatnonzero(self._level[:features] == level)
        out[self._face[mine]] = self._value[mine]
        return out
