"""The card of frequency: one loop as Bode, Nyquist, gang of four, and phase budget."""

import math
from collections.abc import Mapping

import numpy as np
from PyQt6.QtCore import QObject, pyqtSignal
from PyQt6.QtWidgets import (
    QSizePolicy,
)

from workbench.analysis.questions import DrawFrequency, PlanMeasurement, Question
from workbench.control.controller import CUTS
from workbench.control.mode import FlightMode
from workbench.design.judge.gang_of_four import GangOfFour
from workbench.design.judge.measured_loop import measured_loop
from workbench.gui.analysis import Analysis, Follower
from workbench.gui.charts.legend import Entry, Legend
from workbench.gui.charts.ticks import number_text
from workbench.gui.labels import set_tip
from workbench.gui.layout import button, choice, column, fill, hbox, scrolled
from workbench.gui.tuning.card import SPACING, Card, Sentence, offer
from workbench.gui.tuning.designs import FLOWN, KEPT, PROPOSED
from workbench.gui.tuning.drawn_loop import (
    MEASURED,
    STROKES,
    DrawnLoop,
    counting,
    drawn_curves,
    drawn_measurement,
    peak,
)
from workbench.gui.tuning.excitation_card import BUSY, GROUNDED
from workbench.gui.tuning.judgement import Judgement
from workbench.gui.tuning.limits import Limits, find_limit
from workbench.gui.tuning.loop_plots import (
    FOUR,
    LOWEST,
    BodePlots,
    GangPlots,
    NyquistPlot,
    PhaseView,
)
from workbench.gui.tuning.loop_shaping import LoopShaping
from workbench.gui.tuning.margins_card import loop_label, weakest_loop
from workbench.gui.tuning.trial import Trial
from workbench.gui.workspace import Workspace
from workbench.live.view import LiveView
from workbench.scenario.scenario import Injection
from workbench.session.injected import Injected

MEASURE_HELP = (
    "Add a multisine to this loop of the flight, and draw what it measures beside the model: with "
    "the gains that fly, in some {seconds:.0f} s of flight"
)
USUAL = 100.0
"""Usual duration of a measurement [s]: eight periods of 0.5 rad/s."""
Gains = Mapping[str, float]
Key = tuple[str, str, tuple[tuple[str, float], ...]]
VIEWS = ("Bode", "Nyquist", "Gang of four", "Phase")
WEAKEST = "weakest"
"""Stands for the loop with the smallest margins."""
BELOW, ABOVE = 50.0, 30.0
"""Factors from the crossover to the lowest and the highest shown frequency."""
HELP = {
    "Bode": "L is the open loop. Where its magnitude is 0 dB, the phase above −180° is the phase "
    "margin; where its phase is −180°, the magnitude below 0 dB is the gain margin.",
    "Nyquist": "L in the complex plane. The farther it stays from −1, the more robust the loop is; "
    "the red circle is the disk that it stays out of, by its disk margin.",
    "Gang of four": "S: from command to error. T: from command, and noise, to response. KS: from "
    "noise on the error to the actuator. GS: from a load at the actuator to the response.",
    "Phase": "What turned the phase of every loop at its crossover: the law, and all that follows "
    "it.",
}


