"""A detailed sculpt-like mesh that Blender itself makes: a horned creature's bust, one closed surface.

Suzanne, eyeballs, ram's horns and a bust are joined by a voxel remesh; noise textures, each masked to where a sculptor
would put it, then displace the surface: wrinkles on brow and muzzle, scales on skull and neck, pores everywhere.
Deterministic: the same Blender gives the same mesh.
"""

from collections.abc import Callable

import bpy
import numpy as np
from mathutils import Matrix, Vector, noise

from ..core.mesh import TriMesh

VOXEL = 0.021  # Blender units, on a bust 3.6 units high: about 150k triangles
EYE, EYE_RADIUS = np.array([0.352, -0.575, 0.247]), 0.225


def make_sculpt() -> TriMesh:
    """The sculpt as triangles; V in Blender units, z up, facing -y. Replaces the open Blender scene."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    parts = [_head(), _eye(1), _eye(-1), _horn(1), _horn(-1), _bust()]
    body = _joined(parts)
    V, Q = _arrays(body)
    V, Q = _largest_part(V, Q)
    N = _vertex_normals(V, Q)
    V = V + N * displacement(V, N)[:, None]
    return TriMesh.from_arrays(V, np.concatenate([Q[:, [0, 1, 2]], Q[:, [0, 2, 3]]]))


def _head() -> bpy.types.Object:
    """Suzanne without her eyes, which are open bowls."""
    bpy.ops.mesh.primitive_monkey_add(size=2)
    head = bpy.context.object
    V = np.array([v.co for v in head.data.vertices])
    group = head.vertex_groups.new(name="Skin")
    skin = _island_labels(len(V), np.array([e.vertices for e in head.data.edges]))
    group.add(np.flatnonzero(skin == np.bincount(skin).argmax()).tolist(), 1.0, "REPLACE")
    head.modifiers.new("Mask", "MASK").vertex_group = "Skin"
    head.modifiers.new("Smooth", "SUBSURF").levels = 2
    return head


def _eye(side: int) -> bpy.types.Object:
    bpy.ops.mesh.primitive_uv_sphere_add(segments=48, ring_count=24, radius=EYE_RADIUS, location=EYE * (side, 1, 1))
    return bpy.context.object


def _tube(name: str, centres: np.ndarray, radii: np.ndarray, segments: int) -> bpy.types.Object:
    """A closed tube round the curve `centres` (k, 3) with `radii` (k,)."""
    tangents = np.gradient(centres, axis=0)
    tangents /= np.linalg.norm(tangents, axis=1, keepdims=True)
    side = Vector(tangents[0]).orthogonal().normalized()
    rings = []
    for k, t in enumerate(tangents):
        if k:  # carry the frame along the curve without twist
            side = Vector(tangents[k - 1]).rotation_difference(Vector(t)) @ side
        u, v = np.array(side), np.cross(t, side)
        angle = np.linspace(0, 2 * np.pi, segments, endpoint=False)[:, None]
        rings.append(centres[k] + radii[k] * (np.cos(angle) * u + np.sin(angle) * v))
    k, j = np.meshgrid(np.arange(len(centres) - 1), np.arange(segments), indexing="ij")
    corner = [
        k * segments + j,
        k * segments + (j + 1) % segments,
        (k + 1) * segments + (j + 1) % segments,
        (k + 1) * segments + j,
    ]
    faces = np.stack(corner, -1).reshape(-1, 4).tolist()
    last = (len(centres) - 1) * segments
    faces += [list(range(segments))[::-1], [last + i for i in range(segments)]]
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(np.concatenate(rings).tolist(), [], faces)
    tube = bpy.data.objects.new(name, mesh)
    bpy.context.collection.objects.link(tube)
    return tube


def _horn(side: int) -> bpy.types.Object:
    """An ibex's horn: from the crown up, then in a tightening curl back, out and down, with growth rings."""
    t = np.linspace(0, 1, 260)
    angle = np.radians(20 + 235 * t**1.15)
    reach = 0.62 - 0.22 * t
    centres = np.stack(
        [side * (0.30 + 0.12 * t + 0.38 * t**2), 0.62 - reach * np.cos(angle), 0.62 + 1.05 * reach * np.sin(angle)], 1
    )
    rings = 1 + 0.11 * np.abs(np.sin(17 * np.pi * t**0.85)) * (1 - t)
    return _tube("Horn", centres, 0.185 * (1 - t) ** 0.6 * rings + 0.012, 48)


