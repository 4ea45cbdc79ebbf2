"""The card of frequency: one loop as Bode, Nyquist, gang of four, and phase budget."""

import math
from operator import is_

import numpy as np
from PyQt6.QtWidgets import (
    QSizePolicy,
)

from workbench.common.quantity import number_text
from workbench.control.loop import LOOP_CUTS, loop_label
from workbench.gui.charts.legend import Legend, LegendEntry
from workbench.gui.labels import set_tip
from workbench.gui.layout import choice, column, fill, hbox, scrolled
from workbench.gui.tuning.bode_plots import BodePlots
from workbench.gui.tuning.card import CARD_SPACING_PX, ToneLabel, TuningCard, set_items
from workbench.gui.tuning.designs import FLOWN_SET, KEPT_SET, PROPOSED_SET
from workbench.gui.tuning.drawn_loop import (
    LOOP_STROKES,
    MEASURED_LOOP,
    DrawnLoop,
    drawn_curves,
    loop_with_margins,
    response_peak,
)
from workbench.gui.tuning.gang_plots import GANG_OF_FOUR, GangPlots
from workbench.gui.tuning.judgement import StabilityFollower, with_caveat
from workbench.gui.tuning.limits import LimitValues, find_limit
from workbench.gui.tuning.loop_curves import LoopCurves
from workbench.gui.tuning.loop_measuring import LoopMeasuring
from workbench.gui.tuning.loop_shaping import LoopShaping
from workbench.gui.tuning.margins_card import weakest_loop
from workbench.gui.tuning.nyquist_plot import NyquistPlot
from workbench.gui.tuning.phase_view import PhaseView
from workbench.gui.tuning.trial import TuningTrial
from workbench.gui.units import frequency_text
from workbench.gui.workspace import Workspace

LOOP_VIEWS = ("Bode", "Nyquist", "Gang of four", "Phase")
WEAKEST_LOOP_CHOICE = "weakest"
"""Stands for the loop with the smallest margins."""
FACTOR_BELOW_CROSSOVER, FACTOR_ABOVE_CROSSOVER = 50.0, 30.0
"""Factors from the crossover to the lowest and the highest shown frequency."""
LOOP_VIEW_HELP = {
    "Bode": "L is the open loop. Where its magnitude is 0 dB, the phase above −180° is the phase "
    "margin; where its phase is −180°, the magnitude below 0 dB is the gain margin.",
    "Nyquist": "L in the complex plane. The farther it stays from −1, the more robust the loop is; "
    "the red circle is the disk that it stays out of, by its disk margin.",
    "Gang of four": "S: from command to error. T: from command, and noise, to response. KS: from "
    "noise on the error to the actuator. GS: from a load at the actuator to the response.",
    "Phase": "What turned the phase of every loop at its crossover: the law, and all that follows "
    "it.",
}


