"""What the tests of the page in a browser share."""

import time

LONG = 60_000
"""For what a slow machine takes [ms]."""


def wait(condition, said):
    """Wait until something holds."""
    end = time.monotonic() + LONG / 1000
    while not condition():
        assert time.monotonic() < end, f"never {said}"
        time.sleep(0.02)


def centre(page, pad):
    box = page.locator(f"{pad} .pad").bounding_box()
    return box["x"] + box["width"] / 2, box["y"] + box["height"] / 2


class Fingers:
    """Fingers on the glass, as the browser's own protocol moves them."""

    def __init__(self, page):
        self._session = page.context.new_cdp_session(page)
        self._points = {}

    def put(self, finger, x, y):
        """Bring a finger down, or move it."""
        kind = "touchMove" if finger in self._points else "touchStart"
        self._points[finger] = {"x": x, "y": y, "id": finger}
        self._send(kind, *self._points.values())

    def lift(self, finger):
        """Take a finger away; the others stay."""
        self._send("touchEnd", self._points.pop(finger))

    def cancel(self):
        """Let the system take all touches, as for a notification."""
        self._points.clear()
        self._send("touchCancel")

    def _send(self, kind, *points):
        self._session.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": list(points)})


def take_control(page):
    page.tap("#take")
    page.locator("#control[data-mine=true]").wait_for(timeout=LONG)


def in_the_air(flight):
    flight.mode, flight.place = 3, [0.0, 0.0, 1.5]
