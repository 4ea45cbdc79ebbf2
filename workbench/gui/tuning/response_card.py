"""The card of the response: live, against its prediction, its limits and the last ones."""

import math
from collections.abc import Mapping

import numpy as np
from PyQt6.QtWidgets import QWidget

from workbench.analysis.questions import Step
from workbench.analysis.replies import Predicted, StepNumbers
from workbench.gui.tuning.card import Card
from workbench.gui.tuning.excitation_form import ExcitationChoice
from workbench.gui.tuning.limit_strip import LimitStrip, Use
from workbench.gui.tuning.limit_table import STEP_LIMITS
from workbench.gui.tuning.limits import Limits
from workbench.gui.tuning.limits_form import LimitsForm
from workbench.gui.tuning.metric_rows import HEAD, headline, metric_rows
from workbench.gui.tuning.number_table import NumberTable
from workbench.gui.tuning.response_history import ResponseHistory
from workbench.gui.tuning.response_plot import ResponsePlot
from workbench.gui.tuning.rounds import StepPart, step_parts
from workbench.gui.tuning.step_measure import SAME
from workbench.gui.tuning.table_rows import Row, State
from workbench.gui.tuning.trace import Trace, take_trace
from workbench.gui.units import Unit, unit_for
from workbench.gui.workspace import Workspace
from workbench.live.view import LiveView
from workbench.scenario.axes import AXIS_ROWS, find_axis
from workbench.scenario.excitation import Excitation
from workbench.scenario.parameters import parameter_table

PERCENT = Unit("%", 100.0)
FRAME = 1.0 / 32.0
"""Between two pictures of what is being flown [s]."""
LONGEST_STEP = 30.0
"""That is predicted [s]."""
TURNED = math.radians(1.0)
"""A prediction does not follow smaller changes of the heading [rad]."""


