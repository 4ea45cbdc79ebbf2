"""Mapping of a game pad's axes: functions, calibration and shaping; no SDL."""

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

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
"""Axes of a game pad, in SDL's order; y is positive towards the pilot, triggers go from 0 to 1."""
FUNCTIONS = ("Turn right", "Climb", "Right", "Forward")
"""Functions of axes, positive in the named direction; in the order of `PadMapping.axes`."""
CREEP = 0.08
"""Offset up to which a resting stick counts as centred."""
LEAST_WAY = 0.3
"""Least travel from the centre to a stop; an axis that moved less was not calibrated."""
GROUP = "pads"
Raw = tuple[float, ...]


@dataclass(frozen=True)
class PadAxis:
    """One axis: from the pad's value to the command.

    Attributes:
        axis: index in `AXES`.
        inverted: whether its direction is reversed.
        dead_band: share of the travel around the centre without effect.
        expo: share of the cubic part; 0 is a straight line.
        low: the pad's value at one stop.
        middle: the pad's value when released.
        high: the pad's value at the other stop.
    """

    axis: int
    inverted: bool = False
    dead_band: float = 0.0
    expo: float = 0.0
    low: float = -1.0
    middle: float = 0.0
    high: float = 1.0

    def shaped(self, raw: Raw) -> float:
        """Return the command, -1 .. 1, for the pad's axes at `raw`."""
        off = raw[self.axis] - self.middle
        way = off / ((self.high - self.middle) if off > 0.0 else (self.middle - self.low))
        asked = StickCurve(expo=self.expo, dead_band=self.dead_band).shaped(way)
        return -asked if self.inverted else asked

    @property
    def is_sound(self) -> bool:
        """Whether its values are plausible; a settings file may be edited."""
        return (
            self.axis in range(len(AXES))
            and self.low < self.middle < self.high
            and 0.0 <= self.dead_band <= 0.5
            and 0.0 <= self.expo <= 1.0
        )


@dataclass(frozen=True)
class PadMapping:
    """Axes of all `FUNCTIONS`; by default a pad is in mode 2 and has its ends at ±1."""

    axes: tuple[PadAxis, ...] = (
        PadAxis(0),
        PadAxis(1, inverted=True),
        PadAxis(2),
        PadAxis(3, inverted=True),
    )

    def sticks(self, raw: Raw) -> Sticks:
        """Return the sticks, each -1 .. 1, for the pad's axes at `raw`."""
        turn, climb, right, forward = (each.shaped(raw) for each in self.axes)
        return Sticks(_stick(turn, climb), _stick(right, forward))

    def with_axis(self, function: int, **changes: Any) -> "PadMapping":
        """Return it with a different axis for one function."""
        changed = replace(self.axes[function], **changes)
        return PadMapping((*self.axes[:function], changed, *self.axes[function + 1 :]))


@dataclass(frozen=True)
class Ends:
    """Extremes of each axis while the sticks were moved to their stops."""

    low: Raw
    high: Raw

    def after(self, raw: Raw) -> "Ends":
        """Return the extremes after the axes were also at `raw`."""
        return Ends(tuple(map(min, self.low, raw)), tuple(map(max, self.high, raw)))

    def short(self, mapping: PadMapping, middle: Raw) -> list[str]:
        """Return the names of used axes that did not reach both stops."""
        return [
            AXES[each.axis]
            for each in mapping.axes
            if self.high[each.axis] - middle[each.axis] < LEAST_WAY
            or middle[each.axis] - self.low[each.axis] < LEAST_WAY
        ]

    def put_into(self, mapping: PadMapping, middle: Raw) -> PadMapping:
        """Return a mapping with these ends, and the centres of released sticks."""
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
    """Return the stored mapping of a pad, by SDL's GUID; the default without a valid one."""
    try:
        axes = tuple(PadAxis(**row) for row in json.loads(str(store.value(f"{GROUP}/{guid}", ""))))
        sound = len(axes) == len(FUNCTIONS) and all(each.is_sound for each in axes)
    except (ValueError, TypeError):  # absent, or written by another version or an editor
        return PadMapping()
    return PadMapping(axes) if sound else PadMapping()


def keep_mapping(store: QSettings, guid: str, mapping: PadMapping) -> None:
    """Store a pad's mapping for later starts."""
    store.setValue(f"{GROUP}/{guid}", json.dumps([asdict(each) for each in mapping.axes]))


def name_axis(raw: Sequence[float]) -> str:
    """Return the name of the axis that is farthest from zero."""
    axis = max(range(len(raw)), key=lambda each: abs(raw[each]))
    return f"{AXES[axis]} {raw[axis]:+.2f}" if abs(raw[axis]) > LEAST_WAY else "none"


def _stick(x: float, y: float) -> Stick:
    return within_circle(x, y) if max(abs(x), abs(y)) > CREEP else Stick()