def _bust() -> bpy.types.Object:
    """Neck and shoulders on a round foot, turned like a chess piece and flattened from front to back."""
    profile = np.array(
        [
            [-0.20, 0.02],
            [-0.21, 0.44],
            [-0.70, 0.43],
            [-1.05, 0.44],
            [-1.22, 0.55],
            [-1.36, 0.82],
            [-1.50, 0.98],
            [-1.66, 0.98],
            [-1.80, 0.82],
            [-1.92, 0.48],
            [-1.99, 0.30],
            [-2.06, 0.30],
            [-2.13, 0.50],
            [-2.18, 0.60],
            [-2.28, 0.60],
            [-2.29, 0.02],
        ]
    )
    steps = np.linspace(0, len(profile) - 1, 200)
    z, radius = (np.interp(steps, np.arange(len(profile)), column) for column in profile.T)
    soft = np.convolve(np.pad(radius, 5, mode="edge"), np.ones(11) / 11, "valid")
    bust = _tube("Bust", np.stack([0 * z, 0.10 * np.maximum(z + 1.2, 0) ** 1.5, z], 1), soft, 96)
    bust.matrix_world = Matrix.Translation((0, 0.20, 0)) @ Matrix.Diagonal((1.0, 0.72, 1.0, 1.0))
    return bust


def _joined(parts: list[bpy.types.Object]) -> bpy.types.Object:
    """One closed surface round all parts: joined, voxel remeshed, its stair-steps smoothed."""
    bpy.context.view_layer.update()
    bpy.ops.object.select_all(action="DESELECT")
    for part in parts:
        part.select_set(True)
    bpy.context.view_layer.objects.active = parts[0]
    bpy.ops.object.convert(target="MESH")
    bpy.ops.object.join()
    body = bpy.context.object
    remesh = body.modifiers.new("Remesh", "REMESH")
    remesh.mode, remesh.voxel_size, remesh.adaptivity = "VOXEL", VOXEL, 0.0
    smooth = body.modifiers.new("Smooth", "SMOOTH")
    smooth.factor, smooth.iterations = 0.5, 4
    bpy.ops.object.convert(target="MESH")
    return body


def _arrays(body: bpy.types.Object) -> tuple[np.ndarray, np.ndarray]:
    """World positions (n, 3) float64 and quads (m, 4) int32 of an all-quad object."""
    mesh = body.data
    V = np.zeros(3 * len(mesh.vertices))
    mesh.vertices.foreach_get("co", V)
    Q = np.zeros(4 * len(mesh.polygons), np.int32)
    mesh.polygons.foreach_get("vertices", Q)
    world = np.array(body.matrix_world)
    return V.reshape(-1, 3) @ world[:3, :3].T + world[:3, 3], Q.reshape(-1, 4)


def _island_labels(n: int, edges: np.ndarray) -> np.ndarray:
    """Label (n,) of each vertex: the smallest vertex index in its connected part. edges (e, 2)."""
    label = np.arange(n)
    while True:
        new = label.copy()
        np.minimum.at(new, edges[:, 0], label[edges[:, 1]])
        np.minimum.at(new, edges[:, 1], label[edges[:, 0]])
        new = new[new]  # jump: labels are vertices themselves, so this halves the remaining way
        if np.array_equal(new, label):
            return label
        label = new


