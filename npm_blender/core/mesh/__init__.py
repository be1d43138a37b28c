"""Triangle meshes as arrays; NumPy alone."""
from .components import component_labels
from .radix_order import radix_argsort
from .renumbering import Renumbering
from .sharp import Sharp, turns
from .spatial_order import along_curve, in_morton_order, spatial_boxes
from .subdivision import Level, hierarchy, midpoints, subdivided_opposite
from .topology import (
    Topology,
    directed_edges,
    next_halfedges,
    opposite_halfedges,
    prev_halfedges,
    topology_of,
    vertex_fans,
)
from .triangle_mesh import TriMesh, UnitFrame, compact

__all__ = [
    "Level",
    "Renumbering",
    "Sharp",
    "Topology",
    "TriMesh",
    "UnitFrame",
    "along_curve",
    "compact",
    "component_labels",
    "directed_edges",
    "hierarchy",
    "in_morton_order",
    "midpoints",
    "next_halfedges",
    "opposite_halfedges",
    "prev_halfedges",
    "radix_argsort",
    "spatial_boxes",
    "subdivided_opposite",
    "topology_of",
    "turns",
    "vertex_fans",
]
