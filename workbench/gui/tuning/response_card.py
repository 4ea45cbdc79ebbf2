"""Responses to an excitation: flown rounds, the numbers of their steps, and the card.

The card shows the live response against its prediction, its limits and earlier responses.
"""

import math
from collections.abc import Mapping, Sequence

import numpy as np
from PyQt6.QtGui import QResizeEvent
from PyQt6.QtWidgets import QBoxLayout

from workbench.analysis.queries import RequestedStep
from workbench.analysis.replies import Predicted
from workbench.common.quantity import DisplayUnit
from workbench.control.controller_file import controller_or_default
from workbench.gui.charts.curve import COMMAND_COLOUR, CurveStyle
from workbench.gui.charts.static_plot import StaticPlot
from workbench.gui.labels import set_tip
from workbench.gui.layout import column, fill, hbox
from workbench.gui.tuning.card import CARD_SPACING_PX, TuningCard
from workbench.gui.tuning.designs import Designs
from workbench.gui.tuning.excitation_form import ExcitationChoice
from workbench.gui.tuning.limit_strip import LimitStrip, LimitUse
from workbench.gui.tuning.limits import (
    LOAD_LIMITS,
    LOAD_PEAKS,
    STEP_LIMITS,
    LimitsForm,
    LimitValues,
)
from workbench.gui.tuning.metric_row import (
    metric_rows,
    preparing_text,
    response_headline,
    step_limits_of,
)
from workbench.gui.tuning.number_row import NumberRow, RowState
from workbench.gui.tuning.number_table import NumberTable
from workbench.gui.tuning.response_history import (
    DecayTimeReader,
    ExcitationRound,
    FlownResponse,
    ResponseHistory,
)
from workbench.gui.tuning.round_trace import RoundTrace, take_trace
from workbench.gui.tuning.step_part import (
    EQUAL_TIME_TOLERANCE_S,
    StepPart,
    command_curve,
    shown_length,
    step_parts,
)
from workbench.gui.units import unit_for
from workbench.gui.workspace import Workspace
from workbench.live.view import LiveView
from workbench.scenario.axes import CommandAxis
from workbench.scenario.excitation import Excitation, Shape
from workbench.scenario.loads import EXCITED_AXES, Load, find_excited

RESPONSE_COLUMNS = ("flown", "predicted", "limit")
FLOWN_CURVE, PREDICTED_CURVE, AHEAD_CURVE, COMMAND_CURVE = "flown", "predicted", "ahead", "command"
EARLIER_STEPS = "earlier steps"
"""Name of the one entry of the legend for earlier responses."""
ROTOR_USE_UNIT = DisplayUnit("%", 100.0, 1)
MIN_DRAWING_PERIOD_S = 1.0 / 32.0
"""Least period of drawing the flight [s]."""
MAX_PREDICTED_STEP_S = 30.0
"""Longest predicted step [s]."""
MIN_TABLE_BESIDE_PX = 640
"""Width of the card from which the table is beside the curves [px]."""
HEADING_TOLERANCE_RAD = math.radians(1.0)
"""Smaller changes of the heading do not change the prediction [rad]."""


def _history_key(excitation: Excitation) -> tuple[str, bool]:
    """Return the key of an excitation's history: its axis, and whether it is a pulse."""
    return excitation.axis, excitation.shape is Shape.PULSE


