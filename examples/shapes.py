"""The mesh that all examples work on, made in code."""
import numpy as np

from npm_blender.core import TriMesh


def bumpy_torus(around: int = 112, across: int = 44) -> TriMesh:
    """A torus with knobs and a groove that winds round the tube, 2 * around * across faces, in the unit frame.

    That is: centred, longest side of its box 1; all stages but compress work in it.
    Vertex (i, j) is number i * across + j; i runs round the hole, j round the tube.
    """
    u, v = np.meshgrid(np.arange(around) * 2 * np.pi / around, np.arange(across) * 2 * np.pi / across, indexing="ij")
    knobs = 0.07 * np.sin(7 * u) * np.sin(2 * v)
    groove = -0.09 * np.exp(8 * (np.cos(v - 2 * u) - 1))
    radius = 0.42 + knobs + groove
    V = np.stack([(1 + radius * np.cos(v)) * np.cos(u), (1 + radius * np.cos(v)) * np.sin(u), radius * np.sin(v)], 2)
    V = V.reshape(-1, 3) - (V.reshape(-1, 3).max(0) + V.reshape(-1, 3).min(0)) / 2
    number = np.arange(around * across).reshape(around, across)
    a, b = number, np.roll(number, -1, 0)
    d, c = np.roll(a, -1, 1), np.roll(b, -1, 1)
    F = np.concatenate([np.stack([a, b, c], 2).reshape(-1, 3), np.stack([a, c, d], 2).reshape(-1, 3)])
    return TriMesh.from_arrays(V / np.ptp(V, axis=0).max(), F)
