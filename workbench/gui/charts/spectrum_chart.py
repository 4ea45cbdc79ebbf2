"""The chart of the spectra of signals over a time window."""

import dataclasses
from functools import partial
from typing import TYPE_CHECKING

import numpy as np
from PyQt6.QtWidgets import QVBoxLayout

from workbench.common.errors import WorkbenchError
from workbench.common.series import Series
from workbench.gui.charts.chart import Chart
from workbench.gui.charts.chart_kind import SPECTRUM_CHART, ChartKind
from workbench.gui.charts.curve import CurveSet, fixed_source
from workbench.gui.charts.ticks import Scale
from workbench.gui.charts.window_plot import WindowPlot
from workbench.gui.errands import FutureCallbacks
from workbench.gui.labels import Label, set_tip
from workbench.gui.layout import hbox
from workbench.gui.style import set_class
from workbench.gui.wheel import ComboBox
from workbench.gui.workspace import Workspace
from workbench.logs.spectrum import (
    WELCH_DETRENDS,
    WELCH_WINDOWS,
    Spectrum,
    WelchSettings,
    density_unit,
    power_spectrum,
)

if TYPE_CHECKING:
    from workbench.gui.visualization.layouts import ChartSpec

SPECTRUM_AVERAGES = (1, 2, 4, 8, 16, 32, 64)
_WINDOW_NAMES = {"hann": "Hann", "hamming": "Hamming", "flattop": "Flat top", "boxcar": "Boxcar"}
_DETREND_NAMES = {"constant": "Mean off", "linear": "Line off", "none": "As it is"}
LOG_LOG_SCALES = Scale.LOGARITHMIC, Scale.LOGARITHMIC


class SpectrumChart(WindowPlot):
    """Shows the spectra of signals; see `WindowPlot`.

    Spectra are computed outside the screens' thread, at most five times a second.

    Args:
        workspace: source of colours, units, preferences and errands.
    """

    def __init__(self, workspace: Workspace) -> None:
        super().__init__(workspace)
        self._answers = FutureCallbacks(workspace.notices.warn, self)
        self._waits = self._again = False
        self._model.x_name, self._model.x_unit = "Frequency", "Hz"
        self._window, self._averages, self._detrend = ComboBox(), ComboBox(), ComboBox()
        self.said = Label()
        self._lay_out()
        self.set_scales(*LOG_LOG_SCALES)
        for box in (self._window, self._averages, self._detrend):
            box.activated.connect(self._choose)

    @property
    def welch(self) -> WelchSettings:
        """Settings of the spectra."""
        return WelchSettings(
            str(self._window.currentData()),
            int(self._averages.currentData()),
            str(self._detrend.currentData()),
        )

    def set_options(self, spec: "ChartSpec") -> None:
        self.set_welch(WelchSettings(spec.window, spec.averages, spec.detrend))

    def with_options(self, spec: "ChartSpec") -> "ChartSpec":
        return dataclasses.replace(spec, **dataclasses.asdict(self.welch))

    def set_welch(self, welch: WelchSettings) -> None:
        """Set how spectra are computed."""
        self._window.setCurrentIndex(self._window.findData(welch.window))
        if self._averages.findData(welch.averages) < 0:
            self._averages.addItem(f"{welch.averages} averages", welch.averages)
        self._averages.setCurrentIndex(self._averages.findData(welch.averages))
        self._detrend.setCurrentIndex(self._detrend.findData(welch.detrend))
        self._make_anew()

    def redraw(self) -> None:
        """Redraw; the axes stay while the spectra vary within them."""
        if self.window_ends == self._shown_ends:  # the user has not zoomed
            self._model.window.show(*self._wanted_ends())
            self._shown_ends = self.window_ends
        self._model.now = self._now
        Chart.redraw(self)

    def make(self) -> None:
        """Start to compute the spectra; if a computation is in progress, again after it."""
        if self._waits:
            self._again = True
            return
        self._waits = True
        sampled = [
            Series(each.label, each.unit, *self.samples(each)).copy() for each in self.signals
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
        curves, said = CurveSet(), []
        for signal, each in zip(self.signals, found, strict=False):
            if isinstance(each, str):
                said.append(each)
                continue
            source = fixed_source(each.frequency[1:], each.density[1:])
            unit = density_unit(signal.unit or "1")
            made = curves.add(signal.label, unit, source, signal.colour, signal.style)
            made.visible = signal.label not in hidden
            length = each.segment / each.rate
            of = f"segments of {length:.3g} s, {1.0 / length:.3g} Hz apart"
            said.append(of + (", missing samples interpolated" if each.resampled else ""))
            if each.part:
                first, last = each.part
                said.append(f"the longest part without gaps, {first:.2f} to {last:.2f} s")
        whole = f"{part[1] - part[0]:.4g} s: " if found else ""
        self.said.setText(whole + "; ".join(dict.fromkeys(said)))
        self.said.setVisible(bool(self.said.text()))
        self.show_curves(curves)

    def _choose(self) -> None:
        self._make_anew()
        self.options_changed.emit()

    def _make_anew(self) -> None:
        self._made = -np.inf
        self.refresh(self._now)

    def _lay_out(self) -> None:
        row = hbox(spacing=4)
        for box, names, name in (
            (self._window, _WINDOW_NAMES, "Window of the spectrum"),
            (
                self._averages,
                {each: f"{each} averages" for each in SPECTRUM_AVERAGES},
                "Segments averaged",
            ),
            (self._detrend, _DETREND_NAMES, "What is subtracted from each segment"),
        ):
            for value, shown in names.items():
                box.addItem(shown, value)
            box.setAccessibleName(name)
            set_tip(box, name)
            row.addWidget(box)
        row.addStretch(1)
        assert set(_WINDOW_NAMES) == set(WELCH_WINDOWS) and set(_DETREND_NAMES) == set(
            WELCH_DETRENDS
        )
        self._averages.setCurrentIndex(SPECTRUM_AVERAGES.index(WelchSettings().averages))
        self.said.setWordWrap(True)
        set_class(self.said, "muted")
        self.said.hide()
        column = self.layout()
        assert isinstance(column, QVBoxLayout)
        column.insertLayout(1, row)
        column.insertWidget(3, self.said)


def _spectra(sampled: list[Series], welch: WelchSettings) -> list[Spectrum | str]:
    """Return the spectrum of each signal, or a sentence why it has none."""
    found: list[Spectrum | str] = []
    for each in sampled:
        try:
            found.append(power_spectrum(each.time, each.values, welch, each.name))
        except WorkbenchError as error:
            found.append(str(error))
    return found


CHART_KIND = ChartKind(SPECTRUM_CHART, "Spectrum", SpectrumChart, log_axes="xy")