class ResponseCard(TuningCard):
    """Shows the newest response along the selected axis, and its numbers.

    Args:
        workspace: signals of the flight, colours and units.
        limits: limits of a step.
        choice: selected excitation.
        designs: names of the gains that flew.
        decay_time: of the chosen step.

    Attributes:
        table: the numbers.
        plot: the curves.
        strip: use of the flight's limits.
    """

    def __init__(
        self,
        workspace: Workspace,
        limits: LimitValues,
        choice: ExcitationChoice,
        designs: Designs,
        decay_time: DecayTimeReader,
    ) -> None:
        super().__init__("Response")
        self._designs = designs
        self._workspace = workspace
        self._limits = limits
        self._choice = choice
        self._view = LiveView()
        self._gains: Mapping[str, float] = {}
        self._heading, self._round_begun = 0.0, math.nan
        self._histories = {
            (row.name, pulse): ResponseHistory(self._take, decay_time)
            for row in EXCITED_AXES
            for pulse in (False, True)
        }
        self._predicted: Predicted | None = None
        self._predicted_step: RequestedStep | None = None
        self._refusal = self._preparing = ""
        self._ahead = np.empty(0), np.empty(0)
        self._drawn: tuple[object, ...] = ()
        self._still = False
        self._shown_at = -1.0
        self._shown_age = ""
        self.plot = StaticPlot(workspace)
        self.plot.set_hint("Press Start: the response appears here")
        self._ghosts_shown = 0
        self.strip = LimitStrip(workspace.look)
        self.form = LimitsForm(STEP_LIMITS, limits)
        self.load_form = LimitsForm((*LOAD_PEAKS.values(), *LOAD_LIMITS), limits)
        title, widest = "Numbers of the step", "Settling time"
        self.table = NumberTable(
            title, RESPONSE_COLUMNS, workspace.look, paired=False, widest=widest, worded=False
        )
        self.table.expect(len(STEP_LIMITS))
        fill(self.head, self.form.button, self.load_form.button)
        curves = column((self.plot, 1), self.strip, spacing=CARD_SPACING_PX)
        self._content = hbox((curves, 1), self.table, spacing=CARD_SPACING_PX)
        fill(self.body, (self._content, 1), self.form, self.load_form)
        limits.changed.connect(lambda _: self._show_numbers())
        workspace.preferences.changed.connect(lambda _: self._forget_drawn())
        self.plan(choice)

    def resizeEvent(self, event: QResizeEvent | None) -> None:
        """Place the table beside the curves if there is room, else below them."""
        super().resizeEvent(event)
        beside = self.width() >= MIN_TABLE_BESIDE_PX
        directions = QBoxLayout.Direction
        self._content.setDirection(directions.LeftToRight if beside else directions.TopToBottom)

    @property
    def history(self) -> ResponseHistory:
        """Responses along the selected axis."""
        return self._histories[_history_key(self._choice.excitation)]

    @property
    def part(self) -> StepPart | None:
        """The step that is compared with its prediction; none for a chirp."""
        parts = self._parts()
        return parts[0] if parts else None

    @property
    def step(self) -> RequestedStep | None:
        """The step to predict; None for a chirp."""
        part = self.part
        if part is None:
            return None
        axis, duration = self._choice.axis, min(part.duration, MAX_PREDICTED_STEP_S)
        if not isinstance(find_excited(axis), Load):
            return RequestedStep(axis, part.jump, duration, self._heading)
        flown = self.history.round
        excitation = flown.excitation if flown is not None else self._choice.excitation
        acts = excitation.period if excitation.shape is Shape.PULSE else None
        return RequestedStep(axis, part.jump, duration, self._heading, acts)

    def begin(self, view: LiveView) -> None:
        """Clear the last flight's responses."""
        self._view = view
        for history in self._histories.values():
            history.clear()
        self._predicted, self._refusal, self._preparing = None, "", ""
        self._ahead = np.empty(0), np.empty(0)
        self._forget_drawn()
        self.plan(self._choice)

    def plan(self, choice: ExcitationChoice) -> None:
        """Show the responses along another axis, or the command of another shape."""
        self._choice = choice
        loaded = isinstance(find_excited(choice.axis), Load)
        for form, wanted in ((self.form, not loaded), (self.load_form, loaded)):
            form.button.setVisible(wanted)
            form.setVisible(wanted and form.button.isChecked())
        self._forget_drawn()
        self._draw(self._workspace.signals.now)

    def show_view(self, view: LiveView, gains: Mapping[str, float]) -> None:
        """Show a view.

        Args:
            view: view of the flight.
            gains: gains that fly.
        """
        self._view, self._gains = view, gains
        self._take_heading(view)
        now = self._workspace.signals.now
        exciting = view.exciting
        if exciting is not None and exciting.round == 0:  # it comes to rest first
            exciting = None
        if exciting is not None:
            self._histories[_history_key(exciting.excitation)].begin(exciting, gains)
        for place, history in self._histories.items():
            if exciting is None or _history_key(exciting.excitation) != place:
                history.end(now)
        self._draw(now)

    def show_predicted(self, step: RequestedStep, predicted: Predicted) -> None:
        """Show the response to a step that is predicted with the proposed gains."""
        self._predicted, self._refusal, self._preparing = predicted, "", ""
        self._predicted_step = step
        self._show_prediction()
        self._show_numbers()

    def refuse_predicted(self, said: str) -> None:
        """Show why there is no prediction with the proposed gains; remove the last one."""
        self._predicted, self._refusal, self._preparing = None, said, ""
        self._show_prediction()
        self._show_numbers()

    def show_preparing(self, said: str) -> None:
        """Show what a prediction waits for, as compiling."""
        self._preparing = said
        self._show_numbers()

    def show_ahead(self, time: np.ndarray, values: np.ndarray) -> None:
        """Show the future of the flight with the proposed gains.

        Args:
            time: simulated time (N) [s]; empty for none.
            values: (N) velocity [m/s] or yaw rate [rad/s] along the axis.
        """
        self._ahead = time, values
        self._show_ahead()

    def _show_ahead(self) -> None:
        flown = self.history.round
        time, values = self._ahead
        if flown is not None and self.history.is_running and len(time):
            seen = (time >= flown.begun) & (time <= flown.next_edge(float(time[0])))
            # one from before this round does not have its command
            seen &= time[0] >= flown.begun - EQUAL_TIME_TOLERANCE_S
            time, values = time[seen] - flown.begun, values[seen]
            if len(time):
                self.plot.set_curve(AHEAD_CURVE, time, values, CurveStyle.FAINT, 1)
                return
        self.plot.remove_curve(AHEAD_CURVE)

    def _take_heading(self, view: LiveView) -> None:
        """Predict with the heading at the start of a round, or before it with the present one."""
        begun = view.exciting.began if view.exciting is not None else math.nan
        if view.snapshot is None or begun == self._round_begun:
            return
        self._round_begun = begun
        heading = view.snapshot.roll_pitch_yaw[2]
        if abs(math.remainder(heading - self._heading, math.tau)) > HEADING_TOLERANCE_RAD:
            self._heading = heading

    def _parts(self) -> tuple[StepPart, ...]:
        flown = self.history.round
        return flown.parts if flown is not None else step_parts(self._choice.excitation)

    def _take(self, excitation: Excitation, begun: float, end: float) -> RoundTrace:
        assert self._view.vehicle is not None
        return take_trace(self._workspace.signals, excitation, self._view.vehicle, begun, end)

    def _forget_drawn(self) -> None:
        self._drawn, self._still, self._shown_at = (), False, -1.0

    def _draw(self, now: float) -> None:
        """Draw changes: the flown curve thirty times a second, the rest once a round."""
        history = self.history
        if history.age_text(now, self._gains) != self._shown_age:
            self._show_numbers()
        names = self._ghost_names(history.ghosts)
        rounds = (history.round, history.ghosts, names)
        if rounds != self._drawn or not self._drawn:
            self._drawn, self._still, self._shown_at = rounds, False, -1.0
            self._show_plan(history.round)
            self._show_ghosts(history.ghosts, names)
            self._show_ahead()
            self._show_prediction()
        early = history.is_running and 0.0 <= now - self._shown_at < MIN_DRAWING_PERIOD_S
        if self._still or early:
            return
        self._shown_at = now
        before = history.numbers, history.withheld
        trace = history.present(now)
        if trace is None:
            self.plot.remove_curve(FLOWN_CURVE)
        else:
            self.plot.set_curve(FLOWN_CURVE, trace.time, trace.response, CurveStyle.SOLID, 0)
        self._show_uses(trace)
        self._still = not history.is_running
        if (history.numbers, history.withheld) != before or self._still:
            self._show_numbers()
            self.strip.describe()

    def _ghost_names(self, ghosts: Sequence[FlownResponse]) -> tuple[str, ...]:
        rounds = [each.round for each in ghosts]
        return tuple(self._designs.flight_name(each.begun, each.gains) for each in rounds)

    def _show_plan(self, flown: ExcitationRound | None) -> None:
        """Show the command: of the last round, else of the next one."""
        plan = flown or ExcitationRound(self._choice.excitation, 0.0, {})
        shown, axis, length = plan.excitation, plan.excitation.row, shown_length(plan.excitation)
        self.plot.set_axes("time after the step", plan.response_name, axis.response_unit)
        self.plot.set_window(0.0, length)
        if isinstance(axis, Load):  # the command is to hold
            asked = np.array([0.0, length]), np.zeros(2)
        else:
            asked = command_curve(shown, again=plan.again)
        self.plot.set_curve(COMMAND_CURVE, *asked, CurveStyle.SOLID, COMMAND_COLOUR)

    def _show_ghosts(self, ghosts: Sequence[FlownResponse], names: Sequence[str]) -> None:
        """Show earlier responses, the newest first, with their gains in a tool tip."""
        if len(ghosts) > self._ghosts_shown:  # they are below the present response
            for name in (FLOWN_CURVE, PREDICTED_CURVE, AHEAD_CURVE):
                self.plot.remove_curve(name)
        self._ghosts_shown = len(ghosts)
        for name in self.plot.names:
            if name not in (*names, COMMAND_CURVE, FLOWN_CURVE, PREDICTED_CURVE, AHEAD_CURVE):
                self.plot.remove_curve(name)
        said = []
        for name, ghost in zip(names, ghosts, strict=True):
            trace = ghost.trace
            look = CurveStyle.FAINT, COMMAND_COLOUR, EARLIER_STEPS
            self.plot.set_curve(name, trace.time, trace.response, *look)
            withheld = ghost.numbers.withheld if ghost.numbers is not None else ""
            lines = (name, *self._designs.gains_list(ghost.round.gains), withheld)
            said.append("\n    ".join(filter(None, lines)))
        set_tip(self.plot.legend, "\n".join(said))

    @property
    def _fitting(self) -> Predicted | None:
        """The prediction, if it belongs to the shown step."""
        return self._predicted if self._predicted_step == self.step else None

    def _show_prediction(self) -> None:
        found, part = self._fitting, self.part
        if found is None or part is None or found.lost:
            self.plot.remove_curve(PREDICTED_CURVE)
            return
        time = found.time + part.begin
        loaded = isinstance(find_excited(self._choice.axis), Load)
        before = 0.0 if loaded else part.before
        self.plot.set_curve(PREDICTED_CURVE, time, found.response + before, CurveStyle.DASHED, 1)

    def _show_uses(self, trace: RoundTrace | None) -> None:
        flown = self.history.round
        if trace is None or flown is None:
            self.strip.show_uses((), 1.0)
            return
        trace = trace.part(0.0, shown_length(flown.excitation))
        axis = find_excited(self._choice.axis)
        table = controller_or_default(self._view.controller).table
        values = {**table.defaults(), **self._view.values, **self._gains}
        preferences, time = self._workspace.preferences, trace.time
        uses = [
            LimitUse("tilt", time, trace.tilt, values["max_tilt"], unit_for("rad", preferences)),
            LimitUse("rotor use", time, trace.rotor_use, 1.0, ROTOR_USE_UNIT),
        ]
        if isinstance(axis, CommandAxis):
            speed = "yaw rate" if axis.turns else "speed"
            unit = unit_for(axis.unit, preferences)
            uses.append(LimitUse(speed, time, trace.response, values[axis.limit], unit))
        self.strip.show_uses(uses, shown_length(flown.excitation))

    def _show_numbers(self) -> None:
        self._shown_age = self.history.age_text(self._workspace.signals.now, self._gains)
        predicted = self._fitting.numbers if self._fitting is not None else None
        limits = step_limits_of(find_excited(self._choice.axis))
        rows = metric_rows(self.history.numbers, predicted, self._limits.value, limits)
        self.table.set_rows(rows)
        self.said.say(*self._sentence(rows))

    def _sentence(self, rows: tuple[NumberRow, ...]) -> tuple[str, str]:
        if self.step is None:
            return "A chirp has no step to measure.", "muted"
        if self._predicted is not None and self._predicted.lost:
            return "The drone crashes with the proposed gains.", "bad"
        history, age = self.history, self._shown_age
        if history.numbers is not None and history.numbers.withheld:
            return f"Numbers shown as – are withheld: {history.withheld}.", "warning"
        if history.withheld:
            return f"Numbers of {age}; newer ones are withheld: {history.withheld}.", "warning"
        if self._refusal:
            return f"No prediction: {self._refusal}", "warning"
        preparing = preparing_text(self._preparing) if self._preparing else ""
        over = any(cell.state is RowState.OVER for row in rows for cell in row.cells)
        return response_headline(rows, age, preparing), "warning" if over else "muted"
