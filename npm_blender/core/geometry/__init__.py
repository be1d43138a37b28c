"""Queries on triangle meshes, compiled."""
from .bvh import BVH_STACK, build_bvh, refit_bvh
from .closest_point import ClosestPoints
from .disjoint_sets import find_root, unite
from .face_orientation import (
    FLIPPED_FIT,
    FLIPPED_SURFACE,
    OPPOSED,
    is_flipped,
    is_flipped_from,
    not_flipped,
    orientation_cosine,
    orientation_measures,
)
from .geodesic_trace import SurfacePoints, TraceMesh, evaluate_point, move_point, points_on, trace_geodesic
from .halfedge_steps import end_of, next_halfedge, prev_halfedge
from .normals import normals_of, triangle_normal, vertex_normals
from .sampling import sample
from .symmetric3 import DIAGONAL, add_outer, invert_blocks
from .welding import near_places, weld

__all__ = [
    "BVH_STACK",
    "ClosestPoints",
    "DIAGONAL",
    "FLIPPED_FIT",
    "FLIPPED_SURFACE",
    "OPPOSED",
    "SurfacePoints",
    "TraceMesh",
    "add_outer",
    "build_bvh",
    "end_of",
    "evaluate_point",
    "find_root",
    "invert_blocks",
    "is_flipped",
    "is_flipped_from",
    "move_point",
    "near_places",
    "next_halfedge",
    "normals_of",
    "not_flipped",
    "orientation_cosine",
    "orientation_measures",
    "points_on",
    "prev_halfedge",
    "refit_bvh",
    "sample",
    "trace_geodesic",
    "triangle_normal",
    "unite",
    "vertex_normals",
    "weld",
]
