"""Keys as sticks: W A S D is the left one, the arrows are the right one."""

from enum import Enum

from workbench.gui.joystick.sticks import MIDDLE, Stick, Sticks, within_circle

RUN_UP = 0.5
"""From the middle to full stick while a key is held [s]."""


class StickKey(Enum):
    """A direction that a key pushes: whether it is the left stick, and to where."""

    CLIMB = (True, 0, 1)
    SINK = (True, 0, -1)
    TURN_LEFT = (True, -1, 0)
    TURN_RIGHT = (True, 1, 0)
    FORWARD = (False, 0, 1)
    BACK = (False, 0, -1)
    LEFT = (False, -1, 0)
    RIGHT = (False, 1, 0)


class KeyboardSticks:
    """Two sticks that run up while keys are held, and spring back as they are let go.

    Attributes:
        sticks: where they are.
    """

    def __init__(self) -> None:
        self.sticks = Sticks()
        self._held: set[StickKey] = set()

    @property
    def is_held(self) -> bool:
        """Whether a key is down."""
        return bool(self._held)

    def press(self, key: StickKey) -> None:
        """Hold a key; the stick begins to move with the next `advance`."""
        self._held.add(key)

    def release(self, key: StickKey) -> None:
        """Let go of a key: its axis is in the middle at once, unless the opposite key is held."""
        self._held.discard(key)
        self.advance(0.0)

    def release_all(self) -> None:
        """Let go of everything."""
        self._held.clear()
        self.sticks = Sticks()

    def advance(self, duration: float) -> Sticks:
        """Move the sticks for a time [s], and return where they are."""
        step = duration / RUN_UP
        self.sticks = Sticks(
            self._moved(self.sticks.left, True, step), self._moved(self.sticks.right, False, step)
        )
        return self.sticks

    def _moved(self, stick: Stick, is_left: bool, step: float) -> Stick:
        keys = [key.value for key in self._held if key.value[0] is is_left]
        if not keys:
            return MIDDLE
        x = _run(stick.x, sum(key[1] for key in keys), step)
        y = _run(stick.y, sum(key[2] for key in keys), step)
        return within_circle(x, y)


def _run(place: float, towards: int, step: float) -> float:
    """Return an axis one step nearer to its end; a turn begins in the middle."""
    if towards == 0:
        return 0.0
    start = max(0.0, towards * place)
    return towards * min(1.0, start + step)
