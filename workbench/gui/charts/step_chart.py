"""Measured responses to the steps of a command, over each other, with their metrics."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from PyQt6.QtWidgets import QWidget

from workbench.design.response_metrics import NUMBERS
from workbench.design.step_responses import StepResponse, step_responses
from workbench.gui.charts.chart import Chart, Command
from workbench.gui.charts.curve import COMMAND, LIMIT, MOST_CURVES, CurveSet, CurveStyle, source_of
from workbench.gui.charts.legend import Entry
from workbench.gui.charts.ticks import number_text
from workbench.gui.charts.window_plot import WindowPlot
from workbench.gui.units import unit_for
from workbench.gui.workspace import Workspace

MOST_STEPS = 12
"""The newest ones that are drawn, of all flights together."""
_OF_VALUES = ("peak", "steady_state_value")
_OF_TIME = ("rise_time", "settling_time", "peak_time")


@dataclass(frozen=True, eq=False)
class LimitLine:
    """A limit on a step response.

    Attributes:
        label: in the legend.
        time: (n) from the edge on [s].
        values: (n), from the command before the edge.
    """

    label: str
    time: np.ndarray
    values: np.ndarray


Limits = Callable[[StepResponse], Sequence[LimitLine]]
"""Returns the limits of a response."""


class StepChart(WindowPlot):
    """Shows how the second signal answers steps of the first; see `WindowPlot`.

    Steps stand in the table with the newest first; numbers that mean nothing are left out.

    Args:
        workspace: colours, units and preferences.
        parent: the Qt parent; this object is deleted with it.

    Attributes:
        steps: that are shown, the newest last.
    """

    def __init__(self, workspace: Workspace, parent: QWidget | None = None) -> None:
        self.steps: list[StepResponse] = []
        self._names: list[str] = []
        self._limits: Limits = lambda _: ()
        self._hidden: set[str] = set()
        super().__init__(workspace, parent)
        self._model.x_name = "Time after the step"
        self._model.hint = "Drag a command here, then what it commands"
        self.statistics.setAccessibleName("Metrics of the steps that the chart shows")
        self.set_statistics_shown(True)

    def set_limits(self, limits: Limits) -> None:
        """Draw the limits of the newest step."""
        self._limits = limits
        self._made = -np.inf
        self._soon.start()

    def make(self) -> None:
        """Find the steps, and draw the newest ones."""
        if len(self.signals) < 2:
            return
        command, flown = self.signals[0], self.signals[1]
        curves = CurveSet()
        self.steps, self._names = [], []
        share = max(1, MOST_STEPS // (1 + len(self._firsts)))
        for each in (flown, *self._firsts):
            found = step_responses(self.samples(self.first_of(each)), self.samples(each))
            of = each.label.removeprefix(flown.label)
            for number, step in list(enumerate(found, 1))[-share:]:
                newest = step is found[-1]
                style = CurveStyle.SOLID if newest and each is flown else CurveStyle.FAINT
                source = source_of(step.time, step.response)
                self._names.append(f"step {number}{of}")
                colour = 0 if newest else number
                curves.add(self._names[-1], flown.unit, source, colour, style)
                self.steps.append(step)
            if each is flown:
                ours = len(self.steps)
        for step in self.steps[:ours][-1:]:
            asked = np.full(len(step.time), step.amplitude)
            source = source_of(step.time, asked)
            curves.add("command", flown.unit, source, COMMAND, CurveStyle.DASHED)
            for line in self._limits(step)[: MOST_CURVES - len(curves)]:
                source = source_of(line.time, line.values)
                curves.add(line.label, flown.unit, source, LIMIT, CurveStyle.DASHED)
        for curve in curves:
            curve.visible = curve.label not in self._hidden
        self._model.curves = curves
        if not self.steps:
            self._model.hint = (
                f"No step of {command.label} in this part of time: a command that stands, changes, "
                "and stands again"
            )
        self._describe()
        Chart._redraw_if_seen(self)

    def toggle_curve(self, index: int) -> None:
        """Hide a step or a limit, or show it again."""
        self._hidden ^= {self._entries()[index].label}
        for curve in self.curves:
            curve.visible = curve.label not in self._hidden
        self.redraw()

    def _entries(self) -> list[Entry]:
        """Return the legend: a limit of two lines stands there once."""
        found = {each.label: each for each in super()._entries()}
        return [*found.values()]

    def _commands(self) -> list[Command]:
        """Return what can be done; the table is of the metrics."""
        return [
            Command("Metrics", each.key, each.do, each.checked)
            if each.text == "Statistics"
            else each
            for each in super()._commands()
        ]

    def _show_numbers(self) -> None:
        self.legend.show_entries(self._entries())
        if not self.are_statistics_shown or len(self.signals) < 2:
            return
        unit = unit_for(self.signals[1].unit, self._workspace.preferences)
        heads = {"Step": "In the order they were flown", "At s": "When the command changed"}
        heads["By" + f" {unit.symbol}".rstrip()] = "By how much the command changed"
        for name in NUMBERS:
            of = unit.symbol if name in _OF_VALUES else "s" if name in _OF_TIME else "%"
            heads[f"{name} {of}".strip()] = "As python-control defines it"
        heads["Left out, as"] = "Why some numbers mean nothing"
        rows: list[list[str]] = []
        for name, step in zip(self._names, self.steps, strict=True):
            numbers = step.metrics.numbers
            texts = [
                number_text(unit.shown(value) if name in _OF_VALUES else value, 3)
                for name, value in numbers.items()
            ]
            by = number_text(unit.shown(step.amplitude), 2)
            row = [name, number_text(step.begin, 2), by, *texts, step.metrics.withheld]
            rows.insert(0, row)
        self.statistics.show_table(heads, rows)
