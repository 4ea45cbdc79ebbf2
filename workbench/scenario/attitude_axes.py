"""Setpoints of the attitude and rate loops about the body's x and y axes: roll and pitch."""

import math
from dataclasses import dataclass

import numpy as np

from workbench.common.errors import WorkbenchError, find_named_row
from workbench.control.controller import Controller
from workbench.scenario.axes import AXIS_ROWS, CommandAxis
from workbench.scenario.scenario import Action, AttitudeSetpoint

SETPOINT_UNIT_FACTORS = {
    "rad": 1.0,
    "rad/s": 1.0,
    "deg": math.degrees(1.0),
    "deg/s": math.degrees(1.0),
}
"""Units of setpoints at loop points, over rad or rad/s; at a point of unit 1 is a tangent."""


def tilt_angles(q_WB: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return roll and pitch (M, each) [rad] of attitudes (M, 4), as w, x, y, z."""
    w, x, y, z = q_WB.T
    roll: np.ndarray = np.arctan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y))
    return roll, np.arcsin(np.clip(2.0 * (w * y - z * x), -1.0, 1.0))


@dataclass(frozen=True)
class AttitudeAxis:
    """A setpoint of an attitude loop, or of a rate loop, in place of that of the loops outside.

    A control law has it at the loop point `point`, see docs/controllers.md.

    Attributes:
        name: roll, pitch, roll_rate or pitch_rate.
        label: in words.
        unit: SI unit of setpoint and response.
        signals: of the response in the topics: the angle, or the angular velocity in W.
        output: of the response in linear models.
        amplitude: initial amplitude in the app, in `unit`.
        place: 0 for roll, 1 for pitch.
    """

    name: str
    label: str
    unit: str
    signals: tuple[str, ...]
    output: str
    amplitude: float
    place: int

    limit = "max_tilt"
    """Name of the parameter that limits the tilt."""
    turns = False
    """It does not change the heading."""

    @property
    def point(self) -> str:
        """Name of the loop point of its setpoint."""
        return f"{self.name}_setpoint"

    @property
    def is_rate(self) -> bool:
        """Whether it is a setpoint of a rate loop."""
        return self.unit == "rad/s"

    @property
    def signal(self) -> str:
        """The first signal of the response in the topics."""
        return self.signals[0]

    @property
    def response(self) -> str:
        """Name of the response."""
        return self.label

    @property
    def response_unit(self) -> str:
        """SI unit of the response."""
        return self.unit

    def action(self, value: float) -> Action:
        """Return the action that gives a setpoint, in `unit`."""
        return Action(setpoint=AttitudeSetpoint(**{self.name: value}))

    def check(self, law: Controller) -> None:
        """Check that a control law has such a setpoint.

        Raises:
            WorkbenchError: that says which it has.
        """
        if missing := self.missing_from(law):
            raise WorkbenchError(missing)

    def at_point(self, value: float, law: Controller) -> float:
        """Return a setpoint in the unit of its loop point."""
        unit = law.points[self.point]
        if unit == "1":
            return math.tan(value)
        if unit not in SETPOINT_UNIT_FACTORS:
            raise WorkbenchError(
                f"{law.file}: the loop point {self.point} is in {unit!r:.20}: give it one of "
                f"{', '.join(SETPOINT_UNIT_FACTORS)}, or 1 for a tangent"
            )
        return SETPOINT_UNIT_FACTORS[unit] * value

    def from_point(self, value: float, law: Controller) -> float:
        """Return a setpoint in `unit` that is given in the unit of its loop point."""
        unit = law.points[self.point]
        return math.atan(value) if unit == "1" else value / SETPOINT_UNIT_FACTORS.get(unit, 1.0)

    def slope_at_point(self, law: Controller) -> float:
        """Return the derivative of `at_point` at 0."""
        return SETPOINT_UNIT_FACTORS.get(law.points[self.point], 1.0)

    def largest_tilt(self, amplitude: float, duration: float) -> float:
        """Return the tilt after a setpoint for a time [s], of a loop that follows it [rad]."""
        return abs(amplitude) * (duration if self.is_rate else 1.0)

    def check_tilt(
        self, amplitude: float, duration: float, most: float, hover: float = 0.0
    ) -> None:
        """Refuse a step that would tilt the drone further than it may.

        Args:
            amplitude: [rad] or [rad/s].
            duration: of the setpoint [s].
            most: `max_tilt` [rad].
            hover: setpoint of the hover from which an attitude steps [rad].

        Raises:
            WorkbenchError: that says what to give instead.
        """
        tilt = self.largest_tilt(hover + amplitude, duration)
        if tilt > most + 1e-9:
            remedy = "amplitude or a shorter time" if self.is_rate else "amplitude"
            during = f" for {duration:g} s" if self.is_rate else ""
            start = f" from a hover of {hover:.2g} rad" if hover else ""
            raise WorkbenchError(
                f"a {self.label} of {amplitude:g} {self.unit}{during}{start} would tilt the drone "
                f"by {tilt:.2f} rad, and max_tilt is {most:g} rad: give a smaller {remedy}, or "
                "raise max_tilt"
            )

    def missing_from(self, law: Controller) -> str:
        """Return why a control law has no such setpoint, and what to do, as a sentence; or ""."""
        if self.point in law.points:
            return ""
        known = ", ".join(row.name for row in ATTITUDE_ROWS if row.point in law.points)
        has = f"it has setpoints of {known}" if known else "it has no setpoint of attitude or rate"
        return (
            f"{law.name} has no loop that follows a setpoint of {self.label}: {has}; "
            "`workbench controllers` lists other laws, and docs/controllers.md says how a law of "
            "your own gets one"
        )

    def direction(self, yaw: float) -> tuple[float, float, float]:
        """Return the direction in W into which a positive setpoint tilts the thrust."""
        cos, sin = math.cos(yaw), math.sin(yaw)
        return (sin, -cos, 0.0) if self.place == 0 else (cos, sin, 0.0)

    def tilts(self, setpoints: np.ndarray, period: float) -> np.ndarray:
        """Return the tilts (N) [rad] of a drone that follows setpoints (N) at once.

        Args:
            setpoints: in `unit`.
            period: between them [s].
        """
        return np.cumsum(setpoints) * period if self.is_rate else setpoints

    def moved(self, q_WB: np.ndarray, w_WB: np.ndarray) -> np.ndarray:
        """Return the response (M) in a motion: the angle [rad], or the rate in B [rad/s].

        Args:
            q_WB: attitudes (M, 4), as w, x, y, z.
            w_WB: angular velocities in W (M, 3) [rad/s].
        """
        w, x, y, z = q_WB.T
        if not self.is_rate:
            return tilt_angles(q_WB)[self.place]
        if self.place == 0:
            axis = 1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + w * z), 2.0 * (x * z - w * y)
        else:
            axis = 2.0 * (x * y - w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z + w * x)
        return np.sum(np.array(axis) * w_WB.T, axis=0)


_WORLD_RATES = tuple(f"velocity_data.w_{axis}" for axis in "xyz")
ATTITUDE_ROWS = (
    AttitudeAxis("roll", "roll", "rad", ("position_data.roll",), "roll", 0.1, 0),
    AttitudeAxis("pitch", "pitch", "rad", ("position_data.pitch",), "pitch", 0.1, 1),
    AttitudeAxis("roll_rate", "roll rate", "rad/s", _WORLD_RATES, "w_x", 0.3, 0),
    AttitudeAxis("pitch_rate", "pitch rate", "rad/s", _WORLD_RATES, "w_y", 0.3, 1),
)
ATTITUDE_NAMES = tuple(row.name for row in ATTITUDE_ROWS)
STEP_AXIS_ROWS: tuple[CommandAxis | AttitudeAxis, ...] = (*AXIS_ROWS, *ATTITUDE_ROWS)
"""Axes along or about which a step can be flown."""


def attitude_places(law: Controller) -> list[int]:
    """Return the places of the setpoints among the loop points of a law."""
    names = law.point_names
    return [names.index(row.point) for row in ATTITUDE_ROWS if row.point in names]


def point_values(setpoint: AttitudeSetpoint, law: Controller) -> dict[str, float]:
    """Return what setpoints are at the loop points of a law, by point.

    Raises:
        WorkbenchError: if the law has no such setpoint.
    """
    rows = [find_attitude_axis(name) for name in setpoint.given]
    for row in rows:
        row.check(law)
    return {row.point: row.at_point(setpoint.given[row.name], law) for row in rows}


def find_attitude_axis(name: str) -> AttitudeAxis:
    """Return the setpoint of attitude or rate with a name.

    Raises:
        WorkbenchError: if there is none.
    """
    return find_named_row("setpoint", name, ATTITUDE_ROWS)


def find_step_axis(name: str) -> CommandAxis | AttitudeAxis:
    """Return the axis of a step with a name.

    Raises:
        WorkbenchError: if there is none.
    """
    return find_named_row("axis", name, STEP_AXIS_ROWS)
