"""The first collapses of a large mesh, on its regions side by side.

The vertices are divided into boxes. A vertex is deep where no neighbour is in another box and none of its edges on the
border; a collapse of an edge with two deep ends moves, joins and looks up vertices of its box only, and leaves a deep
vertex deep. So the boxes can be decimated at the same time, each to a number of faces from which the base could still
be made of that box alone; what is left, with the strips between the boxes, is divided again or decimated as a whole.
Which boxes there are depends on the mesh and the number of base faces, not on the number of threads.
"""
from dataclasses import replace

import numpy as np

from ..geometry import next_halfedge
from ..jit import compiled
from ..mesh import radix_argsort, spatial_boxes
from ..parallel import each
from ..parameterization import CollapseRecord
from ..progress import Progress
from .admissibility import TestColumns
from .collapse_loop import FACES_LEFT, MORE, RANDOM, Limits, Scratch
from .decimator import Decimator, fresh_counts
from .edge_heap import DEAD, LOCKED

LEFT = 4  # times the base's faces are left in a region
DIVIDED = 4  # times as many faces as are left: those of a region at least
SMALLEST = 32_000  # faces a region may have in any case; with half as many, strips between regions cost what the cache saves
LARGEST = 64_000  # where a region would need more, the mesh is decimated as a whole


def _size(base_faces: int) -> tuple[int, int]:
    """Faces that a region may have, and those that are left of it."""
    left = LEFT * base_faces
    return max(DIVIDED * left, SMALLEST), left


def worth_dividing(faces: int, base_faces: int) -> bool:
    """Whether a mesh of so many faces is large enough for regions."""
    most, _ = _size(base_faces)
    return most <= LARGEST and faces >= 2 * most


@compiled
def _assign(m, label, place, region, edges, faces, deep):
    """Lock the edges that no region may collapse; region (e,) gets the box of the others, -1 for dead and locked ones.

    edges, faces (boxes,): how many each box has. deep (n,) bool, of ones, keeps them for the deep vertices.
    """
    for f in range(len(m.corner) // 3):
        a, b, c = m.corner[3 * f], m.corner[3 * f + 1], m.corner[3 * f + 2]
        if a < 0:
            continue
        if label[a] == label[b] and label[b] == label[c]:
            faces[label[a]] += 1
        else:
            deep[a] = deep[b] = deep[c] = False
        for h in range(3 * f, 3 * f + 3):
            if m.opposite[h] == h:
                deep[m.corner[h]] = deep[m.corner[next_halfedge(h)]] = False
    for e in range(len(place)):
        region[e] = -1
        if place[e] == DEAD:
            continue
        i, j = m.corner[m.start[e]], m.corner[next_halfedge(m.start[e])]
        if deep[i] and deep[j]:
            region[e] = label[i]
            edges[label[i]] += 1
        else:
            place[e] = LOCKED


def decimate_regions(work: Decimator, base_faces: int, dear: float, progress: Progress, message: str) -> None:
    """Collapse edges inside of boxes, and append them to the record of the work.

    Only edges that pass the first test, at a price of at most `dear`. Raises what `progress` does.
    """
    mesh, queue, counts = work.mesh, work.queue, work.counts
    most, left = _size(base_faces)
    living = np.flatnonzero(mesh.out >= 0)
    label = np.full(len(mesh.out), -1, np.int32)
    label[living] = spatial_boxes(mesh.X.take(living, 0), most // 2)
    count = int(label.max()) + 1
    region, edges, faces = np.empty(len(queue.place), np.int32), np.zeros(count, np.int64), np.zeros(count, np.int64)
    _assign(mesh, label, queue.place, region, edges, faces, np.ones(len(label), bool))
    order = radix_argsort(region + 1)[len(region) - edges.sum():].astype(np.int32)
    ends = np.cumsum(edges)
    first_test = TestColumns(*(column[:1] for column in work.tests))

    def task(k: int) -> Decimator:
        seed = int(counts[RANDOM]) + 2 * k if counts[RANDOM] else 0
        heap, key = np.empty(edges[k], np.int32), np.empty(edges[k])
        region = replace(work, queue=queue._replace(heap=heap, key=key), tests=first_test,
                         counts=fresh_counts(faces[k], seed, False), record=CollapseRecord.empty())
        region.offer(order[ends[k] - edges[k]:ends[k]])
        while region.run(Scratch.make(), Limits(left, len(order), len(order), dear)) == MORE:
            pass
        return region

    regions = each(task, range(count), progress, message)
    counts[FACES_LEFT] -= sum(int(faces[k]) - region.faces for k, region in enumerate(regions))
    work.record = work.record.followed_by([region.record.used() for region in regions], work.faces // 2)
