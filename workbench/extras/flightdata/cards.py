"""The card of the app that flies a log again with the proposed gains."""

from dataclasses import replace

from workbench.extras.flightdata.flying_again_question import FlownAgain, FlyAgain
from workbench.gui.analysis import QueryStream
from workbench.gui.charts.curve import COMMAND_COLOUR, CurveStyle
from workbench.gui.charts.static_plot import StaticPlot
from workbench.gui.errands import single_shot
from workbench.gui.file_dialogs import log_file_filter, open_file
from workbench.gui.help import add_card_help
from workbench.gui.labels import set_tip
from workbench.gui.layout import button, fill, hbox
from workbench.gui.preferences import log_folder
from workbench.gui.tuning.added_cards import AddedCard, CardRow
from workbench.gui.tuning.card import ToneLabel, fields_beside, set_items
from workbench.gui.tuning.designs import Designs, controller_label, gain_differences_text
from workbench.gui.tuning.trial import TuningTrial
from workbench.gui.wheel import ComboBox
from workbench.gui.workspace import Workspace

SETPOINT_CURVE, LOGGED_CURVE, REFLOWN_CURVE, LOW_BAND_CURVE, HIGH_BAND_CURVE = (
    "setpoint",
    "flown",
    "again",
    "low",
    "high",
)
REFLOWN_SIGNALS = (
    ("x", "m"),
    ("y", "m"),
    ("z", "m"),
    ("v_x", "m/s"),
    ("v_y", "m/s"),
    ("v_z", "m/s"),
)
"""Signals in the order of `FlownAgain`, with their units."""
POSITION_SIGNALS = 3
"""Number of positions among the signals; the others have no setpoint."""
REFLOWN_NUMBERS_HELP = (
    "RMS over the flight: how far the log is off the setpoint, how far the flight with these gains "
    "would be, how far the two are apart, and half the width of the band"
)
DRAW_COUNTS = (0, 8, 16, 24, 32, 40)
"""Numbers of draws of successive answers: the curve comes first, and the band improves while gains
do not change."""
NO_LOG_TEXT = "Open a log, to fly it again with the gains on the left."
NO_MODEL_TEXT = "No drone flies: open the model of the one that flew the log (File > Open model…)."
REFLOWN_HINT = "The logged flight, and the one with other gains"
PROPOSED_GAINS_CHOICE = "these gains"
AS_LOGGED_CHOICE = "as logged"


add_card_help(
    "What if",
    "The opened log as it was flown, and as it would have been with the proposed gains.",
    "Move a gain and compare the curves; the band shows the uncertainty of the vehicle.",
    "prediction.md#in-the-app",
)


