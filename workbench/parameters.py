"""The table of everything that can change while flying.

One row makes a slider, a `--set NAME=VALUE`, a line of `workbench params` and a test. Changing a
parameter never rebuilds the diagram; what would need that stands in the scenario.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from numbers import Real

from workbench.errors import WorkbenchError, unknown_name


@dataclass(frozen=True)
class Parameter:
    """One live number.

    Attributes:
        name: unique, as in `--set name=value` and in gain files.
        system: the diagram's system that has it in its numeric parameter 0, at the place that
            the row has among the rows of that system.
        unit: SI.
        minimum: smallest value allowed.
        maximum: largest value allowed.
        default: where no gain file says otherwise.
        help: what it does, for a tool tip.
    """

    name: str
    system: str
    unit: str
    minimum: float
    maximum: float
    default: float
    help: str

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
            raise WorkbenchError(
                f"{where}{self.name} is {value:g} {self.unit}: keep it within "
                f"{self.minimum:g} .. {self.maximum:g} {self.unit}"
            )
        return float(value)


def _controller(
    name: str, unit: str, limits: tuple[float, float], default: float, help: str
) -> Parameter:
    return Parameter(name, "controller", unit, *limits, default, help)


_RATE = (0.0, 30.0)
_DAMPING = (0.0, 1.0)
_STIFFNESS = (0.0, 2500.0)
_ANGLE_RATE = (0.0, 150.0)

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
    Parameter("take_off_speed", "modes", "m/s", 0.1, 3.0, 1.0, "climb of a take-off"),
    Parameter("landing_speed", "modes", "m/s", 0.1, 0.5, 0.4, "descent of a landing"),
    Parameter("battery_reserve", "modes", "1", 0.0, 0.9, 0.15, "charge at which the drone lands"),
    Parameter(
        "battery_duration", "battery", "s", 1.0, 36000.0, 1200.0, "time a full battery hovers"
    ),
)


def find_parameter(name: str, where: str = "") -> Parameter:
    """Return the row of a name.

    Args:
        name: of the parameter.
        where: file and line for the message, if any.

    Raises:
        WorkbenchError: if there is none.
    """
    for parameter in PARAMETERS:
        if parameter.name == name:
            return parameter
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
