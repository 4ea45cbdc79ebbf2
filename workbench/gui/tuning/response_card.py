"""Responses to an excitation: flown rounds, the numbers of their steps, and the card.

The card shows the live response against its prediction, its limits and earlier responses.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from PyQt6.QtCore import QPointF, QRectF, QSize, Qt
from PyQt6.QtGui import QPainter, QPaintEvent, QPen, QPolygonF
from PyQt6.QtWidgets import QSizePolicy, QWidget
from pyqtgraph.functions import arrayToQPolygonF

from workbench.analysis.questions import Step
from workbench.analysis.replies import Predicted, StepNumbers, step_numbers
from workbench.design.response_metrics import load_metrics, step_metrics
from workbench.gui.charts.curve import COMMAND, CurveStyle
from workbench.gui.charts.plots import StaticPlot
from workbench.gui.icons import paint_picture
from workbench.gui.labels import set_tip
from workbench.gui.layout import fill
from workbench.gui.signals import Signals
from workbench.gui.theme import Look
from workbench.gui.tuning.card import Card
from workbench.gui.tuning.designs import Designs
from workbench.gui.tuning.excitation_form import ExcitationChoice
from workbench.gui.tuning.limits import (
    LOAD_LIMITS,
    LOAD_PEAKS,
    STEP_LIMITS,
    Limit,
    Limits,
    LimitsForm,
)
from workbench.gui.tuning.number_table import MARKS, TONES, Cell, NumberTable, Row, State
from workbench.gui.units import Unit, unit_for
from workbench.gui.workspace import Workspace
from workbench.live.view import LiveView
from workbench.plant.vehicle import Vehicle
from workbench.scenario.axes import Axis
from workbench.scenario.excitation import LATE, Excitation, Exciting, Shape
from workbench.scenario.loads import EXCITED, Load, find_excited
from workbench.scenario.parameters import parameter_table

STRIP_ROOM = 1.15
"""Upper edge of a chart, as a multiple of its limit."""
NEAR = 0.999
"""Share of a limit at which it counts as reached."""
STRIP_GAP = 12.0
STRIP_MARK = 8.0
HEAD = ("flown", "predicted", "limit")
CHIRP_POINTS = 400
"""Number of points of a chirp."""
FLOWN, PREDICTED, FUTURE, ASKED = "flown", "predicted", "ahead", "command"
PERCENT = Unit("%", 100.0)
FRAME = 1.0 / 32.0
"""Least period of drawing the flight [s]."""
LONGEST_STEP = 30.0
"""Longest predicted step [s]."""
TURNED = math.radians(1.0)
"""Smaller changes of the heading do not change the prediction [rad]."""
GHOSTS = 5
"""Number of kept earlier responses."""
SHORTEST = 0.1
"""Shortest kept response [s]."""
FEWEST = 8
"""Least number of samples of a step with numbers."""
SAME = 1e-6
"""Times that differ by less are equal [s]."""
SAMPLED = 1 / 128
"""Largest time between a round's last sample and its end [s]."""


@dataclass(frozen=True)
class Trace:
    """Flown signals from the edge of a round on; (N) each.

    Attributes:
        time: time from the edge on [s].
        response: velocity [m/s] or yaw rate [rad/s]; for a load the deviation from the original
            position.
        tilt: tilt [rad].
        rotor_use: largest share of its speed limit that any rotor has, at each time.
    """

    time: np.ndarray
    response: np.ndarray
    tilt: np.ndarray
    rotor_use: np.ndarray

    def __len__(self) -> int:
        return len(self.time)

    def until(self, end: float) -> "Trace":
        """Return the part up to and including a time [s]."""
        size = int(np.searchsorted(self.time, end + 1e-6))
        return self.between(0, size)

    def since(self, begin: float) -> "Trace":
        """Return the part from a time on, which becomes zero [s]."""
        first = int(np.searchsorted(self.time, begin - 1e-6))
        return self.between(first, len(self.time), begin)

    def between(self, first: int, last: int, zero: float = 0.0) -> "Trace":
        """Return the samples between two times, with times relative to `zero`."""
        part = slice(first, last)
        return Trace(
            self.time[part] - zero,
            self.response[part],
            self.tilt[part],
            self.rotor_use[part],
        )


