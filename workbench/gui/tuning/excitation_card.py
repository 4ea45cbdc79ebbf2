"""The card that excites the drone: by a command, a load, a gust, the wind or a fault."""

import math
from dataclasses import replace
from itertools import pairwise

from PyQt6.QtCore import QSignalBlocker, pyqtSignal
from PyQt6.QtWidgets import (
    QCheckBox,
    QStackedWidget,
    QTabBar,
    QWidget,
)

from workbench.common.quantity import DisplayUnit
from workbench.control.controller_file import controller_or_default, load_controller
from workbench.control.mode import FlightMode
from workbench.gui.command_action import CommandAction, show_tip
from workbench.gui.key_table import EXCITE_KEY
from workbench.gui.labels import Label, set_tip, tip_text
from workbench.gui.layout import button, choice, fill, hbox
from workbench.gui.number_field import NumberField
from workbench.gui.style import set_class
from workbench.gui.tuning.card import CARD_SPACING_PX, TuningCard, fields_beside
from workbench.gui.tuning.excitation_form import (
    EXCITATION_KINDS,
    MIN_AMPLITUDE,
    PERIOD_LIMITS_S,
    ExcitationChoice,
    load_choice,
    load_kind,
    loop_excitation,
    reach_text,
    save_choice,
)
from workbench.gui.tuning.fault_form import FaultForm
from workbench.gui.tuning.wind_form import ELIDING_SIZE_POLICY, FIELD_LABEL_GAP_PX, WindForm
from workbench.gui.units import unit_for
from workbench.gui.workspace import Workspace
from workbench.live.orders import FlightOrder
from workbench.live.view import LiveView
from workbench.scenario.attitude_axes import AttitudeAxis
from workbench.scenario.excitation import MAX_SWING_WAIT_S, ActiveExcitation
from workbench.scenario.loads import Load, find_excited
from workbench.scenario.scenario import Action

EXCITATION_FIELD_WIDTHS_PX = (50, 94, 102, 82)
"""Least widths of the fields [px]."""
GROUNDED_MODES = (FlightMode.OFF, FlightMode.ARMED)
EXCITATION_TAB_STYLE = "QTabBar::tab { padding: 4px 6px; margin-right: 0; }"
WIND_TAB, FAULT_TAB = len(EXCITATION_KINDS), len(EXCITATION_KINDS) + 1
"""Indices of the tabs after those of the kinds of excitation."""
TRANSITION_MODES = (FlightMode.TAKING_OFF, FlightMode.LANDING)