class ResponseCard(Card):
    """Shows the newest response along the chosen axis, and its numbers.

    Args:
        workspace: signals of the flight, colours and units.
        limits: that a step should keep.
        choice: of the excitation.
        parent: the Qt parent; this object is deleted with it.

    Attributes:
        table: the numbers.
        plot: the curves.
        strip: use of the flight's limits.
    """

    def __init__(
        self,
        workspace: Workspace,
        limits: Limits,
        choice: ExcitationChoice,
        parent: QWidget | None = None,
    ) -> None:
        super().__init__("Response", parent)
        self._workspace = workspace
        self._limits = limits
        self._choice = choice
        self._view = LiveView()
        self._gains: Mapping[str, float] = {}
        self._heading, self._round_begun = 0.0, math.nan
        self._histories = {axis.name: ResponseHistory(self._take) for axis in AXIS_ROWS}
        self._predicted: Predicted | None = None
        self._refusal = ""
        self._ahead = np.empty(0), np.empty(0)
        self._drawn: tuple[object, ...] = ()
        self._still = False
        self._shown_at = -1.0
        self.plot = ResponsePlot(workspace)
        self.strip = LimitStrip(workspace.look)
        self.form = LimitsForm(STEP_LIMITS, limits)
        self.table = NumberTable(
            "Numbers of the step", HEAD, workspace.look, paired=False, widest="Settling time"
        )
        self.table.expect(len(STEP_LIMITS))
        self.head.addWidget(self.form.button)
        self.body.addWidget(self.plot, 1)
        self.body.addWidget(self.strip)
        self.body.addWidget(self.form)
        self.body.addWidget(self.table)
        limits.changed.connect(lambda _: self._show_numbers())
        workspace.preferences.changed.connect(lambda _: self._forget_drawn())
        self.plan(choice)

    @property
    def history(self) -> ResponseHistory:
        """Responses along the chosen axis."""
        return self._histories[self._choice.axis]

    @property
    def part(self) -> StepPart | None:
        """The step that is compared with its prediction; a chirp has none."""
        parts = self._parts()
        return parts[0] if parts else None

    @property
    def step(self) -> Step | None:
        """What is to be predicted; None for a chirp."""
        part = self.part
        if part is None:
            return None
        duration = min(part.duration, LONGEST_STEP)
        return Step(self._choice.axis, part.jump, duration, self._heading)

    def begin(self, view: LiveView) -> None:
        """Forget the responses of another flight."""
        self._view = view
        for history in self._histories.values():
            history.clear()
        self._predicted, self._refusal = None, ""
        self._ahead = np.empty(0), np.empty(0)
        self._forget_drawn()
        self.plan(self._choice)

    def plan(self, choice: ExcitationChoice) -> None:
        """Show the responses along another axis, or what another shape asks for."""
        self._choice = choice
        self._forget_drawn()
        self._draw(self._workspace.signals.now)

    def show_view(self, view: LiveView, gains: Mapping[str, float]) -> None:
        """Show the present.

        Args:
            view: of the flight.
            gains: that fly.
        """
        self._view, self._gains = view, gains
        self._take_heading(view)
        now = self._workspace.signals.now
        if view.exciting is not None:
            self._histories[view.exciting.excitation.axis].begin(view.exciting, gains)
        for axis, history in self._histories.items():
            if view.exciting is None or view.exciting.excitation.axis != axis:
                history.end(now)
        self._draw(now)

    def show_predicted(self, predicted: Predicted | None) -> None:
        """Show what the proposed gains would do."""
        self._predicted, self._refusal = predicted, ""
        self._show_prediction()
        self._show_numbers()

    def refuse_predicted(self, said: str) -> None:
        """Say why what the proposed gains would do is not known; what was known is of others."""
        self._predicted, self._refusal = None, said
        self._show_prediction()
        self._show_numbers()

    def show_ahead(self, time: np.ndarray, values: np.ndarray) -> None:
        """Show how the flight would go on with the proposed gains.

        Args:
            time: simulated (N) [s]; empty for nothing.
            values: (N) velocity [m/s] or yaw rate [rad/s] along the axis.
        """
        self._ahead = time, values
        self._show_ahead()

    def _show_ahead(self) -> None:
        flown = self.history.round
        time, values = self._ahead
        if flown is None or not self.history.is_running or not len(time):
            self.plot.show_future()
        else:
            seen = (time >= flown.begun) & (time <= flown.next_edge(float(time[0])))
            seen &= time[0] >= flown.begun - SAME  # else it knows nothing of this round's command
            self.plot.show_future(time[seen] - flown.begun, values[seen])

    def _take_heading(self, view: LiveView) -> None:
        """Predict with the heading at which a round began, or with the present one before it."""
        begun = view.exciting.began if view.exciting is not None else math.nan
        if view.snapshot is None or begun == self._round_begun:
            return
        self._round_begun = begun
        heading = view.snapshot.roll_pitch_yaw[2]
        if abs(math.remainder(heading - self._heading, math.tau)) > TURNED:
            self._heading = heading

    def _parts(self) -> tuple[StepPart, ...]:
        flown = self.history.round
        return flown.parts if flown is not None else step_parts(self._choice.excitation)

    def _take(self, excitation: Excitation, begun: float, end: float) -> Trace:
        assert self._view.vehicle is not None
        return take_trace(self._workspace.signals, excitation, self._view.vehicle, begun, end)

    def _forget_drawn(self) -> None:
        self._drawn, self._still, self._shown_at = (), False, -1.0

    def _draw(self, now: float) -> None:
        """Draw what has changed: the flown curve thirty times a second, the rest once a round."""
        history = self.history
        rounds = (history.round, history.ghosts)
        if rounds != self._drawn or not self._drawn:
            self._drawn, self._still, self._shown_at = rounds, False, -1.0
            self.plot.show_plan(self._choice.excitation, history)
            self.plot.show_ghosts(history.ghosts, self._gains)
            self._show_ahead()
            self._show_prediction()
        if self._still or (history.is_running and 0.0 <= now - self._shown_at < FRAME):
            return
        self._shown_at = now
        before = history.numbers
        trace = history.present(now)
        self.plot.show_flown(trace)
        self._show_uses(trace)
        self._still = not history.is_running
        if history.numbers is not before or self._still:
            self._show_numbers()
            self.strip.describe()

    def _show_prediction(self) -> None:
        step, found = self.step, self._predicted
        fits = found is not None and step is not None and found.step == step
        self.plot.show_predicted(found if fits else None, self.part)

    def _show_uses(self, trace: Trace | None) -> None:
        if trace is None:
            self.strip.show_uses((), 1.0)
            return
        axis = find_axis(self._choice.axis)
        table = parameter_table(self._view.controller)
        values = {**table.defaults(), **self._view.values, **self._gains}
        preferences = self._workspace.preferences
        speed = "yaw rate" if axis.place is None else "speed"
        uses = (
            Use("tilt", trace.time, trace.tilt, values["max_tilt"], unit_for("rad", preferences)),
            Use("rotor use", trace.time, trace.rotor_use, 1.0, PERCENT),
            Use(
                speed,
                trace.time,
                trace.response,
                values[axis.limit],
                unit_for(axis.unit, preferences),
                1,
            ),
        )
        flown = self.history.round
        self.strip.show_uses(uses, flown.excitation.round_time if flown else 1.0)

    def _show_numbers(self) -> None:
        step, found = self.step, self._predicted
        fits = found is not None and step is not None and found.step == step
        predicted: StepNumbers | None = found.numbers if fits and found is not None else None
        rows = metric_rows(self.history.numbers, predicted, self._limits.value)
        self.table.set_rows(rows)
        self.said.say(*self._sentence(rows))

    def _sentence(self, rows: tuple[Row, ...]) -> tuple[str, str]:
        if self.step is None:
            return "A chirp has no step to measure.", "muted"
        if self._predicted is not None and self._predicted.lost:
            return "With the proposed gains the drone would be lost.", "bad"
        if self._refusal:
            return f"No prediction: {self._refusal}", "warning"
        flown = self.history.numbers
        if flown is not None and flown.withheld:
            return f"Numbers shown as – are withheld: {flown.withheld}.", "warning"
        over = any(row.state is State.OVER for row in rows)
        return headline(rows), "warning" if over else "muted"
