"""Mapping of a game pad's axes: functions, calibration and shaping; no SDL."""

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace

from PyQt6.QtCore import QSettings

from workbench.gui.joystick.piloting import (
    StickPosition,
    Sticks,
    shaped_deflection,
    within_circle,
)

PAD_AXIS_NAMES = (
    "left stick, x",
    "left stick, y",
    "right stick, x",
    "right stick, y",
    "left trigger",
    "right trigger",
)
"""Axes of a game pad, in SDL's order; y is positive towards the pilot, triggers go from 0 to 1."""
PAD_FUNCTIONS = ("Turn right", "Climb", "Right", "Forward")
"""Functions of axes, positive in the named direction; in the order of `PadMapping`."""
PAD_CENTRE_TOLERANCE = 0.08
"""Offset up to which a resting stick counts as centred."""
MIN_PAD_AXIS_TRAVEL = 0.3
"""Least travel from the centre to a stop; an axis that moved less was not calibrated."""
PADS_SETTINGS_GROUP = "pads"
RawPadAxes = tuple[float, ...]


@dataclass(frozen=True)
class PadAxis:
    """One axis: from the pad's value to the command.

    Attributes:
        axis: index in `PAD_AXIS_NAMES`.
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

    def shaped(self, raw: RawPadAxes) -> float:
        """Return the command, -1 .. 1, for the pad's axes at `raw`."""
        off = raw[self.axis] - self.middle
        way = off / ((self.high - self.middle) if off > 0.0 else (self.middle - self.low))
        asked = shaped_deflection(way, self.expo, self.dead_band)
        return -asked if self.inverted else asked

    @property
    def is_sound(self) -> bool:
        """Whether its values are plausible; a settings file may be edited."""
        return (
            self.axis in range(len(PAD_AXIS_NAMES))
            and self.low < self.middle < self.high
            and 0.0 <= self.dead_band <= 0.5
            and 0.0 <= self.expo <= 1.0
        )


PadMapping = tuple[PadAxis, ...]
"""The axis of each of `PAD_FUNCTIONS`."""
DEFAULT_PAD_MAPPING: PadMapping = (
    PadAxis(0),
    PadAxis(1, inverted=True),
    PadAxis(2),
    PadAxis(3, inverted=True),
)
"""Mode 2, with the ends of all axes at ±1."""


def mapped_sticks(mapping: PadMapping, raw: RawPadAxes) -> Sticks:
    """Return the sticks for the pad's axes at `raw`."""
    turn, climb, right, forward = (axis.shaped(raw) for axis in mapping)
    return Sticks(*_centred(turn, climb), *_centred(right, forward))


def calibrated_mapping(
    mapping: PadMapping, readings: Sequence[RawPadAxes]
) -> tuple[PadMapping, list[str]]:
    """Return a mapping with calibrated axes, and the names of axes that did not reach both stops.

    Args:
        mapping: the mapping until now.
        readings: the pad's axes while the sticks moved to their stops; released in the last one.
    """
    ends = [(min(values), values[-1], max(values)) for values in zip(*readings, strict=True)]
    calibrated, short = [], []
    for axis in mapping:
        low, middle, high = ends[axis.axis]
        calibrated.append(replace(axis, low=low, middle=middle, high=high))
        if min(high - middle, middle - low) < MIN_PAD_AXIS_TRAVEL:
            short.append(PAD_AXIS_NAMES[axis.axis])
    return tuple(calibrated), short


def read_mapping(store: QSettings, guid: str) -> PadMapping:
    """Return the stored mapping of a pad, by SDL's GUID; the default without a valid one."""
    try:
        rows = json.loads(str(store.value(f"{PADS_SETTINGS_GROUP}/{guid}", "")))
        mapping = tuple(PadAxis(**row) for row in rows)
        sound = len(mapping) == len(PAD_FUNCTIONS) and all(axis.is_sound for axis in mapping)
    except (ValueError, TypeError):  # absent, or written by another version or an editor
        return DEFAULT_PAD_MAPPING
    return mapping if sound else DEFAULT_PAD_MAPPING


def save_mapping(store: QSettings, guid: str, mapping: PadMapping) -> None:
    """Store a pad's mapping for later starts."""
    store.setValue(f"{PADS_SETTINGS_GROUP}/{guid}", json.dumps([*map(asdict, mapping)]))


def name_axis(raw: Sequence[float]) -> str:
    """Return the name of the axis that is farthest from zero."""
    axis = max(range(len(raw)), key=lambda each: abs(raw[each]))
    return (
        f"{PAD_AXIS_NAMES[axis]} {raw[axis]:+.2f}"
        if abs(raw[axis]) > MIN_PAD_AXIS_TRAVEL
        else "none"
    )


def _centred(x: float, y: float) -> StickPosition:
    return within_circle(x, y) if max(abs(x), abs(y)) > PAD_CENTRE_TOLERANCE else (0.0, 0.0)
