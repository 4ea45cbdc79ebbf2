"""The tuning screen: gains, excitation, response, margins, and further aids."""

from collections.abc import Callable, Sequence

import numpy as np
from PyQt6.QtCore import QObject, QSize, Qt, pyqtSignal
from PyQt6.QtGui import QHideEvent, QResizeEvent, QShowEvent
from PyQt6.QtWidgets import QLayout, QSplitter, QTabWidget, QVBoxLayout, QWidget

from workbench.analysis.questions import Fork, Predict, Question
from workbench.analysis.replies import Predicted, StepNumbers
from workbench.design.branches import Branch, FlownBranch
from workbench.gui.analysis import Analysis, Follower
from workbench.gui.errands import single_shot
from workbench.gui.flight_model import FlightModel
from workbench.gui.gains.gain_bar import GainBar, ask_to_save
from workbench.gui.gains.gain_editor import GainEditor
from workbench.gui.gains.gain_files import GainFileDiff, GainFiles
from workbench.gui.gains.gain_panel import GainPanel
from workbench.gui.help import explain
from workbench.gui.layout import NO_MARGINS, column, hbox, scrolled
from workbench.gui.screens import Screen
from workbench.gui.tuning.autotune_card import AutoTuneCard
from workbench.gui.tuning.compare_card import CompareCard
from workbench.gui.tuning.designs import Designs
from workbench.gui.tuning.excitation_card import ExcitationCard
from workbench.gui.tuning.excitation_form import ExcitationChoice
from workbench.gui.tuning.fork_card import ForkCard
from workbench.gui.tuning.frequency_card import FrequencyCard
from workbench.gui.tuning.judgement import Judgement
from workbench.gui.tuning.limits import Limits
from workbench.gui.tuning.map_card import MapCard
from workbench.gui.tuning.margins_card import MarginsCard
from workbench.gui.tuning.pin_card import PinCard
from workbench.gui.tuning.poles_card import PolesCard
from workbench.gui.tuning.response_card import ResponseCard
from workbench.gui.tuning.trial import Trial
from workbench.gui.tuning.weights_card import WeightsCard
from workbench.gui.tuning.what_if_card import WhatIfCard
from workbench.gui.workspace import Workspace
from workbench.live.view import LiveView
from workbench.session.checkpoint import Checkpoint

WIDE = 1166
"""Least width with three columns [px]."""
GAP = 6
GAINS = 448
MIDDLE = 364
"""Initial least widths of the first two columns [px]."""
NARROWEST_GAINS = 399
"""Least width of the gains in three columns; below it the sliders are too short [px]."""
SHARES = (0.3, 0.3)
"""Shares of a wide screen for gains and response; the rest is for margins and tabs."""
TABS = (
    (1400, "QTabBar::tab { padding: 6px 2px; margin-right: 0; } QTabBar { font-size: 11px; }"),
    (2000, "QTabBar::tab { padding: 6px 8px; }"),
)
"""Widths [px] up to which tabs are closer together, so that all eleven, or nine, are visible."""
LEAST = 372
SHORTEST = 520
"""Width of the tabs, and height of everything, without clipping [px]; their bar may scroll."""
ALL_TABS = 450
"""Width of the bar of eleven tabs [px]."""
BOTH = NARROWEST_GAINS + ALL_TABS
FUTURE_NAME = "next five seconds"
AHEAD = 5.0
"""Predicted time [s]."""


