"""Limits of the numbers of a step and of a loop: table, values, and a form."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from PyQt6.QtCore import QObject, QSettings, pyqtSignal
from PyQt6.QtWidgets import QWidget

from workbench.common.errors import WorkbenchError, find_named_row
from workbench.common.quantity import DisplayUnit, Quantity, number_text
from workbench.gui.labels import set_tip
from workbench.gui.layout import NO_MARGINS, buddy, grid, named, tool_button
from workbench.gui.number_field import NumberField
from workbench.gui.units import DEGREES_PER_RADIAN

TUNING_LIMITS_GROUP = "tuning/limits"
ARROWLESS_FIELD_STYLE = (
    "QAbstractSpinBox { padding-right: 5px; } QAbstractSpinBox:focus { padding-right: 4px; }"
)
"""A field without arrows needs no room for them; the arrow keys still work."""
MIN_LIMIT_FIELD_PX = 72
"""Least width of a field [px]."""


@dataclass(frozen=True)
class NumberLimit(Quantity):
    """One number with a limit; its name is as in `StepMetrics` and `JudgedLoop`.

    Unit and limits are as shown; dB and ms are always used as they are.

    Attributes:
        label: name in words.
        default: default, in the shown unit.
        decimals: number of shown decimals.
        factor: factor from the number to the shown value; -1 for decibels counted downwards.
        heading: heading of a column, if different from the label.
        at_least: whether the limit is a lower one, else an upper one.
        number: its name in the results, if different.
    """

    label: str = ""
    default: float = 0.0
    decimals: int = 1
    factor: float = 1.0
    heading: str = ""
    at_least: bool = False
    number: str = ""

    @property
    def title(self) -> str:
        """Name in words."""
        return self.label

    @property
    def short(self) -> str:
        """Heading of a column."""
        return self.heading or self.label

    def of(self, numbers: object) -> float:
        """Return the number from a result, NaN if the result has none."""
        return float(getattr(numbers, self.number or self.name, math.nan))

    def shown(self, value: float) -> float:
        """Return a number in the shown unit."""
        if math.isnan(value):
            return value
        if self.unit == "dB":
            return self.factor * (20.0 * math.log10(value) if value > 0.0 else -math.inf)
        return value * self.factor

    def number_text(self, value: float) -> str:
        """Return a number as text without its unit; a dash if there is none."""
        return self.digits(self.shown(value))

    def text(self, value: float) -> str:
        """Return a number as text with its unit."""
        return f"{self.number_text(value)}{DisplayUnit(self.unit).suffix}"

    def relation(self, limit: float) -> str:
        """Return a limit in the shown unit, with its sign and its unit."""
        return f"{self.sign} {limit:g}{DisplayUnit(self.unit).suffix}"

    def digits(self, shown: float) -> str:
        """Return a shown value as text."""
        if math.isinf(shown):
            return "∞" if shown > 0.0 else "−∞"
        # A large margin needs no decimals, and the column no more width.
        decimals = 0 if abs(shown) >= 99.95 and self.decimals == 1 else self.decimals
        return number_text(shown, decimals)

    def keeps(self, value: float, limit: float) -> bool:
        """Return whether a number meets a limit in the shown unit; NaN does not."""
        shown = self.shown(value)
        return shown >= limit if self.at_least else shown <= limit

    @property
    def sign(self) -> str:
        """Relation sign in front of the limit."""
        return "≥" if self.at_least else "≤"


STEP_LIMITS = (
    NumberLimit("rise_time", "s", "from 10 % to 90 %", 0.01, 60.0, "Rise time", 0.5, 3),
    NumberLimit("overshoot", "%", "above the steady state", 0.0, 1e3, "Overshoot", 10.0, 1),
    NumberLimit("settling_time", "s", "until within 2 %", 0.01, 60.0, "Settling time", 1.5, 3),
    NumberLimit("steady_state_error", "%", "off the command", 0.0, 1e3, "Steady error", 5.0, 1),
    NumberLimit(
        "peak_rotor_use", "%", "of the speed limit", 1.0, 100.0, "Rotor use", 95.0, 1, factor=100.0
    ),
)
PEAK_DEVIATION_HELP = "farthest from where it was"
LOAD_PEAKS = {
    "m": NumberLimit(
        "peak_position", "m", PEAK_DEVIATION_HELP, 0.001, 100.0, "Peak", 0.5, 3, number="peak"
    ),
    "rad": NumberLimit(
        "peak_angle",
        "°",
        PEAK_DEVIATION_HELP,
        0.01,
        180.0,
        "Peak",
        5.0,
        3,
        factor=DEGREES_PER_RADIAN,
        number="peak",
    ),
    "rad/s": NumberLimit(
        "peak_rate",
        "°/s",
        "fastest turn",
        0.01,
        1e3,
        "Peak",
        20.0,
        3,
        factor=DEGREES_PER_RADIAN,
        number="peak",
    ),
}
"""Peaks by the SI unit of the deviating quantity."""
LOAD_LIMITS = (
    NumberLimit(
        "load_settling_time",
        "s",
        "until within 5 % of the peak of its steady state",
        0.01,
        60.0,
        "Settling time",
        4.0,
        3,
        number="settling_time",
    ),
    NumberLimit(
        "load_steady_state_error",
        "%",
        "of the peak, what is left; a law with integral action leaves nothing",
        0.0,
        100.0,
        "Steady error",
        100.0,
        1,
        number="steady_state_error",
    ),
    STEP_LIMITS[-1],
)
MARGIN_LIMITS = (
    NumberLimit(
        *("gain_margin", "dB", "how far the gain may rise", 0.0, 60.0, "Gain margin", 6.0, 1),
        heading="gain\N{NO-BREAK SPACE}+",
        at_least=True,
    ),
    NumberLimit(
        "gain_reduction_margin",
        "dB",
        "how far the gain may fall",
        0.0,
        60.0,
        "Gain reduction margin",
        6.0,
        1,
        factor=-1.0,
        heading="gain\N{NO-BREAK SPACE}−",
        at_least=True,
    ),
    NumberLimit(
        *("phase_margin", "°", "phase to instability", 0.0, 180.0, "Phase margin", 45.0, 1),
        factor=DEGREES_PER_RADIAN,
        heading="phase",
        at_least=True,
    ),
    NumberLimit(
        *("delay_margin", "ms", "delay to instability", 0.0, 1e4, "Delay margin", 10.0, 0),
        factor=1e3,
        heading="delay",
        at_least=True,
    ),
    NumberLimit(
        "disk_margin",
        "",
        "gain and phase together: α, at most 2",
        0.0,
        2.0,
        "Disk margin",
        0.6,
        2,
        heading="disk",
        at_least=True,
    ),
)
NUMBER_LIMITS = (*STEP_LIMITS, *LOAD_PEAKS.values(), *LOAD_LIMITS[:-1], *MARGIN_LIMITS)


def find_limit(name: str) -> NumberLimit:
    """Return the row with a name.

    Raises:
        WorkbenchError: if there is none.
    """
    return find_named_row("limit", name, NUMBER_LIMITS)


class LimitValues(QObject):
    """Values of the limits, in shown units.

    Args:
        store: storage of the values.
        parent: the Qt parent; this object is deleted with it.
    """

    changed = pyqtSignal(str)
    """Name of a limit whose value has changed."""

    def __init__(self, store: QSettings, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._store = store

    def value(self, name: str) -> float:
        """Return a limit in the shown unit; its default without a valid stored value."""
        row = find_limit(name)
        kept = self._store.value(f"{TUNING_LIMITS_GROUP}/{name}", row.default)
        try:
            return row.check(float(str(kept)))
        except (ValueError, WorkbenchError):  # written by another version or an editor
            return row.default

    def set(self, name: str, value: float) -> None:
        """Set a limit, in the shown unit.

        Raises:
            WorkbenchError: if the value is not valid.
        """
        value = find_limit(name).check(value)
        if value != self.value(name):
            self._store.setValue(f"{TUNING_LIMITS_GROUP}/{name}", value)
            self.changed.emit(name)


class LimitsForm(QWidget):
    """A form with a field for each of some limits.

    Args:
        rows: rows of the table of limits.
        limits: values of the limits.
        columns: number of columns of fields.

    Attributes:
        fields: fields by the limit's name.
        button: shows and hides the form.
    """

    def __init__(self, rows: Sequence[NumberLimit], limits: LimitValues, columns: int = 2) -> None:
        super().__init__()
        self.fields: dict[str, NumberField] = {}
        self._limits = limits
        parts: list[QWidget] = []
        for row in rows:
            field = NumberField(f"Limit of {row.label.lower()}", row.decimals, 10.0**-row.decimals)
            field.set_range(DisplayUnit(row.unit), row.minimum, row.maximum)
            field.show_si(limits.value(row.name))
            field.edited.connect(lambda value, name=row.name: limits.set(name, value))
            field.setMinimumWidth(MIN_LIMIT_FIELD_PX)
            field.setButtonSymbols(NumberField.ButtonSymbols.NoButtons)
            field.setProperty("class", "bare")
            field.setStyleSheet(ARROWLESS_FIELD_STYLE)
            label = buddy(f"{row.short.capitalize()} {row.sign}", field)
            set_tip(label, f"{row.label}: {row.help}")
            parts += [label, field]
            self.fields[row.name] = field
        lines = (parts[at : at + 2 * columns] for at in range(0, len(parts), 2 * columns))
        grid(*lines, of=self, margins=NO_MARGINS, stretches=(0, 1) * columns)
        self.setVisible(False)
        self.button = named(
            tool_button("Limits", kind="quiet compact"), "Show the limits, to set others"
        )
        self.button.setCheckable(True)
        self.button.toggled.connect(self.setVisible)
        limits.changed.connect(self._show)

    def _show(self, name: str) -> None:
        if name in self.fields:
            self.fields[name].show_si(self._limits.value(name))
