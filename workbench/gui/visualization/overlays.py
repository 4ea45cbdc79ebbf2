"""Logs drawn over the charts, each shifted in time."""

from collections.abc import Sequence

import numpy as np
from PyQt6.QtCore import pyqtSignal
from PyQt6.QtWidgets import QWidget

from workbench.common.errors import WorkbenchError
from workbench.common.plain_text import plain_name
from workbench.common.quantity import DisplayUnit
from workbench.common.series import TimedValues
from workbench.gui.labels import Label
from workbench.gui.layout import NO_MARGINS, buddy, button, hbox, named, vbox
from workbench.gui.number_field import NumberField
from workbench.gui.visualization.derived_signals import (
    ESTIMATED_STATES,
    DerivedSignal,
    SeriesSource,
    WithDerived,
    true_signal,
)

_COMMAND_SIGNALS = tuple(f"command_velocity.{name}" for name in ("v_x", "v_y", "v_z", "yaw_rate"))
_HEIGHT_SIGNALS = ("position_data.z", "estimate.z")
_MOTOR_SIGNAL = "motors.command_1"
_MIN_MOTOR_COMMAND = 0.05
"""Change of a motor's share of full command from which on it turns."""
_MIN_COMMAND_CHANGE = 1e-3
"""Least change of a command that counts as a step [m/s or rad/s]."""
_TAKE_OFF_HEIGHT_M = 0.1
"""Height above its initial position at which a drone has taken off [m]."""
_ESTIMATES = {true_signal(field): f"estimate.{field}" for field, _ in ESTIMATED_STATES}
COUNTERPARTS = _ESTIMATES | {estimate: name for name, estimate in _ESTIMATES.items()}
"""Signals of true and of estimated motion, of which logs of real flights have only the latter."""
MAX_LOG_SHIFT_S = 1e5
"""Largest shift of a log's time [s]."""


class Overlay:
    """A log over the charts' own source: its series, shifted in time.

    Args:
        name: name in legends.
        log: its series, with the log's times.

    Attributes:
        name: name in legends.
        shift: value added to its times [s].
    """

    def __init__(self, name: str, log: SeriesSource) -> None:
        self.name = name
        self.shift = 0.0
        self._log = log
        self._source: SeriesSource = log

    def derive(self, derived: Sequence[DerivedSignal]) -> None:
        """Add derived signals."""
        self._source = WithDerived(self._log, derived)

    @property
    def units(self) -> "dict[str, str]":
        """SI unit of every series, by name."""
        return dict(self._source.units)

    def signal(self, name: str) -> str:
        """Return the signal to draw over another: the same, or its counterpart; "" for none."""
        both = (name, COUNTERPARTS.get(name, ""))
        return next((each for each in both if each in self._source.units), "")

    def series(self, name: str, since: float = -np.inf) -> TimedValues:
        """Return shifted times [s] and values of a signal from a time on (N).

        Raises:
            WorkbenchError: if there is no such signal, or it cannot be computed.
        """
        time, values = self._source.series(name, since - self.shift)
        return time + self.shift, values

    def align(self, to: SeriesSource) -> None:
        """Shift it so that its first step of a command, or its take-off, coincides with another's.

        Without them, the first turn of the motors counts.

        Raises:
            WorkbenchError: if they share neither.
        """
        for first in (_first_step, _first_take_off, _first_motor_command):
            own, other = first(self._log), first(to)
            if np.isfinite(own) and np.isfinite(other):
                self.shift = float(other - own)
                return
        raise WorkbenchError(
            f"{self.name}: there is no command step or take-off in both: type the shift"
        )


def _first_step(source: SeriesSource) -> float:
    """Return the time of the first change of a command [s]; NaN without one."""
    return min(
        (_first_change(source, name, _MIN_COMMAND_CHANGE) for name in _COMMAND_SIGNALS),
        key=_finite_or_inf,
    )


def _first_take_off(source: SeriesSource) -> float:
    times = (_first_change(source, name, _TAKE_OFF_HEIGHT_M) for name in _HEIGHT_SIGNALS)
    return next((time for time in times if np.isfinite(time)), np.nan)


def _first_motor_command(source: SeriesSource) -> float:
    return _first_change(source, _MOTOR_SIGNAL, _MIN_MOTOR_COMMAND)


def _finite_or_inf(time: float) -> float:
    return time if np.isfinite(time) else np.inf


def _first_change(source: SeriesSource, name: str, by: float) -> float:
    """Return when a signal first differs from its start by an amount [s]; NaN if it never does."""
    if name not in source.units:
        return np.nan
    time, values = source.series(name, -np.inf)
    known = np.isfinite(values)
    time, values = time[known], values[known]
    moved = np.flatnonzero(np.abs(values - values[:1]) > by)
    return float(time[moved[0]]) if len(moved) else np.nan


class OverlayBar(QWidget):
    """A line for each log over the charts: its name, its shift, and a button to remove it."""

    changed = pyqtSignal()
    """The logs, or their shifts, have changed."""
    align_wanted = pyqtSignal(object)
    """An `Overlay` to align with the charts' own source."""

    def __init__(self) -> None:
        super().__init__()
        self._rows: dict[Overlay, tuple[QWidget, NumberField]] = {}
        self._box = vbox(of=self, margins=NO_MARGINS, spacing=4)
        self.hide()

    @property
    def overlays(self) -> tuple[Overlay, ...]:
        """The logs, in the order of opening."""
        return tuple(self._rows)

    def add(self, overlay: Overlay) -> None:
        """Add a log over the charts."""
        widget = QWidget()
        shift = NumberField(f"Shift of {overlay.name}", decimals=3, step=0.1)
        shift.set_range(DisplayUnit("s"), -MAX_LOG_SHIFT_S, MAX_LOG_SHIFT_S)
        shift.show_decimals(3)
        align = button(
            "Align",
            lambda: self.align_wanted.emit(overlay),
            help="Shift it so that its first step or its take-off is at the same time as here",
        )
        remove = button("Remove", lambda: self._remove(overlay))
        hbox(
            buddy("Overlay shifted by", shift, kind=""),
            shift,
            align,
            named(remove, f"Remove {overlay.name}"),
            (Label(plain_name(overlay.name)), 1),
            of=widget,
            margins=NO_MARGINS,
        )
        self._rows[overlay] = widget, shift
        self._box.addWidget(widget)
        shift.edited.connect(lambda value: self._set_shift(overlay, value))
        self.show()
        self.changed.emit()

    def slide(self, by: float) -> None:
        """Shift the newest log by a time [s]."""
        if self._rows:
            self.overlays[-1].shift += by
            self.show_shifts()

    def show_shifts(self) -> None:
        """Show shifts that were changed elsewhere."""
        for overlay, (_, field) in self._rows.items():
            field.show_si(overlay.shift)
        self.changed.emit()

    def _set_shift(self, overlay: Overlay, value: float) -> None:
        overlay.shift = value
        self.changed.emit()

    def _remove(self, overlay: Overlay) -> None:
        widget, _ = self._rows.pop(overlay)
        widget.hide()
        widget.deleteLater()
        self.setVisible(bool(self._rows))
        self.changed.emit()
