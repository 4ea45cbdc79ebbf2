"""What a search may change: logarithms of gains, some of them tied together."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from workbench.control.controller import load_controller
from workbench.scenario.parameters import find_parameter

LEAST = 1e-3
"""A gain that may be 0 goes down to this share of its largest value, as 0 has no logarithm."""
DIGITS = 4
"""Of a gain that is found; more would be noise."""
LOOPS_OF_AXIS = {
    "x": ("velocity_x", "pitch"),
    "y": ("velocity_y", "roll"),
    "z": ("velocity_z",),
    "yaw": ("yaw_rate",),
}
"""The loops that an axis answers through."""
GAINS_OF_LOOP = {
    "velocity_x": ("kp_velocity_x", "kd_velocity_x"),
    "velocity_y": ("kp_velocity_y", "kd_velocity_y"),
    "velocity_z": ("kp_velocity_z", "kd_velocity_z"),
    "pitch": ("kp_pitch", "kd_pitch"),
    "roll": ("kp_roll", "kd_roll"),
    "yaw_rate": ("kp_yaw_rate",),
    "position_x": ("kp_position_xy",),
    "position_y": ("kp_position_xy",),
    "position_z": ("kp_position_z",),
}
AROUND = {"position_x": "x", "position_y": "y", "position_z": "z"}
"""A loop that stands around an axis' others."""
_LOOP_OF = {
    point: loop.name
    for loop in load_controller().loops
    for point in (loop.error, loop.actuator)
    if point not in GAINS_OF_LOOP
}
TWINS = {
    "kp_velocity_x": "kp_velocity_y",
    "kd_velocity_x": "kd_velocity_y",
    "kp_pitch": "kp_roll",
    "kd_pitch": "kd_roll",
}
"""Gains that a symmetric vehicle has equal."""


def loop_of(subject: str) -> str:
    """Return the loop that a loop point belongs to; axes and loops as they are."""
    return _LOOP_OF.get(subject, subject)


@dataclass(frozen=True)
class Variables:
    """The coordinates of a search: ln of a gain, or of several that are kept equal.

    Attributes:
        groups: names of the gains of each coordinate.
    """

    groups: tuple[tuple[str, ...], ...]

    @property
    def low(self) -> np.ndarray:
        """Smallest coordinates (n)."""
        rows = [find_parameter(group[0]) for group in self.groups]
        return np.log([max(row.minimum, LEAST * row.maximum) for row in rows])

    @property
    def high(self) -> np.ndarray:
        """Largest coordinates (n)."""
        return np.log([find_parameter(group[0]).maximum for group in self.groups])

    def point(self, gains: Mapping[str, float]) -> np.ndarray:
        """Return the coordinates (n) nearest to gains; tied ones take their mean."""
        tiny = math.exp(-30.0)
        means = [
            np.mean([math.log(max(tiny, gains[name])) for name in group]) for group in self.groups
        ]
        return np.clip(means, self.low, self.high)

    def gains(self, point: np.ndarray) -> dict[str, float]:
        """Return the gains at coordinates (n)."""
        values = np.exp(np.clip(point, self.low, self.high))
        return {
            name: float(value)
            for group, value in zip(self.groups, values, strict=True)
            for name in group
        }

    def rounded(self, point: np.ndarray) -> dict[str, float]:
        """Return the gains at coordinates (n) with few digits."""
        return {
            name: find_parameter(name).check(float(f"{value:.{DIGITS}g}"))
            for name, value in self.gains(point).items()
        }


def variables_for(subjects: Sequence[str], *, tied: bool) -> Variables:
    """Return the gains that matter for axes and loops.

    Args:
        subjects: axes and loops with wishes; "rotors" stands for all axes.
        tied: whether roll and pitch, and x and y, have equal gains.
    """
    loops: list[str] = []
    for subject in map(loop_of, subjects):
        inner = AROUND.get(subject, subject)
        for axis, answering in LOOPS_OF_AXIS.items():
            if inner in (axis, "rotors", *answering):
                loops += answering
        loops += [subject] if subject in AROUND else []
    names = dict.fromkeys(name for loop in loops for name in GAINS_OF_LOOP[loop])
    if not tied:
        return Variables(tuple((name,) for name in names))
    twins = {twin: name for name, twin in TWINS.items()}
    heads = dict.fromkeys(twins.get(name, name) for name in names)
    return Variables(tuple((name, TWINS[name]) if name in TWINS else (name,) for name in heads))
