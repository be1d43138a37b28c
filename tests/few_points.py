"""Streams made in a fraction of the time, for tests of what is done with them: candidates are compared by few points.

Which base and steps a stream has then differs from what a user gets. Tests of how near a stream is do without this.
"""
from npm_blender.core.codec import stages, target

POINTS = 2_000  # each way, where `target.CHECKED` has ten times as many


def compare_by_few_points(patch) -> None:
    """patch: a pytest.MonkeyPatch, or what has its `setattr`."""
    for module in (target, stages):
        patch.setattr(module, "CHECKED", POINTS)