class FrequencyCard(TuningCard):
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
        self,
        workspace: Workspace,
        trial: TuningTrial,
        judgement: StabilityFollower,
        limits: LimitValues,
    ) -> None:
        super().__init__("Frequency")
        self._look = workspace.look
        self._trial, self._judgement, self._limits = trial, judgement, limits
        self._cursor: float | None = None
        self._drawn: tuple[DrawnLoop, ...] = ()
        self._framed = ("", "")
        self._hidden: set[str] = set()
        self._content: tuple[object, ...] = ()
        self._sources: list[object] = []
        self._seen = False
        self.curves = LoopCurves(workspace.analysis, self)
        self.measuring = LoopMeasuring(workspace, self)
        self.views = choice("What is drawn", LOOP_VIEWS)
        self.loops = choice("Loop")
        self.cuts = choice("Where the loop is opened", LOOP_CUTS)
        self.bode, self.nyquist = BodePlots(workspace), NyquistPlot(workspace)
        self.gang, self.phase = GangPlots(workspace), PhaseView(workspace, judgement, limits)
        self.shaping = LoopShaping(workspace, trial, judgement, limits)
        self.legend = Legend(workspace.look)
        policy = self.legend.sizePolicy()
        policy.setHeightForWidth(True)
        self.legend.setSizePolicy(policy)
        self.reading = ToneLabel()
        # no stack, which would be as tall as its tallest page
        self._pages = (self.bode, self.nyquist, self.gang, self.phase)
        for page in self._pages:  # it has the room that there is, down to its least height
            page.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Ignored)
            page.setMinimumHeight(page.minimumSizeHint().height())
        self.progress = ToneLabel()
        parts = column(
            self.legend,
            *((page, 1) for page in self._pages),
            self.reading,
            self.shaping,
            spacing=CARD_SPACING_PX // 2,
        )
        row = hbox(self.views, self.loops, self.cuts, (self.progress, 1), self.measuring.button)
        # scrolled in a low window, as plots and sliders have a least height
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
        workspace.look.changed.connect(self._draw_again)
        self._turn_to_view()

    def begin(self) -> None:
        """Clear the last flight."""
        self.curves.clear()
        self.loops.clear()
        self.measuring.begin()
        self.shaping.begin()
        self.curves.choose("", self.cuts.currentText())
        self._framed = ("", "")
        self._draw_again()

    def follow(self) -> None:
        """Draw the present proposed, flown and kept gains."""
        trial = self._trial
        self.curves.follow(
            {PROPOSED_SET: trial.judged, FLOWN_SET: trial.judged_flown, KEPT_SET: trial.judged_kept}
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
        place = self.loops.findData(self._weakest() if name == WEAKEST_LOOP_CHOICE else name)
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
        """The views that draw one loop, in the order of `LOOP_VIEWS`."""
        return self.bode, self.nyquist, self.gang

    def _choose(self) -> None:
        loop = self.loops.currentData()
        self.curves.choose(loop if loop != WEAKEST_LOOP_CHOICE else "", self.cuts.currentText())

    def _weakest(self) -> str:
        judged = self._judgement.proposed
        found = weakest_loop(judged, self._limits.value) if judged is not None else None
        return found.name if found is not None else ""

    def _hear_judgement(self) -> None:
        """Offer the existing loops; the weakest one is shown until one is selected."""
        judged = self._judgement.proposed
        if judged is not None and judged.loops:
            names = (WEAKEST_LOOP_CHOICE, *(each.name for each in judged.loops))
            if set_items(self.loops, {name: loop_label(name) for name in names}):
                self.choose_loop(WEAKEST_LOOP_CHOICE)
        self._say()  # why there is none, or that it is of an earlier vehicle

    def _turn_to_view(self) -> None:
        name = self._view
        for index, page in enumerate(self._pages):
            page.setVisible(index == self.views.currentIndex())
            set_tip(page, LOOP_VIEW_HELP[name])
        of_a_loop = (self.loops, self.cuts, self.legend, self.reading, self.shaping)
        for part in (*of_a_loop, self.measuring.button):
            part.setVisible(name != "Phase")
        self.set_seen(self._seen)

    def _draw_again(self) -> None:
        self._content = ()
        self._show()

    def _show(self) -> None:
        """Draw the known curves in the visible view, if they are others than those drawn."""
        shown = self.curves.shown
        chosen = self.curves.loop, self.curves.cut, self._trial.judged_flown
        self.measuring.choose(*chosen)
        self.shaping.choose(self.curves.loop)
        self.progress.say(self.measuring.said, "good")
        measured = self.measuring.known(*chosen)
        self._say()
        content, sources = (self._seen, self._view, {*self._hidden}, [*shown]), self._sources
        self._sources = [*shown.values(), measured]
        if content == self._content and all(map(is_, self._sources, sources)):
            return
        self._content = content
        drawn = {name: drawn_curves(name, each) for name, each in shown.items()}
        if measured is not None:
            drawn[MEASURED_LOOP] = measured
        self._drawn = tuple(drawn[name] for name in LOOP_STROKES if name in drawn)
        self._show_legend()
        if not self._seen or self._view == "Phase":
            return
        if self._view == "Gang of four" and shown:
            any_of = next(iter(shown.values()))
            self.gang.name_units(any_of.control_per_error, any_of.error_per_control)
        seen = [each for each in self._drawn if each.name not in self._hidden]
        self._drawing[LOOP_VIEWS.index(self._view)].show_loops(seen)
        self._frame()

    def _frame(self) -> None:
        """Show the frequencies around the crossover of a newly shown loop."""
        chosen = self.curves.loop, self.curves.cut
        loop = loop_with_margins(self._drawn)
        if chosen == self._framed or loop is None:
            return
        self._framed = chosen
        top = float(loop.frequency[-1])
        middle = loop.crossover if math.isfinite(loop.crossover) else 0.05 * top
        left = max(float(loop.frequency[0]), middle / FACTOR_BELOW_CROSSOVER)
        for view in self._drawing:
            view.show_window(left, min(top, middle * FACTOR_ABOVE_CROSSOVER))

    def _say(self) -> None:
        shown = self.curves.shown
        now = shown.get(PROPOSED_SET, shown.get(FLOWN_SET))
        if self._view == "Phase":
            self.said.say(*self.phase.headline)
        elif self.curves.said:
            self.said.say(f"Not known: {self.curves.said}", "warning")
        elif now is None:
            self.said.say(self._judgement.said or "Not known yet: the analyst is computing it.")
        elif not now.margins.stable:
            said = "The closed loop is unstable with these gains."
            self.said.say(*with_caveat(self._judgement.vehicle_said, said, "bad"))
        elif self._judgement.vehicle_said:
            self.said.say(self._judgement.vehicle_said, "warning")
        else:
            margins = now.margins
            phase, gain = find_limit("phase_margin"), find_limit("gain_margin")
            _, top = response_peak(now.frequency, now.sensitivity)
            self.said.say(
                f"{phase.text(margins.phase_margin)} at {frequency_text(margins.crossover)}, "
                f"{gain.text(margins.gain_margin)}, Ms {number_text(top, 2)}"
            )

    def _show_legend(self) -> None:
        """Write the names."""
        entries = []
        for loop in self._drawn:
            colour = self._look.curve(loop.colour)
            visible = loop.name not in self._hidden
            number = loop.colour + 1 if len(self._drawn) > 1 else 0
            entries.append(LegendEntry(loop.name, "", colour, loop.style, number, visible))
        self.legend.show_entries(entries)
        self._read()

    def _read(self) -> None:
        """Show each loop's magnitude and phase at the cursor, in the order of the legend."""
        if self._cursor is None:
            words = self.shaping.said or "Point at a curve to read it; Ctrl and the wheel zoom"
            self.reading.say(words, self.shaping.tone or "muted")
            return
        loop = loop_with_margins(self._drawn)
        if self._view == "Gang of four" and loop is not None:
            said = [
                f"{name} {abs(loop.at(self._cursor, of(loop))):.3g}" for name, _, of in GANG_OF_FOUR
            ]
        else:
            said = [_loop_value_text(each.at(self._cursor, each.open_loop)) for each in self._drawn]
        at = "" if self._view == "Gang of four" else "L at "
        self.reading.say("  ".join([f"{at}{frequency_text(self._cursor)}:", *said]))

    def _toggle(self, index: int) -> None:
        """Hide or show a curve."""
        self._hidden ^= {self._drawn[index].name}
        self._show()


def _loop_value_text(value: complex) -> str:
    """Return a response in dB and degrees, from -270 to 90; a dash if unknown."""
    if not np.isfinite(value) or not value:
        return "–"
    turn = math.degrees(math.atan2(value.imag, value.real))
    turn -= 360.0 * (turn > 90.0)
    return f"{number_text(20.0 * math.log10(abs(value)), 1)} dB {number_text(turn, 1)}°"