class ExcitationCard(TuningCard):
    """Starts and stops an excitation of the flight, sets its wind, and makes its parts fail.

    Args:
        workspace: its flight is excited, and its preferences store the choice.

    Attributes:
        is_running: whether the flight is excited.
        excite: starts and stops by its key.
    """

    chosen = pyqtSignal(object)
    """A new `ExcitationChoice`."""

    def __init__(self, workspace: Workspace) -> None:
        super().__init__("Excitation")
        self._flight, self._absence = workspace.flight, workspace.absence
        self._preferences = workspace.preferences
        store = workspace.preferences.store
        self._choices = {kind.name: load_choice(store, kind) for kind in EXCITATION_KINDS}
        self.choice = self._choices[load_kind(store).name]
        self.is_running = False
        self._mode = FlightMode.OFF
        self._seen: tuple[object, ...] = ()
        self.tabs = QTabBar()
        for kind in EXCITATION_KINDS:
            self.tabs.setTabToolTip(self.tabs.addTab(kind.name), tip_text(kind.help))
        self.tabs.setTabToolTip(self.tabs.addTab("Wind"), "Wind and turbulence that stay")
        self.tabs.setTabToolTip(self.tabs.addTab("Fault"), "A rotor or a sensor that fails")
        self.axis, self.shape = choice("Axis"), choice("Shape")
        self.amplitude = NumberField("Amplitude", 2, 0.1)
        self.period = NumberField("Period", 2, 0.1)
        self.wind = WindForm(workspace)
        self.fault = FaultForm(workspace)
        self.pages = QStackedWidget()
        self.repeats = QCheckBox("Repea&t")
        set_tip(self.repeats, "Repeat it until it is stopped")
        self.button = button("Start", self.start_or_stop, "primary")
        self.excite = CommandAction(EXCITE_KEY, workspace.keys, self.start_or_stop, self)
        show_tip(self.button, self.excite)
        self.take_off = button(
            "Take off", self._take_off, help="The drone must fly before it can be excited"
        )
        self.take_off.setVisible(False)
        self._lay_out()
        self.tabs.setCurrentIndex(EXCITATION_KINDS.index(self.choice.kind))
        self._show_kind()
        self.tabs.currentChanged.connect(self._choose_tab)
        self.fault.changed.connect(lambda: self._show_state(self._flight.view))
        self._absence.changed.connect(lambda _: self._show_state(self._flight.view))
        self.wind.speed.refused.connect(lambda _: self._show_state(self._flight.view))
        self.axis.activated.connect(self._choose_axis)
        self.shape.activated.connect(self._choose_shape)
        self.amplitude.edited.connect(self._choose_amplitude)
        self.period.edited.connect(lambda value: self._take(replace(self.choice, period=value)))
        for field in (self.amplitude, self.period):
            field.refused.connect(lambda _: self._show_state(self._flight.view))
        self.repeats.toggled.connect(lambda on: self._take(replace(self.choice, repeats=on)))
        workspace.preferences.changed.connect(lambda name: self._show_choice())
        self._show_state(workspace.flight.view)

    def show_view(self, view: LiveView) -> None:
        """Show the possible actions."""
        running = view.exciting is not None
        mode = view.snapshot.mode if view.snapshot is not None else FlightMode.OFF
        phase = _phase(view.exciting) if view.exciting else None
        seen = (running, phase, view.excitation_ended, mode, view.phase)
        if seen != self._seen or not self.said.text():
            self._seen, self.is_running, self._mode = seen, running, mode
            self._show_state(view)

    def start_or_stop(self) -> None:
        """Start or stop the excitation; does nothing if the drone cannot fly it."""
        if self.is_running:
            self._flight.do(FlightOrder.STOP_EXCITING)
        elif self.button.isEnabled() and self.tabs.currentIndex() < len(EXCITATION_KINDS):
            excitation = self.choice.excitation
            self._flight.do(excitation)

    def choose_loop(self, loop: str) -> None:
        """Choose a step of the setpoint of a loop, if it has one and nothing runs."""
        found = loop_excitation(loop)
        if found is None or self.is_running:
            return
        kind, axis = found
        step = kind.shapes[0]
        self._choices[kind.name] = replace(self._choices[kind.name], axis=axis, shape=step)
        self.tabs.setCurrentIndex(EXCITATION_KINDS.index(kind))
        self._take(self._choices[kind.name])

    def _take_off(self) -> None:
        self._flight.do(Action(request="take_off"))

    def _choose_tab(self, index: int) -> None:
        if index < len(EXCITATION_KINDS):
            self._take(self._choices[EXCITATION_KINDS[index].name])
        self._show_kind()
        self._show_state(self._flight.view)

    def _choose_axis(self, index: int) -> None:
        self._take(replace(self.choice, axis=self.choice.kind.rows[index].name))

    def _choose_shape(self, index: int) -> None:
        self._take(replace(self.choice, shape=self.choice.kind.shapes[index]))

    def _choose_amplitude(self, amplitude: float) -> None:
        self._take(self.choice.with_amplitude(amplitude))

    def _take(self, choice: ExcitationChoice) -> None:
        if choice == self.choice:
            return
        other = choice.kind is not self.choice.kind
        self.choice = self._choices[choice.kind.name] = choice
        save_choice(self._preferences.store, choice)
        self._show_choice()
        self._show_state(self._flight.view)
        self.chosen.emit(choice)
        if self.is_running and not other:  # show the running excitation
            excitation = choice.excitation
            self._flight.do(excitation)

    def _show_kind(self) -> None:
        """Show the fields of the selected tab."""
        index, kind = self.tabs.currentIndex(), self.choice.kind
        self.pages.setCurrentIndex(max(0, index - len(EXCITATION_KINDS) + 1))
        if index >= len(EXCITATION_KINDS):
            return
        for box, names in (
            (self.axis, [kind.label(row) for row in kind.rows]),
            (self.shape, [shape.value for shape in kind.shapes]),
        ):
            with QSignalBlocker(box):
                box.clear()
                box.addItems(names)
            box.setEnabled(len(names) > 1)
        self._time_label.setText(kind.time)
        self.period.setAccessibleName(kind.time.replace("&", ""))
        self.period.set_range(DisplayUnit("s"), kind.shortest, PERIOD_LIMITS_S[1])
        self._show_choice()

    def _show_choice(self) -> None:
        choice, axis = self.choice, find_excited(self.choice.axis)
        self.axis.setCurrentIndex(choice.kind.find(choice.axis))
        set_tip(self.axis, axis.label)
        self.shape.setCurrentIndex(choice.kind.shapes.index(choice.shape))
        row = load_controller().table.find(axis.limit)
        most = row.maximum
        if not isinstance(axis, Load):  # the parameter that limits a load is the load itself
            most = self._flight.view.values.get(axis.limit, most)
        if isinstance(axis, AttitudeAxis):
            most /= axis.largest_tilt(1.0, choice.excitation.longest_level)
        self.amplitude.set_range(unit_for(axis.unit, self._preferences), -most, most, MIN_AMPLITUDE)
        self.amplitude.show_si(min(max(choice.amplitude, -most), most))
        self.period.show_si(choice.period)
        with QSignalBlocker(self.repeats):
            self.repeats.setChecked(choice.repeats)

    def begin(self) -> None:
        """Use the limits of another flight."""
        self.is_running, self._mode, self._seen = False, FlightMode.OFF, ()
        self.fault.begin(self._flight.view.values)
        self._show_choice()
        limited = self.amplitude.si
        if abs(limited) >= MIN_AMPLITUDE and limited != self.choice.amplitude:
            self.choice = self.choice.with_amplitude(limited)
        self._show_state(self._flight.view)

    def _show_state(self, view: LiveView) -> None:
        lives = view.snapshot is not None and not view.is_over
        flies = lives and self._mode not in (*GROUNDED_MODES, *TRANSITION_MODES)
        excites = self.tabs.currentIndex() < len(EXCITATION_KINDS)
        for part, shown in (
            *((each, excites or self.is_running) for each in (self.repeats, self.button)),
            *((each, self.tabs.currentIndex() == WIND_TAB) for each in self.wind.buttons),
            *((each, self.tabs.currentIndex() == FAULT_TAB) for each in self.fault.buttons),
        ):
            part.setVisible(shown)
        self.wind.set_enabled(view.snapshot is not None)
        self.button.setText("Stop" if self.is_running else self.choice.kind.start)
        set_class(self.button, "" if self.is_running else "primary")
        axis, law = find_excited(self.choice.axis), controller_or_default(view.controller)
        missing = axis.missing_from(law) if isinstance(axis, AttitudeAxis) else ""
        faults = self.amplitude.fault or self.period.fault or missing
        self.button.setEnabled(self.is_running or (flies and not faults))
        self.take_off.setVisible(lives and excites and self._mode in GROUNDED_MODES)
        if view.snapshot is None:
            self.said.say(self._absence.text)
        elif not lives:
            self.said.say("The flight has ended: reset it.", "warning")
        elif not excites and not self.is_running:
            self._say_disturbed(view)
        elif view.exciting is not None and view.exciting.waited is not None:
            waited = f"{math.floor(view.exciting.waited)} s, {MAX_SWING_WAIT_S:.0f} s at most"
            self.said.say(f"Waiting until it no longer swings: {waited}.", "good")
        elif view.exciting is not None and view.exciting.drifts:
            self.said.say("Drifting with the wind until that is steady.", "good")
        elif view.exciting is not None and view.exciting.returning:
            self.said.say("Flying back to where it began.", "good")
        elif view.exciting is not None and view.exciting.round == 0:
            self.said.say("Coming to rest before the first step.", "good")
        elif self.is_running:
            self.said.say("Running.", "good")
        elif faults:
            self.said.say(faults, "warning")
        elif self._mode in GROUNDED_MODES:
            self.said.say("The drone must hover: take off.", "warning")
        elif self._mode in TRANSITION_MODES:
            self.said.say(f"The drone is {self._mode.label}.")
        elif view.excitation_ended:
            self.said.say(f"Ended: {view.excitation_ended}.", "warning")
        else:
            self.said.say(reach_text(self.choice.excitation) or "Ready.")

    def _say_disturbed(self, view: LiveView) -> None:
        """Show the present wind, or what has failed."""
        if self.tabs.currentIndex() == WIND_TAB:
            self.said.say(self.wind.speed.fault or "It blows until you change it.")
        elif self.fault.said:
            self.said.say(f"Failed: {self.fault.said}.", "warning")
        else:
            self.said.say("Nothing has failed.")

    def _fields(self) -> tuple[QWidget, ...]:
        return self.axis, self.shape, self.amplitude, self.period

    def _lay_out(self) -> None:
        # the sentence has a line of its own, with the button that goes after a take-off at its end:
        # there it has room for two lines at any width, so that nothing else moves
        self.head.removeWidget(self.said)
        parts = (*self.wind.buttons, *self.fault.buttons, self.repeats, self.button)
        fill(self.head, 1, *parts)
        for box in (self.axis, self.shape):
            box.setSizeAdjustPolicy(ELIDING_SIZE_POLICY)
        self.tabs.setStyleSheet(EXCITATION_TAB_STYLE)
        self.tabs.setDrawBase(False)
        self.tabs.setExpanding(False)
        self.tabs.setUsesScrollButtons(False)
        self.tabs.setAccessibleName("Kind of excitation")
        excitation = QWidget()
        for page in (excitation, self.wind, self.fault):
            self.pages.addWidget(page)
        names = ("Ax&is", "&Shape", "&Amplitude", "&Period")
        fields = [*zip(names, self._fields(), strict=True)]
        fields_beside(fields, EXCITATION_FIELD_WIDTHS_PX, of=excitation, gap=FIELD_LABEL_GAP_PX)
        *_, self._time_label = excitation.findChildren(Label)  # of the period, the last one
        state = hbox((self.said, 1), self.take_off, spacing=CARD_SPACING_PX)
        fill(self.body, state, self.tabs, self.pages)
        order = (*self._fields(), self.take_off, self.repeats, self.button)
        for one, other in pairwise(order):
            QWidget.setTabOrder(one, other)


def _phase(exciting: ActiveExcitation) -> tuple[bool, bool, bool, int | None]:
    """Return what the sentence tells of an excitation: it changes once a second at most."""
    waited = None if exciting.waited is None else math.floor(exciting.waited)
    return exciting.drifts, exciting.returning, exciting.round == 0, waited
