"""The card that flies a log again with the proposed gains."""

from dataclasses import replace

from PyQt6.QtWidgets import QComboBox

from workbench.analysis.questions import FlyAgain
from workbench.analysis.replies import FlownAgain
from workbench.gui.analysis import Follower
from workbench.gui.charts.curve import COMMAND, CurveStyle
from workbench.gui.charts.plots import StaticPlot
from workbench.gui.errands import single_shot
from workbench.gui.file_dialogs import LOG_FILES, open_file
from workbench.gui.labels import set_tip
from workbench.gui.layout import button, fill
from workbench.gui.preferences import log_folder
from workbench.gui.tuning.card import Card, Sentence, fields_beside, offer
from workbench.gui.tuning.designs import Designs, controller_label, gains_text
from workbench.gui.tuning.trial import Trial
from workbench.gui.workspace import Workspace

ASKED, FLOWN, AGAIN, LOW, HIGH = "setpoint", "flown", "again", "low", "high"
SIGNALS = (("x", "m"), ("y", "m"), ("z", "m"), ("v_x", "m/s"), ("v_y", "m/s"), ("v_z", "m/s"))
"""Signals in the order of `FlownAgain`, with their units."""
POSITIONS = 3
"""Number of positions among the signals; the others have no setpoint."""
NUMBERS = (
    "RMS over the flight: how far the log is off the setpoint, how far the flight with these gains "
    "would be, how far the two are apart, and half the width of the band"
)
DRAWS = (0, 8, 16, 24, 32, 40)
"""Numbers of draws of successive answers: the curve comes first, and the band improves while gains
do not change."""
NO_LOG = "Open a log, to fly it again with the gains on the left."
NO_MODEL = "No drone flies: open the model of the one that flew the log (File > Open model…)."
HINT = "The logged flight, and the one with other gains"
SLIDERS = "these gains"
AS_LOGGED = "as logged"


