"""The losses of the paper (section 3.3), split into what can be seen and what cannot.

L_corr, the distance to corresponding points, is dominated by sliding along the surface, which no picture and no
point-to-mesh distance shows; so its normal part and its tangential part have weights of their own (equal weights give
the paper's). L_jacobian is taken on its column along the normal: the turn of the face normals, bounded for slivers.
"""

import torch

from npm_blender.core.network import face_normals

UNIT = 15e-4  # unit cube; distances are divided by it, so that the terms are of order 1


def correspondence(V, target, normal, weight, tangential):
    """L_corr of one level over UNIT: area-weighted mean distance of V (n, 3) to target (n, 3), tangential part scaled."""
    offset = V - target
    along = (offset * normal).sum(1)
    aside = offset - along[:, None] * normal
    distance = torch.sqrt(along * along + 1e-8) + tangential * torch.sqrt((aside * aside).sum(1) + 1e-8)
    return (distance * weight).sum() / UNIT


def normal_jacobian(B, V, mesh, target_normals, weight):
    """Area-weighted mean of |n - n*| over the faces of V (n, 3): the normal column of the Jacobian J - I."""
    n, _ = face_normals(B, V, mesh)
    d = n - target_normals
    return (torch.sqrt((d * d).sum(1) + 1e-6) * weight).sum()


def sparsity(features):
    """L_sparsity: sum over levels of the mean absolute feature."""
    return sum(f.abs().mean() for f in features)
