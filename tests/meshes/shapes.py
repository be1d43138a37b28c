"""Meshes made in code, for tests."""
import numpy as np

from npm_blender.core.mesh.subdivision import hierarchy
from npm_blender.core.mesh.triangle_mesh import TriMesh


def icosphere(levels: int = 2) -> TriMesh:
    """Unit sphere with 20 * 4**levels faces."""
    g = (1 + 5**0.5) / 2
    V = np.array([[-1, g, 0], [1, g, 0], [-1, -g, 0], [1, -g, 0], [0, -1, g], [0, 1, g], [0, -1, -g], [0, 1, -g],
                  [g, 0, -1], [g, 0, 1], [-g, 0, -1], [-g, 0, 1]], float)
    F = np.array([[0, 11, 5], [0, 5, 1], [0, 1, 7], [0, 7, 10], [0, 10, 11], [1, 5, 9], [5, 11, 4], [11, 10, 2],
                  [10, 7, 6], [7, 1, 8], [3, 9, 4], [3, 4, 2], [3, 2, 6], [3, 6, 8], [3, 8, 9], [4, 9, 5], [2, 4, 11],
                  [6, 2, 10], [8, 6, 7], [9, 8, 1]], np.int32)
    for level in hierarchy(F, 12, levels)[:-1]:
        V = np.concatenate([V, (V[level.edges[:, 0]] + V[level.edges[:, 1]]) / 2])
    return TriMesh(V / np.linalg.norm(V, axis=1, keepdims=True), hierarchy(F, 12, levels)[-1].F)


def bumpy(levels: int = 4, height: float = 0.15, seed: int = 0) -> TriMesh:
    """A sphere with smooth random bumps: detail that a 400-face base misses."""
    mesh = icosphere(levels)
    random = np.random.default_rng(seed)
    waves = random.normal(size=(12, 3)) * 4
    radius = 1 + height * np.sin(mesh.V @ waves.T + random.uniform(0, 6, 12)).mean(1)
    return TriMesh(mesh.V * radius[:, None], mesh.F)


def grid(n: int = 24, height: float = 0.1, seed: int = 0) -> TriMesh:
    """An open square sheet of 2 n^2 faces with waves."""
    x, y = np.meshgrid(np.linspace(-1, 1, n + 1), np.linspace(-1, 1, n + 1), indexing="ij")
    phase = np.random.default_rng(seed).uniform(0, 6, 2)
    V = np.stack([x, y, height * np.sin(4 * x + phase[0]) * np.cos(3 * y + phase[1])], 2).reshape(-1, 3)
    i = np.arange((n + 1) * (n + 1)).reshape(n + 1, n + 1)
    a, b, c, d = i[:-1, :-1], i[1:, :-1], i[1:, 1:], i[:-1, 1:]
    F = np.concatenate([np.stack([a, b, c], 2).reshape(-1, 3), np.stack([a, c, d], 2).reshape(-1, 3)])
    return TriMesh(V, F.astype(np.int32))


def torus(n: int = 40, m: int = 20, height: float = 0.05, seed: int = 0) -> TriMesh:
    """A closed surface of genus 1 with 2 n m faces and waves."""
    u, v = np.meshgrid(np.arange(n) * 2 * np.pi / n, np.arange(m) * 2 * np.pi / m, indexing="ij")
    r = 0.4 + height * np.sin(5 * u + 3 * v + seed)
    V = np.stack([(1 + r * np.cos(v)) * np.cos(u), (1 + r * np.cos(v)) * np.sin(u), r * np.sin(v)], 2).reshape(-1, 3)
    i = np.arange(n * m).reshape(n, m)
    a, b = i, np.roll(i, -1, 0)
    c, d = np.roll(b, -1, 1), np.roll(i, -1, 1)
    F = np.concatenate([np.stack([a, b, c], 2).reshape(-1, 3), np.stack([a, c, d], 2).reshape(-1, 3)])
    return TriMesh(V, F.astype(np.int32))
