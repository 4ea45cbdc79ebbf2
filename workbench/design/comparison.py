"""The rows of a comparison of controllers, and its results."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

from workbench.common.quantity import Quantity
from workbench.common.series import TimedValues
from workbench.control.controller import Controller
from workbench.design.judge.step_pair import PAPER_STEPS
from workbench.scenario.axes import find_axis


@dataclass(frozen=True)
class ComparisonRow(Quantity):
    """A number used to compare controllers.

    Attributes:
        part: of the comparison that measures it, one of `COMPARISON_PARTS`.
    """

    part: str = ""


COMPARISON_ROWS = (
    *(
        ComparisonRow(
            f"{name}_{axis}",
            unit,
            f"step of {size:g} {find_axis(axis).unit} along {axis}: {what}",
            part="steps",
        )
        for axis, size in PAPER_STEPS
        for name, unit, what in (
            ("rise_time", "s", "10 % to 90 %"),
            ("settling_time", "s", "until it stays within 2 %"),
            ("overshoot", "%", "above the steady state"),
            ("steady_state_error", "%", "of the command"),
        )
    ),
    ComparisonRow(
        "peak_rotor_use", "1", "largest share of a rotor's speed limit in these steps", part="steps"
    ),
    ComparisonRow(
        "path",
        "m",
        "largest distance from the commanded position along the figure of eight",
        part="path",
    ),
    ComparisonRow(
        "path_without", "m", "the same without the path's acceleration fed forward", part="path"
    ),
    ComparisonRow(
        "push_distance",
        "m",
        "largest distance after a push of half the weight for 0.2 s",
        part="push",
    ),
    ComparisonRow("push_recovery", "s", "from its start until it stays within 5 cm", part="push"),
    ComparisonRow(
        "over_recovery", "s", "from upside down until it stays upright", part="upside_down"
    ),
    ComparisonRow("over_height", "m", "height lost by then", part="upside_down"),
    ComparisonRow(
        "wind_error",
        "m",
        "distance from the held position after 30 s of wind of 8 m/s",
        part="wind",
    ),
    ComparisonRow(
        "worst_overshoot", "%", "mass ± 20 %, inertia ± 30 %, rotors 1.5 as slow", part="vehicles"
    ),
    ComparisonRow("lost", "1", "of 8 such vehicles, those that a step loses", part="vehicles"),
    ComparisonRow("own_disk_margin", "1", "least of its own loops, one at a time", part="margins"),
    ComparisonRow("input_disk_margin", "1", "at the plant's input, all at once", part="margins"),
    ComparisonRow(
        "noise_amplification", "N·s/rad", "rms of thrust over noise of body rates", part="margins"
    ),
)
COMPARISON_PARTS = tuple(dict.fromkeys(row.part for row in COMPARISON_ROWS))
UNMET_WISHES_ROW = ComparisonRow(
    "unmet_wishes", "1", "wishes that the gains found for them do not meet", part="tune"
)
COMPARISON_PANELS = ("x", "y", "z", "yaw", "path", "push", "upside_down", "wind")
"""Panels of the picture, each with one curve per controller."""


@dataclass(frozen=True)
class ControllerCandidate:
    """A controller with its gains.

    Attributes:
        name: of its column: that of the controller, or of its gain file.
        reference: of the controller, see `load_controller`.
        law: the controller.
        gains: path of its gain file; "" for those of the vehicle.
    """

    name: str
    reference: str
    law: Controller
    gains: str = ""


@dataclass
class ControllerResult:
    """The results of one controller.

    Attributes:
        name: of its column, see `ControllerCandidate`.
        numbers: by the name of their row; NaN where there is none.
        remarks: by the name of a row: why it has no number, or a comment on the number.
        curves: by panel, see `COMPARISON_PANELS`.
        gains: tuned for the wishes, by name; empty without wishes.
    """

    name: str
    numbers: dict[str, float] = field(default_factory=dict)
    remarks: dict[str, str] = field(default_factory=dict)
    curves: dict[str, TimedValues] = field(default_factory=dict)
    gains: dict[str, float] = field(default_factory=dict)

    def note(self, name: str, value: float, remark: str = "") -> None:
        """Note a number, and a remark where there is one."""
        self.numbers[name] = value
        if remark:
            self.remarks[name] = remark

    def none(self, names: Sequence[str], why: str) -> None:
        """Note why there are no numbers."""
        for name in names:
            self.note(name, math.nan, why)


@dataclass(frozen=True)
class ControllerComparison:
    """Controllers beside each other.

    Attributes:
        vehicle: its name.
        rows: that were measured.
        controllers: a column each.
    """

    vehicle: str
    rows: tuple[ComparisonRow, ...]
    controllers: tuple[ControllerResult, ...]
