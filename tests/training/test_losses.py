import numpy as np
import pytest
import torch

from npm_blender.core.mesh.subdivision import Level
from npm_blender.core.network.mesh_index import MeshIndex
from npm_blender.core.network.torch_backend import TorchBackend
from tests.meshes.shapes import icosphere
from training import losses

B = TorchBackend()
MESH = icosphere(2)
V, N = B.array(MESH.V), B.array(MESH.V)
W = torch.full((len(V),), 1 / len(V))


def test_sliding_counts_by_its_weight():
    random = torch.from_numpy(np.random.default_rng(0).normal(size=V.shape).astype(np.float32))
    slide = 0.01 * (random - (random * N).sum(1)[:, None] * N)
    free, full = (float(losses.correspondence(V + slide, V, N, W, t)) for t in (0.0, 1.0))
    assert free < 0.1 < full
    assert np.isclose(full - free, float(slide.norm(dim=1).mean()) / losses.UNIT, rtol=0.02)


def test_offset_along_the_normal_counts_in_full():
    assert np.isclose(float(losses.correspondence(V + 0.01 * N, V, N, W, 0.0)), 0.01 / losses.UNIT, rtol=1e-3)


def test_normal_jacobian_sees_bending_but_neither_motion_nor_scale():
    mesh = MeshIndex.of(B, Level.of(MESH.F, len(MESH.V)))
    normals, area = B.array(MESH.face_normals()), B.array(MESH.face_areas() / MESH.face_areas().sum())
    still = float(losses.normal_jacobian(B, 2 * V + 1, mesh, normals, area))
    bent = V * (1 + 0.2 * torch.sin(4 * V[:, :1]))
    assert still < 2e-3 < float(losses.normal_jacobian(B, bent, mesh, normals, area))


@pytest.mark.parametrize("share", [0.0, 0.5, 1.0])
def test_sparsity_is_the_mean_absolute_value_per_level(share):
    f = [torch.full((10, 8), 2 * share), torch.full((40, 8), -share)]
    assert np.isclose(float(losses.sparsity(f)), 3 * share)
