"""Pictures of meshes without a graphics card: triangles sorted from far to near, each in one shade (painter's algorithm)."""
import sys
from pathlib import Path

import matplotlib
import numpy as np

from npm_blender.core import TriMesh

matplotlib.use("Agg")  # pictures, no window
from matplotlib import pyplot  # noqa: E402
from matplotlib.collections import PolyCollection  # noqa: E402

FRONT, BACK, MARK = (0.66, 0.74, 0.85), (0.80, 0.25, 0.20), (0.08, 0.08, 0.12)
VIEW = np.radians(35), np.radians(48)  # turned about the vertical axis, then seen from above
LIGHT = np.array([-0.45, 0.55, 0.70])
DOT = 0.004  # radius of a marked point, in units of the mesh


def folder() -> Path:
    """Where an example writes to: the folder that is its only argument, or out/examples."""
    out = Path(sys.argv[1] if len(sys.argv) > 1 else "out/examples")
    out.mkdir(parents=True, exist_ok=True)
    return out


def draw(path: Path, panels: dict[str, TriMesh], colours: dict[str, np.ndarray] | None = None,
         points: dict[str, np.ndarray] | None = None, edges: bool = False) -> None:
    """Meshes side by side, each under its title.

    colours: (m, 3) of the faces of a panel, 0..1; points: (k, 3) places to mark on a panel. Faces that are seen from behind are
    red, so a flipped face shows. edges: draw the sides of the triangles.
    """
    figure, axes = pyplot.subplots(1, len(panels), figsize=(3.6 * len(panels), 3.3), squeeze=False)
    for axis, (title, mesh) in zip(axes[0], panels.items()):
        shapes, shades = _seen(mesh, (colours or {}).get(title), (points or {}).get(title))
        lines = {"edgecolors": (0.1, 0.15, 0.25, 0.7), "linewidths": 0.4} if edges else {"edgecolors": "face", "linewidths": 0.3}
        axis.add_collection(PolyCollection(shapes, facecolors=shades, **lines))
        axis.set(xlim=(-0.56, 0.56), ylim=(-0.45, 0.45), aspect="equal")
        axis.set_title(title, fontsize=10)
        axis.axis("off")
    figure.subplots_adjust(left=0, right=1, bottom=0, top=0.9, wspace=0)
    figure.savefig(path, dpi=110)
    pyplot.close(figure)


def _seen(mesh: TriMesh, colour: np.ndarray | None, points: np.ndarray | None) -> tuple[np.ndarray, np.ndarray]:
    """Triangles (k, 3, 2) in the plane of the picture, far ones first, and their colours (k, 3)."""
    V, corners = _turned(mesh.V), mesh.F
    T = V[corners]
    normal = np.cross(T[:, 1] - T[:, 0], T[:, 2] - T[:, 0])
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-12)
    behind = normal[:, 2] < 0
    shade = 0.35 + 0.65 * np.clip(np.where(behind, -1, 1) * (normal @ (LIGHT / np.linalg.norm(LIGHT))), 0, 1)
    base = np.tile(FRONT, (len(T), 1)) if colour is None else colour
    shades = np.where(behind[:, None], BACK, base) * shade[:, None]
    shapes, depth = T[:, :, :2], T[:, :, 2].mean(1)
    depth -= behind * np.ptp(T[:, :, 2], axis=1)  # so that the inside of a coarse mesh does not show through its outside
    if points is not None:  # small triangles, a little nearer than what they lie on
        at = _turned(points)
        shapes = np.concatenate([shapes, at[:, None, :2] + DOT * np.array([[-1, -0.6], [1, -0.6], [0, 1.2]])])
        depth = np.concatenate([depth, at[:, 2] + 0.06])
        shades = np.concatenate([shades, np.tile(MARK, (len(at), 1))])
    order = np.argsort(depth, kind="stable")
    return shapes[order], shades[order]


def _turned(V: np.ndarray) -> np.ndarray:
    """Points as the viewer has them: x to the right, y up, z towards the eye."""
    (c, s), (d, t) = ((np.cos(a), np.sin(a)) for a in VIEW)
    V = np.stack([c * V[:, 0] - s * V[:, 1], s * V[:, 0] + c * V[:, 1], V[:, 2]], 1)
    return np.stack([V[:, 0], t * V[:, 1] + d * V[:, 2], t * V[:, 2] - d * V[:, 1]], 1)


def heat(share: np.ndarray) -> np.ndarray:
    """Colours (m, 3) of numbers 0..1: blue, pale yellow in the middle, red."""
    return pyplot.get_cmap("RdYlBu_r")(share)[:, :3]


def plot(path: Path, across: str, up: str, lines: dict[str, tuple]) -> None:
    """Lines with a legend; lines: name to (x, y)."""
    figure, axis = pyplot.subplots(figsize=(6, 3.6), layout="constrained")
    for name, (x, y) in lines.items():
        axis.plot(x, y, "o-", label=name, markersize=4)
    axis.set(xlabel=across, ylabel=up, xlim=(0, None), ylim=(0, None))
    axis.grid(alpha=0.3)
    axis.legend()
    figure.savefig(path, dpi=110)
    pyplot.close(figure)