class LoopCurves(QObject):
    """Asks for the curves of a loop, one question at a time; proposed gains have priority.

    Args:
        analysis: answers the questions.
        parent: the Qt parent; this object is deleted with it.

    Attributes:
        loop: name of the loop, "" before one is selected.
        cut: where the loop is opened: actuator or error.
        said: why there is no answer, "" without an error.
    """

    changed = pyqtSignal()
    """The known answers changed."""

    def __init__(self, analysis: Analysis, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._analysis = analysis
        self._follower = Follower(analysis, DrawFrequency, self)
        analysis.answered.connect(self._hear)
        self._follower.refused.connect(self._hear_refusal)
        self.loop, self.cut = "", "actuator"
        self._sets: dict[str, Gains] = {}
        self.clear()

    def clear(self) -> None:
        """Clear all: another flight begins."""
        self._newest: GangOfFour | None = None
        self.said = ""
        self._follower.forget()

    def set_seen(self, seen: bool) -> None:
        """Ask only while the card is visible."""
        self._follower.set_seen(seen)

    def choose(self, loop: str, cut: str) -> None:
        """Ask about another loop, or another cut."""
        if (loop, cut) != (self.loop, self.cut):
            self.loop, self.cut = loop, cut
            self._newest, self.said = None, ""
            self._ask()
            self.changed.emit()

    def follow(self, sets: Mapping[str, Gains]) -> None:
        """Ask about these gains from now on: proposed, flown and kept ones, by these names."""
        changed = dict(sets) != self._sets
        self._sets = dict(sets)
        self._ask()
        if changed:
            self.changed.emit()

    @property
    def shown(self) -> dict[str, GangOfFour]:
        """Known curves of each set, by name; a set equal to another one is left out.

        While gains change faster than answers arrive, the newest answer represents the proposed
        ones.
        """
        found: dict[str, GangOfFour] = {}
        seen: list[DrawFrequency] = []
        for name in (FLOWN, PROPOSED, KEPT):
            question = self._question(name)
            known = self._analysis.known(question)
            if known is None and name == PROPOSED:
                known = self._newest
            if known is not None and question not in seen:
                found[name] = known
                seen.append(question)
        return found

    def _ask(self) -> None:
        names = (PROPOSED, FLOWN, KEPT) if self.loop else ()
        self._follower.ask(*(self._question(name) for name in names if self._sets.get(name)))

    def _question(self, name: str) -> DrawFrequency:
        return DrawFrequency(self._sets.get(name, {}), self.loop, self.cut)

    def _hear(self, asked: Question, drawn: GangOfFour) -> None:
        if not isinstance(asked, DrawFrequency):
            return
        changes = asked not in (self._question(FLOWN), self._question(KEPT))  # with a slider
        if changes and (asked.loop, asked.cut) == (self.loop, self.cut):
            self._newest = drawn
        self.said = ""
        self.changed.emit()

    def _hear_refusal(self, said: str) -> None:
        self.said = said
        self.changed.emit()


class LoopMeasuring(QObject):
    """Asks for an injection, flies it, and keeps the measurement with the gains that flew.

    Args:
        workspace: its flight is measured, and its analyst plans the injection.
        parent: the Qt parent; this object is deleted with it.

    Attributes:
        button: starts and ends a measurement.
        said: progress, "" without a measurement.
    """

    changed = pyqtSignal()
    """A measurement was made, or has progressed."""

    def __init__(self, workspace: Workspace, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._flight, self._analysis = workspace.flight, workspace.analysis
        self._notices = workspace.notices
        self.button = button(
            "Measure", self._press, kind="compact", help=MEASURE_HELP.format(seconds=USUAL)
        )
        self.said = ""
        self._analysis.answered.connect(self._fly)
        self._analysis.refused.connect(self._hear_refusal)
        self._wanted: tuple[str, str, Gains] = ("", "", {})
        self.begin()

    def begin(self) -> None:
        """Clear the last flight's measurements."""
        self._measured: dict[Key, DrawnLoop] = {}
        self._asked: PlanMeasurement | None = None
        self._flown: tuple[str, str, Gains] | None = None
        self._seen: Injected | None = None
        self._share: float | None = None
        self._say("")

    def choose(self, loop: str, cut: str, gains: Gains) -> None:
        """Select the loop to measure next, with the gains that fly."""
        self._wanted = loop, cut, gains
        self._show_button()

    def known(self, loop: str, cut: str, gains: Gains) -> DrawnLoop | None:
        """Return the measurement of a loop with these gains, None without one."""
        return self._measured.get(_key(loop, cut, gains))

    def keep(self, loop: str, cut: str, gains: Gains, drawn: DrawnLoop) -> None:
        """Keep a measurement."""
        self._measured[_key(loop, cut, gains)] = drawn
        self.changed.emit()

    def show_view(self, view: LiveView) -> None:
        """Show the progress of a measurement, and its result so far."""
        before, self._share = self._share, view.measuring
        measured = view.measured
        if measured is not None and measured is not self._seen and self._flown is not None:
            self._seen = measured
            found = measured_loop(measured)
            drawn = drawn_measurement(
                found.frequency, found.response, found.coherence, found.deviation
            )
            self.keep(*self._flown, drawn)
        if self._share is not None and self._flown is not None:
            # reported in whole percent, it changes a hundred times, not sixty times a second
            name = loop_label(self._flown[0])
            self._say(f"Measuring {name}: {100.0 * self._share:.0f} %")
        elif before is not None:
            self._say("")
        self._show_button()

    @property
    def _busy(self) -> bool:
        return self._share is not None or self._asked is not None

    def _press(self) -> None:
        if self._share is not None:
            self._flight.order(lambda live: live.stop_exciting())
            return
        loop, cut, gains = self._wanted
        self._asked = PlanMeasurement(gains, loop, cut)
        self._say("Finding a size that the loop can take …")
        self._analysis.ask(self._asked)

    def _fly(self, question: Question, planned: tuple[Injection, bool]) -> None:
        if not isinstance(question, PlanMeasurement) or question != self._asked:
            return
        self._asked = None
        self._flown = question.loop, question.cut, question.gains
        self._seen = self._flight.view.measured  # of the last measurement
        self._say("")
        injection, hold = planned
        self._flight.order(lambda live: live.measure(injection, hold=hold), refused=self._refuse)

    def _hear_refusal(self, question: Question, said: str) -> None:
        if isinstance(question, PlanMeasurement) and question == self._asked:
            self._asked = None
            self._say("")

    def _refuse(self, said: str) -> None:
        self._notices.warn(said)
        self._say("")

    def _say(self, said: str) -> None:
        if said != self.said:
            self.said = said
            self.changed.emit()
        self._show_button()

    def _show_button(self) -> None:
        view = self._flight.view
        mode = view.snapshot.mode if view.snapshot is not None else FlightMode.OFF
        flies = mode not in (*GROUNDED, *BUSY)
        stops = self._share is not None
        text = "Stop" if stops else "Measure"
        if self.button.text() != text:
            self.button.setText(text)
        self.button.setEnabled(stops or (flies and bool(self._wanted[0]) and not self._busy))


def _key(loop: str, cut: str, gains: Gains) -> Key:
    return loop, cut, tuple(sorted(gains.items()))


class FrequencyCard(Card):
    """Frequency response of a loop, with proposed, flown and kept gains.

    Args:
        workspace: colours and analysis.
        trial: the gains that are being tried.
        judgement: stability of all loops.
        limits: limits that determine the weakest loop.

    Attributes:
        curves: known curves of the loop.
        measuring: measures the loop in flight.
        shaping: changes the loop's gains together.
        loops: selects the loop.
        cuts: selects where it is opened.
        bode, nyquist, gang, phase: the views.
        legend: names of the curves.
        reading: values at the cursor.
    """

    def __init__(
        self, workspace: Workspace, trial: Trial, judgement: Judgement, limits: Limits
    ) -> None:
        super().__init__("Frequency")
        self._look = workspace.look
        self._trial, self._judgement, self._limits = trial, judgement, limits
        self._cursor: float | None = None
        self._drawn: tuple[DrawnLoop, ...] = ()
        self._framed = ("", "")
        self._hidden: set[str] = set()
        self._seen = False
        self.curves = LoopCurves(workspace.analysis, self)
        self.measuring = LoopMeasuring(workspace, self)
        self.views = choice("What is drawn", VIEWS)
        self.loops = choice("Loop")
        self.cuts = choice("Where the loop is opened", CUTS)
        self.bode, self.nyquist = BodePlots(workspace), NyquistPlot(workspace)
        self.gang, self.phase = GangPlots(workspace), PhaseView(workspace, judgement, limits)
        self.shaping = LoopShaping(workspace, trial, judgement)
        self.legend = Legend(workspace.look)
        policy = self.legend.sizePolicy()
        policy.setHeightForWidth(True)
        self.legend.setSizePolicy(policy)
        self.reading = Sentence()
        # no stack, which would be as tall as its tallest page
        self._pages = (self.bode, self.nyquist, scrolled(self.gang), self.phase)
        for page in self._pages:  # it has the room that there is, down to its least height
            page.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Ignored)
            tall = page.minimumSizeHint().height() if page is self.phase else LOWEST
            page.setMinimumHeight(tall)
        self.progress = Sentence()
        parts = column(
            self.legend,
            *((page, 1) for page in self._pages),
            hbox((self.reading, 1), self.measuring.button),
            self.shaping,
            spacing=SPACING // 2,
        )
        row = hbox(self.views, self.loops, self.cuts, (self.progress, 1))
        # scrolled in a low window: plots and sliders need 260 px
        fill(self.body, row, (scrolled(parts), 1))
        self.views.currentIndexChanged.connect(lambda _: self._turn_to_view())
        self.loops.activated.connect(lambda _: self.choose_loop(self.loops.currentData()))
        self.cuts.activated.connect(lambda _: self._choose())
        self.legend.toggled.connect(self._toggle)
        for view in self._drawing:
            view.pointed.connect(self.set_cursor)
        self.curves.changed.connect(self._show)
        self.measuring.changed.connect(self._show)
        self.shaping.told.connect(self._read)
        self.phase.changed.connect(self._say)
        trial.gains.state_changed.connect(self.follow)  # as for kept gains
        judgement.changed.connect(self._hear_judgement)
        workspace.look.changed.connect(self._show)
        self._turn_to_view()

    def begin(self) -> None:
        """Clear the last flight."""
        self.curves.clear()
        self.loops.clear()
        self.measuring.begin()
        self.shaping.begin()
        self.curves.choose("", self.cuts.currentText())
        self._framed = ("", "")
        self._show()

    def follow(self) -> None:
        """Draw the present proposed, flown and kept gains."""
        trial = self._trial
        self.curves.follow(
            {PROPOSED: trial.judged, FLOWN: trial.judged_flown, KEPT: trial.judged_kept}
        )

    def set_seen(self, seen: bool) -> None:
        """Ask only while the card is visible."""
        self._seen = seen
        self.curves.set_seen(seen and self._view != "Phase")
        self.shaping.set_seen(seen and self._view != "Phase")
        if seen:
            self._show()

    def show_view(self, name: str) -> None:
        """Show Bode, Nyquist, Gang of four or Phase."""
        self.views.setCurrentText(name)

    def choose_loop(self, name: str) -> None:
        """Show a loop by its name, or the weakest one."""
        place = self.loops.findData(self._weakest() if name == WEAKEST else name)
        if place >= 0:
            self.loops.setCurrentIndex(place)
            self._choose()

    def set_cursor(self, frequency: float | None) -> None:
        """Set the cursor of all views to a frequency [rad/s], or remove it."""
        self._cursor = frequency
        for view in self._drawing:
            view.set_cursor(frequency)
        self._read()

    @property
    def _view(self) -> str:
        return self.views.currentText()

    @property
    def _drawing(self) -> tuple[BodePlots, NyquistPlot, GangPlots]:
        """The views that draw one loop, in the order of `VIEWS`."""
        return self.bode, self.nyquist, self.gang

    def _choose(self) -> None:
        loop = self.loops.currentData()
        self.curves.choose(loop if loop != WEAKEST else "", self.cuts.currentText())

    def _weakest(self) -> str:
        judged = self._judgement.proposed
        found = weakest_loop(judged, self._limits.value) if judged is not None else None
        return found.name if found is not None else ""

    def _hear_judgement(self) -> None:
        """Offer the existing loops; the weakest one is shown until one is selected."""
        judged = self._judgement.proposed
        if judged is None or not judged.loops:
            self._say()  # why there is none
            return
        names = (WEAKEST, *(each.name for each in judged.loops))
        if offer(self.loops, {name: loop_label(name) for name in names}):
            self.choose_loop(WEAKEST)

    def _turn_to_view(self) -> None:
        name = self._view
        for index, page in enumerate(self._pages):
            page.setVisible(index == self.views.currentIndex())
            set_tip(page, HELP[name])
        of_a_loop = (self.loops, self.cuts, self.legend, self.reading, self.shaping)
        for part in (*of_a_loop, self.measuring.button):
            part.setVisible(name != "Phase")
        self.set_seen(self._seen)
        self._show()

    def _show(self) -> None:
        """Draw the known curves in the visible view."""
        drawn = {name: drawn_curves(name, each) for name, each in self.curves.shown.items()}
        chosen = self.curves.loop, self.curves.cut, self._trial.judged_flown
        self.measuring.choose(*chosen)
        self.shaping.choose(self.curves.loop)
        self.progress.say(self.measuring.said, "good")
        measured = self.measuring.known(*chosen)
        if measured is not None:
            drawn[MEASURED] = measured
        self._drawn = tuple(drawn[name] for name in STROKES if name in drawn)
        self._say()
        self._show_legend()
        if not self._seen or self._view == "Phase":
            return
        if self._view == "Gang of four" and self.curves.shown:
            any_of = next(iter(self.curves.shown.values()))
            self.gang.name_units(any_of.control_per_error, any_of.error_per_control)
        seen = [each for each in self._drawn if each.name not in self._hidden]
        self._drawing[VIEWS.index(self._view)].show_loops(seen)
        self._frame()

    def _frame(self) -> None:
        """Show the frequencies around the crossover of a newly shown loop."""
        chosen = self.curves.loop, self.curves.cut
        loop = counting(self._drawn)
        if chosen == self._framed or loop is None:
            return
        self._framed = chosen
        top = float(loop.frequency[-1])
        middle = loop.crossover if math.isfinite(loop.crossover) else 0.05 * top
        left = max(float(loop.frequency[0]), middle / BELOW)
        for view in self._drawing:
            view.show_window(left, min(top, middle * ABOVE))

    def _say(self) -> None:
        shown = self.curves.shown
        now = shown.get(PROPOSED, shown.get(FLOWN))
        if self._view == "Phase":
            self.said.say(*self.phase.headline)
        elif self.curves.said:
            self.said.say(f"Not known: {self.curves.said}", "warning")
        elif now is None:
            self.said.say(self._judgement.said or "Not known yet: the analyst is computing it.")
        elif not now.margins.stable:
            self.said.say("The closed loop is unstable with these gains.", "bad")
        else:
            margins = now.margins
            phase, gain = find_limit("phase_margin"), find_limit("gain_margin")
            _, top = peak(now.frequency, now.sensitivity)
            self.said.say(
                f"{phase.text(margins.phase_margin)}° at {margins.crossover:.3g} rad/s, "
                f"{gain.text(margins.gain_margin)} dB, Ms {top:.2f}"
            )

    def _show_legend(self) -> None:
        """Write the names."""
        entries = []
        for number, loop in enumerate(self._drawn, 1):
            colour = self._look.curve(loop.colour)
            visible = loop.name not in self._hidden
            told = number if len(self._drawn) > 1 else 0
            entries.append(Entry(loop.name, "", colour, loop.style, told, visible))
        self.legend.show_entries(entries)
        self._read()

    def _read(self) -> None:
        """Show each loop's magnitude and phase at the cursor, in the order of the legend."""
        if self._cursor is None:
            words = self.shaping.said or "Point at a curve to read it; the wheel zooms"
            self.reading.say(words, self.shaping.tone or "muted")
            return
        loop = counting(self._drawn)
        if self._view == "Gang of four" and loop is not None:
            said = [f"{name} {abs(loop.at(self._cursor, of(loop))):.3g}" for name, _, of in FOUR]
        else:
            said = [_size_and_phase(each.at(self._cursor, each.open_loop)) for each in self._drawn]
        at = "" if self._view == "Gang of four" else "L at "
        self.reading.say("  ".join([f"{at}{self._cursor:.3g} rad/s:", *said]))

    def _toggle(self, index: int) -> None:
        """Hide or show a curve."""
        self._hidden ^= {self._drawn[index].name}
        self._show()


def _size_and_phase(value: complex) -> str:
    """Return a response in dB and degrees, from -270 to 90; a dash if unknown."""
    if not np.isfinite(value) or not value:
        return "–"
    turn = math.degrees(math.atan2(value.imag, value.real))
    turn -= 360.0 * (turn > 90.0)
    return f"{number_text(20.0 * math.log10(abs(value)), 1)} dB {number_text(turn, 0)}°"