class Arrangement(QWidget):
    """Gains on the left, the response beside them, margins and tabs on the right or in tabs.

    Args:
        gains: left part.
        response: excitation and response.
        margins: margins of all loops.
        tabs: all other parts, with their names.
    """

    def __init__(
        self, gains: QWidget, response: QWidget, margins: QWidget, tabs: QTabWidget
    ) -> None:
        super().__init__()
        self._gains, self._response = gains, response
        self._margins, self._tabs = margins, tabs
        self._columns = 0
        tabs.setDocumentMode(True)
        tabs.setUsesScrollButtons(True)
        tabs.setElideMode(Qt.TextElideMode.ElideNone)
        self._middle, self._right = column(spacing=GAP), column(spacing=GAP)
        self.splitter = QSplitter(Qt.Orientation.Horizontal)
        self.splitter.setHandleWidth(GAP)
        self.splitter.setChildrenCollapsible(False)
        for part in (gains, self._middle, self._right):
            self.splitter.addWidget(part)
        for index, share in enumerate((2, 3, 3)):
            self.splitter.setStretchFactor(index, share)
        box = hbox(self.splitter, of=self, margins=(GAP, GAP, GAP, GAP))
        box.setSizeConstraint(QLayout.SizeConstraint.SetNoConstraint)

    def minimumSizeHint(self) -> QSize:
        """Return the smallest size, with all parts in tabs."""
        return QSize(LEAST + 2 * GAP, SHORTEST)

    def resizeEvent(self, event: QResizeEvent | None) -> None:
        """Arrange the parts according to the width."""
        super().resizeEvent(event)
        both = self._gains.minimumSizeHint().width() + LEAST + 3 * GAP
        self.arrange(3 if self.width() >= WIDE else 2 if self.width() >= both else 1)
        style = next((each for width, each in TABS if self.width() < width), "")
        if style != self._tabs.styleSheet():
            self._tabs.setStyleSheet(style)

    def arrange(self, columns: int) -> None:
        """Arrange the parts side by side, or in tabs.

        Args:
            columns: 3 for gains, response, and margins with the tabs; 2 for gains, and tabs; 1 for
                only tabs.
        """
        if columns == self._columns:
            return
        self._columns = columns
        wide = columns == 3
        self._gains.setMinimumWidth(NARROWEST_GAINS if wide else 0)
        chosen = self._tabs.currentWidget()
        middle, right = self._middle.layout(), self._right.layout()
        assert isinstance(middle, QVBoxLayout) and isinstance(right, QVBoxLayout)
        if wide:
            for part in (self._gains, self._response, self._margins):
                if self._tabs.indexOf(part) >= 0:
                    self._tabs.removeTab(self._tabs.indexOf(part))
            middle.addWidget(self._response)
            right.addWidget(self._margins)
            right.addWidget(self._tabs)
            right.setStretch(1, 1)
            self._right.show()
            self.splitter.insertWidget(0, self._gains)
            for part in (self._gains, self._response, self._margins):
                part.show()
            gains = max(GAINS, round(SHARES[0] * self.width()))
            response = max(MIDDLE, round(SHARES[1] * self.width()))
            rest = self.width() - gains - response - 4 * GAP
            self.splitter.setSizes([gains, response, rest])
        else:
            middle.addWidget(self._tabs)
            self._tabs.insertTab(0, self._response, "Step")
            self._tabs.insertTab(1, self._margins, "Margins")
            self._right.hide()
            if columns == 2:
                self._tabs.removeTab(self._tabs.indexOf(self._gains))
                self.splitter.insertWidget(0, self._gains)
                self._gains.show()
                room = self.width() - 3 * GAP
                gains = min(GAINS, room - (ALL_TABS if room >= BOTH else LEAST))
                self.splitter.setSizes([gains, self.width() - gains - 3 * GAP, 0])
            else:
                self._tabs.insertTab(0, self._gains, "Gains")
            self._tabs.setCurrentIndex(0)
        self._tabs.show()  # a widget with a new parent stays hidden until the next event loop cycle
        if chosen is not None and self._tabs.indexOf(chosen) >= 0 and wide:
            self._tabs.setCurrentWidget(chosen)


class Ghost(QObject):
    """Predicts the future of the flight with proposed gains that do not fly yet.

    It asks one question at a time, next about the newest gains. It asks nothing while the gains
    already fly, while the screen is hidden, and during longer work.

    Args:
        flight: the flight to continue.
        analysis: computes the prediction.
        trial: the gains that are being tried.
        may_ask: returns whether no longer work is in progress.
        parent: the Qt parent; this object is deleted with it.
    """

    seen_ahead = pyqtSignal(object, object)
    """Simulated times [s] and velocity or yaw rate along the trial's axis; both may be empty."""
    foreseen = pyqtSignal(float, object)
    """End of the predicted path [s], and its positions in W (N, 3) [m]; N may be 0."""

    def __init__(
        self,
        flight: FlightModel,
        analysis: Analysis,
        trial: Trial,
        may_ask: Callable[[], bool],
        parent: QObject | None = None,
    ) -> None:
        super().__init__(parent)
        self._flight, self._analysis, self._trial = flight, analysis, trial
        self._may_ask = may_ask
        self._seen = False
        self._busy = False
        self._again = False
        self._asked: Fork | None = None
        trial.changed.connect(self.follow)
        analysis.answered.connect(self._hear)
        analysis.refused.connect(self._hear_refusal)

    def set_seen(self, seen: bool) -> None:
        """Predict only while the screen is visible."""
        self._seen = seen

    def begin(self) -> None:
        """Clear the last flight."""
        self._busy = self._again = False
        self._asked = None
        self._clear()

    def follow(self) -> None:
        """Predict with the present proposed gains."""
        if self._trial.proposed == self._trial.flown:
            self._again = False
            self._clear()
        elif self._busy:
            self._again = True
        elif self._seen and self._trial.step is not None and self._may_ask():
            self._busy, self._again = True, False
            self._flight.order(lambda live: live.checkpoint(), self._ask, lambda said: self._rest())

    def _ask(self, checkpoint: Checkpoint) -> None:
        branch = Branch(FUTURE_NAME, self._trial.proposed)
        self._asked = Fork(checkpoint, (branch,), AHEAD)
        self._analysis.ask(self._asked)

    def _hear(
        self, question: Question, forked: Sequence[tuple[FlownBranch, StepNumbers | None]]
    ) -> None:
        if not isinstance(question, Fork) or self._asked is None:
            return
        branch, _ = forked[0]
        step = self._trial.step
        waited = self._trial.proposed != self._trial.flown
        if branch.name == FUTURE_NAME and step is not None and waited:
            self.seen_ahead.emit(branch.time, branch.response(step.axis))
            self.foreseen.emit(branch.time[-1] if len(branch.time) else 0.0, branch.position)
        self._rest()

    def _hear_refusal(self, question: Question, said: str) -> None:
        if isinstance(question, Fork):  # the card of forks reports the reason if it has asked
            self._rest()

    def _rest(self) -> None:
        self._busy, self._asked = False, None
        if self._again:
            self.follow()

    def _clear(self) -> None:
        self.seen_ahead.emit(np.empty(0), np.empty(0))
        self.foreseen.emit(0.0, np.empty((0, 3)))


