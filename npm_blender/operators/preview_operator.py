"""What the operators on the active preview share."""
from .target import poll_preview


class PreviewOperator:
    """Mix-in of an operator that needs an active preview in Object Mode, and says so where there is none."""

    @classmethod
    def poll(cls, context):
        return poll_preview(cls, context)
