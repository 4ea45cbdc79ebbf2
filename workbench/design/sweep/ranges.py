"""The ranges of a sweep: of a parameter, a variation or the random seed."""

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from workbench.common.errors import WorkbenchError, unknown_name
from workbench.common.parameter import is_servo_parameter
from workbench.control.controller import Controller
from workbench.control.controller_file import controller_or_default
from workbench.parameters.flight_parameters import SIGNAL_PATH
from workbench.plant.servo import SERVO_SYSTEM
from workbench.plant.variation import DELAY_NAMES, Variation

RANGE_POINTS = 9
"""Default number of points of a range."""
MAX_RANGE_POINTS = 10_000
VARIATION_PREFIX = "vary."
"""Prefix of the names of variations; they are of the drone, not of its controller."""
VARIATIONS = tuple(
    f"{VARIATION_PREFIX}{name}" for name in ("mass", "inertia", "rotor_lag", *DELAY_NAMES)
)
SEED_NAME = "seed"
"""The name of the seed of turbulence and of sensors' noise."""
MAX_SWEEP_SEED = 2**31 - 1
_SWEPT_SYSTEMS = ("controller", "air", "payload", "rotors", SERVO_SYSTEM, *SIGNAL_PATH)
"""Systems with parameters that act in a step flight."""


def swept_names(controller: Controller | None = None) -> tuple[str, ...]:
    """Return the names that can be swept with a controller, None for the default one."""
    rows = controller_or_default(controller).table
    return (*(row.name for row in rows if row.system in _SWEPT_SYSTEMS), *VARIATIONS, SEED_NAME)


@dataclass(frozen=True)
class SweepRange:
    """A range of a swept number.

    Attributes:
        name: a live parameter that acts in a step flight, or one of `VARIATIONS`, or seed, which
            has whole values.
        low: smallest value.
        high: largest value.
        points: number of points in a grid, including both ends.
        log: whether points are spaced logarithmically.
        controller: with the parameters; None for the default one.

    Raises:
        WorkbenchError: if the range is invalid.
    """

    name: str
    low: float
    high: float
    points: int = RANGE_POINTS
    log: bool = False
    controller: Controller | None = field(default=None, repr=False)

    def __post_init__(self) -> None:
        names = swept_names(self.controller)
        if self.name not in names:
            try:
                controller_or_default(self.controller).table.find(self.name)
            except WorkbenchError:
                if is_servo_parameter(self.name):
                    raise
                raise unknown_name("parameter", self.name, names) from None
            raise WorkbenchError(
                f"{self.name} is not something that a sweep can vary: gains, limits, filters, "
                "settings of the estimator, air, payload, rotors, servos, and "
                f"{', '.join(VARIATIONS)}"
            )
        for value in (self.low, self.high):
            check_value(self.name, value, self.controller)
        if not self.low < self.high:
            raise WorkbenchError(
                f"{self.name} is swept from {self.low:g} to {self.high:g}: give the smaller first"
            )
        if not 2 <= self.points <= MAX_RANGE_POINTS:
            raise WorkbenchError(
                f"{self.name} has {self.points} points: give 2 .. {MAX_RANGE_POINTS}"
            )
        if self.name == SEED_NAME and self.points > self.high - self.low + 1:
            raise WorkbenchError(
                f"there are {self.high - self.low + 1:g} seeds from {self.low:g} to {self.high:g}, "
                f"and {self.points} are asked for: write {SEED_NAME}={self.low:g}..{self.high:g}:"
                f"{self.high - self.low + 1:g}, or a wider range"
            )
        if self.log and self.low <= 0.0:
            raise WorkbenchError(
                f"{self.name} is swept from {self.low:g} logarithmically: begin above 0"
            )

    @property
    def unit(self) -> str:
        """Unit of the values."""
        if self.name in VARIATIONS:
            return "s" if self.name.removeprefix(VARIATION_PREFIX) in DELAY_NAMES else "1"
        if self.name == SEED_NAME:
            return "1"
        return controller_or_default(self.controller).table.find(self.name).unit

    @property
    def grid(self) -> np.ndarray:
        """The values of a grid, (points)."""
        return self.spread(np.linspace(0.0, 1.0, self.points))

    def spread(self, shares: np.ndarray) -> np.ndarray:
        """Return the values at shares of the range from low to high, 0 .. 1, of any shape."""
        if self.log:
            values = np.exp(math.log(self.low) + shares * math.log(self.high / self.low))
        else:
            values = self.low + shares * (self.high - self.low)
        if self.name == SEED_NAME:
            values = np.round(values)
        return np.clip(values, self.low, self.high)


def parse_range(text: str, controller: Controller | None = None) -> SweepRange:
    """Return the range of a text NAME=LOW..HIGH, NAME=LOW..HIGH:POINTS, with :log for a logarithm.

    Raises:
        WorkbenchError: if it is not of that form, or the range is invalid.
    """
    name, equals, rest = text.partition("=")
    span, *options = rest.split(":")
    low, dots, high = span.partition("..")
    log = bool(options) and options[-1].strip() == "log"
    counts = options[:-1] if log else options
    try:
        if not (equals and dots and len(counts) <= 1):
            raise ValueError
        points = int(counts[0]) if counts else RANGE_POINTS
        ends = float(low), float(high)
    except ValueError:
        raise WorkbenchError(
            f"'{text}' is not a range: write NAME=LOW..HIGH:POINTS, as kp_roll=100..400:9, and "
            ":log behind it for a logarithmic one"
        ) from None
    return SweepRange(name.strip(), *ends, points=points, log=log, controller=controller)


def check_value(name: str, value: float, controller: Controller | None = None) -> None:
    """Check that a value is valid for a swept name.

    Raises:
        WorkbenchError: if it is invalid.
    """
    if name == SEED_NAME:
        if not (0 <= value <= MAX_SWEEP_SEED and float(value).is_integer()):
            raise WorkbenchError(f"a seed is {value:g}: give a whole number 0 .. {MAX_SWEEP_SEED}")
    elif name not in VARIATIONS:
        controller_or_default(controller).table.find(name).check(value)
    else:
        varied: dict[str, Any] = {name.removeprefix(VARIATION_PREFIX): value}
        Variation(**varied).check()
