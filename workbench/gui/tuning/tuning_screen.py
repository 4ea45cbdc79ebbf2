"""The tuning screen: gains, excitation, response, margins, and further aids."""

import time
from collections.abc import Callable, Iterable

from PyQt6.QtCore import Qt
from PyQt6.QtGui import QHideEvent, QKeySequence, QResizeEvent, QShortcut, QShowEvent
from PyQt6.QtWidgets import QApplication, QSizePolicy, QTabWidget, QWidget

from workbench.analysis.queries import Predict
from workbench.analysis.replies import Predicted
from workbench.common.plain_files import write_in_folder
from workbench.gui.analysis import QueryStream
from workbench.gui.errands import single_shot
from workbench.gui.gains.gain_bar import GainBar, ask_to_save
from workbench.gui.gains.gain_editor import GainEditor
from workbench.gui.gains.gain_file_diff import GainFileDiff
from workbench.gui.gains.gain_files import GainFiles
from workbench.gui.gains.gain_history import GainHistory
from workbench.gui.gains.gain_panel import GainPanel
from workbench.gui.help import set_card_help
from workbench.gui.layout import NO_MARGINS, column, hbox, scrolled
from workbench.gui.saved_files import save_beside_logs
from workbench.gui.screens import Screen
from workbench.gui.tuning.added_cards import added_cards
from workbench.gui.tuning.ahead_prediction import AheadPrediction
from workbench.gui.tuning.arrangement import LOW_SCREEN_PX, TUNING_GAP_PX, Arrangement
from workbench.gui.tuning.autotune_card import AutoTuneCard
from workbench.gui.tuning.card import CARD_FILL_SHORTCUT, CARD_WINDOW_SHORTCUT, TuningCard
from workbench.gui.tuning.compare_card import CompareCard
from workbench.gui.tuning.designs import Designs
from workbench.gui.tuning.excitation_card import ExcitationCard
from workbench.gui.tuning.excitation_form import ExcitationChoice
from workbench.gui.tuning.fork_card import ForkCard
from workbench.gui.tuning.frequency_card import FrequencyCard
from workbench.gui.tuning.history_dialog import HistoryDialog
from workbench.gui.tuning.judgement import StabilityFollower
from workbench.gui.tuning.limits import LimitValues
from workbench.gui.tuning.map_card import MapCard
from workbench.gui.tuning.margins_card import MarginsCard
from workbench.gui.tuning.pin_card import PinCard
from workbench.gui.tuning.poles_card import PolesCard
from workbench.gui.tuning.response_card import ResponseCard
from workbench.gui.tuning.session_report import picture_of, session_report
from workbench.gui.tuning.trial import TuningTrial
from workbench.gui.tuning.weights_card import WeightsCard
from workbench.gui.workspace import Workspace
from workbench.live.view import LiveView
from workbench.parameters.flight_parameters import VEHICLE_SYSTEMS

