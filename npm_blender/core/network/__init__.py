"""Encoder and decoder, written once for NumPy and torch."""
from typing import TYPE_CHECKING

from ..lazy import lazy_exports

if TYPE_CHECKING:
    from .backend import Backend
    from .decoder import FEATURES, Step, decode, handed_down, predict
    from .encoder import details, encode
    from .frames import edge_frames, face_normals
    from .input_features import geometry_features
    from .mesh_index import MeshIndex
    from .numpy_backend import NUMPY
    from .parameters import NetworkConfig, flatten_tree, folded, initial_parameters, map_tree, unflatten_tree
    from .torch_backend import TorchBackend, torch_device
    from .weights import Weights, load_weights, save_weights

__all__ = [
    "Backend",
    "FEATURES",
    "MeshIndex",
    "NUMPY",
    "NetworkConfig",
    "Step",
    "TorchBackend",
    "Weights",
    "decode",
    "details",
    "edge_frames",
    "encode",
    "face_normals",
    "flatten_tree",
    "folded",
    "geometry_features",
    "handed_down",
    "initial_parameters",
    "load_weights",
    "map_tree",
    "predict",
    "save_weights",
    "torch_device",
    "unflatten_tree",
]
__getattr__, __dir__ = lazy_exports(__name__, {
    "backend": ("Backend",),
    "decoder": ("FEATURES", "Step", "decode", "handed_down", "predict",),
    "encoder": ("details", "encode",),
    "frames": ("edge_frames", "face_normals",),
    "input_features": ("geometry_features",),
    "mesh_index": ("MeshIndex",),
    "numpy_backend": ("NUMPY",),
    "parameters": ("NetworkConfig", "flatten_tree", "folded", "initial_parameters", "map_tree", "unflatten_tree",),
    "torch_backend": ("TorchBackend", "torch_device",),
    "weights": ("Weights", "load_weights", "save_weights"),
})