def take_trace(
    signals: Signals, excitation: Excitation, vehicle: Vehicle, begun: float, end: float = np.inf
) -> Trace:
    """Return copies of the signals since the start of a round, or until its end.

    Args:
        signals: signals of the flight.
        excitation: the flown excitation.
        vehicle: the flown vehicle.
        begun: simulated time of the round's edge [s].
        end: simulated time of the end [s].
    """
    since = begun - 1e-6
    time, response = signals.series(excitation.row.signal, since)
    _, roll = signals.series("position_data.roll", since)
    _, pitch = signals.series("position_data.pitch", since)
    shares = [
        signals.series(f"rotors.speed.{index}", since)[1] / rotor.max_rot_velocity
        for index, rotor in enumerate(vehicle.rotors)
    ]
    last = int(np.searchsorted(time, end + 1e-6))
    # All of these come from one sample of the flight; a topic may briefly be one sample behind.
    size = min(last, len(roll), *(len(share) for share in shares))
    time, roll, pitch, response = time[:size], roll[:size], pitch[:size], response[:size]
    if isinstance(excitation.row, Load):
        response = response - response[:1]
    tilt = np.arccos(np.clip(np.cos(roll) * np.cos(pitch), -1.0, 1.0))
    use = np.max(np.abs([share[:size] for share in shares]), axis=0)
    return Trace(time - begun, response.copy(), tilt, use)


@dataclass(frozen=True)
class StepPart:
    """A step within a round, from one level of the command to another.

    Attributes:
        begin: time from the round's edge on [s].
        end: time at which the command changes again [s].
        before: previous level, in the unit of the excitation's amplitude.
        level: commanded level.
    """

    begin: float
    end: float
    before: float
    level: float

    @property
    def duration(self) -> float:
        """Duration of the commanded level [s]."""
        return self.end - self.begin

    @property
    def jump(self) -> float:
        """Change of the command."""
        return self.level - self.before


def step_parts(excitation: Excitation, *, again: bool = False) -> tuple[StepPart, ...]:
    """Return the steps of a round in order, except the return to rest; a chirp has none.

    Args:
        excitation: the flown excitation.
        again: whether an equal round was flown just before.
    """
    size, period = excitation.amplitude, excitation.period
    half = 0.5 * period
    match excitation.shape:
        case Shape.STEP:
            return (StepPart(0.0, period, 0.0, size),)
        case Shape.PULSE:  # the effect of a load ends when the drone is back
            over = excitation.round_time if isinstance(excitation.row, Load) else period
            return (StepPart(0.0, over, 0.0, size),)
        case Shape.DOUBLET:
            return (StepPart(0.0, half, 0.0, size), StepPart(half, period, size, -size))
        case Shape.SQUARE:
            first = StepPart(0.0, half, -size if again else 0.0, size)
            return (first, StepPart(half, period, size, -size))
        case Shape.CHIRP:
            return ()


def measure_step(
    trace: Trace, part: StepPart, *, decay: float = 0.0, changed: bool = False
) -> StepNumbers | None:
    """Return the numbers of a step; None before its end, or if it is too short.

    Args:
        trace: signals of the round, from its edge on.
        part: the step in it.
        decay: time by which its transient has decayed [s], 0 if unknown; see `step_metrics`.
        changed: whether gains changed during it.
    """
    if not len(trace) or trace.time[-1] < part.end - SAME:
        return None
    flown = trace.until(part.end).since(part.begin)
    if len(flown) < FEWEST or part.jump == 0.0:
        return None
    rise = flown.response - part.before
    found = step_metrics(flown.time, rise, part.jump, decay=decay, changed=changed)
    return step_numbers(found, float(flown.rotor_use.max()))


