"""What the axes of a game pad move: which, how far they go, and how they are felt; no SDL."""

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace

from PyQt6.QtCore import QSettings

from workbench.gui.joystick.piloting import Stick, StickCurve, Sticks, within_circle

AXES = (
    "left stick, x",
    "left stick, y",
    "right stick, x",
    "right stick, y",
    "left trigger",
    "right trigger",
)
"""Of a game pad, in SDL's order; y is positive towards the pilot, triggers from 0 to 1."""
FUNCTIONS = ("Turn right", "Climb", "Right", "Forward")
"""That axes move, positive as they are named; in the order of `PadMapping.axes`."""
CREEP = 0.08
"""A resting stick of a pad is seldom quite in the middle: up to here it is taken as being there."""
LEAST_WAY = 0.3
"""From its middle to a stop; an axis that was moved less was not calibrated."""
GROUP = "pads"
Raw = tuple[float, ...]


@dataclass(frozen=True)
class PadAxis:
    """One axis, from what the pad says to what is asked for.

    Attributes:
        axis: its place in `AXES`.
        inverted: whether what it does is turned round.
        dead_band: share of the way around the middle that asks for nothing.
        expo: share of the cubic part; 0 is a straight line.
        low: what the pad says at one stop.
        middle: what it says when let go.
        high: what it says at the other stop.
    """

    axis: int
    inverted: bool = False
    dead_band: float = 0.0
    expo: float = 0.0
    low: float = -1.0
    middle: float = 0.0
    high: float = 1.0

    def shaped(self, raw: Raw) -> float:
        """Return what is asked for, -1 .. 1, when the pad's axes are at `raw`."""
        off = raw[self.axis] - self.middle
        way = off / ((self.high - self.middle) if off > 0.0 else (self.middle - self.low))
        asked = StickCurve(expo=self.expo, dead_band=self.dead_band).shaped(way)
        return -asked if self.inverted else asked

    @property
    def is_sound(self) -> bool:
        """Whether its values are such as a pad can have; a settings file may be edited."""
        return (
            self.axis in range(len(AXES))
            and self.low < self.middle < self.high
            and 0.0 <= self.dead_band <= 0.5
            and 0.0 <= self.expo <= 1.0
        )


@dataclass(frozen=True)
class PadMapping:
    """What moves each of `FUNCTIONS`; as it stands, a pad is in mode 2 and has its ends at ±1."""

    axes: tuple[PadAxis, ...] = (
        PadAxis(0),
        PadAxis(1, inverted=True),
        PadAxis(2),
        PadAxis(3, inverted=True),
    )

    def sticks(self, raw: Raw) -> Sticks:
        """Return where the sticks are when the pad's axes are at `raw`, each -1 .. 1."""
        turn, climb, right, forward = (each.shaped(raw) for each in self.axes)
        return Sticks(_stick(turn, climb), _stick(right, forward))

    def with_axis(self, function: int, **changes: float) -> "PadMapping":
        """Return it with one function's axis changed."""
        changed = replace(self.axes[function], **changes)  # type: ignore[arg-type]
        return PadMapping((*self.axes[:function], changed, *self.axes[function + 1 :]))


@dataclass(frozen=True)
class Ends:
    """How far each axis of a pad went while its sticks were moved to their stops."""

    low: Raw
    high: Raw

    def after(self, raw: Raw) -> "Ends":
        """Return them once the axes were at `raw`, too."""
        return Ends(tuple(map(min, self.low, raw)), tuple(map(max, self.high, raw)))

    def short(self, mapping: PadMapping, middle: Raw) -> list[str]:
        """Return the names of axes in use that did not go to both stops."""
        return [
            AXES[each.axis]
            for each in mapping.axes
            if self.high[each.axis] - middle[each.axis] < LEAST_WAY
            or middle[each.axis] - self.low[each.axis] < LEAST_WAY
        ]

    def put_into(self, mapping: PadMapping, middle: Raw) -> PadMapping:
        """Return a mapping with these ends, and the middle of sticks that are let go."""
        axes = tuple(
            replace(
                each,
                low=self.low[each.axis],
                middle=middle[each.axis],
                high=self.high[each.axis],
            )
            for each in mapping.axes
        )
        return PadMapping(axes)


def read_mapping(store: QSettings, guid: str) -> PadMapping:
    """Return what is kept for a pad, by SDL's GUID; the default where that is nothing sensible."""
    try:
        axes = tuple(PadAxis(**row) for row in json.loads(str(store.value(f"{GROUP}/{guid}", ""))))
        sound = len(axes) == len(FUNCTIONS) and all(each.is_sound for each in axes)
    except (ValueError, TypeError):  # none is kept, another version wrote it, or an editor
        return PadMapping()
    return PadMapping(axes) if sound else PadMapping()


def keep_mapping(store: QSettings, guid: str, mapping: PadMapping) -> None:
    """Keep a pad's mapping between starts."""
    store.setValue(f"{GROUP}/{guid}", json.dumps([asdict(each) for each in mapping.axes]))


def name_axis(raw: Sequence[float]) -> str:
    """Return which axis is farthest from zero, in words."""
    axis = max(range(len(raw)), key=lambda each: abs(raw[each]))
    return f"{AXES[axis]} {raw[axis]:+.2f}" if abs(raw[axis]) > LEAST_WAY else "none"


def _stick(x: float, y: float) -> Stick:
    return within_circle(x, y) if max(abs(x), abs(y)) > CREEP else Stick()
