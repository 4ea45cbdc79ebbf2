"""A live parameter, for a slider, a `--set NAME=VALUE` and a line of `workbench params`."""

import math
from dataclasses import dataclass
from numbers import Real

from workbench.common.errors import WorkbenchError


@dataclass(frozen=True)
class Parameter:
    """One live number.

    Attributes:
        name: unique, as in `--set name=value` and in gain files.
        system: the system of the diagram that has it in its numeric parameter 0, at the index of
            the row among those of that system; "rotors" and "payload" apply to the vehicle and to
            what the law knows of it, see `live_context`.
        unit: SI.
        minimum: smallest value allowed.
        maximum: largest value allowed.
        default: value without a gain file.
        help: its effect, for a tool tip.
        whole: whether only whole numbers are meaningful.
        group: heading for the row of a controller.
    """

    name: str
    system: str
    unit: str
    minimum: float
    maximum: float
    default: float
    help: str
    whole: bool = False
    group: str = ""

    def check(self, value: float, where: str = "") -> float:
        """Return `value` as a float.

        Args:
            value: to be set.
            where: file and line for the message, if any.

        Raises:
            WorkbenchError: if it is not a number, or out of range.
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
    return Parameter(name, "controller", unit, *limits, default, help, group=group)


@dataclass(frozen=True)
class State:
    """A number in the memory of a law, with its SI unit and its initial value."""

    name: str
    unit: str
    initial: float = 0.0
