"""Edge collapses by quadric error, topology kept."""
from .admissibility import shape_holds
from .collapse_loop import NEVER, needs_compiling, oriented
from .decimator import half_edges_with_quadrics
from .edge_collapse import collapse_edge, gather_stencil, link_condition_holds
from .edge_heap import DEAD, REJECTED, heapify_edges, put_edge, take_edge
from .halfedge_mesh import connect_halfedges, is_border
from .qem import Decimation, decimate
from .quadric import best_point, edge_costs

__all__ = [
    "DEAD",
    "Decimation",
    "NEVER",
    "REJECTED",
    "best_point",
    "collapse_edge",
    "connect_halfedges",
    "decimate",
    "edge_costs",
    "gather_stencil",
    "half_edges_with_quadrics",
    "heapify_edges",
    "is_border",
    "link_condition_holds",
    "needs_compiling",
    "oriented",
    "put_edge",
    "shape_holds",
    "take_edge",
]
