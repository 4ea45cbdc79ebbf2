"""Limits of the numbers of a step and of a loop: table, values, and a form."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from PyQt6.QtCore import QObject, QSettings, pyqtSignal
from PyQt6.QtWidgets import QWidget

from workbench.common.errors import WorkbenchError, find_row
from workbench.gui.charts.ticks import number_text
from workbench.gui.labels import set_tip
from workbench.gui.layout import NO_MARGINS, buddy, grid, named, tool_button
from workbench.gui.number_field import NumberField
from workbench.gui.units import Unit

GROUP = "tuning/limits"
BARE = "QAbstractSpinBox { padding-right: 5px; } QAbstractSpinBox:focus { padding-right: 4px; }"
"""A field without arrows needs no room for them; the arrow keys still work."""
NARROWEST = 72
"""Least width of a field [px]."""


@dataclass(frozen=True)
class Limit:
    """One number with a limit.

    Attributes:
        name: name of the number, as in `StepNumbers` and `JudgedLoop`.
        label: name in words.
        unit: shown unit; dB and ms are always used as they are.
        factor: factor from the number to the shown value; -1 for decibels counted downwards.
        default: default, in the shown unit.
        minimum: minimum, in the shown unit.
        maximum: maximum, in the shown unit.
        decimals: number of shown decimals.
        help: description of the number.
        heading: heading of a column, if different from the label.
        at_least: whether the limit is a lower one, else an upper one.
        number: its name in the results, if different.
    """

    name: str
    label: str
    unit: str
    factor: float
    default: float
    minimum: float
    maximum: float
    decimals: int
    help: str
    heading: str = ""
    at_least: bool = False
    number: str = ""

    @property
    def short(self) -> str:
        """Heading of a column."""
        return self.heading or self.label

    def of(self, numbers: object) -> float:
        """Return the number from a result."""
        return float(getattr(numbers, self.number or self.name))

    def shown(self, value: float) -> float:
        """Return a number in the shown unit."""
        if math.isnan(value):
            return value
        if self.unit == "dB":
            return self.factor * (20.0 * math.log10(value) if value > 0.0 else -math.inf)
        return value * self.factor

    def text(self, value: float) -> str:
        """Return a number as text without its unit; a dash if there is none."""
        return self.digits(self.shown(value))

    def digits(self, shown: float) -> str:
        """Return a shown value as text."""
        if math.isnan(shown):
            return "–"
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


DEGREES = 180.0 / math.pi
STEP_LIMITS = (
    Limit("rise_time", "Rise time", "s", 1.0, 0.5, 0.01, 60.0, 3, "from 10 % to 90 %"),
    Limit("overshoot", "Overshoot", "%", 1.0, 10.0, 0.0, 1e3, 1, "above the steady state"),
    Limit("settling_time", "Settling time", "s", 1.0, 1.5, 0.01, 60.0, 3, "until within 2 %"),
    Limit("steady_state_error", "Steady error", "%", 1.0, 5.0, 0.0, 1e3, 1, "off the command"),
    Limit("peak_rotor_use", "Rotor use", "%", 100.0, 95.0, 1.0, 100.0, 1, "of the speed limit"),
)
FARTHEST = "farthest from where it was"
LOAD_PEAKS = {
    "m": Limit("peak_position", "Peak", "m", 1.0, 0.5, 0.001, 100.0, 3, FARTHEST, number="peak"),
    "rad": Limit("peak_angle", "Peak", "°", DEGREES, 5.0, 0.01, 180.0, 3, FARTHEST, number="peak"),
    "rad/s": Limit(
        "peak_rate", "Peak", "°/s", DEGREES, 20.0, 0.01, 1e3, 3, "fastest turn", number="peak"
    ),
}
"""Peaks by the SI unit of the deviating quantity."""
LOAD_LIMITS = (
    Limit(
        "load_settling_time",
        *("Settling time", "s", 1.0, 4.0, 0.01, 60.0, 3),
        "until within 5 % of the peak of its steady state",
        number="settling_time",
    ),
    Limit(
        "load_steady_state_error",
        *("Steady error", "%", 1.0, 100.0, 0.0, 100.0, 1),
        "of the peak, what is left; a law with integral action leaves nothing",
        number="steady_state_error",
    ),
    STEP_LIMITS[-1],
)
MARGIN_LIMITS = (
    Limit(
        *("gain_margin", "Gain margin", "dB", 1.0, 6.0, 0.0, 60.0, 1),
        *("how far the gain may rise", "gain\N{NO-BREAK SPACE}+", True),
    ),
    Limit(
        *("gain_reduction_margin", "Gain reduction margin", "dB", -1.0, 6.0, 0.0, 60.0, 1),
        *("how far the gain may fall", "gain\N{NO-BREAK SPACE}−", True),
    ),
    Limit(
        *("phase_margin", "Phase margin", "°", DEGREES, 45.0, 0.0, 180.0, 1),
        *("phase to instability", "phase", True),
    ),
    Limit(
        *("delay_margin", "Delay margin", "ms", 1e3, 10.0, 0.0, 1e4, 0),
        *("delay to instability", "delay", True),
    ),
    Limit(
        *("disk_margin", "Disk margin", "", 1.0, 0.6, 0.0, 2.0, 2),
        *("gain and phase together: α, at most 2", "disk", True),
    ),
)
LIMITS = (*STEP_LIMITS, *LOAD_PEAKS.values(), *LOAD_LIMITS[:-1], *MARGIN_LIMITS)


def find_limit(name: str) -> Limit:
    """Return the row with a name.

    Raises:
        WorkbenchError: if there is none.
    """
    return find_row("limit", name, LIMITS)


class Limits(QObject):
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
        try:
            kept = float(str(self._store.value(f"{GROUP}/{name}", row.default)))
        except ValueError:  # written by another version or an editor
            return row.default
        return kept if row.minimum <= kept <= row.maximum else row.default

    def set(self, name: str, value: float) -> None:
        """Set a limit, in the shown unit.

        Raises:
            WorkbenchError: if the value is not valid.
        """
        row = find_limit(name)
        if not (math.isfinite(value) and row.minimum <= value <= row.maximum):
            raise WorkbenchError(
                f"{row.label} is {value:g} {row.unit}: keep it within "
                f"{row.minimum:g} .. {row.maximum:g}"
            )
        if value != self.value(name):
            self._store.setValue(f"{GROUP}/{name}", value)
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

    def __init__(self, rows: Sequence[Limit], limits: Limits, columns: int = 2) -> None:
        super().__init__()
        self.fields: dict[str, NumberField] = {}
        self._limits = limits
        parts: list[QWidget] = []
        for row in rows:
            field = NumberField(f"Limit of {row.label.lower()}", row.decimals, 10.0**-row.decimals)
            field.set_range(Unit(row.unit), row.minimum, row.maximum)
            field.show_si(limits.value(row.name))
            field.edited.connect(lambda value, name=row.name: limits.set(name, value))
            field.setMinimumWidth(NARROWEST)
            field.setButtonSymbols(NumberField.ButtonSymbols.NoButtons)
            field.setProperty("class", "bare")
            field.setStyleSheet(BARE)
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