VEHICLE_REST_MS = 1000
"""Time without a change of the vehicle after which it is judged anew [ms]."""
VEHICLE_SYSTEM_TEXTS = {"cables": "hooks"}
"""What systems of the vehicle are called, where it is not their name."""


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
        fork, autotune, pin: cards as well.
        added: cards of other packages by their titles.
    """

    def __init__(self, workspace: Workspace) -> None:
        super().__init__(workspace)
        analysis = workspace.analysis
        self.gains = GainEditor(
            workspace.flight, analysis, workspace.preferences, workspace.notices, self
        )
        self.gain_files = GainFiles(self.gains, workspace.notices, self)
        self.history = GainHistory(self.gains, workspace.flight, self)
        self.history.changed.connect(self._take_note)
        self.trial = TuningTrial(self.gains, self)
        self.limits = LimitValues(workspace.preferences.store, self)
        self.judgement = StabilityFollower(analysis, self)
        self._predictor = QueryStream(analysis, self)
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
        self.added = {
            row.title: row.make(workspace, self.trial, self.designs) for row in added_cards()
        }
        self.ghost = AheadPrediction(workspace.flight, analysis, self.trial, self._is_free, self)
        self._cards = {
            "Frequency": self.frequency,
            "Poles": self.poles,
            "Map": self.map,
            "Sensitivity": self.weights,
            "Compare": self.compare,
            "Fork": self.fork,
            "Tune": self.autotune,
            "Pin": self.pin,
            **self.added,
        }
        self.tabs = QTabWidget()
        for name, card in self._cards.items():
            self.tabs.addTab(card, name)
        self.panel = GainPanel(workspace, self.gains)
        self.diff_judgement = StabilityFollower(analysis, self)
        self.diff_margins = MarginsCard(
            workspace, self.diff_judgement, self.limits, "Margins with these"
        )
        self.diff_margins.setSizePolicy(QSizePolicy.Policy.Preferred, QSizePolicy.Policy.Maximum)
        self.diff_margins.excite.hide()
        self.diff_margins.hide()
        self.gain_files.diff_changed.connect(self._judge_diff)
        bar = GainBar(workspace, self.gains, self.gain_files)
        bar.history_wanted.connect(self._show_history)
        bar.report_wanted.connect(self.write_report)
        gains = column(bar, self.diff_margins, (self.panel, 1), 0, spacing=TUNING_GAP_PX)
        set_card_help(gains, "Gains")
        response = column(self.excitation, (self.response, 1), spacing=TUNING_GAP_PX)
        self.arrangement = Arrangement(
            gains, scrolled(response), self.margins, self.tabs, [*bar.actions_by_name.values()]
        )
        hbox(self.arrangement, of=self, margins=NO_MARGINS)
        self.addActions([self.excitation.excite, self.panel.search_action])  # on each tab
        self.panel.search_action.triggered.connect(lambda: self._show_gains(gains))
        # Linked gains, or a whole gain file, change one by one: ask once.
        self._soon = single_shot(self._ask, self)
        self._vehicle_rest = single_shot(self._judge_vehicle, self, VEHICLE_REST_MS)
        self._changed_systems: set[str] = set()
        self._connect()
        self._plan(self.excitation.choice)

    def _judge_diff(self, diff: GainFileDiff | None) -> None:
        """Show the effect of a loaded gain file on the margins, while it waits for a choice."""
        self._make_room_for_diff()
        self.diff_judgement.set_seen(diff is not None)
        self.diff_margins.setVisible(diff is not None)
        if diff is not None:
            flown = self.gains.flown
            self.diff_judgement.follow(diff.after(flown), diff.before(flown))

    def _make_room_for_diff(self) -> None:
        """Show the lines of a loaded gain file in place of the gains where the screen is low."""
        low = self.height() < LOW_SCREEN_PX
        if low == self.diff_margins.fold.isVisibleTo(self.diff_margins):
            self.diff_margins.set_folded(low)
            self.diff_margins.fold.setVisible(not low)
        self.panel.setVisible(self.gain_files.diff is None or not low)

    def resizeEvent(self, event: QResizeEvent | None) -> None:
        """Make room for the lines of a loaded gain file."""
        super().resizeEvent(event)
        self._make_room_for_diff()

    def begin(self, view: LiveView) -> None:
        """Clear the last flight."""
        self._vehicle_rest.stop()
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
        self.diff_judgement.clear()
        self._judge_diff(self.gain_files.diff)
        self._predictor.forget()
        self.designs.take_over()
        self._begin_cards()

    def show_card(self, title: str) -> None:
        """Show a card of another package."""
        self.arrangement.show_card(self.added[title])

    def write_report(self) -> None:
        """Write the report of the session to the folder for logs."""
        pictures = {"Response": picture_of(self.response)}
        if self.frequency.curves.shown:  # else it would be a picture of nothing
            pictures["Frequency"] = picture_of(self.frequency)
        view, margins = self.workspace.flight.view, self.margins.rows
        page = session_report(view, self.gains, self.history, margins, pictures)
        name = f"tuning_{time.strftime('%Y%m%d_%H%M%S')}.html"
        save_beside_logs(self.workspace, name, lambda path: bool(write_in_folder(path, page)))

    def _take_note(self) -> None:
        """Let the note on the kept gains be saved with them."""
        self.gain_files.note = self.history.note

    def _show_history(self) -> None:
        notices = self.workspace.notices
        HistoryDialog(self.gains, self.history, self.gain_files, notices, self.window()).show()

    def _show_gains(self, gains: QWidget) -> None:
        """Show the gains if they are in a tab, and search them."""
        if self.tabs.indexOf(gains) >= 0:
            self.tabs.setCurrentWidget(gains)
            self.panel.search.setFocus(Qt.FocusReason.ShortcutFocusReason)

    def _begin_cards(self) -> None:
        self._changed_systems.clear()
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
        self.margins.show_excited(view.exciting is not None)
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
        self.arrangement.close_windows()
        self.gain_files.close()

    def focusNextPrevChild(self, forward: bool) -> bool:
        """Let Tab go to the gains first."""
        first = self.panel.first_stop if forward and self.hasFocus() else None
        if first is None:
            return super().focusNextPrevChild(forward)
        first.setFocus(Qt.FocusReason.TabFocusReason)
        return True

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
        self.gains.flown_changed.connect(self._follow_vehicle)
        self.gains.flown_changed.connect(self.excitation.fault.follow)
        self.trial.changed.connect(self._soon.start)
        self.excitation.chosen.connect(self._plan)
        self._predictor.answered.connect(self._show_predicted)
        self._predictor.refused.connect(self.response.refuse_predicted)
        self._predictor.preparing.connect(self.response.show_preparing)
        self.ghost.seen_ahead.connect(self.response.show_ahead)
        self.ghost.foreseen.connect(self.workspace.scene.foreseen)
        self.margins.loop_chosen.connect(self.frequency.choose_loop)
        self.margins.loop_chosen.connect(self.poles.prefer_loop)
        self.margins.excitation_wanted.connect(self._choose_excited_loop)
        self.poles.loop_wanted.connect(self._show_loop)
        self.tabs.currentChanged.connect(lambda _: self._set_seen())
        self.arrangement.windows_changed.connect(self._set_seen)
        for keys, do in (
            (CARD_FILL_SHORTCUT, self.arrangement.fill_column),
            (CARD_WINDOW_SHORTCUT, self.arrangement.move_to_window),
        ):
            shortcut = QShortcut(QKeySequence(keys), self)
            shortcut.activated.connect(lambda do=do: do(self._present_card()))

    def _show_loop(self, name: str) -> None:
        """Show the frequency response of a loop."""
        self.frequency.choose_loop(name)
        self.arrangement.show_card(self.frequency)

    def _choose_excited_loop(self, name: str) -> None:
        """Choose the setpoint of a loop for the next excitation, and show it."""
        self.excitation.choose_loop(name)
        self.arrangement.show_card(self.excitation)

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

    def _follow_vehicle(self, names: Iterable[str]) -> None:
        """Judge anew soon after a load is dropped or taken, or a servo moves."""
        if changed := self._vehicle_names & {*names}:
            self._vehicle_rest.start()
            self._changed_systems |= {row.system for row in self.gains.rows if row.name in changed}
            self._note_vehicle("soon")

    def _note_vehicle(self, when: str = "") -> None:
        """Let the cards say that their numbers are of the vehicle before a change, if it is so."""
        words = (VEHICLE_SYSTEM_TEXTS.get(name, name) for name in self._changed_systems)
        what = " and ".join(sorted(words))
        said = f"Of the vehicle before its {what} changed: judged anew {when}." if what else ""
        for each in (self.judgement, self.diff_judgement):
            each.note_vehicle(said)

    @property
    def _vehicle_names(self) -> frozenset[str]:
        """Names of the parameters that change the vehicle."""
        return frozenset(row.name for row in self.gains.rows if row.system in VEHICLE_SYSTEMS)

    def _judge_vehicle(self) -> None:
        """Evaluate the vehicle with its present payload, hooks and setpoints of servos."""
        view = self.workspace.flight.view
        if not self._is_free():  # a search or a fork would be lost
            self._vehicle_rest.start()
            self._note_vehicle("once the search or the fork has ended")
        elif view.scenario is not None:
            now = {name: self.gains.flown[name] for name in self._vehicle_names}
            settings = {**view.values, **now}
            if self.workspace.analysis.begin(view.scenario, settings, view.controller):
                self.take_over(view)
            else:  # it is as it was
                self._changed_systems.clear()
                self._note_vehicle()

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

    def _present_card(self) -> TuningCard:
        """Return the card with the keyboard, else that of the tab in front, else the response."""
        part: QWidget | None = QApplication.focusWidget()
        while part is not None and not isinstance(part, TuningCard):
            part = part.parentWidget()
        shown = self.tabs.currentWidget()
        return part or (shown if isinstance(shown, TuningCard) else self.response)

    def _set_seen(self) -> None:
        windowed = self.arrangement.windowed
        seen = self.isVisible() or bool(windowed)
        self.judgement.set_seen(seen)
        self._predictor.set_seen(seen)
        self.ghost.set_seen(seen)
        shown = self.tabs.currentWidget() if self.isVisible() else None
        for card in self._cards.values():
            card.set_seen(card is shown or card in windowed)
