"""The stencil of an edge collapse: the ring of faces round the edge that the collapse changes."""

INNER, ANCHORED, EDGE = 0, 1, 2
MAX_RING = 96