def measure_load(trace: Trace, part: StepPart, *, changed: bool = False) -> StepNumbers | None:
    """Return the numbers of a step of a load; None before its end, or if it is too short.

    Args: as for `measure_step`.
    """
    if not len(trace) or trace.time[-1] < part.end - SAMPLED:
        return None
    flown = trace.until(part.end).since(part.begin)
    if len(flown) < FEWEST or part.jump == 0.0:
        return None
    found = load_metrics(flown.time, flown.response - flown.response[0], changed=changed)
    return step_numbers(found, float(flown.rotor_use.max()))


Take = Callable[[Excitation, float, float], Trace]
"""Returns the signals of an excitation between two simulated times [s]."""
DecayTime = Callable[[], float]
"""Returns the time by which the transient of the chosen step decays with the gains that fly [s]."""


@dataclass(frozen=True)
class Round:
    """One round of an excitation.

    Attributes:
        excitation: the flown excitation.
        begun: simulated time of its edge [s].
        gains: gains that fly it.
        again: whether an equal round preceded it without a gap.
    """

    excitation: Excitation
    begun: float
    gains: Mapping[str, float]
    again: bool = False

    @property
    def end(self) -> float:
        """Simulated time of its end [s]."""
        return self.begun + self.excitation.round_time

    def next_edge(self, time: float) -> float:
        """Return the time of the command's next jump after a time, or of the round's end [s]."""
        edges = (self.begun + edge for edge in self.excitation.edges)
        return min((edge for edge in edges if edge > time + LATE), default=self.end)

    @property
    def parts(self) -> tuple[StepPart, ...]:
        """The steps in it."""
        return step_parts(self.excitation, again=self.again)


@dataclass(frozen=True)
class Response:
    """A flown round.

    Attributes:
        round: the round.
        trace: flown signals.
        numbers: numbers of its first step; None if it has none, or ended early.
    """

    round: Round
    trace: Trace
    numbers: StepNumbers | None


class ResponseHistory:
    """Divides a flight into responses.

    Args:
        take: returns signals of the flight.
        decay_time: of the step.

    Attributes:
        round: the present or last round; None before the first.
        numbers: numbers of the newest round with a completed first step, None before it.
        ghosts: earlier responses, the newest first.
        is_running: whether the newest round is in progress.
    """

    def __init__(self, take: Take, decay_time: DecayTime) -> None:
        self._take = take
        self._decay_time = decay_time
        self.clear()

    def clear(self) -> None:
        """Clear all: another flight begins."""
        self.round: Round | None = None
        self.numbers: StepNumbers | None = None
        self.ghosts: tuple[Response, ...] = ()
        self.is_running = False
        self._ended = 0.0
        self._measured = False
        self._changed = False

    def begin(self, exciting: Exciting, gains: Mapping[str, float]) -> None:
        """Record a round; the same one has no effect unless gains have changed.

        Args:
            exciting: the excitation and its start.
            gains: gains that fly it now.
        """
        before = self.round
        excitation, begun = exciting.excitation, exciting.began
        if before is not None and before.begun == begun and before.excitation == excitation:
            self._changed = self._changed or gains != before.gains
            return
        self._keep(min(begun, before.end) if before is not None else begun)
        self.round = Round(excitation, begun, dict(gains), exciting.again)
        self.is_running, self._measured, self._changed = True, False, False

    def end(self, now: float) -> None:
        """Record that the excitation has ended, at a simulated time [s]."""
        if self.is_running:
            self.is_running, self._ended = False, now

    def present(self, now: float) -> Trace | None:
        """Return the signals of the newest round until now [s], and measure completed steps."""
        if self.round is None:
            return None
        until = min(now, self.round.end) if self.is_running else min(self._ended, self.round.end)
        trace = self._take(self.round.excitation, self.round.begun, until)
        if not self._measured:
            numbers = self._measure(self.round, trace)
            if numbers is not None:
                self.numbers, self._measured = numbers, True
        return trace

    def _keep(self, end: float) -> None:
        """Make the newest round a ghost."""
        if self.round is None:
            return
        until = end if self.is_running else min(self._ended, self.round.end)
        trace = self._take(self.round.excitation, self.round.begun, until)
        if not len(trace) or trace.time[-1] < SHORTEST:
            return
        numbers = self.numbers if self._measured else self._measure(self.round, trace)
        kept = Response(self.round, trace, numbers)
        self.ghosts = (kept, *self.ghosts)[:GHOSTS]

    def _measure(self, flown: Round, trace: Trace) -> StepNumbers | None:
        """Return the numbers of a round's first step; the other steps are similar."""
        if not flown.parts:
            return None
        if isinstance(flown.excitation.row, Load):
            return measure_load(trace, flown.parts[0], changed=self._changed)
        decay = self._decay_time()
        return measure_step(trace, flown.parts[0], decay=decay, changed=self._changed)


