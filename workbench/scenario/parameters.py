"""The table of everything that can change while flying.

One row makes a slider, a `--set NAME=VALUE`, a line of `workbench params` and a test. Changing a
parameter never rebuilds the diagram; what would need that stands in the scenario.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from numbers import Real

from workbench.common.errors import WorkbenchError, unknown_name


@dataclass(frozen=True)
class Parameter:
    """One live number.

    Attributes:
        name: unique, as in `--set name=value` and in gain files.
        system: the diagram's system that has it in its numeric parameter 0, at the place that
            the row has among the rows of that system; "rotors" and "payload" are what flies and
            what the law knows of it, see `live_context`.
        unit: SI.
        minimum: smallest value allowed.
        maximum: largest value allowed.
        default: where no gain file says otherwise.
        help: what it does, for a tool tip.
        whole: whether only whole numbers mean something.
    """

    name: str
    system: str
    unit: str
    minimum: float
    maximum: float
    default: float
    help: str
    whole: bool = False

    def check(self, value: float, where: str = "") -> float:
        """Return `value` as a float.

        Args:
            value: what is to be set.
            where: file and line for the message, if any.

        Raises:
            WorkbenchError: if it is no number or out of range.
        """
        if isinstance(value, bool) or not isinstance(value, Real) or math.isnan(value):
            raise WorkbenchError(f"{where}{self.name} is '{value}': give it a number")
        if not self.minimum <= value <= self.maximum:
            unit = "" if self.unit == "1" else f" {self.unit}"
            raise WorkbenchError(
                f"{where}{self.name} is {value:g}{unit}: keep it within "
                f"{self.minimum:g} .. {self.maximum:g}{unit}"
            )
        if self.whole and not float(value).is_integer():
            raise WorkbenchError(f"{where}{self.name} is {value:g}: it is {self.help}")
        return float(value)


def _controller(
    name: str, unit: str, limits: tuple[float, float], default: float, help: str
) -> Parameter:
    return Parameter(name, "controller", unit, *limits, default, help)


def _fault(kind: str) -> Parameter:
    """Return the row of a fault to order, in all sensors of a kind."""
    help = f"fault of the {kind.replace('_', ' ')}: 0 none, 1 frozen, 2 noisy, 3 silent"
    return Parameter(f"{kind}_fault", kind, "1", 0.0, 3.0, 0.0, help, whole=True)


def _rotor(number: int) -> Parameter:
    """Return the row of a fault to order, in one rotor."""
    help = f"share of its thrust that rotor {number} gives; 0 stops it"
    return Parameter(f"rotor_{number}", "rotors", "1", 0.0, 1.0, 1.0, help)


def _air(name: str, unit: str, limits: tuple[float, float], default: float, help: str) -> Parameter:
    return Parameter(name, "air", unit, *limits, default, help)


def _payload(name: str, unit: str, limits: tuple[float, float], help: str) -> Parameter:
    return Parameter(name, "payload", unit, *limits, 0.0, help)


_SPEED_OF_AIR = (-50.0, 50.0)
_FORCE = (-1000.0, 1000.0)
_PLACE = (-10.0, 10.0)
_LOAD = (0.0, 100.0)
_SIZE = (0.0, 10.0)
_TIME = (0.0, 1e6)
_DURATION = (0.001, 3600.0)
_RATE = (0.0, 30.0)
_DAMPING = (0.0, 1.0)
_STIFFNESS = (0.0, 2500.0)
_ANGLE_RATE = (0.0, 150.0)

MOST_ROTORS = 12
"""So many can be weakened; a vehicle may have fewer, or more."""
SENSOR_KINDS = ("imu", "gps", "lidar", "range_finder", "barometer", "depth_camera")
"""Rows of these systems act on every sensor of the kind; a flight may have none."""

PARAMETERS: tuple[Parameter, ...] = (
    _controller(
        "kp_position_xy", "1/s", (0.0, 5.0), 1.0, "pull to a held place or way-point, level"
    ),
    _controller(
        "kp_position_z", "1/s", (0.0, 5.0), 1.5, "pull to a held place or way-point, height"
    ),
    _controller("kp_velocity_x", "1/s", _RATE, 3.0, "acceleration per velocity error along x"),
    _controller("kp_velocity_y", "1/s", _RATE, 3.0, "acceleration per velocity error along y"),
    _controller(
        "kp_velocity_z", "1/s", (0.5, 30.0), 4.0, "acceleration per velocity error along z"
    ),
    _controller("kd_velocity_x", "1", _DAMPING, 0.1, "share of acceleration along x taken back"),
    _controller("kd_velocity_y", "1", _DAMPING, 0.1, "share of acceleration along y taken back"),
    _controller("kd_velocity_z", "1", _DAMPING, 0.1, "share of acceleration along z taken back"),
    _controller("kp_roll", "1/s^2", _STIFFNESS, 150.0, "angular acceleration per roll error"),
    _controller("kp_pitch", "1/s^2", _STIFFNESS, 150.0, "angular acceleration per pitch error"),
    _controller("kd_roll", "1/s", _ANGLE_RATE, 20.0, "angular acceleration per roll rate"),
    _controller("kd_pitch", "1/s", _ANGLE_RATE, 20.0, "angular acceleration per pitch rate"),
    _controller("kp_yaw_rate", "1/s", _RATE, 4.0, "angular acceleration per yaw-rate error"),
    _controller("max_speed", "m/s", (0.1, 20.0), 8.0, "largest level speed"),
    _controller("max_climb_rate", "m/s", (0.1, 10.0), 8.0, "largest speed up or down"),
    _controller("max_height", "m", (0.5, 500.0), 120.0, "no climb above this height"),
    _controller("max_tilt", "rad", (0.05, 1.2), 0.7, "largest tilt that is asked for"),
    _controller("max_yaw_rate", "rad/s", (0.05, 6.0), 0.4, "largest yaw rate"),
    _controller(
        "spin_up_feedforward",
        "1",
        (0.0, 1.0),
        0.0,
        "share of the rotors' spin-up torque that the law reckons with in yaw",
    ),
    Parameter("take_off_speed", "modes", "m/s", 0.1, 3.0, 1.0, "climb of a take-off"),
    Parameter("landing_speed", "modes", "m/s", 0.1, 0.5, 0.4, "descent of a landing"),
    Parameter("battery_reserve", "modes", "1", 0.0, 0.9, 0.15, "charge at which the drone lands"),
    Parameter(
        "obstacle_brake",
        "modes",
        "1/s",
        0.0,
        1.5,
        0.0,
        "largest speed towards an obstacle per way left; 0 sets no limit",
    ),
    Parameter(
        "stop_distance", "modes", "m", 0.0, 20.0, 0.5, "clearance at which a braked drone stops"
    ),
    Parameter(
        "battery_duration", "battery", "s", 1.0, 36000.0, 1200.0, "time a full battery hovers"
    ),
    Parameter(
        "warning_distance",
        "obstacles",
        "m",
        0.1,
        20.0,
        1.0,
        "clearance below which there is a warning",
    ),
    _air("wind_x", "m/s", _SPEED_OF_AIR, 0.0, "velocity of the mean wind to the east"),
    _air("wind_y", "m/s", _SPEED_OF_AIR, 0.0, "velocity of the mean wind to the north"),
    _air("wind_z", "m/s", _SPEED_OF_AIR, 0.0, "velocity of the mean wind upwards"),
    _air(
        "turbulence",
        "m/s",
        (0.0, 50.0),
        0.0,
        "wind speed at 20 ft that makes it: light 7.7, moderate 15.4, severe 23.2",
    ),
    _air("gust_x", "m/s", _SPEED_OF_AIR, 0.0, "peak of the gust to the east"),
    _air("gust_y", "m/s", _SPEED_OF_AIR, 0.0, "peak of the gust to the north"),
    _air("gust_z", "m/s", _SPEED_OF_AIR, 0.0, "peak of the gust upwards"),
    _air("gust_start", "s", _TIME, 0.0, "when the gust begins"),
    _air("gust_duration", "s", _DURATION, 1.0, "how long the gust rises and falls"),
    _air("push_x", "N", _FORCE, 0.0, "force of the push to the east"),
    _air("push_y", "N", _FORCE, 0.0, "force of the push to the north"),
    _air("push_z", "N", _FORCE, 0.0, "force of the push upwards"),
    _air("push_at_x", "m", _PLACE, 0.0, "where the push acts, ahead of the base link's origin"),
    _air("push_at_y", "m", _PLACE, 0.0, "where the push acts, left of the base link's origin"),
    _air("push_at_z", "m", _PLACE, 0.0, "where the push acts, above the base link's origin"),
    _air("push_start", "s", _TIME, 0.0, "when the push begins"),
    _air("push_duration", "s", _DURATION, 0.1, "how long the push lasts"),
    _air("drag_area", "m^2", (0.0, 10.0), 0.015, "drag coefficient times area of the body"),
    _air("air_density", "kg/m^3", (0.0, 2.0), 1.225, "density of the air, for the body's drag"),
    _payload("payload_mass", "kg", _LOAD, "mass of the payload; 0 drops it"),
    _payload("payload_x", "m", _PLACE, "the payload's centre, ahead of the base link's origin"),
    _payload("payload_y", "m", _PLACE, "the payload's centre, left of the base link's origin"),
    _payload("payload_z", "m", _PLACE, "the payload's centre, above the base link's origin"),
    _payload("payload_size_x", "m", _SIZE, "length of the payload, a box of even density"),
    _payload("payload_size_y", "m", _SIZE, "width of the payload"),
    _payload("payload_size_z", "m", _SIZE, "height of the payload"),
    _payload("known_payload_mass", "kg", _LOAD, "mass that the law takes the payload to have"),
    *map(_fault, SENSOR_KINDS),
    *map(_rotor, range(1, MOST_ROTORS + 1)),
)

_BY_NAME = {parameter.name: parameter for parameter in PARAMETERS}


def find_parameter(name: str, where: str = "") -> Parameter:
    """Return the row of a name.

    Args:
        name: of the parameter.
        where: file and line for the message, if any.

    Raises:
        WorkbenchError: if there is none.
    """
    if name in _BY_NAME:
        return _BY_NAME[name]
    error = unknown_name("parameter", name, [parameter.name for parameter in PARAMETERS])
    raise WorkbenchError(f"{where}{error}")


def defaults() -> dict[str, float]:
    """Return every parameter's default by name."""
    return {parameter.name: parameter.default for parameter in PARAMETERS}


def checked(values: Mapping[str, float], where: str = "") -> dict[str, float]:
    """Return `values` if every name is in the table and every value within its limits.

    Raises:
        WorkbenchError: for the first that is not, prefixed with `where`.
    """
    return {name: find_parameter(name, where).check(value, where) for name, value in values.items()}


def parameters_of(system: str) -> tuple[Parameter, ...]:
    """Return the rows of one system, in the order of its numeric parameter."""
    return tuple(parameter for parameter in PARAMETERS if parameter.system == system)


def parse_setting(text: str) -> tuple[str, float]:
    """Return name and value of a `NAME=VALUE` text.

    Raises:
        WorkbenchError: if it is not of that form, unknown or out of range.
    """
    name, equals, value = text.partition("=")
    if not equals:
        raise WorkbenchError(f"'{text}' is no setting: write NAME=VALUE, as kp_velocity_x=5")
    parameter = find_parameter(name.strip())
    try:
        number = float(value)
    except ValueError:
        raise WorkbenchError(f"{parameter.name} is '{value}': give it a number") from None
    return parameter.name, parameter.check(number)
