"""Sizes and initial values of the network's parameters; the forward passes are in `encoder` and `decoder`.

Parameters are a plain tree of dicts and lists of arrays, so that both backends, the optimiser and the weight file see
the same thing.
"""
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np

from .backend import Array, Layer
from .decoder import SLOT_FEATURES
from .input_features import CHANNELS

DETAILS = 3
Tree: TypeAlias = Any  # a dict or a list of trees, or a leaf; mypy cannot follow where a recursive type is taken apart


@dataclass(frozen=True)
class NetworkConfig:
    """Widths per slot; a face has three slots.

    decoder: hidden width of the steps from levels 0, 1, ..; encoder: of the steps to levels 0, 1, ...

    >>> from npm_blender.core.network import NetworkConfig
    >>> len(NetworkConfig().decoder)  # steps that are trained; finer levels use the last one again
    3
    """

    decoder: tuple[int, ...] = (32, 32, 16)
    encoder: tuple[int, ...] = (32, 16, 8)


def initial_parameters(config: NetworkConfig, seed: int = 0) -> dict:
    """Random parameters, with a direct linear path so that the untrained pair is already a (crude) codec:

    two slot features carry a midpoint's offset along the edge normal, the decoder applies their sum from both sides. The
    entries of the other maps are normal of variance gain^2 / inputs, which keeps the size of what passes (LeCun et al. 1998).

    >>> from npm_blender.core.network import NetworkConfig, flatten_tree, initial_parameters
    >>> params = initial_parameters(NetworkConfig(decoder=(4, 4), encoder=(4,)), seed=1)
    >>> params["decoder"][1]["conv2"]["own"].shape, params["decoder"][1]["conv2"]["own"].dtype.name
    ((12, 4), 'float32')
    """
    rng = np.random.default_rng(seed)

    def dense(rows: int, columns: int, gain: float = 1.0) -> np.ndarray:
        return (rng.standard_normal((rows, columns)) * gain / np.sqrt(rows)).astype(np.float32)

    def normalised(layer: Layer, width: int) -> Layer:
        layer.update(gamma=np.ones(width), beta=np.zeros(width), mean=np.zeros(width), var=np.ones(width))
        return layer

    def two_face(width_in: int, width_out: int, gain: float = 1.0) -> Layer:
        return {
            "own": dense(3 * width_in, width_out, gain),
            "other": dense(3 * width_in, width_out, gain),
            "bias": np.zeros(width_out),
        }

    step: dict[str, Any]
    decoder, below = [], 0
    for width, above in zip(config.decoder, (*config.decoder[1:], config.decoder[-1]), strict=True):
        given = below + CHANNELS + SLOT_FEATURES
        step = {
            "conv1": normalised(two_face(given, width), width),
            "conv2": normalised(two_face(width, width), width),
            "skip": dense(given, width, 0.3),
            "displace": two_face(width + CHANNELS + SLOT_FEATURES, 6, 0.0),
            "up": {name: dense(3 * width, above) for name in ("corner0", "corner1", "corner2", "centre")},
        }
        for side in ("own", "other"):
            step["displace"][side][width + CHANNELS + 2, 2] = 0.05
        decoder.append(step)
        below = above
    encoder = []
    for i, width in enumerate(config.encoder):
        above = config.encoder[min(i + 1, len(config.encoder) - 1)]
        step = {
            "conv": normalised(two_face(CHANNELS + DETAILS + above, width), width),
            "pool": {name: dense(3 * width, width) for name in ("own", "next", "prev", "centre")},
            "features": dense(width, SLOT_FEATURES, 0.1),
            "direct": np.zeros((DETAILS, SLOT_FEATURES)),
        }
        step["direct"][2, 2] = 0.5
        encoder.append(step)
    return as_float32({"decoder": decoder, "encoder": encoder})


def as_float32(tree: Tree) -> Tree:
    """The tree with every leaf as a float32 array."""
    return map_tree(lambda x: np.asarray(x, dtype=np.float32), tree)


def map_tree(function: Callable[[Array], Array], tree: Tree) -> Tree:
    """The tree with `function` applied to every leaf.

    >>> from npm_blender.core.network import map_tree
    >>> map_tree(lambda x: 2 * x, {"decoder": [1, 2], "encoder": [3]})
    {'decoder': [2, 4], 'encoder': [6]}
    """
    if isinstance(tree, dict):
        return {k: map_tree(function, v) for k, v in tree.items()}
    if isinstance(tree, list):
        return [map_tree(function, v) for v in tree]
    return function(tree)


def flatten_tree(tree: Tree, prefix: str = "") -> dict[str, Array]:
    """The leaves of the tree by dotted name, e.g. 'decoder.0.conv1.own'.

    >>> from npm_blender.core.network import flatten_tree
    >>> flatten_tree({"decoder": [{"skip": 1}, {"skip": 2}]})
    {'decoder.0.skip': 1, 'decoder.1.skip': 2}
    """
    items = tree.items() if isinstance(tree, dict) else ((str(i), v) for i, v in enumerate(tree))
    out: dict[str, Array] = {}
    for key, value in items:
        name = f"{prefix}{key}"
        out.update(flatten_tree(value, name + ".") if isinstance(value, dict | list) else {name: value})
    return out


def unflatten_tree(leaves: dict[str, Array]) -> Tree:
    """The tree of dotted names; levels whose keys are all numbers become lists. The inverse of `flatten_tree`.

    >>> from npm_blender.core.network import unflatten_tree
    >>> unflatten_tree({"decoder.0.skip": 1, "decoder.1.skip": 2})
    {'decoder': [{'skip': 1}, {'skip': 2}]}
    """
    tree: dict = {}
    for name, value in leaves.items():
        *path, last = name.split(".")
        node = tree
        for key in path:
            node = node.setdefault(key, {})
        node[last] = value

    def lists(node: Tree) -> Tree:
        if not isinstance(node, dict):
            return node
        node = {k: lists(v) for k, v in node.items()}
        return [node[str(i)] for i in range(len(node))] if node and all(k.isdigit() for k in node) else node

    return lists(tree)


def folded(tree: Tree) -> Tree:
    """The tree with batch normalization folded into the linear maps before it, for inference.

    gamma (x w + b - mean) / sqrt(var + 1e-5) + beta = x (w s) + (b - mean) s + beta, s = gamma / sqrt(var + 1e-5)
    (batch normalization: Ioffe and Szegedy 2015).

    >>> import numpy as np
    >>> from npm_blender.core.network import folded
    >>> one = np.ones(1, np.float32)
    >>> layer = {"own": one, "other": one, "bias": one, "gamma": one, "beta": 2 * one, "mean": one, "var": 4 * one}
    >>> {name: x.round(3).tolist() for name, x in folded(layer).items()}
    {'own': [0.5], 'other': [0.5], 'bias': [2.0]}
    """
    if isinstance(tree, list):
        return [folded(v) for v in tree]
    if not isinstance(tree, dict):
        return tree
    if "gamma" not in tree:
        return {k: folded(v) for k, v in tree.items()}
    scale = tree["gamma"] / np.sqrt(tree["var"] + np.float32(1e-5))
    bias = (tree["bias"] - tree["mean"]) * scale + tree["beta"]
    return as_float32({"own": tree["own"] * scale, "other": tree["other"] * scale, "bias": bias})
