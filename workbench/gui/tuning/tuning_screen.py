"""The tuning screen: gains, excitation, response, margins, and all that helps to choose."""

from collections.abc import Callable

from PyQt6.QtGui import QHideEvent, QShowEvent
from PyQt6.QtWidgets import QHBoxLayout, QTabWidget, QVBoxLayout, QWidget

from workbench.analysis.questions import Predict, Question
from workbench.analysis.replies import Predicted, Reply
from workbench.gui.gains.gain_editor import GainEditor
from workbench.gui.gains.gain_panel import GainPanel
from workbench.gui.gains.profile_bar import ProfileBar, ask_to_save
from workbench.gui.gains.profiles import GainProfiles
from workbench.gui.page import scrolled
from workbench.gui.screen import Screen
from workbench.gui.soon import Soon
from workbench.gui.tuning.arrangement import GAP, Arrangement
from workbench.gui.tuning.autotune_card import AutoTuneCard
from workbench.gui.tuning.excitation_card import ExcitationCard
from workbench.gui.tuning.excitation_form import ExcitationChoice
from workbench.gui.tuning.follower import Follower
from workbench.gui.tuning.fork_card import ForkCard
from workbench.gui.tuning.ghost import Ghost
from workbench.gui.tuning.judgement import Judgement
from workbench.gui.tuning.limits import Limits
from workbench.gui.tuning.map_card import MapCard
from workbench.gui.tuning.margins_card import MarginsCard
from workbench.gui.tuning.pin_card import PinCard
from workbench.gui.tuning.poles_card import PolesCard
from workbench.gui.tuning.response_card import ResponseCard
from workbench.gui.tuning.trial import Trial
from workbench.gui.tuning.weights_card import WeightsCard
from workbench.gui.workspace import Workspace
from workbench.live.view import LiveView


