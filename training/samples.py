"""What a training step needs of one LoD sequence: connectivity, targets and weights, as torch tensors."""

from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
import torch

from npm_blender.core.mesh import TriMesh, hierarchy
from npm_blender.core.network import MeshIndex, details, geometry_features


@dataclass
class Sample:
    """One LoD sequence. V0 (n0, 3) is the base that is transmitted: a latent of the sample, refined while training.

    meshes: MeshIndex of levels 0..L; targets: V^1..V^L; normals (n_L, 3) of the input there; vertex_weights per level:
    share of the area, sums to 1; face_normals, face_weights (m_L,) of M^L; scale: mean normal distance of the
    subdivided QEM base to the targets, unit frame; moments: state of the optimiser of V0.
    """

    name: str
    V0: torch.Tensor
    meshes: list
    targets: list
    normals: torch.Tensor
    vertex_weights: list
    face_normals: torch.Tensor
    face_weights: torch.Tensor
    scale: float
    face_scale: list
    inputs: list = field(default_factory=list)
    moments: list = field(default_factory=list)

    @property
    def levels(self) -> int:
        """L."""
        return len(self.targets)


def load(path: Path, B) -> Sample:
    """The sample of a cached sequence (an .npz of V0, F0, V, N; see `sequences`)."""
    with np.load(path, allow_pickle=False) as z:
        V0, F0, V, N = z["V0"], z["F0"], z["V"].astype(np.float64), z["N"]
        levels = int(z["levels"]) if "levels" in z.files else 3
    lods = hierarchy(F0, len(V0), levels)
    targets, weights, scales = [], [], []
    for level in lods:
        mesh = TriMesh(V[: level.n] if level.n > len(V0) else V0.astype(np.float64), level.F)
        areas = mesh.face_areas()
        w = np.bincount(level.F.reshape(-1), weights=np.repeat(areas, 3), minlength=level.n)
        weights.append(w / max(w.sum(), 1e-12))
        scales.append(np.sqrt(areas) * areas / max(areas.sum(), 1e-12))
        targets.append(mesh.V)
    P = V0.astype(np.float64)
    for level in lods[:-1]:
        P = np.concatenate([P, (P[level.edges[:, 0]] + P[level.edges[:, 1]]) / 2])
    scale = float((np.abs(((P - V) * N).sum(1)) * weights[-1]).sum())
    finest = TriMesh(V, lods[-1].F)
    areas = finest.face_areas()
    return Sample(
        path.stem,
        B.array(V0),
        [MeshIndex.of(B, level) for level in lods],
        [B.array(v) for v in targets[1:]],
        B.array(N),
        [B.array(w) for w in weights[1:]],
        B.array(finest.face_normals()),
        B.array(areas / areas.sum()),
        max(scale, 1e-5),
        [B.array(s) for s in scales[:-1]],
    )


def encoder_inputs(B, sample: Sample):
    """Geometry features and details of levels 1..L and 1..L-1, which do not change while training.

    They are kept in half precision, and what only they needed of the finest level is let go: memory holds all samples.
    """
    if not sample.inputs:
        with torch.no_grad():
            Vs = [sample.V0, *sample.targets]
            geometry = [geometry_features(B, V, mesh) for V, mesh in zip(Vs[1:], sample.meshes[1:], strict=True)]
            detail = [details(B, Vs[i], Vs[i + 1], sample.meshes[i]) for i in range(1, len(Vs) - 1)]
        sample.inputs[:] = [[x.half() for x in geometry], [x.half() for x in detail]]
        gone = dict.fromkeys(("end", "edge_a", "edge_b", "left", "right", "inner", "share", "edge_of", "side"))
        sample.meshes[-1] = replace(sample.meshes[-1], **gone)
    return [[x.float() for x in part] for part in sample.inputs]
