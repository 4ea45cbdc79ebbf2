"""The chart of a signal's responses to the steps of another, with limits."""

from collections.abc import Callable, Sequence

import numpy as np

from workbench.common.quantity import number_text
from workbench.common.series import Series
from workbench.design.metrics import FLOWN_METRICS, SIGNAL_UNIT, find_metric
from workbench.design.step_metrics import STEP_NUMBERS
from workbench.design.step_responses import LoggedStep, step_responses
from workbench.gui.charts.chart_command import ChartCommand
from workbench.gui.charts.chart_kind import STEP_CHART, ChartKind
from workbench.gui.charts.curve import (
    COMMAND_COLOUR,
    LIMIT_COLOUR,
    MAX_CHART_CURVES,
    CurveSet,
    CurveStyle,
    fixed_source,
)
from workbench.gui.charts.window_plot import WindowPlot
from workbench.gui.units import unit_for
from workbench.gui.workspace import Workspace

MAX_DRAWN_STEPS = 12
"""Number of drawn steps: the newest ones of all flights."""


LimitLinesOf = Callable[[LoggedStep], Sequence[Series]]
"""Returns the limits of a response by their names in the legend: from the edge on, relative to the
command before it."""


class StepChart(WindowPlot):
    """Shows the responses of the second signal to steps of the first; see `WindowPlot`.

    The table lists the newest step first; meaningless numbers are left out.

    Args:
        workspace: source of colours, units and preferences.

    Attributes:
        steps: the shown steps, the newest last.
    """

    def __init__(self, workspace: Workspace) -> None:
        self.steps: list[LoggedStep] = []
        self._names: list[str] = []
        self._limits: LimitLinesOf = lambda _: ()
        self._hidden: set[str] = set()
        super().__init__(workspace)
        self._model.x_name = "Time after the step"
        self._model.hint = "Drag a command here, then its response"
        self.statistics.setAccessibleName("Metrics of the steps that the chart shows")
        self.set_statistics_shown(True)

    def set_limits(self, limits: LimitLinesOf) -> None:
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
        share = max(1, MAX_DRAWN_STEPS // (1 + len(self._firsts)))
        for each in (flown, *self._firsts):
            found = step_responses(self.samples(self.first_of(each)), self.samples(each))
            of = each.label.removeprefix(flown.label)
            for number, step in list(enumerate(found, 1))[-share:]:
                newest = step is found[-1]
                style = CurveStyle.SOLID if newest and each is flown else CurveStyle.FAINT
                source = fixed_source(step.time, step.response)
                self._names.append(f"step {number}{of}")
                colour = 0 if newest else number
                made = curves.add(self._names[-1], flown.unit, source, colour, style)
                made.group = "" if newest and each is flown else f"earlier steps{of}"
                self.steps.append(step)
            if each is flown:
                ours = len(self.steps)
        for step in self.steps[:ours][-1:]:
            asked = np.full(len(step.time), step.amplitude)
            source = fixed_source(step.time, asked)
            curves.add("command", flown.unit, source, COMMAND_COLOUR, CurveStyle.DASHED)
            for line in self._limits(step)[: MAX_CHART_CURVES - len(curves)]:
                source = fixed_source(line.time, line.values)
                made = curves.add(line.name, flown.unit, source, LIMIT_COLOUR, CurveStyle.DASHED)
                made.group = line.name
        for curve in curves:
            curve.visible = (curve.group or curve.label) not in self._hidden
        if not self.steps:
            self._model.hint = (
                f"No step of {command.label} in this part of time: a step is a command that is "
                "constant, changes, and is constant again"
            )
        self.show_curves(curves)

    def toggle_entry(self, index: int) -> None:
        """Hide a step, earlier steps or a limit, or show them again."""
        super().toggle_entry(index)
        self._hidden = {each.group or each.label for each in self.curves if not each.visible}

    def _commands(self) -> list[ChartCommand]:
        """Return the commands; the table has the metrics."""
        return [
            ChartCommand("Metrics", each.key, each.do, each.checked)
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
        for name in STEP_NUMBERS:
            of = find_metric(name).unit_for(unit.symbol)
            heads[f"{name} {of}".strip()] = "As python-control defines it"
        heads["Left out, as"] = "Why some numbers have no meaning"
        signals = [row.name for row in FLOWN_METRICS if row.unit == SIGNAL_UNIT]
        rows: list[list[str]] = []
        for name, step in zip(self._names, self.steps, strict=True):
            numbers = step.metrics.numbers
            texts = [
                number_text(unit.shown(value) if name in signals else value, 3)
                for name, value in numbers.items()
            ]
            by = number_text(unit.shown(step.amplitude), 2)
            row = [name, number_text(step.begin, 2), by, *texts, step.metrics.withheld]
            rows.insert(0, row)
        self.statistics.show_table(heads, rows)


CHART_KIND = ChartKind(
    STEP_CHART, "Responses to steps of the first signal", StepChart, over_first=True
)