@dataclass(frozen=True)
class Use:
    """Use of a limit over time.

    Attributes:
        label: name of the quantity.
        time: (N) time from the edge on [s].
        value: (N) values, in SI.
        limit: limit, in SI.
        unit: unit in which both are shown.
        decimals: number of shown decimals.
    """

    label: str
    time: np.ndarray
    value: np.ndarray
    limit: float
    unit: Unit
    decimals: int = 0

    @property
    def peak(self) -> float:
        """Largest magnitude so far; NaN before the first value."""
        return float(np.abs(self.value).max()) if len(self.value) else float("nan")

    @property
    def state(self) -> State:
        """Whether the limit was reached."""
        if not len(self.value):
            return State.NONE
        return State.OVER if self.peak >= NEAR * self.limit else State.GOOD

    @property
    def text(self) -> str:
        """Peak and limit in words."""
        plain = Unit("", self.unit.factor).text(self.peak, self.decimals)
        return f"{plain} of {self.unit.text(self.limit, self.decimals)}"


class LimitStrip(QWidget):
    """Charts side by side, each with its limit as a line and its peak as a number.

    Args:
        look: source of colours.

    Attributes:
        uses: the shown quantities.
    """

    def __init__(self, look: Look) -> None:
        super().__init__()
        self._look = look
        self.uses: tuple[Use, ...] = ()
        self._length = 1.0
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)
        self.setAccessibleName("Use of the flight's limits")
        look.changed.connect(self.update)

    def show_uses(self, uses: Sequence[Use], length: float) -> None:
        """Show quantities over a time [s]."""
        self.uses, self._length = tuple(uses), max(length, 1e-3)
        self.update()

    def describe(self) -> None:
        """Describe the charts in words: after a response, not with every frame."""
        self.setAccessibleDescription("; ".join(f"{use.label} {use.text}" for use in self.uses))

    def sizeHint(self) -> QSize:
        """Return the size of two lines of text and a chart."""
        return QSize(320, 2 * self.fontMetrics().height() + 22)

    def paintEvent(self, event: QPaintEvent | None) -> None:
        """Paint the charts."""
        if not self.uses:
            return
        painter = QPainter(self)
        width = (self.width() - STRIP_GAP * (len(self.uses) - 1)) / len(self.uses)
        for index, use in enumerate(self.uses):
            self._paint_use(
                painter, QRectF(index * (width + STRIP_GAP), 0.0, width, self.height()), use
            )

    def _paint_use(self, painter: QPainter, box: QRectF, use: Use) -> None:
        colour = self._look.colour
        line = float(self.fontMetrics().height())
        left = Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter
        painter.setPen(colour("muted"))
        painter.drawText(QRectF(box.left(), box.top(), box.width(), line), left, use.label)
        tone = colour("warning" if use.state is State.OVER else "ink")
        painter.setPen(tone)
        second = QRectF(box.left(), box.top() + line, box.width() - 2.0 * STRIP_MARK, line)
        painter.drawText(second, left, use.text)
        if use.state is not State.NONE:
            mark = QRectF(
                box.right() - STRIP_MARK,
                second.center().y() - STRIP_MARK / 2.0,
                STRIP_MARK,
                STRIP_MARK,
            )
            paint_picture(painter, mark, MARKS[use.state], colour(TONES[use.state]))
        chart = box.adjusted(0.0, 2.0 * line + 2.0, 0.0, -1.0)
        painter.fillRect(chart, colour("ground"))
        top = chart.bottom() - chart.height() / STRIP_ROOM
        painter.setPen(QPen(colour("warning"), 1, Qt.PenStyle.DashLine))
        painter.drawLine(QPointF(chart.left(), top), QPointF(chart.right(), top))
        if len(use.time) > 1:
            painter.setPen(QPen(tone, 1))
            painter.drawPolyline(self._line(chart, use))

    def _line(self, chart: QRectF, use: Use) -> QPolygonF:
        skip = max(1, len(use.time) // max(1, int(chart.width())))
        share = np.minimum(np.abs(use.value) / use.limit, STRIP_ROOM)
        # The largest of several samples, so that no peak is lost between two pixels.
        size = len(share) // skip * skip
        peaks = share[:size].reshape(-1, skip).max(axis=1)
        times = use.time[:size:skip] / self._length
        x = chart.left() + np.clip(times, 0.0, 1.0) * chart.width()
        y = chart.bottom() - peaks / STRIP_ROOM * chart.height()
        return arrayToQPolygonF(x, y)


def metric_rows(
    flown: StepNumbers | None,
    predicted: StepNumbers | None,
    limit_of: Callable[[str], float],
    limits: tuple[Limit, ...] = STEP_LIMITS,
) -> tuple[Row, ...]:
    """Return a row for each number of a step.

    Args:
        flown: numbers of the newest step, None before it.
        predicted: numbers with the proposed gains, None if unknown.
        limit_of: returns a limit by name, as shown.
        limits: limits of the numbers, in order.
    """
    return tuple(_row(limit, flown, predicted, limit_of(limit.name)) for limit in limits)


def limits_of(row: Axis | Load) -> tuple[Limit, ...]:
    """Return the limits for a step along an axis or of a load."""
    if isinstance(row, Load):
        return (LOAD_PEAKS[row.response_unit], *LOAD_LIMITS)
    return STEP_LIMITS


def _row(
    limit: Limit, flown: StepNumbers | None, predicted: StepNumbers | None, most: float
) -> Row:
    values = [
        limit.of(numbers) if numbers is not None else math.nan for numbers in (flown, predicted)
    ]
    over = [math.isfinite(value) and not limit.keeps(value, most) for value in values]
    reasons = [numbers.withheld if numbers is not None else "" for numbers in (flown, predicted)]
    cells = tuple(
        Cell(limit.text(value), over=beyond, help=why if math.isnan(value) and why else limit.help)
        for value, beyond, why in zip(values, over, reasons, strict=True)
    )
    unit = f" {limit.unit}" if limit.unit else ""
    state = State.NONE
    if flown is not None:
        if math.isnan(values[0]):
            state = State.NONE if flown.withheld else State.OVER
        else:
            state = State.OVER if over[0] else State.GOOD
    return Row(limit.label, (*cells, Cell(f"{limit.sign} {most:g}{unit}")), state)


def headline(rows: tuple[Row, ...]) -> str:
    """Return a summary of the rows, as a sentence."""
    if all(row.state is State.NONE for row in rows):
        return "No step was flown yet."
    over = [row.label.lower() for row in rows if row.state is State.OVER]
    if over:
        return f"Over the limit: {', '.join(over)}."
    if any(row.cells[1].over for row in rows):
        return "Only the prediction is over its limits."
    return "The step keeps all limits."


def _place(excitation: Excitation) -> tuple[str, bool]:
    """Return the key of an excitation's history: its axis, and whether it is a pulse."""
    return excitation.axis, excitation.shape is Shape.PULSE


def command_line(excitation: Excitation, *, again: bool = False) -> tuple[np.ndarray, np.ndarray]:
    """Return times from the edge on [s] and commanded values of a round.

    Args:
        excitation: the flown excitation.
        again: whether an equal round was flown just before.
    """
    length = excitation.round_time
    if excitation.shape is Shape.CHIRP:
        time = np.linspace(0.0, length, CHIRP_POINTS, endpoint=False)
        return time, np.array([excitation.command(float(each)) for each in time])
    times, values = [0.0], [0.0]
    parts = step_parts(excitation, again=again)
    values[0] = parts[0].before
    for part in parts:
        times += [part.begin, part.end]
        values += [part.level, part.level]
    if parts[-1].end < length:
        times += [parts[-1].end, length]
        values += [0.0, 0.0]
    return np.array(times), np.array(values)


class ResponseCard(Card):
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
        limits: Limits,
        choice: ExcitationChoice,
        designs: Designs,
        decay_time: DecayTime,
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
            for row in EXCITED
            for pulse in (False, True)
        }
        self._predicted: Predicted | None = None
        self._predicted_step: Step | None = None
        self._refusal = self._preparing = ""
        self._ahead = np.empty(0), np.empty(0)
        self._drawn: tuple[object, ...] = ()
        self._still = False
        self._shown_at = -1.0
        self.plot = StaticPlot(workspace)
        self.plot.set_hint("Press Start: the response appears here")
        self._ghosts_shown = 0
        self.strip = LimitStrip(workspace.look)
        self.form = LimitsForm(STEP_LIMITS, limits)
        self.load_form = LimitsForm((*LOAD_PEAKS.values(), *LOAD_LIMITS), limits)
        self.table = NumberTable(
            "Numbers of the step", HEAD, workspace.look, paired=False, widest="Settling time"
        )
        self.table.expect(len(STEP_LIMITS))
        fill(self.head, self.form.button, self.load_form.button)
        fill(self.body, (self.plot, 1), self.strip, self.form, self.load_form, self.table)
        limits.changed.connect(lambda _: self._show_numbers())
        workspace.preferences.changed.connect(lambda _: self._forget_drawn())
        self.plan(choice)

    @property
    def history(self) -> ResponseHistory:
        """Responses along the selected axis."""
        return self._histories[_place(self._choice.excitation)]

    @property
    def part(self) -> StepPart | None:
        """The step that is compared with its prediction; none for a chirp."""
        parts = self._parts()
        return parts[0] if parts else None

    @property
    def step(self) -> Step | None:
        """The step to predict; None for a chirp."""
        part = self.part
        if part is None:
            return None
        axis, duration = self._choice.axis, min(part.duration, LONGEST_STEP)
        if not isinstance(find_excited(axis), Load):
            return Step(axis, part.jump, duration, self._heading)
        flown = self.history.round
        excitation = flown.excitation if flown is not None else self._choice.excitation
        acts = excitation.period if excitation.shape is Shape.PULSE else None
        return Step(axis, part.jump, duration, self._heading, acts)

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
        if view.exciting is not None:
            self._histories[_place(view.exciting.excitation)].begin(view.exciting, gains)
        for place, history in self._histories.items():
            if view.exciting is None or _place(view.exciting.excitation) != place:
                history.end(now)
        self._draw(now)

    def show_predicted(self, step: Step, predicted: Predicted) -> None:
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
            seen &= time[0] >= flown.begun - SAME  # else it does not have this round's command
            time, values = time[seen] - flown.begun, values[seen]
            if len(time):
                self.plot.set_curve(FUTURE, time, values, CurveStyle.FAINT, 1)
                return
        self.plot.remove_curve(FUTURE)

    def _take_heading(self, view: LiveView) -> None:
        """Predict with the heading at the start of a round, or before it with the present one."""
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
        """Draw changes: the flown curve thirty times a second, the rest once a round."""
        history = self.history
        names = self._ghost_names(history.ghosts)
        rounds = (history.round, history.ghosts, names)
        if rounds != self._drawn or not self._drawn:
            self._drawn, self._still, self._shown_at = rounds, False, -1.0
            self._show_plan(history.round)
            self._show_ghosts(history.ghosts, names)
            self._show_ahead()
            self._show_prediction()
        if self._still or (history.is_running and 0.0 <= now - self._shown_at < FRAME):
            return
        self._shown_at = now
        before = history.numbers
        trace = history.present(now)
        if trace is None:
            self.plot.remove_curve(FLOWN)
        else:
            self.plot.set_curve(FLOWN, trace.time, trace.response, CurveStyle.SOLID, 0)
        self._show_uses(trace)
        self._still = not history.is_running
        if history.numbers is not before or self._still:
            self._show_numbers()
            self.strip.describe()

    def _ghost_names(self, ghosts: Sequence[Response]) -> tuple[str, ...]:
        return tuple(
            self._designs.flight_name(each.round.begun, each.round.gains) for each in ghosts
        )

    def _show_plan(self, flown: Round | None) -> None:
        """Show the command: of the last round, else of the next one."""
        shown = self._choice.excitation if flown is None else flown.excitation
        axis, length = shown.row, shown.round_time
        self.plot.set_axes("time after the step", axis.response, axis.response_unit)
        self.plot.set_window(0.0, length)
        if isinstance(axis, Load):  # the command is to hold
            asked = np.array([0.0, length]), np.zeros(2)
        else:
            asked = command_line(shown, again=flown is not None and flown.again)
        self.plot.set_curve(ASKED, *asked, CurveStyle.SOLID, COMMAND)

    def _show_ghosts(self, ghosts: Sequence[Response], names: Sequence[str]) -> None:
        """Show earlier responses, the newest first, with their gains in a tool tip."""
        if len(ghosts) > self._ghosts_shown:  # they are below the present response
            for name in (FLOWN, PREDICTED, FUTURE):
                self.plot.remove_curve(name)
        self._ghosts_shown = len(ghosts)
        for name in self.plot.names:
            if name not in (*names, ASKED, FLOWN, PREDICTED, FUTURE):
                self.plot.remove_curve(name)
        shown, said = self.plot.names, []
        for name, ghost in zip(names, ghosts, strict=True):
            if name not in shown:
                trace = ghost.trace
                self.plot.set_curve(name, trace.time, trace.response, CurveStyle.FAINT, COMMAND)
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
            self.plot.remove_curve(PREDICTED)
            return
        time = found.time + part.begin
        loaded = isinstance(find_excited(self._choice.axis), Load)
        before = 0.0 if loaded else part.before
        self.plot.set_curve(PREDICTED, time, found.response + before, CurveStyle.DASHED, 1)

    def _show_uses(self, trace: Trace | None) -> None:
        if trace is None:
            self.strip.show_uses((), 1.0)
            return
        axis = find_excited(self._choice.axis)
        table = parameter_table(self._view.controller)
        values = {**table.defaults(), **self._view.values, **self._gains}
        preferences = self._workspace.preferences
        uses = [
            Use("tilt", trace.time, trace.tilt, values["max_tilt"], unit_for("rad", preferences)),
            Use("rotor use", trace.time, trace.rotor_use, 1.0, PERCENT),
        ]
        if isinstance(axis, Axis):
            speed = "yaw rate" if axis.turns else "speed"
            unit = unit_for(axis.unit, preferences)
            uses.append(Use(speed, trace.time, trace.response, values[axis.limit], unit, 1))
        flown = self.history.round
        self.strip.show_uses(uses, flown.excitation.round_time if flown else 1.0)

    def _show_numbers(self) -> None:
        predicted = self._fitting.numbers if self._fitting is not None else None
        limits = limits_of(find_excited(self._choice.axis))
        rows = metric_rows(self.history.numbers, predicted, self._limits.value, limits)
        self.table.set_rows(rows)
        self.said.say(*self._sentence(rows))

    def _sentence(self, rows: tuple[Row, ...]) -> tuple[str, str]:
        if self.step is None:
            return "A chirp has no step to measure.", "muted"
        if self._predicted is not None and self._predicted.lost:
            return "With the proposed gains the drone would be lost.", "bad"
        if self._refusal:
            return f"No prediction: {self._refusal}", "warning"
        if self._preparing:
            return f"Predicting … {self._preparing}", "muted"
        flown = self.history.numbers
        if flown is not None and flown.withheld:
            return f"Numbers shown as – are withheld: {flown.withheld}.", "warning"
        over = any(row.state is State.OVER for row in rows)
        return headline(rows), "warning" if over else "muted"
