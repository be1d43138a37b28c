"""Quantization steps of the paper's stream, from what the mesh is off by anyway."""
import numpy as np

BASE_STEP = 1.5  # of the lattice of base positions at most, over the mean error of the mesh without features
LEAST_BITS, MOST_BITS = 9, 14  # of a coordinate of the base
LATENT_STEP = 1.0  # quantization step on the finest trained level
LATENT_ERROR = 8e-4  # a mesh that is off by less without features gets finer steps, down to a tenth


def position_bits_for(error: float) -> int:
    """Bits of a coordinate that resolve what the mesh is off by anyway (mean distance, unit frame)."""
    return int(np.clip(np.ceil(-np.log2(BASE_STEP * error)), LEAST_BITS, MOST_BITS))


def step_scale(error: float) -> float:
    """Scale of the latents' steps, from a mesh's error without features (unit frame): error / LATENT_ERROR, within 0.1 and 1."""
    return float(np.clip(error / LATENT_ERROR, 0.1, 1))


def latent_steps(levels: int, scale: float = 1.0) -> np.ndarray:
    """Quantization step of the latents of each level i, (levels,) float32: finer where a latent moves more surface.

    scale * LATENT_STEP * max(0.5, 0.7^(2 - i)), and scale * LATENT_STEP from level 2 on.
    """
    return np.array([scale * LATENT_STEP * max(0.5, 0.7 ** max(2 - i, 0)) for i in range(levels)], dtype=np.float32)
