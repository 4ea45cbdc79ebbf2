"""The card that searches gains for wishes and shows the result for approval."""

import re
from collections.abc import Sequence
from itertools import starmap

from PyQt6.QtCore import Qt, pyqtSignal
from PyQt6.QtWidgets import (
    QComboBox,
    QCompleter,
    QLineEdit,
    QProgressBar,
    QScrollArea,
    QSizePolicy,
    QStackedWidget,
    QWidget,
)

from workbench.analysis.questions import Question, Tune
from workbench.analysis.replies import Searched, Tuned
from workbench.common.errors import WorkbenchError
from workbench.control.controller import Controller, load_controller
from workbench.design.metrics import WISHED
from workbench.design.tune.wish import groups_of, parse_wish, subjects_of
from workbench.gui.charts.curve import CurveStyle
from workbench.gui.charts.plots import StaticPlot
from workbench.gui.layout import NO_MARGINS, buddy, button, column, hbox, label, named, vbox
from workbench.gui.number_field import NUMBER, read_number
from workbench.gui.style import set_class
from workbench.gui.tuning.card import SPACING, Card, Sentence, wrapped
from workbench.gui.tuning.designs import gains_text
from workbench.gui.tuning.number_table import Cell, NumberTable, Row, State
from workbench.gui.tuning.trial import Trial
from workbench.gui.workspace import Workspace
from workbench.scenario.axes import find_axis

_BOUND = re.compile(rf"(?P<sign>[<>≤≥]=?)\s*(?P<number>{NUMBER})")
MOST = 6
"""Largest number of wishes."""
LEAST_LIST = 48
"""Height of the scrolled part, two rows; Qt would demand a window of more than 720 px [px]."""
DEFAULT = ("level.rise_time <= 0.4 s", "level.overshoot <= 10 %", "tilt.phase_margin >= 45 deg")


def completions(law: Controller) -> tuple[str, ...]:
    """Return possible beginnings of a wish for a controller, as `x.rise_time <= `."""
    return tuple(
        f"{subject}.{metric.name} {'>=' if metric.better > 0 else '<='} "
        for metric in WISHED
        for subject in (*subjects_of(metric, law), *groups_of(metric, law))
    )


def what_is_wrong(text: str, law: Controller) -> str:
    """Return what is wrong with a wish, as a sentence; "" if it is valid."""
    bound = _BOUND.search(text)
    try:
        if bound:
            read_number(bound["number"])
        parse_wish(with_point(text), law=law)
    except WorkbenchError as error:
        return str(error)
    return ""


def with_point(text: str) -> str:
    """Return a wish with a decimal point in place of a comma."""
    bound = _BOUND.search(text)
    if bound is None:
        return text.strip()
    begin, end = bound.span("number")
    number = bound["number"].replace(",", ".").replace("\N{MINUS SIGN}", "-")
    return (text[:begin] + number + text[end:]).strip()


class WishLine(QWidget):
    """One wish, with its error below."""

    changed = pyqtSignal()
    """The text changed."""

    def __init__(self, number: int, law: Controller) -> None:
        super().__init__()
        self._law = law
        self.field = named(QLineEdit(), f"Wish {number}, as x.rise_time <= 0.4 s")
        self.field.setPlaceholderText("another wish, as x.rise_time <= 0.4 s")
        self.set_controller(law)
        self.fault = wrapped("bad")
        self.fault.setVisible(False)
        vbox(self.field, self.fault, of=self, margins=NO_MARGINS, spacing=1)
        self.field.textChanged.connect(lambda _: self._check(typing=True))
        self.field.editingFinished.connect(lambda: self._check(typing=False))

    @property
    def text(self) -> str:
        """The wish, "" if the line is empty."""
        return with_point(self.field.text())

    @property
    def is_good(self) -> bool:
        """Whether no error is known."""
        return not self.text or not what_is_wrong(self.text, self._law)

    def set_controller(self, law: Controller) -> None:
        """Accept wishes about the loops of a controller."""
        self._law = law
        completer = QCompleter(list(completions(law)), self.field)  # which deletes the last one
        completer.setFilterMode(Qt.MatchFlag.MatchContains)
        completer.setCaseSensitivity(Qt.CaseSensitivity.CaseInsensitive)
        self.field.setCompleter(completer)

    def blame(self, said: str) -> None:
        """Show an error, "" for none."""
        self.fault.setText(f"✕ {said}" if said else "")
        self.fault.setVisible(bool(said))
        self.field.setAccessibleDescription(said)
        set_class(self.field, "bad" if said else "")

    def _check(self, *, typing: bool) -> None:
        """Show an error once the line loses the focus; clear it as soon as it is corrected."""
        if self.is_good:
            self.blame("")
        elif not typing:
            self.blame(what_is_wrong(self.text, self._law))
        if typing:
            self.changed.emit()


