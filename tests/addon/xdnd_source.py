"""Drags files over an X display and drops them, as a file manager does: the source's side of XDND, up to version 5.

    python tests/addon/xdnd_source.py X Y FILE...

Presses the mouse in a small window of its own, moves to (X, Y), which like Blender's windows is counted from the lower left
corner of the screen, and lets go there once the window below has said that it takes the drop. A program of its own:
source and target wait for each other. Exit code 1, and why in one line, if the drop was refused or not answered. Needs
python-xlib and the server's XTEST extension. Source: XDND, freedesktop.org/wiki/Specifications/XDND.
"""
import select
import sys
import time
from pathlib import Path

from Xlib import X, Xatom
from Xlib.display import Display
from Xlib.ext import xtest
from Xlib.protocol import event

VERSION = 5
STEPS = 5  # positions on the way
ANSWER_SECONDS = 20.0
GRIP = 8  # pixels, the side of the window in which the drag begins


class DropError(Exception):
    """The drop did not happen; says why."""


class DragSource:
    """One drag of some files, from the upper left corner of the screen."""

    def __init__(self, display: Display, paths: list[Path]) -> None:
        self._display, self._root = display, display.screen().root
        self._offer = b"".join(path.absolute().as_uri().encode() + b"\r\n" for path in paths)
        self._type = self._atom("text/uri-list")
        self._window = self._root.create_window(0, 0, GRIP, GRIP, 0, X.CopyFromParent, override_redirect=True,
                                                event_mask=X.ButtonPressMask | X.ButtonReleaseMask)
        self._window.map()

    def drop_at(self, x: int, y: int) -> None:
        """Drag to a point of the screen and let go. Raises DropError."""
        self._point(X.MotionNotify, x=GRIP // 2, y=GRIP // 2)
        self._point(X.ButtonPress, detail=1)  # the server now sends the pointer's events here, until it is released
        try:
            now = self._next(X.ButtonPress).time
            selection = self._atom("XdndSelection")
            self._window.set_selection_owner(selection, now)
            if self._display.get_selection_owner(selection) != self._window:
                raise DropError("another program keeps the selection")
            target, version = self._target_at(x, y)
            self._send(target, "XdndEnter", version << 24, self._type)
            for step in range(1, STEPS + 1):
                at_x, at_y = (GRIP + (to - GRIP) * step // STEPS for to in (x, y))
                self._point(X.MotionNotify, x=at_x, y=at_y)
                self._send(target, "XdndPosition", 0, at_x << 16 | at_y, now, self._atom("XdndActionCopy"))
                taken = self._answer("XdndStatus")[1] & 1
        finally:
            self._point(X.ButtonRelease, detail=1)
        now = self._next(X.ButtonRelease).time
        if not taken:
            self._send(target, "XdndLeave")
            raise DropError("the window does not take the drop")
        self._send(target, "XdndDrop", 0, now)
        self._answer("XdndFinished")

    def _atom(self, name: str) -> int:
        return self._display.intern_atom(name)

    def _point(self, kind: int, **what: int) -> None:
        xtest.fake_input(self._display, kind, **what)
        self._display.sync()

    def _target_at(self, x: int, y: int) -> tuple:
        """The outermost window at a point that takes drops, and the version that both speak."""
        window = self._root
        while child := window.translate_coords(self._root, x, y).child:
            window = child
            aware = window.get_full_property(self._atom("XdndAware"), Xatom.ATOM)
            if aware is not None:
                return window, min(VERSION, aware.value[0])
        raise DropError(f"no window at ({x}, {y}) says that it takes drops")

    def _send(self, target, name: str, *values: int) -> None:
        data = [self._window.id, *values, 0, 0, 0, 0][:5]
        target.send_event(event.ClientMessage(window=target, client_type=self._atom(name), data=(32, data)))
        self._display.flush()

    def _answer(self, name: str) -> list[int]:
        """The five numbers of the target's message of this name."""
        return self._next(X.ClientMessage, self._atom(name)).data[1]

    def _next(self, kind: int, name: int | None = None):
        """The next event of a kind; until it comes, the target may ask for the files."""
        deadline = time.monotonic() + ANSWER_SECONDS
        while (left := deadline - time.monotonic()) > 0:
            if not self._display.pending_events():
                select.select([self._display], [], [], left)
                continue
            found = self._display.next_event()
            if found.type == X.SelectionRequest:
                self._hand_over(found)
            elif found.type == kind and name in (None, getattr(found, "client_type", None)):
                return found
        raise DropError(f"no {self._display.get_atom_name(name) if name else 'mouse button'} in {ANSWER_SECONDS:.0f} s")

    def _hand_over(self, request) -> None:
        """Write the list of files where the target wants it."""
        given = request.target == self._type
        if given:
            request.requestor.change_property(request.property, self._type, 8, self._offer)
        request.requestor.send_event(event.SelectionNotify(
            time=request.time, requestor=request.requestor, selection=request.selection, target=request.target,
            property=request.property if given else X.NONE))
        self._display.flush()


def main() -> None:
    """Drop the files that the command line names."""
    x, y, *paths = sys.argv[1:]
    display = Display()
    try:
        source = DragSource(display, [Path(path) for path in paths])
        source.drop_at(int(x), display.screen().height_in_pixels - 1 - int(y))
    except DropError as error:
        sys.exit(f"Expected a drop, found: {error}")


if __name__ == "__main__":
    main()
