"""The trained weights: an .npz of arrays with the configuration beside them, identified by a hash of their content."""
import hashlib
import json
import os
import zipfile
import zlib
from dataclasses import asdict, dataclass
from functools import cache
from pathlib import Path

import numpy as np

from ..errors import WeightsError
from .parameters import NetworkConfig, flatten_tree, unflatten_tree

FOLDER = Path(__file__).parents[2] / "weights"
DEFAULT = "npm1"


@dataclass(frozen=True)
class Weights:
    """Trained parameters, batch normalization folded. model_id: short name; digest: 8 bytes that identify them.

    >>> from npm_blender.core.network import load_weights
    >>> weights = load_weights()
    >>> weights.model_id, len(weights.digest), sorted(weights.params)
    ('npm1', 8, ['decoder', 'encoder'])
    """

    params: dict
    config: NetworkConfig
    model_id: str
    digest: bytes


def weights_digest(params: dict) -> bytes:
    """First 8 bytes of the SHA-256 of all arrays in the order of their names."""
    h = hashlib.sha256()
    for name, value in sorted(flatten_tree(params).items()):
        h.update(f"{name}{value.shape}".encode())
        h.update(np.ascontiguousarray(value, dtype="<f4").tobytes())
    return h.digest()[:8]


def save_weights(path: Path, params: dict, config: NetworkConfig) -> None:
    """Write folded parameters (a tree of float32 arrays) to an .npz, atomically.

    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> from npm_blender.core.network import NetworkConfig, folded, initial_parameters, load_weights, save_weights
    >>> config = NetworkConfig(decoder=(4,), encoder=(4,))
    >>> with TemporaryDirectory() as folder:
    ...     save_weights(Path(folder, "small.npz"), folded(initial_parameters(config)), config)
    ...     load_weights("small", Path(folder)).config == config
    True
    """
    temporary = path.with_name(path.name + ".tmp.npz")
    np.savez_compressed(temporary, config=np.array(json.dumps(asdict(config))), **flatten_tree(params))
    os.replace(temporary, path)


@cache
def load_weights(model_id: str = DEFAULT, folder: Path = FOLDER) -> Weights:
    """The weights of a model. Raises WeightsError if they are missing or damaged.

    >>> from npm_blender.core.network import load_weights
    >>> len(load_weights().params["decoder"])  # steps that are trained
    3
    """
    path = folder / f"{model_id}.npz"
    if not path.is_file():
        raise WeightsError(
            f"Expected trained weights '{model_id}' in {folder.name}/, found none; reinstall the extension"
        )
    try:
        with np.load(path, allow_pickle=False) as z:
            config = NetworkConfig(**{k: tuple(v) for k, v in json.loads(str(z["config"])).items()})
            params = unflatten_tree({k: z[k] for k in z.files if k != "config"})
    except (OSError, ValueError, KeyError, TypeError, EOFError, zipfile.BadZipFile, zlib.error) as error:
        raise WeightsError(
            f"Expected readable weights in {path.name}, found a damaged file ({error}); reinstall the extension"
        ) from error
    return Weights(params, config, model_id, weights_digest(params))