class WhatIfCard(Card):
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

    def __init__(self, workspace: Workspace, trial: Trial, designs: Designs) -> None:
        super().__init__("What if")
        self._workspace, self._trial = workspace, trial
        self._designs = designs
        self._answer: FlownAgain | None = None
        self._asked: FlyAgain | None = None
        self._refusal = ""
        analysis = workspace.analysis
        self._follower = Follower(analysis, FlyAgain, self)
        self.open = button("&Open log…", self._choose, help="Choose the flight that is flown again")
        self.own = button("Log's &gains", self._adopt, help="Propose the gains that flew the log")
        self.flown, self.law, self.signal = QComboBox(), QComboBox(), QComboBox()
        self.signal.addItems([name for name, _ in SIGNALS])
        self.plot = StaticPlot(workspace)
        self.numbers = Sentence()
        self.numbers.setAccessibleDescription(NUMBERS)
        self._lay_out()
        self._offer()
        self._soon = single_shot(self._ask, self)
        self.flown.currentIndexChanged.connect(self._soon.start)
        self.law.currentIndexChanged.connect(self._soon.start)
        self.signal.currentIndexChanged.connect(self._draw)
        trial.changed.connect(self._soon.start)
        workspace.log.changed.connect(self._forget)
        self._follower.answered.connect(self._take)
        self._follower.refused.connect(self._refuse)
        self._follower.preparing.connect(lambda said: self.said.say(f"{said} …"))
        self._forget()

    def begin(self) -> None:
        """Clear the answers of another vehicle's model, or about another controller."""
        self._offer()
        self._forget()

    def set_seen(self, seen: bool) -> None:
        """Ask only while the card is visible."""
        self._follower.set_seen(seen)
        self._show_state()

    def _forget(self) -> None:
        self._follower.forget()
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
        question = self._question(DRAWS[0])
        if question is not None:
            self._follower.ask(question)
        self._show_state()

    def _take(self, asked: FlyAgain, answer: FlownAgain) -> None:
        """Show an answer, and ask for more draws if nothing else is requested."""
        self._asked, self._answer, self._refusal = asked, answer, ""
        more = next((draws for draws in DRAWS if draws > asked.draws), None)
        wanted = replace(asked, draws=more or 0)
        if more is not None and wanted == self._question(more):
            self._follower.ask(wanted)
        self._draw()

    def _refuse(self, said: str) -> None:
        path = self._workspace.log.path  # its folder is known, and the chart is small
        self._answer, self._refusal = None, said.replace(f"{path}", path.name) if path else said
        self._draw()

    def _draw(self) -> None:
        self.plot.clear()
        index = self.signal.currentIndex()
        name, unit = SIGNALS[index]
        self.plot.set_axes("time of the log", name, unit)
        answer = self._answer
        self.numbers.say("" if answer is None else _numbers(answer, index))
        set_tip(self.numbers, f"{self.numbers.text()}\n{NUMBERS}")
        if answer is not None:
            time = answer.time
            if index < POSITIONS:
                self.plot.set_curve(ASKED, time, answer.setpoint[:, index], colour=COMMAND)
            if answer.drawn > 1:
                for edge, values in ((LOW, answer.low), (HIGH, answer.high)):
                    self.plot.set_curve(edge, time, values[:, index], CurveStyle.FAINT, 1)
            self.plot.set_curve(FLOWN, time, answer.logged[:, index], colour=0)
            self.plot.set_curve(AGAIN, time, answer.other[:, index], colour=1)
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
        self.plot.set_hint(text or HINT)

    def _sentence(self, same: bool) -> tuple[str, str]:
        """Return a sentence about the result, and its tone.

        Args:
            same: whether the law that flew also flies it again, with the proposed gains.
        """
        answer, asked = self._answer, self._asked
        if self._workspace.log.path is None:
            return NO_LOG, "muted"
        if not self._trial.proposed:
            return NO_MODEL, "warning"
        if self._refusal:
            return f"Not flown again: {self._refusal}", "warning"
        if answer is None or asked is None:
            return ("Flying it again …" if self._follower.is_waiting else ""), "muted"
        if asked != self._question(asked.draws):
            return "For the previous request; the new flight follows …", "muted"
        if answer.logged_vehicle not in ("", answer.vehicle):
            return (
                f"The log is of {answer.logged_vehicle}, the model of {answer.vehicle}.",
                "warning",
            )
        if answer.doubt:
            return f"{answer.doubt[:1].upper()}{answer.doubt[1:]}", "warning"
        if not answer.stays:
            return "With it the drone would have been lost.", "bad"
        if same:
            what = gains_text(asked.gains, answer.flown_gains, same="as it flew")
        else:
            law = controller_label(asked.controller) or self._law_name()
            what = f"{law} in place of {answer.flown}"
        said = f"{answer.vehicle} flies {asked.log.name}: {what}"
        if answer.lost:
            said = f"{answer.lost} of {answer.drawn} uncertain drones would be lost: {what}"
        return said, "warning" if answer.lost else "muted"

    def _law_name(self) -> str:
        """Return the name of the controller whose gains are shown on the left."""
        return controller_label(self._designs.present)

    def _adopt(self) -> None:
        if self._answer is not None:
            self._trial.gains.adopt(self._answer.flown_gains, "the gains of a log")

    def _choose(self) -> None:
        folder = str(log_folder(self._workspace.preferences))
        open_file(self, "Open log", self._workspace.log.open, folder, f"{LOG_FILES};;All files (*)")

    def _offer(self) -> None:
        """Offer all known controllers."""
        for box, first, names in (
            (self.flown, AS_LOGGED, self._designs.controllers),
            (self.law, SLIDERS, self._designs.others),
        ):
            offer(box, {"": first} | {name: controller_label(name) for name in names})

    def _lay_out(self) -> None:
        fill(self.head, self.own, self.open)
        fields = (("Flo&wn by", self.flown), ("Fl&y with", self.law), ("S&how", self.signal))
        fill(self.body, fields_beside(fields), (self.plot, 1), self.numbers)


def _numbers(answer: FlownAgain, index: int) -> str:
    """Return the numbers of a signal; a velocity has no setpoint, and a lost flight none."""
    unit, said = SIGNALS[index][1], []
    if index < POSITIONS:
        before, after = answer.off_setpoint[:, index]
        said.append(f"off setpoint {before:.3f}" + (f" → {after:.3f}" if answer.stays else ""))
    if answer.stays:
        band = f" ± {answer.band[index]:.3f}" if answer.drawn > 1 else ""
        said.append(f"apart {answer.difference[index]:.3f}{band}")
    return f"{', '.join(said)} {unit}" if said else ""