class TuningScreen(Screen):
    """Where gains are tuned while the drone flies.

    Args:
        workspace: services that all screens share.

    Attributes:
        gains: editor of the gains.
        gain_files: loads and saves gain files.
        trial: the gains that are being tried.
        designs: designs to compare.
        excitation, response, margins, frequency, poles, map, weights, compare: cards.
        fork, autotune, pin, what_if: cards as well.
    """

    def __init__(self, workspace: Workspace) -> None:
        super().__init__(workspace)
        analysis = workspace.analysis
        self.gains = GainEditor(
            workspace.flight, analysis, workspace.preferences, workspace.notices, self
        )
        self.gain_files = GainFiles(self.gains, workspace.notices, self)
        self.trial = Trial(self.gains, self)
        self.limits = Limits(workspace.preferences.store, self)
        self.judgement = Judgement(analysis, self)
        self._predictor = Follower(analysis, Predict, self)
        self.designs = Designs(workspace.flight, self.trial, self)
        self.excitation = ExcitationCard(workspace)
        self.response = ResponseCard(
            workspace, self.limits, self.excitation.choice, self.designs, self._decay_time
        )
        self.margins = MarginsCard(workspace, self.judgement, self.limits)
        self.poles = PolesCard(workspace, self.trial, self.judgement)
        self.frequency = FrequencyCard(workspace, self.trial, self.judgement, self.limits)
        self.map = MapCard(workspace, self.trial)
        self.weights = WeightsCard(workspace, self.trial)
        self.compare = CompareCard(workspace, self.trial, self.designs, self.limits)
        self.fork = ForkCard(workspace, self.trial, self.designs)
        self.autotune = AutoTuneCard(workspace, self.trial)
        self.pin = PinCard(workspace, self.trial)
        self.what_if = WhatIfCard(workspace, self.trial, self.designs)
        self.ghost = Ghost(workspace.flight, analysis, self.trial, self._is_free, self)
        self._cards = {
            "Frequency": self.frequency,
            "Poles": self.poles,
            "Map": self.map,
            "Sensitivity": self.weights,
            "Compare": self.compare,
            "Fork": self.fork,
            "Tune": self.autotune,
            "Pin": self.pin,
            "What if": self.what_if,
        }
        self.tabs = QTabWidget()
        for name, card in self._cards.items():
            self.tabs.addTab(card, name)
        self.panel = GainPanel(workspace, self.gains)
        self.diff_judgement = Judgement(analysis, self)
        self.diff_margins = MarginsCard(
            workspace, self.diff_judgement, self.limits, "Margins with these"
        )
        self.diff_margins.hide()
        self.gain_files.diff_changed.connect(self._judge_diff)
        bar = GainBar(workspace, self.gains, self.gain_files)
        gains = column(bar, self.diff_margins, (self.panel, 1), spacing=GAP)
        explain(gains, "Gains")
        response = column(self.excitation, (self.response, 1), spacing=GAP)
        self.arrangement = Arrangement(gains, scrolled(response), self.margins, self.tabs)
        hbox(self.arrangement, of=self, margins=NO_MARGINS)
        # Linked gains, or a whole gain file, change one by one: ask once.
        self._soon = single_shot(self._ask, self)
        self._connect()
        self._plan(self.excitation.choice)

    def _judge_diff(self, diff: GainFileDiff | None) -> None:
        """Show the effect of a loaded gain file on the margins, while it waits for a choice."""
        self.diff_judgement.set_seen(diff is not None)
        self.diff_margins.setVisible(diff is not None)
        if diff is not None:
            flown = self.gains.flown
            self.diff_judgement.follow(diff.after(flown), diff.before(flown))

    def begin(self, view: LiveView) -> None:
        """Clear the last flight."""
        self.gains.begin(view)
        self.judgement.clear()
        self.diff_judgement.clear()
        self._predictor.forget()
        self.excitation.begin()
        self.response.begin(view)
        self.trial.set_step(self.response.step)
        self.designs.begin()
        self._begin_cards()

    def take_over(self, view: LiveView) -> None:
        """Evaluate the controller that has taken over."""
        self.gains.take_over(view)
        self.judgement.clear()
        self._predictor.forget()
        self.designs.take_over()
        self._begin_cards()

    def _begin_cards(self) -> None:
        for card in self._cards.values():
            card.begin()
        self.ghost.begin()
        self.trial.changed.emit()

    def show_view(self, view: LiveView) -> None:
        """Show a view."""
        if view.snapshot is not None:
            self.gains.follow(view.snapshot)
            self.panel.set_bar.show_snapshot(view.snapshot)
        self.excitation.show_view(view)
        self.frequency.measuring.show_view(view)
        self.response.show_view(view, self.trial.flown)
        self.trial.set_step(self.response.step)

    def unsaved(self) -> str:
        """Return which gains would be lost with the flight."""
        return self.gain_files.unsaved()

    def save_unsaved(self, saved: Callable[[], object]) -> None:
        """Ask for a file, and write those gains to it."""
        ask_to_save(self.window() or self, lambda path: self.gain_files.save_unsaved(path, saved))

    def close_screen(self) -> None:
        """Wait for files that are being read or written."""
        self.gain_files.close()

    def showEvent(self, event: QShowEvent | None) -> None:
        """Ask again: the screen is visible."""
        super().showEvent(event)
        self.workspace.analysis.warm_up()
        self._set_seen()

    def hideEvent(self, event: QHideEvent | None) -> None:
        """Stop asking: the screen is hidden."""
        super().hideEvent(event)
        self._set_seen()

    def _connect(self) -> None:
        self.gains.set_changed.connect(self._judge_set)
        self.trial.changed.connect(self._soon.start)
        self.excitation.chosen.connect(self._plan)
        self._predictor.answered.connect(self._show_predicted)
        self._predictor.refused.connect(self.response.refuse_predicted)
        self._predictor.preparing.connect(self.response.show_preparing)
        self.ghost.seen_ahead.connect(self.response.show_ahead)
        self.ghost.foreseen.connect(self.workspace.scene.foreseen)
        self.margins.loop_chosen.connect(self.frequency.choose_loop)
        self.margins.loop_chosen.connect(self.poles.choose_loop)
        self.tabs.currentChanged.connect(lambda _: self._set_seen())

    def _plan(self, choice: ExcitationChoice) -> None:
        self.response.plan(choice)
        self.trial.set_step(self.response.step)

    def _ask(self) -> None:
        """Ask about the proposed gains."""
        gains, step = self.trial.judged, self.trial.excited
        if not gains:
            return
        self.judgement.follow(gains, self.trial.judged_flown)
        self.frequency.follow()
        if step is not None:
            self._predictor.ask(Predict(gains, step))
            self._show_predicted()

    def _show_predicted(
        self, question: Predict | None = None, predicted: Predicted | None = None
    ) -> None:
        """Show the prediction with the present gains if it is known, else the newest one."""
        gains, step = self.trial.judged, self.trial.excited
        known = self.workspace.analysis.known(Predict(gains, step)) if step is not None else None
        if known is not None and step is not None:
            self.response.show_predicted(step, known)
        elif question is not None and predicted is not None:
            self.response.show_predicted(question.step, predicted)

    def _decay_time(self) -> float:
        """Return the decay time of the chosen step with the gains that fly [s], 0 if unknown."""
        step = self.response.step
        if step is None:
            return 0.0
        known = self.workspace.analysis.known(Predict(self.trial.judged_flown, step))
        return known.decay if known is not None else 0.0

    def _judge_set(self) -> None:
        """Evaluate another set of scheduled gains."""
        self.judgement.clear()
        self._predictor.forget()
        for card in (self.frequency, self.map, self.weights, self.compare):
            card.begin()
        self._soon.start()

    def _is_free(self) -> bool:
        """Whether no long work is in progress for the user."""
        return not (self.autotune.is_running or self.fork.is_busy)

    def _set_seen(self) -> None:
        seen = self.isVisible()
        self.judgement.set_seen(seen)
        self._predictor.set_seen(seen)
        self.ghost.set_seen(seen)
        shown = self.tabs.currentWidget()
        for card in self._cards.values():
            card.set_seen(seen and shown is card)
