"""The LoD sequence M^0..M^L of a mesh (paper section 3.2, "LoD preprocessing"): the result type and its builder."""
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class LodSequence:
    """A base mesh, and where the vertices of its subdivisions lie on the input surface. All in the unit frame.

    V0 (n0, 3) float64: QEM-optimal base positions; F0 (m0, 3) int32: base faces.
    V (nL, 3) float64: vertices of the finest level on the input surface, in the vertex order of `subdivide`; the first
    n_l rows are the vertices of level l (level 0 included: where the map puts the base vertices on the surface).
    N (nL, 3) float64: unit normals of the input at V (area-weighted vertex normals, interpolated).
    source_face (nL,) int32 and barycentric (nL, 3) float64: V as points of the input mesh's faces.
    levels: L. message: '' or one line on what could not be reached ("Reached 412 of 400 base faces: ...").
    """

    V0: np.ndarray
    F0: np.ndarray
    V: np.ndarray
    N: np.ndarray
    source_face: np.ndarray
    barycentric: np.ndarray
    levels: int
    message: str = ""


@dataclass(frozen=True)
class BaseOrder:
    """A renumbering of the base mesh, the one in which the receiver will see it (see `connectivity.canonical_order`).

    vertices (n0,) int32: old index of each new vertex; faces (m0,) int32: old index of each new face;
    F (m0, 3) int32: the new faces in the new numbering. Corners may be rotated against the old face, never mirrored.
    """

    vertices: np.ndarray
    faces: np.ndarray
    F: np.ndarray