class WishLines(QWidget):
    """Wishes one below the other, always with an empty line for another one.

    Args:
        wishes: initial wishes.
    """

    changed = pyqtSignal()
    """The wishes changed."""

    def __init__(self, wishes: Sequence[str]) -> None:
        super().__init__()
        self._law = load_controller()
        self.lines: list[WishLine] = []
        heading = label("&Wishes", "muted")
        self._box = vbox(heading, of=self, margins=NO_MARGINS, spacing=3)
        for wish in (*wishes, ""):
            self._add(wish)
        heading.setBuddy(self.lines[0].field)

    @property
    def wishes(self) -> tuple[str, ...]:
        """The wishes, without empty lines."""
        return tuple(line.text for line in self.lines if line.text)

    @property
    def are_good(self) -> bool:
        """Whether there is a wish, and all are valid."""
        return bool(self.wishes) and all(line.is_good for line in self.lines)

    def set_controller(self, law: Controller) -> None:
        """Accept wishes about the loops of a controller; mark those with unknown loops."""
        self._law = law
        for line in self.lines:
            line.set_controller(law)
            line.blame(what_is_wrong(line.text, law) if line.text else "")

    def _add(self, wish: str) -> None:
        line = WishLine(len(self.lines) + 1, self._law)
        line.field.setText(wish)
        line.changed.connect(self._grow)
        self.lines.append(line)
        self._box.addWidget(line)

    def _grow(self) -> None:
        if self.lines[-1].text and len(self.lines) < MOST:
            self._add("")
        self.changed.emit()