def _largest_part(V: np.ndarray, Q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The connected part with most vertices; the remesh also leaves bubbles inside."""
    label = _island_labels(len(V), np.concatenate([Q[:, :2], Q[:, 2:], Q[:, 1:3]]))
    keep = label == np.bincount(label).argmax()
    index = np.cumsum(keep) - 1
    return V[keep], index[Q[keep[Q[:, 0]]]].astype(np.int32)


def _vertex_normals(V: np.ndarray, Q: np.ndarray) -> np.ndarray:
    """Unit vertex normals (n, 3), area-weighted."""
    a, b, c, d = V[Q].swapaxes(0, 1)
    face = np.cross(c - a, d - b)
    N = np.stack([np.bincount(Q.reshape(-1), np.repeat(face[:, k], 4), len(V)) for k in range(3)], 1)
    return N / np.maximum(np.linalg.norm(N, axis=1, keepdims=True), 1e-30)


def _sampled(function: Callable[[Vector], float], P: np.ndarray) -> np.ndarray:
    return np.fromiter((function(p) for p in map(Vector, P)), float, len(P))


def _step(x: np.ndarray, low: float, high: float) -> np.ndarray:
    """Smooth step from 0 at `low` to 1 at `high` (either may be the larger)."""
    t = np.clip((x - low) / (high - low), 0, 1)
    return t * t * (3 - 2 * t)


def displacement(V: np.ndarray, N: np.ndarray) -> np.ndarray:
    """Displacement along the normals (n,), Blender units, for points V (n, 3) with normals N (n, 3)."""
    x, y, z = V.T
    side = np.abs(x)
    mirrored = np.stack([side, y, z], 1)
    to_eye = mirrored - EYE
    eye = np.linalg.norm(to_eye, axis=1)
    skin = _step(eye, EYE_RADIUS * 1.03, EYE_RADIUS * 1.35)
    iris = np.degrees(np.arccos(np.clip(-to_eye[:, 1] / np.maximum(eye, 1e-9), -1, 1)))
    foot = _step(z, -1.86, -1.94)
    horn = _step(z, 0.93, 1.0) + _step(y, 0.80, 0.86) * _step(z, 0.1, 0.2)
    head = _step(z, -1.05, -0.8) * (1 - np.minimum(horn, 1))
    warp = _sampled(lambda p: noise.fractal(p * 1.3, 1.0, 2.0, 3), mirrored)
    forms = _sampled(lambda p: noise.fractal(p * 2.4 + Vector((7, 3, 1)), 1.0, 2.0, 3), V)
    cells = _sampled(lambda p: np.subtract(*noise.voronoi(p * 5.0)[0][1::-1]), mirrored + 0.02 * warp[:, None])
    pores = _sampled(lambda p: noise.fractal(p * 13.0, 1.0, 2.0, 2), V)
    cloth = _step(z, -1.02, -1.18) * (1 - foot)
    skull = head * _step(y, -0.35, 0.05) * _step(side, 0.80, 0.65)
    brow = head * _step(z, 0.40, 0.50) * _step(y, -0.15, -0.4) * _step(z, 0.86, 0.70)
    muzzle = head * _step(y, -0.5, -0.7) * _step(z, 0.05, -0.08) * _step(side, 0.50, 0.40)
    folds = 0.016 * brow * np.sin(30 * z + 8 * warp + 5 * side) + 0.009 * muzzle * np.sin(
        44 * (z + 0.5 * side) + 6 * warp
    )
    scales = _step(cells, -0.05, 0.42) * (0.034 * skull + 0.050 * cloth)
    grain = 0.030 * forms * (1 - foot) * (1 - 0.7 * muzzle) + 0.006 * pores * (1 - foot) * (1 + np.minimum(horn, 1))
    pupil = -0.026 * _step(iris, 22, 12) + 0.012 * _step(iris, 40, 30) * _step(iris, 20, 28)
    return skin * (folds + scales + grain) + (1 - skin) * pupil
