"""The error of a budget that does not pay for a base mesh."""
from ..errors import SettingsError


class BaseTooLarge(SettingsError):
    """The base mesh alone takes more bytes than the budget."""

    def __init__(self, size: int, faces: int, budget: int) -> None:
        super().__init__(
            f"Expected a base mesh of at most {budget:,} bytes, found {size:,} for {faces:,} faces; "
            "allow more bytes, or ask for fewer base faces"
        )
