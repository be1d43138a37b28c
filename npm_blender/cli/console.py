"""What the verbs print: progress on standard error; tables and JSON on standard output."""

import json
import sys
import time
from collections.abc import Sequence
from types import TracebackType

REDRAW_SECONDS = 0.1  # a terminal shows no more than this usefully, and redrawing costs time


class ProgressLine:
    """A `Progress` for the console: one rewritten line on a terminal, one line per new message elsewhere.

    Use it as a context manager, so that the line is wiped before anything else is printed.
    """

    def __init__(self) -> None:
        self._tty = sys.stderr.isatty()
        self._message = ""
        self._width = 0
        self._drawn = 0.0

    def __call__(self, fraction: float, message: str) -> None:
        """Show `fraction` (0..1) and a short phrase."""
        now = time.monotonic()
        if not self._tty:
            if message != self._message:
                print(f"{message} ...", file=sys.stderr, flush=True)
        elif message != self._message or now - self._drawn >= REDRAW_SECONDS:
            line = f"{100 * min(max(fraction, 0.0), 1.0):3.0f} %  {message}"[:78]
            print(f"\r{line:<{self._width}}", end="", file=sys.stderr, flush=True)
            self._width, self._drawn = len(line), now
        self._message = message

    def note(self, message: str) -> None:
        """A line that stays: something the user should know although the command goes on."""
        self._wipe()
        print(f"note: {message}", file=sys.stderr, flush=True)

    def _wipe(self) -> None:
        if self._width:
            print(f"\r{'':<{self._width}}\r", end="", file=sys.stderr, flush=True)
            self._width = 0

    def __enter__(self) -> "ProgressLine":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._wipe()


def print_json(value: object) -> None:
    """One JSON value on standard output. NaN and infinity are refused: they are not JSON."""
    print(json.dumps(value, allow_nan=False, ensure_ascii=False))


def table(header: Sequence[str], rows: Sequence[Sequence[object]]) -> str:
    """Rows as right-aligned columns: whole numbers with thousands separators, other numbers with two decimals."""

    def cell(value: object) -> str:
        if isinstance(value, int):
            return f"{value:,}"
        return f"{value:,.2f}" if isinstance(value, float) else str(value)

    cells = [list(header), *([cell(v) for v in row] for row in rows)]
    widths = [max(len(row[k]) for row in cells) for k in range(len(header))]
    return "\n".join("  ".join(text.rjust(width) for text, width in zip(row, widths, strict=True)) for row in cells)
