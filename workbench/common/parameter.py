"""A live parameter, for a slider, a `--set NAME=VALUE` and a line of `workbench params`."""

import re
from collections.abc import Mapping
from dataclasses import dataclass

from workbench.common.errors import WorkbenchError
from workbench.common.quantity import Quantity

HOOKS = "open_hooks"
"""Parameter that opens the hooks of cables, and closes them."""
SERVO_PREFIX = "servo_"
"""First part of the names of the parameters that are setpoints of servos."""
SERVO_UNITS = {
    "position": ("rad", "m"),
    "velocity": ("rad/s", "m/s"),
    "effort": ("N*m", "N"),
}
"""Units of setpoints of turning and of sliding joints, by the kind of servo."""
MAX_SERVO_JOINT_CHARS = 60


@dataclass(frozen=True)
class Parameter(Quantity):
    """One live number; its name is that of `--set name=value` and of gain files, its unit SI.

    Attributes:
        default: value without a gain file.
        system: the system of the diagram that has it in its numeric parameter 0, at the index of
            the row among those of that system; "rotors" and "payload" apply to the vehicle and to
            what the law knows of it, see `live_context`.
        whole: whether only whole numbers are meaningful.
        group: heading for the row of a controller.
    """

    default: float = 0.0
    system: str = "controller"
    whole: bool = False
    group: str = ""

    def check(self, value: float, where: str = "") -> float:
        """Return a value as a float, see `Quantity.check`; refuse a fraction of a whole one."""
        number = super().check(value, where)
        if self.whole and not number.is_integer():
            raise WorkbenchError(f"{where}{self.name} is {value:g}: it is {self.help}")
        return number


def is_servo_parameter(name: str) -> bool:
    """Return whether a parameter is the setpoint of a servo, which only some vehicles have."""
    return name.startswith(SERVO_PREFIX)


def servo_parameter_name(joint: str) -> str:
    """Return the name of the parameter with the setpoint of a joint's servo."""
    plain = re.sub(r"\W+", "_", joint, flags=re.ASCII).strip("_")[:MAX_SERVO_JOINT_CHARS]
    return SERVO_PREFIX + (plain or "joint")


def gain(
    name: str,
    unit: str,
    limits: tuple[float, float],
    default: float,
    help: str,
    group: str = "",
) -> Parameter:
    """Return a row for the parameters in a user's own file.

    Args:
        name: unique among all parameters of a flight.
        unit: SI.
        limits: smallest and largest value.
        default: value without a rule or gain file.
        help: its effect, for a tool tip.
        group: heading for the row.
    """
    return Parameter(name, unit, help, *limits, default=default, group=group)


@dataclass(frozen=True)
class State:
    """A number in the memory of a law, with its SI unit and its initial value."""

    name: str
    unit: str
    initial: float = 0.0


def hooks_are_open(values: Mapping[str, float]) -> bool:
    """Return whether parameter values open the hooks of cables."""
    return values.get(HOOKS, 0.0) > 0.5