class WhatIfCard(AddedCard):
    """Shows a logged flight, and how it would have gone with the proposed gains.

    The model is that of the drone that flies in the app. The part of the log that it cannot explain
    acts again, see docs/prediction.md.

    Args:
        workspace: the opened log, flight, analysis and colours.
        trial: the gains that are being tried.
        designs: the controllers.

    Attributes:
        flown: the controller that flew the log.
        law: selects the controller that flies it again.
        signal: selects the drawn signal.
        numbers: its numbers, in words.
        own: proposes the gains that flew the log.
    """

    def __init__(self, workspace: Workspace, trial: TuningTrial, designs: Designs) -> None:
        super().__init__("What if")
        self._workspace, self._trial = workspace, trial
        self._designs = designs
        self._answer: FlownAgain | None = None
        self._asked: FlyAgain | None = None
        self._refusal = ""
        analysis = workspace.analysis
        self._queries = QueryStream(analysis, self)
        self.open = button("&Open log…", self._choose, help="Choose the flight that is flown again")
        self.own = button("Log's &gains", self._adopt, help="Propose the gains that flew the log")
        self.flown, self.law, self.signal = ComboBox(), ComboBox(), ComboBox()
        self.signal.addItems([name for name, _ in REFLOWN_SIGNALS])
        self.plot = StaticPlot(workspace)
        self.numbers = ToneLabel()
        self.numbers.setAccessibleDescription(REFLOWN_NUMBERS_HELP)
        self._lay_out()
        self._offer()
        self._soon = single_shot(self._ask, self)
        self.flown.currentIndexChanged.connect(self._soon.start)
        self.law.currentIndexChanged.connect(self._soon.start)
        self.signal.currentIndexChanged.connect(self._draw)
        trial.changed.connect(self._soon.start)
        workspace.log.changed.connect(self._forget)
        self._queries.answered.connect(self._take)
        self._queries.refused.connect(self._refuse)
        self._queries.preparing.connect(lambda said: self.said.say(f"{said} …"))
        self._forget()

    def begin(self) -> None:
        """Clear the answers of another vehicle's model, or about another controller."""
        self._offer()
        self._forget()

    def set_seen(self, seen: bool) -> None:
        """Ask only while the card is visible."""
        self._queries.set_seen(seen)
        self._show_state()

    def _forget(self) -> None:
        self._queries.forget()
        self._answer, self._refusal = None, ""
        self._draw()
        self._soon.start()

    def _question(self, draws: int) -> FlyAgain | None:
        """Return the next question; None without a log or a model."""
        path, gains = self._workspace.log.path, self._trial.proposed
        if path is None or not gains:
            return None
        return FlyAgain(path, gains, self.law.currentData(), self.flown.currentData(), draws)

    def _ask(self) -> None:
        question = self._question(DRAW_COUNTS[0])
        if question is not None:
            self._queries.ask(question)
        self._show_state()

    def _take(self, asked: FlyAgain, answer: FlownAgain) -> None:
        """Show an answer, and ask for more draws if nothing else is requested."""
        self._asked, self._answer, self._refusal = asked, answer, ""
        counts = DRAW_COUNTS if answer.has_band else ()
        more = next((draws for draws in counts if draws > asked.draws), None)
        wanted = replace(asked, draws=more or 0)
        if more is not None and wanted == self._question(more):
            self._queries.ask(wanted)
        self._draw()

    def _refuse(self, said: str) -> None:
        path = self._workspace.log.path  # its folder is known, and the chart is small
        self._answer, self._refusal = None, said.replace(f"{path}", path.name) if path else said
        self._draw()

    def _draw(self) -> None:
        self.plot.clear()
        index = self.signal.currentIndex()
        name, unit = REFLOWN_SIGNALS[index]
        self.plot.set_axes("time of the log", name, unit)
        answer = self._answer
        self.numbers.say("" if answer is None else _reflown_numbers(answer, index))
        set_tip(self.numbers, f"{self.numbers.text()}\n{REFLOWN_NUMBERS_HELP}")
        if answer is not None:
            time = answer.time
            if index < POSITION_SIGNALS and answer.has_band:
                self.plot.set_curve(
                    SETPOINT_CURVE, time, answer.setpoint[:, index], colour=COMMAND_COLOUR
                )
            if answer.drawn > 1:
                for edge, values in ((LOW_BAND_CURVE, answer.low), (HIGH_BAND_CURVE, answer.high)):
                    self.plot.set_curve(edge, time, values[:, index], CurveStyle.FAINT, 1)
            self.plot.set_curve(LOGGED_CURVE, time, answer.logged[:, index], colour=0)
            self.plot.set_curve(REFLOWN_CURVE, time, answer.other[:, index], colour=1)
        self._show_state()

    def _show_state(self) -> None:
        answer, sliders = self._answer, not self.law.currentData()
        same = answer is not None and sliders and answer.flown == self._law_name()
        gains = self._trial.proposed
        self.own.setEnabled(
            answer is not None
            and same
            and any(gains.get(name) != value for name, value in answer.flown_gains.items())
        )
        text, tone = self._sentence(same)
        self.said.say(text, tone)
        self.plot.set_hint(text or REFLOWN_HINT)

    def _sentence(self, same: bool) -> tuple[str, str]:
        """Return a sentence about the result, and its tone.

        Args:
            same: whether the law that flew also flies it again, with the proposed gains.
        """
        answer, asked = self._answer, self._asked
        if self._workspace.log.path is None:
            return NO_LOG_TEXT, "muted"
        if not self._trial.proposed:
            return NO_MODEL_TEXT, "warning"
        if self._refusal:
            return f"Not flown again: {self._refusal}", "warning"
        if answer is None or asked is None:
            return ("Flying it again …" if self._queries.is_waiting else ""), "muted"
        if asked != self._question(asked.draws):
            return "For the previous request; the new flight follows …", "muted"
        if answer.logged_vehicle not in ("", answer.vehicle):
            return (
                f"The log is of {answer.logged_vehicle}, the model of {answer.vehicle}.",
                "warning",
            )
        doubt = f"{answer.doubt[:1].upper()}{answer.doubt[1:]}"
        ground = (
            f"{answer.grounded} of {answer.drawn} would reach the ground" if answer.grounded else ""
        )
        if not answer.stays:
            said = ("With it the drone would have been lost", ground, doubt)
            return f"{'. '.join(filter(None, said))}.", "bad"
        if same:
            what = gain_differences_text(asked.gains, answer.flown_gains, same="as it flew")
        else:
            law = controller_label(asked.controller) or self._law_name()
            what = f"{law} in place of {answer.flown}"
        if answer.lost:
            lost = f"{answer.lost} of {answer.drawn} uncertain drones would be lost: {what}"
            return ". ".join(filter(None, (lost, ground, doubt))), "warning"
        if doubt:
            return doubt, "warning"
        return f"{answer.vehicle} flies {asked.log.name}: {what}", "muted"

    def _law_name(self) -> str:
        """Return the name of the controller whose gains are shown on the left."""
        return controller_label(self._designs.present)

    def _adopt(self) -> None:
        if self._answer is not None:
            self._trial.gains.adopt(self._answer.flown_gains, "the gains of a log")

    def _choose(self) -> None:
        folder = str(log_folder(self._workspace.preferences))
        open_file(
            self,
            "Open log",
            self._workspace.log.open,
            folder,
            f"{log_file_filter()};;All files (*)",
        )

    def _offer(self) -> None:
        """Offer all known controllers."""
        for box, first, names in (
            (self.flown, AS_LOGGED_CHOICE, self._designs.controllers),
            (self.law, PROPOSED_GAINS_CHOICE, self._designs.others),
        ):
            set_items(box, {"": first} | {name: controller_label(name) for name in names})

    def _lay_out(self) -> None:
        fields = (("Flo&wn by", self.flown), ("Fl&y with", self.law), ("&Show", self.signal))
        line = hbox(1, self.own, self.open)  # so the sentence has the head
        fill(self.body, fields_beside(fields), (self.plot, 1), self.numbers, line)


def _reflown_numbers(answer: FlownAgain, index: int) -> str:
    """Return the numbers of a signal; a velocity has no setpoint, and a lost flight none."""
    unit, said = REFLOWN_SIGNALS[index][1], []
    if index < POSITION_SIGNALS and answer.has_band:
        before, after = answer.off_setpoint[:, index]
        said.append(f"off setpoint {before:.3f}" + (f" → {after:.3f}" if answer.stays else ""))
    if answer.stays:
        band = f" ± {answer.band[index]:.3f}" if answer.drawn > 1 else ""
        said.append(f"apart {answer.difference[index]:.3f}{band}")
    return f"{', '.join(said)} {unit}" if said else ""


WHAT_IF = CardRow(
    "What if",
    WhatIfCard,
    log_button="What if…",
    log_help="Fly it again with other gains, on the Tuning screen",
)