class AutoTuneCard(Card):
    """Wishes, a search that can be stopped, and its result, which the user accepts or rejects.

    Args:
        workspace: analysis, colours and units.
        trial: the gains that are being tried.

    Attributes:
        is_running: whether a search is in progress.
    """

    def __init__(self, workspace: Workspace, trial: Trial) -> None:
        super().__init__("Auto-tune")
        self._analysis, self._trial = workspace.analysis, trial
        self.is_running = False
        self._tuned: Tuned | None = None
        self.wishes = WishLines(DEFAULT)
        self.start = button("&Search", self.search, "primary")
        self.progress = named(QProgressBar(), "Progress of the search, 0 to 100 %")
        self.progress.setRange(0, 100)
        self.progress.setTextVisible(False)
        self.stop = button("S&top, keep the best", self._analysis.stop)
        self.best = wrapped()
        self.table = NumberTable(
            "Wishes before and after",
            ("before", "after"),
            workspace.look,
            paired=False,
            widest="level.rise_time <= 0.4",
        )
        self.axis = QComboBox()
        self.axis.currentIndexChanged.connect(self._draw)
        self.plot = StaticPlot(workspace)
        self.remarks = Sentence()
        self.accept = button("&Accept", self._accept, "primary")
        self.discard = button("&Discard", self._discard)
        self.pages = QStackedWidget()
        self._lay_out()
        self.body.addWidget(self.pages, 1)
        self.wishes.changed.connect(self._show_state)
        trial.changed.connect(self._show_state)
        self._analysis.searched.connect(self._hear_progress)
        self._analysis.answered.connect(self._hear_result)
        self._analysis.refused.connect(self._hear_refusal)
        self._show_state()

    def begin(self) -> None:
        """Clear the search for another vehicle."""
        self.is_running, self._tuned = False, None
        self.wishes.set_controller(self._trial.gains.table.controller)
        self.pages.setCurrentIndex(0)
        self._show_state()

    def search(self) -> None:
        """Start a search from the proposed gains."""
        if self.is_running or not self.wishes.are_good or not self._trial.proposed:
            return
        self.is_running = True
        self.progress.setValue(0)
        self.best.setText("The search starts: it takes about a minute.")
        self.said.say("Searching; the flight continues.")
        self.pages.setCurrentIndex(1)
        self._analysis.ask(
            Tune(self._trial.proposed, self.wishes.wishes, self._trial.gains.velocity)
        )

    def _hear_progress(self, searched: Searched) -> None:
        if not self.is_running:
            return
        self.progress.setValue(round(100.0 * searched.share))
        words = gains_text(searched.gains, self._trial.proposed) if searched.gains else ""
        best = f"Best so far: {words}" if words else ""
        lines = (searched.phase.capitalize(), best, searched.said)
        self.best.setText("\n".join(line for line in lines if line))

    def _hear_result(self, question: Question, tuned: Tuned) -> None:
        if not isinstance(question, Tune) or not self.is_running:
            return
        self.is_running, self._tuned = False, tuned
        self.table.set_rows(tuple(starmap(_row, tuned.wishes)))
        self.axis.clear()
        self.axis.addItems(tuned.steps)
        self._draw()
        self.remarks.say(" ".join(tuned.said))
        self.remarks.setVisible(bool(tuned.said))
        if tuned.met and tuned.widened:
            many = "one limit was" if tuned.widened == 1 else f"{tuned.widened} limits were"
            self.said.say(f"The wishes are met, but {many} widened: see below.", "warning")
        elif tuned.met:
            self.said.say("All wishes are met.", "good")
        elif tuned.stopped:
            self.said.say("Stopped: the best so far.", "warning")
        else:
            self.said.say("Not all wishes are met.", "warning")
        self.pages.setCurrentIndex(2)

    def _hear_refusal(self, question: Question, said: str) -> None:
        if not isinstance(question, Tune) or not self.is_running:
            return
        self.is_running = False
        self.pages.setCurrentIndex(0)
        guilty = [line for line in self.wishes.lines if line.text and line.text in said]
        for line in guilty:
            line.blame(said)
        self.said.say("" if guilty else said, "bad")
        if guilty:
            guilty[0].field.setFocus()

    def _draw(self) -> None:
        self.plot.clear()
        if self._tuned is None or self.axis.currentIndex() < 0:
            return
        axis = find_axis(self.axis.currentText())
        time, before, after = self._tuned.steps[axis.name]
        self.plot.set_axes("time after the step", axis.label, axis.unit)
        self.plot.set_curve("before", time, before, CurveStyle.SOLID, 0)
        self.plot.set_curve("after", time, after, CurveStyle.DASHED, 1)

    def _accept(self) -> None:
        if self._tuned is not None:
            self._trial.gains.adopt(self._tuned.gains, "auto-tune")
        self._discard()
        self.said.say("Accepted: one undo reverts it.", "good")

    def _discard(self) -> None:
        self._tuned = None
        self.pages.setCurrentIndex(0)
        self.said.say("")
        self._show_state()

    def _show_state(self) -> None:
        self.start.setEnabled(
            self.wishes.are_good and bool(self._trial.proposed) and not self.is_running
        )

    def _lay_out(self) -> None:
        self.wishes.setSizePolicy(QSizePolicy.Policy.Preferred, QSizePolicy.Policy.Maximum)
        along = buddy("Ste&p along", self.axis)
        line = hbox(along, self.axis, 1, self.discard, self.accept)
        for page in (
            ((_scrolling(self.wishes), 1), hbox(1, self.start)),
            (self.progress, self.best, 1, hbox(1, self.stop)),
            ((_scrolling(self.table), 1), self.remarks, (self.plot, 1), line),
        ):
            self.pages.addWidget(column(*page, spacing=SPACING))


def _row(wish: str, before: str, after: str, met: bool) -> Row:
    state = State.GOOD if met else State.MISSED
    return Row(wish, (Cell(before), Cell(after, over=not met)), state)


def _scrolling(widget: QWidget) -> QScrollArea:
    scroll = QScrollArea()
    scroll.setWidgetResizable(True)
    scroll.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
    scroll.setWidget(widget)
    scroll.setMinimumHeight(LEAST_LIST)
    return scroll
