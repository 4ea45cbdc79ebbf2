"""The card that searches gains for wishes and shows the result for approval."""

from itertools import starmap

from PyQt6.QtCore import Qt
from PyQt6.QtWidgets import (
    QProgressBar,
    QScrollArea,
    QSizePolicy,
    QStackedWidget,
    QWidget,
)

from workbench.analysis.queries import Tune
from workbench.analysis.replies import Searched, Tuned
from workbench.gui.analysis import QueryStream
from workbench.gui.charts.curve import CurveStyle
from workbench.gui.charts.static_plot import StaticPlot
from workbench.gui.layout import buddy, button, column, hbox, named
from workbench.gui.tuning.card import CARD_SPACING_PX, ToneLabel, TuningCard, wrapped_label
from workbench.gui.tuning.designs import gain_differences_text
from workbench.gui.tuning.number_row import Cell, NumberRow, RowState
from workbench.gui.tuning.number_table import NumberTable
from workbench.gui.tuning.requirement_rows import RequirementRows
from workbench.gui.tuning.trial import TuningTrial
from workbench.gui.wheel import ComboBox
from workbench.gui.workspace import Workspace
from workbench.scenario.axes import find_axis

MIN_REQUIREMENTS_HEIGHT_PX = 48
"""Height of the scrolled part, two rows; Qt would demand a window of more than 720 px [px]."""
DEFAULT_REQUIREMENTS = (
    "level.rise_time <= 0.4 s",
    "level.overshoot <= 10 %",
    "tilt.phase_margin >= 45 deg",
)


class AutoTuneCard(TuningCard):
    """Wishes, a search that can be stopped, and its result, which the user accepts or rejects.

    Args:
        workspace: analysis, colours and units.
        trial: the gains that are being tried.
    """

    def __init__(self, workspace: Workspace, trial: TuningTrial) -> None:
        super().__init__("Auto-tune")
        self._analysis, self._trial = workspace.analysis, trial
        self._searches = QueryStream(workspace.analysis, self, seen=True)
        self._tuned: Tuned | None = None
        self.wishes = RequirementRows(DEFAULT_REQUIREMENTS)
        self.start = button("&Search", self.search, "primary")
        self.progress = named(QProgressBar(), "Progress of the search, 0 to 100 %")
        self.progress.setRange(0, 100)
        self.progress.setTextVisible(False)
        self.stop = button("S&top, keep the best", self._analysis.stop)
        self.best = wrapped_label()
        self.table = NumberTable(
            "Wishes before and after",
            ("before", "after"),
            workspace.look,
            paired=False,
            widest="level.rise_time <= 0.4",
        )
        self.axis = ComboBox()
        self.axis.currentIndexChanged.connect(self._draw)
        self.plot = StaticPlot(workspace)
        self.remarks = ToneLabel()
        self.accept = button("&Accept", self._accept, "primary")
        self.discard = button("&Discard", self._discard)
        self.pages = QStackedWidget()
        self._lay_out()
        self.body.addWidget(self.pages, 1)
        self.wishes.changed.connect(self._show_state)
        trial.changed.connect(self._show_state)
        self._analysis.searched.connect(self._hear_progress)
        self._searches.answered.connect(self._show_result)
        self._searches.refused.connect(self._show_refusal)
        self._show_state()

    @property
    def is_running(self) -> bool:
        """Whether a search is in progress."""
        return self._searches.is_waiting

    def begin(self) -> None:
        """Clear the search for another vehicle."""
        self._searches.forget()
        self._tuned = None
        self.wishes.set_controller(self._trial.gains.controller)
        self.pages.setCurrentIndex(0)
        self._show_state()

    def search(self) -> None:
        """Start a search from the proposed gains."""
        if self.is_running or not self.wishes.are_good or not self._trial.proposed:
            return
        self.progress.setValue(0)
        self.best.setText("The search starts: it takes about a minute.")
        self.said.say("Searching; the flight continues.")
        self.pages.setCurrentIndex(1)
        self._searches.ask(
            Tune(self._trial.proposed, self.wishes.wishes, self._trial.gains.velocity)
        )

    def _hear_progress(self, searched: Searched) -> None:
        if not self.is_running:
            return
        self.progress.setValue(round(100.0 * searched.share))
        words = (
            gain_differences_text(searched.gains, self._trial.proposed) if searched.gains else ""
        )
        best = f"Best so far: {words}" if words else ""
        lines = (searched.phase.capitalize(), best, searched.said)
        self.best.setText("\n".join(line for line in lines if line))

    def _show_result(self, _: Tune, tuned: Tuned) -> None:
        self._tuned = tuned
        self.table.set_rows(tuple(starmap(_requirement_row, tuned.wishes)))
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

    def _show_refusal(self, said: str) -> None:
        self.pages.setCurrentIndex(0)
        guilty = [row for row in self.wishes.rows if row.text in said]
        for row in guilty:
            row.blame(said)
        self.said.say("" if guilty else said, "bad")
        if guilty:
            guilty[0].number.setFocus()

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
            ((_scroll_requirements(self.wishes), 1), hbox(1, self.start)),
            (self.progress, self.best, 1, hbox(1, self.stop)),
            ((_scroll_requirements(self.table), 1), self.remarks, (self.plot, 1), line),
        ):
            self.pages.addWidget(column(*page, spacing=CARD_SPACING_PX))


def _requirement_row(wish: str, before: str, after: str, met: bool) -> NumberRow:
    state = RowState.GOOD if met else RowState.MISSED
    return NumberRow(wish, (Cell(before), Cell(after, over=not met)), state)


def _scroll_requirements(widget: QWidget) -> QScrollArea:
    scroll = QScrollArea()
    scroll.setWidgetResizable(True)
    scroll.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
    scroll.setWidget(widget)
    scroll.setMinimumHeight(MIN_REQUIREMENTS_HEIGHT_PX)
    return scroll
