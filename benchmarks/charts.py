"""What a frame of moving charts costs: the app's, and plain ones of pyqtgraph.

A window of 1280 x 720, offscreen, shows 20 s of signals that move on by a sixtieth of a second with
each frame: 4 charts of 3 curves of 2,000 points, and 8 charts of 6 curves of 4,000. Pens are one
pixel wide. Each plain chart is a `PlotWidget`. It gets all points, or only the peaks that the app
finds, or finds the peaks itself. All take turns within the run; figures are processor times.
"""

import os
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from itertools import product

import numpy as np

os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")  # before Qt is imported

import pyqtgraph
from PyQt6.QtCore import QSettings
from PyQt6.QtGui import QColor, QPen
from PyQt6.QtWidgets import QApplication, QGridLayout, QWidget
from spread import Spread, spread, text

from workbench.gui.charts.decimation import ColumnReducer
from workbench.gui.charts.strip_chart import StripChart
from workbench.gui.preferences import Preferences
from workbench.gui.workspace import Workspace, make_workspace

SPAN, FRAME = 20.0, 1.0 / 60.0
CASES = ((4, 3, 2000), (8, 6, 4000))
TURNS, FRAMES = 4, 30
COLOURS = ("#0067a5", "#c1440e", "#00826a", "#9c3f8e", "#8a6d00", "#3b3fb5")


@dataclass(frozen=True)
class ChartRow:
    """One kind of chart.

    Attributes:
        curves: in all charts together.
        points: of each curve.
        kind: whose charts.
        milliseconds: of processor time a frame takes.
    """

    curves: int
    points: int
    kind: str
    milliseconds: Spread


Refresh = Callable[[float], None]
Samples = tuple[np.ndarray, np.ndarray]


class Signal:
    """A noisy wave."""

    def __init__(self, rate: float, number: int) -> None:
        end = 2 * SPAN + len(KINDS) * TURNS * (FRAMES + 5) * FRAME
        self._time = np.arange(0.0, end, 1.0 / rate)
        noise = np.random.default_rng(number).standard_normal(len(self._time))
        self._values = np.sin((0.5 + 0.1 * number) * self._time + number) + 0.05 * noise
        self.now = 0.0

    def since(self, since: float) -> Samples:
        """Return the samples from a time until now [s]."""
        first, last = np.searchsorted(self._time, (since, self.now))
        return self._time[first:last], self._values[first:last]


def _app_charts(box: QGridLayout, workspace: Workspace, signals: list[list[Signal]]) -> Refresh:
    charts = []
    for index, some in enumerate(signals):
        chart = StripChart(workspace)
        chart.set_title(f"Chart {index}")
        for number, signal in enumerate(some):
            chart.add_curve(f"signal {number}", "m/s", signal.since)
        box.addWidget(chart, index % 2, index // 2)
        charts.append(chart)

    def refresh(now: float) -> None:
        for chart in charts:
            chart.refresh(now)

    return refresh


def _plain_charts(
    box: QGridLayout, signals: list[list[Signal]], decimates: bool, itself: bool
) -> Refresh:
    shown = []
    for index, some in enumerate(signals):
        plot = pyqtgraph.PlotWidget(background="w")
        plot.showGrid(x=True, y=True)
        if itself:
            plot.setDownsampling(auto=True, mode="peak")
            plot.setClipToView(True)
        box.addWidget(plot, index % 2, index // 2)
        plot.setYRange(-1.2, 1.2)
        for number, signal in enumerate(some):
            pen = QPen(QColor(COLOURS[number]), 1)
            pen.setCosmetic(True)
            shown.append((plot, number == 0, plot.plot(pen=pen), signal, ColumnReducer()))

    def refresh(now: float) -> None:
        for plot, is_first, curve, signal, peaks in shown:
            if is_first:
                plot.setXRange(now - SPAN, now, padding=0.0)
            time, values = signal.since(now - SPAN)
            if decimates:
                columns = int(0.5 * plot.width())
                time, values = peaks.reduce(time, values, now - SPAN, now, columns)
            curve.setData(time, values, skipFiniteCheck=True)

    return refresh


KINDS = ("the app's", "pyqtgraph, all points", "pyqtgraph, our peaks", "pyqtgraph, its peaks")


def measure() -> list[ChartRow]:
    """Return a row for each kind and number of curves."""
    application = QApplication.instance() or QApplication(sys.argv[:1])
    store = QSettings(f"{tempfile.mkdtemp()}/settings.ini", QSettings.Format.IniFormat)
    workspace = make_workspace(Preferences(store))
    rows = []
    for charts, curves, points in CASES:
        signals = [
            [Signal(points / SPAN, curves * each + number) for number in range(curves)]
            for each in range(charts)
        ]
        windows = []
        for kind in KINDS:
            window = QWidget()
            window.resize(1280, 720)
            box = QGridLayout(window)
            if kind == KINDS[0]:
                refresh = _app_charts(box, workspace, signals)
            else:
                refresh = _plain_charts(box, signals, kind == KINDS[2], kind == KINDS[3])
            windows.append((window, refresh, list[float]()))
        now = SPAN
        for _, (window, refresh, took) in product(range(TURNS), windows):
            window.show()
            begun = 0.0
            for frame in range(-5, FRAMES):
                if frame == 0:  # the first ones lay out what has not been seen yet
                    begun = time.process_time()
                now += FRAME
                for signal in sum(signals, []):
                    signal.now = now
                refresh(now)
                application.processEvents()
            took.append(1e3 * (time.process_time() - begun) / FRAMES)
            window.hide()
        for kind, (window, _, took) in zip(KINDS, windows, strict=True):
            rows.append(ChartRow(charts * curves, points, kind, spread(took)))
            window.deleteLater()
    workspace.close()
    return rows


def show(rows: list[ChartRow]) -> None:
    """Print the table."""
    print(f"{'curves':>6} {'points':>6} {'charts':24} [ms] a frame")
    for each in rows:
        print(f"{each.curves:6} {each.points:6} {each.kind:24} {text(each.milliseconds)}")


if __name__ == "__main__":
    show(measure())
