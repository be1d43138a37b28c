"""Quantization steps: finer for meshes that need little, and where a latent moves more surface."""
import numpy as np

from npm_blender.core.codec.quantization import LATENT_ERROR, LATENT_STEP, latent_steps, step_scale


def test_the_scale_follows_the_error_within_its_bounds():
    scales = [step_scale(share * LATENT_ERROR) for share in (0, 0.05, 0.1, 0.5, 1, 3)]
    assert np.allclose(scales, [0.1, 0.1, 0.1, 0.5, 1, 1])


def test_coarse_levels_have_finer_steps_and_none_is_coarser_than_the_last():
    steps = latent_steps(5)
    assert steps.dtype == np.float32 and steps[-1] == LATENT_STEP and (np.diff(steps) >= 0).all() and steps[0] >= 0.49
    assert np.allclose(latent_steps(5, 0.1), 0.1 * steps)
