"""One live number: what a slider, a `--set NAME=VALUE` and a line of `workbench params` show."""

import math
from dataclasses import dataclass
from numbers import Real

from workbench.common.errors import WorkbenchError


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
        group: heading under which a controller's row is shown.
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


def gain(
    name: str,
    unit: str,
    limits: tuple[float, float],
    default: float,
    help: str,
    group: str = "",
) -> Parameter:
    """Return a row of the parameters that a file of the user's own states.

    Args:
        name: unique among all parameters of a flight.
        unit: SI.
        limits: least and largest value.
        default: where neither rule nor gain file says otherwise.
        help: what it does, for a tool tip.
        group: heading under which it is shown.
    """
    return Parameter(name, "controller", unit, *limits, default, help, group=group)


@dataclass(frozen=True)
class State:
    """A number that is remembered, with its SI unit and its value at the start."""

    name: str
    unit: str
    initial: float = 0.0
