"""Border vertices made one where surfaces belong together: seams, triangle soups, T-junctions.

Both repairs are tried first and kept only where fewer border edges are left once the result is cut into a manifold.
"""
import numpy as np

from ..geometry import near_places, weld
from ..mesh import compact, next_halfedges
from ..progress import Progress, no_progress
from .degenerate_faces import repeated_corners
from .duplicate_faces import duplicates
from .edge_groups import EdgeGroups
from .manifold_cut import cut
from .orientation import orient

NEAR = 1e-6  # of the box: how far apart border vertices may be and still be one
SINGLE = 2.0**-22  # two units in the last place of single precision


def weld_borders(V: np.ndarray, groups: EdgeGroups, progress: Progress = no_progress) -> tuple[EdgeGroups, int]:
    """The edges of faces whose coincident border vertices were made one, and the number of vertices that went.

    Only where fewer border edges are left once the result is cut into a manifold again. Vertices inside a surface are
    never joined, so surfaces that merely touch stay apart. Exact coincidence is tried first, then a distance of NEAR
    times the box, of a tenth of the shortest border edge at either vertex if that is less: no edge is collapsed.
    """
    changed = 0
    for near in (0.0, reach_of(V, groups.F)):
        alone, flat = groups.border, groups.F.reshape(-1)
        if len(alone) == 0:
            break
        a, b = flat[alone], flat[next_halfedges(alone)]
        border = np.unique([a, b])
        progress(near > 0, "Merging vertices")
        first, place = weld(V[border])
        if near:
            length = np.linalg.norm(V[b] - V[a], axis=1)
            shortest = np.full(len(V), near)
            np.minimum.at(shortest, np.concatenate([a, b]), 0.1 * np.concatenate([length, length]))
            least = np.full(len(first), near)
            np.minimum.at(least, place, shortest[border])
            first = first[near_places(V[border[first]], least)]
        joined = np.arange(len(V), dtype=np.int32)
        joined[border] = border[first[place]]
        joined = _apart_along_edges(groups.F, joined)
        count = int((joined != np.arange(len(V))).sum())
        if count:
            progress(0.5 + 0.5 * (near > 0), "Merging vertices")
            trial = groups.replaced(joined[groups.F])
            if borders_after_cut(V, trial) < len(alone):
                groups, changed = trial, changed + count
    return groups, changed


def reach_of(V: np.ndarray, F: np.ndarray) -> float:
    """How far vertices of faces F (m, 3) may be apart and still be one, in units of V.

    NEAR times the longest side of their box, or what two roundings to single precision leave if V holds only numbers
    of that: far from the origin that is more.
    """
    V = compact(V, F)[0]
    near = NEAR * float(np.ptp(V, axis=0).max())
    largest = float(np.abs(V).max())
    with np.errstate(over="ignore"):
        single = largest * SINGLE > near and (V.astype(np.float32) == V).all()
    if not single:
        return near
    return SINGLE * largest


def _apart_along_edges(F: np.ndarray, joined: np.ndarray) -> np.ndarray:
    """joined (n,) without the places that hold two corners of one face."""
    trial = joined[F]
    broken = repeated_corners(trial)
    if not broken.any():
        return joined
    flat = trial[broken]
    same = np.concatenate([flat[flat[:, k] == flat[:, k - 1], k] for k in range(3)])
    split = np.isin(joined, same)
    return np.where(split, np.arange(len(joined)), joined).astype(np.int32)


def borders_after_cut(V: np.ndarray, groups: EdgeGroups) -> int:
    """Border edges of the manifold that the faces of `groups` would be made."""
    if (groups.sizes > 2).any() or groups.disagree().any():
        groups = EdgeGroups.of(groups.F[~duplicates(groups.F)], groups.n)
        groups = groups.replaced(orient(V, groups)[0])
        V, F, _, _ = cut(V, groups)
        groups = EdgeGroups.of(F, len(V))
    return len(groups.border)
