"""Power spectral densities of signals over frequency, by Welch's method."""

from functools import partial
from typing import NamedTuple

import numpy as np
from PyQt6.QtCore import pyqtSignal
from PyQt6.QtWidgets import QComboBox, QHBoxLayout, QLabel, QVBoxLayout, QWidget

from workbench.common.errors import WorkbenchError
from workbench.gui.answers import Answers
from workbench.gui.charts.chart import Chart
from workbench.gui.charts.curve import CurveSet, source_of
from workbench.gui.charts.scale import Scale
from workbench.gui.charts.window_plot import WindowPlot
from workbench.gui.style import set_class
from workbench.gui.workspace import Workspace
from workbench.logs.spectrum import (
    DETRENDS,
    WINDOWS,
    Spectrum,
    Welch,
    density_unit,
    power_spectrum,
)

AVERAGES = (1, 2, 4, 8, 16, 32, 64)
_WINDOW_NAMES = {"hann": "Hann", "hamming": "Hamming", "flattop": "Flat top", "boxcar": "Boxcar"}
_DETREND_NAMES = {"constant": "Mean off", "linear": "Line off", "none": "As it is"}
BOTH = Scale.LOGARITHMIC, Scale.LOGARITHMIC


class _Sampled(NamedTuple):
    """A signal in a part of time: its label, times [s] and values."""

    label: str
    time: np.ndarray
    values: np.ndarray


class SpectrumChart(WindowPlot):
    """Shows what frequencies signals are made of; see `WindowPlot`.

    Spectra are worked out beside the thread of the screens, five times a second at most.

    Args:
        workspace: colours, units, preferences and errands.
        parent: the Qt parent; this object is deleted with it.
    """

    welch_changed = pyqtSignal()
    """The user has chosen another window, averaging or detrending."""

    def __init__(self, workspace: Workspace, parent: QWidget | None = None) -> None:
        super().__init__(workspace, parent)
        self._answers = Answers(workspace.notices.warn, self)
        self._waits = self._again = False
        self._model.x_name, self._model.x_unit = "Frequency", "Hz"
        self._window, self._averages, self._detrend = QComboBox(), QComboBox(), QComboBox()
        self.said = QLabel()
        self._lay_out()
        self.set_scales(*BOTH)
        for box in (self._window, self._averages, self._detrend):
            box.activated.connect(self._choose)

    @property
    def welch(self) -> Welch:
        """How spectra are made."""
        return Welch(
            str(self._window.currentData()),
            int(self._averages.currentData()),
            str(self._detrend.currentData()),
        )

    def set_welch(self, welch: Welch) -> None:
        """Make spectra otherwise."""
        self._window.setCurrentIndex(self._window.findData(welch.window))
        if self._averages.findData(welch.averages) < 0:
            self._averages.addItem(f"{welch.averages} averages", welch.averages)
        self._averages.setCurrentIndex(self._averages.findData(welch.averages))
        self._detrend.setCurrentIndex(self._detrend.findData(welch.detrend))
        self._make_anew()

    def redraw(self) -> None:
        """Draw anew; the axes stay while the spectra swing within them."""
        if self.window_ends == self._shown_ends:  # nobody has zoomed
            self._model.window.show(*self._wanted_ends())
            self._shown_ends = self.window_ends
        self._model.now = self._now
        Chart.redraw(self)

    def make(self) -> None:
        """Begin to work out the spectra; where that goes on already, again after it."""
        if self._waits:
            self._again = True
            return
        self._waits = True
        sampled = [
            _Sampled(each.label, *(part.copy() for part in self.samples(each)))
            for each in self.signals
        ]
        signals, part = self.signals, self.part
        self._answers.expect(
            self._workspace.errands.run(partial(_spectra, sampled, self.welch)),
            lambda found: self._show(signals, part, found),
        )

    def _show(
        self, signals: CurveSet, part: tuple[float, float], found: list[Spectrum | str]
    ) -> None:
        """Show spectra, or why there are none."""
        self._waits = False
        if signals is self.signals:
            self._draw_spectra(part, found)
        if self._again or signals is not self.signals:
            self._again = False
            self.make()

    def _draw_spectra(self, part: tuple[float, float], found: list[Spectrum | str]) -> None:
        hidden = {curve.label for curve in self.curves if not curve.visible}
        self._model.curves = CurveSet()
        said = []
        for signal, each in zip(self.signals, found, strict=False):
            if isinstance(each, str):
                said.append(each)
                continue
            source = source_of(each.frequency[1:], each.density[1:])
            unit = density_unit(signal.unit or "1")
            made = self._model.curves.add(signal.label, unit, source, signal.colour, signal.style)
            made.visible = signal.label not in hidden
            length = each.segment / each.rate
            of = f"segments of {length:.3g} s, {1.0 / length:.3g} Hz apart"
            said.append(of + (", samples that were missing interpolated" if each.resampled else ""))
        whole = f"{part[1] - part[0]:.4g} s: " if found else ""
        self.said.setText(whole + "; ".join(dict.fromkeys(said)))
        self.said.setVisible(bool(self.said.text()))
        self._describe()
        super()._redraw_if_seen()

    def _choose(self) -> None:
        self._make_anew()
        self.welch_changed.emit()

    def _make_anew(self) -> None:
        self._made = -np.inf
        self.refresh(self._now)

    def _lay_out(self) -> None:
        row = QHBoxLayout()
        row.setSpacing(4)
        for box, names, name in (
            (self._window, _WINDOW_NAMES, "Window of the spectrum"),
            (self._averages, {each: f"{each} averages" for each in AVERAGES}, "Segments averaged"),
            (self._detrend, _DETREND_NAMES, "What is taken off each segment"),
        ):
            for value, shown in names.items():
                box.addItem(shown, value)
            box.setAccessibleName(name)
            box.setToolTip(name)
            row.addWidget(box)
        row.addStretch(1)
        assert set(_WINDOW_NAMES) == set(WINDOWS) and set(_DETREND_NAMES) == set(DETRENDS)
        self._averages.setCurrentIndex(AVERAGES.index(Welch().averages))
        self.said.setWordWrap(True)
        set_class(self.said, "muted")
        self.said.hide()
        column = self.layout()
        assert isinstance(column, QVBoxLayout)
        column.insertLayout(1, row)
        column.insertWidget(3, self.said)


def _spectra(sampled: list[_Sampled], welch: Welch) -> list[Spectrum | str]:
    """Return the spectrum of each signal, or a sentence why it has none."""
    found: list[Spectrum | str] = []
    for each in sampled:
        try:
            found.append(power_spectrum(each.time, each.values, welch, each.label))
        except WorkbenchError as error:
            found.append(str(error))
    return found