class TuningScreen(Screen):
    """Where gains are tuned while the drone flies.

    Args:
        workspace: what all screens share.
        parent: owner.

    Attributes:
        gains: that are tuned.
        profiles: of gains, loaded and saved.
        trial: what is tried.
        excitation, response, margins, poles, map, weights, fork, autotune, pin: the cards.
    """

    title = "Tuning"
    icon = "tuning"

    def __init__(self, workspace: Workspace, parent: QWidget | None = None) -> None:
        super().__init__(workspace, parent)
        analysis = workspace.analysis
        self.gains = GainEditor(
            workspace.flight, analysis, workspace.preferences, workspace.notices, self
        )
        self.profiles = GainProfiles(self.gains, workspace.notices, self)
        self.trial = Trial(self.gains, self)
        self.limits = Limits(workspace.preferences.store, self)
        self.judgement = Judgement(analysis, self)
        self._predictor = Follower(analysis, analysis.predicted, Predict, _answers, self)
        self.excitation = ExcitationCard(workspace)
        self.response = ResponseCard(workspace, self.limits, self.excitation.choice)
        self.margins = MarginsCard(workspace, self.judgement, self.limits)
        self.poles = PolesCard(workspace, self.judgement)
        self.map = MapCard(workspace, self.trial)
        self.weights = WeightsCard(workspace, self.trial)
        self.fork = ForkCard(workspace, self.trial)
        self.autotune = AutoTuneCard(workspace, self.trial)
        self.pin = PinCard(workspace, self.trial)
        self.ghost = Ghost(workspace.flight, analysis, self.trial, self._is_free, self)
        self.tabs = QTabWidget()
        for card, name in (
            (self.poles, "Poles"),
            (self.map, "Map"),
            (self.weights, "Sensitivity"),
            (self.fork, "Fork"),
            (self.autotune, "Tune"),
            (self.pin, "Pin"),
        ):
            self.tabs.addTab(card, name)
        self.panel = GainPanel(workspace, self.gains)
        self.arrangement = Arrangement(
            _stacked(ProfileBar(workspace, self.gains, self.profiles), self.panel),
            scrolled(_stacked(self.excitation, self.response)),
            self.margins,
            self.tabs,
        )
        box = QHBoxLayout(self)
        box.setContentsMargins(0, 0, 0, 0)
        box.addWidget(self.arrangement)
        # Gains that are linked, or a whole profile, change one by one: they are asked about once.
        self._soon = Soon(self._ask, self)
        self._connect()
        self._plan(self.excitation.choice)

    def begin(self, view: LiveView) -> None:
        """Forget the flight before."""
        self.gains.begin(view)
        self.judgement.clear()
        self._predictor.forget()
        self.excitation.begin()
        self.response.begin(view)
        self.trial.set_step(self.response.step)
        for card in (self.map, self.weights, self.fork, self.autotune, self.pin, self.ghost):
            card.begin()
        self.trial.begin()

    def take_over(self, view: LiveView) -> None:
        """Judge the controller that has taken over."""
        self.gains.take_over(view)
        self.judgement.clear()
        self._predictor.forget()
        for card in (self.map, self.weights, self.fork, self.autotune, self.pin, self.ghost):
            card.begin()
        self.trial.begin()

    def show_view(self, view: LiveView) -> None:
        """Show the present."""
        if view.snapshot is not None:
            self.gains.follow(view.snapshot)
            self.panel.set_bar.show_snapshot(view.snapshot)
        self.excitation.show_view(view)
        self.response.show_view(view, self.trial.flown)
        self.trial.set_step(self.response.step)

    def unsaved(self) -> str:
        """Return which gains would be lost with the flight."""
        return self.profiles.unsaved()

    def save_unsaved(self, saved: Callable[[], object]) -> None:
        """Ask for a file, and write them to it."""
        ask_to_save(self.window() or self, lambda path: self.profiles.save_unsaved(path, saved))

    def close_screen(self) -> None:
        """Wait for what is read or written."""
        self.profiles.close()

    def showEvent(self, event: QShowEvent | None) -> None:
        """Ask again: somebody looks."""
        super().showEvent(event)
        self.workspace.analysis.warm_up()
        self._set_seen()

    def hideEvent(self, event: QHideEvent | None) -> None:
        """Ask nothing more: nobody looks."""
        super().hideEvent(event)
        self._set_seen()

    def _connect(self) -> None:
        self.gains.set_changed.connect(self._judge_set)
        self.trial.changed.connect(self._soon.ask)
        self.excitation.chosen.connect(self._plan)
        self._predictor.answered.connect(self.response.show_predicted)
        self._predictor.refused.connect(self.response.refuse_predicted)
        self.ghost.seen_ahead.connect(self.response.show_ahead)
        self.tabs.currentChanged.connect(lambda _: self._set_seen())

    def _plan(self, choice: ExcitationChoice) -> None:
        self.response.plan(choice)
        self.trial.set_step(self.response.step)

    def _ask(self) -> None:
        """Ask about what is proposed now."""
        gains, step = self.trial.judged, self.trial.step
        if not gains:
            return
        self.judgement.follow(gains, self.trial.judged_flown)
        if step is not None:
            self._predictor.ask(Predict(gains, step))

    def _judge_set(self) -> None:
        """Judge another set of scheduled gains."""
        self.judgement.clear()
        self._predictor.forget()
        self.map.begin()
        self.weights.begin()
        self._soon.ask()

    def _is_free(self) -> bool:
        """Whether nothing that takes long is worked on for the user."""
        return not (self.autotune.is_running or self.fork.is_busy)

    def _set_seen(self) -> None:
        seen = self.isVisible()
        self.judgement.set_seen(seen)
        self._predictor.set_seen(seen)
        self.ghost.set_seen(seen)
        shown = self.tabs.currentWidget()
        self.map.set_seen(seen and shown is self.map)
        self.weights.set_seen(seen and shown is self.weights)


def _stacked(*parts: QWidget) -> QWidget:
    """Return parts below each other; the last takes the room there is."""
    column = QWidget()
    box = QVBoxLayout(column)
    box.setContentsMargins(0, 0, 0, 0)
    box.setSpacing(GAP)
    for part in parts:
        box.addWidget(part, 1 if part is parts[-1] else 0)
    return column


def _answers(question: Question, reply: Reply) -> bool:
    assert isinstance(question, Predict)
    return (
        isinstance(reply, Predicted)
        and reply.step == question.step
        and dict(reply.gains) == dict(question.gains)
    )
