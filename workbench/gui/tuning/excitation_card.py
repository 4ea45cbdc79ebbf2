"""The card that excites the drone: by a command, a load, a gust, the wind or a fault."""

import math
from collections.abc import Mapping
from dataclasses import replace

from PyQt6.QtCore import QSignalBlocker, Qt, pyqtSignal
from PyQt6.QtGui import QKeySequence, QShortcut
from PyQt6.QtWidgets import (
    QCheckBox,
    QComboBox,
    QStackedWidget,
    QTabBar,
    QWidget,
)

from workbench.control.mode import FlightMode
from workbench.gui.labels import Label, set_tip, tip_text
from workbench.gui.layout import NO_MARGINS, buddy, button, choice, fill, grid
from workbench.gui.number_field import NumberField
from workbench.gui.style import set_class
from workbench.gui.tuning.card import SPACING, Card, fields_beside
from workbench.gui.tuning.excitation_form import (
    KINDS,
    LEAST,
    PERIODS,
    ExcitationChoice,
    keep_choice,
    load_choice,
    load_kind,
    reach_text,
)
from workbench.gui.units import Unit, unit_for
from workbench.gui.workspace import Workspace
from workbench.live.view import LiveView
from workbench.scenario.faults import PARTS, SENSOR_MODES, TURBULENCES, Part
from workbench.scenario.loads import Load, find_excited
from workbench.scenario.parameters import parameter_table

MOST_WIND = 25.0
"""Largest wind speed [m/s]."""
TURN = math.tau
GAP = 4
"""Between a label and its field [px]."""
ELIDES = QComboBox.SizeAdjustPolicy.AdjustToMinimumContentsLengthWithIcon
NARROWEST_WIND = 100
"""Least width of a field [px]."""
SPEED_KEY, DIRECTION_KEY, TURBULENCE_KEY = (
    f"tuning/wind/{name}" for name in ("speed", "direction", "turbulence")
)
"""Settings keys of the last values."""
THRUST_LEFT = 0.8
"""Initial share of a failed rotor's thrust that remains."""
WIDTHS = (50, 94, 102, 82)
"""Least widths of the fields [px]."""
KEY = "Ctrl+E"
"""Key that starts and stops."""
GROUNDED = (FlightMode.OFF, FlightMode.ARMED)
TABS = "QTabBar::tab { padding: 4px 6px; margin-right: 0; }"
WIND, FAULT = len(KINDS), len(KINDS) + 1
"""Indices of the tabs after those of the kinds of excitation."""
BUSY = (FlightMode.TAKING_OFF, FlightMode.LANDING)


class WindForm(QWidget):
    """Sets the wind of a flight, or calm air.

    Args:
        workspace: its flight gets the wind, and its preferences store the values.

    Attributes:
        buttons: set the wind, and calm the air; the form's user places them.
    """

    def __init__(self, workspace: Workspace) -> None:
        super().__init__()
        self._flight, self._preferences = workspace.flight, workspace.preferences
        self.speed = NumberField("Wind", 1, 1.0)
        self.direction = NumberField("To, from east on to north", 0, 15.0)
        self.direction.set_range(Unit("°", 180.0 / math.pi), -TURN, TURN)
        set_tip(self.direction, "Where the wind blows to: 0° is east, 90° is north")
        self.turbulence = choice(
            "Turbulence", TURBULENCES, "Dryden's, by the wind speed at 20 ft that makes it"
        )
        self.turbulence.setSizeAdjustPolicy(ELIDES)
        self.button = button("Set wind", self.blow, "primary")
        self.still = button(
            "Still air",
            lambda: self._set(0.0, 0.0, TURBULENCES["still"]),
            help="No wind and no turbulence",
        )
        self.buttons = (self.still, self.button)
        store = self._preferences.store
        self._take_kept(store.value(SPEED_KEY, 4.0), store.value(DIRECTION_KEY, 0.0))
        kept = str(store.value(TURBULENCE_KEY, "still"))
        self.turbulence.setCurrentIndex(max(0, self.turbulence.findText(kept)))
        fields = (("&Wind", self.speed), ("T&o", self.direction), ("&Turbulence", self.turbulence))
        fields_beside(fields, NARROWEST_WIND, of=self, gap=GAP)
        self._preferences.changed.connect(lambda _: self._show_unit())

    def blow(self) -> None:
        """Set the wind from now on."""
        store, name = self._preferences.store, self.turbulence.currentText()
        for key, value in ((SPEED_KEY, self.speed.si), (DIRECTION_KEY, self.direction.si)):
            store.setValue(key, value)
        store.setValue(TURBULENCE_KEY, name)
        speed = TURBULENCES[name]
        self._set(self.speed.si, self.direction.si, speed)

    def set_enabled(self, flies: bool) -> None:
        """Enable the buttons while there is a flight."""
        self.button.setEnabled(flies and not self.speed.fault and not self.direction.fault)
        self.still.setEnabled(flies)

    def _set(self, speed: float, direction: float, turbulence: float) -> None:
        values = {
            "wind_x": speed * math.cos(direction),
            "wind_y": speed * math.sin(direction),
            "wind_z": 0.0,
            "turbulence": turbulence,
        }
        self._flight.order(lambda live: live.set_all(values))

    def _take_kept(self, speed: object, direction: object) -> None:
        self._show_unit()
        for field, value, most in (
            (self.speed, speed, MOST_WIND),
            (self.direction, direction, TURN),
        ):
            try:
                number = float(str(value))
            except ValueError:  # written by another version or an editor
                number = 0.0
            field.show_si(number if abs(number) <= most else 0.0)

    def _show_unit(self) -> None:
        speed = self.speed.si if self.speed.text() else 0.0
        self.speed.set_range(unit_for("m/s", self._preferences), 0.0, MOST_WIND)
        self.speed.show_si(speed)


class FaultForm(QWidget):
    """Makes a part of the drone fail, and repairs it.

    Args:
        workspace: has the flight.

    Attributes:
        faults: parameter values of the failed parts.
        buttons: repair, and make fail; the form's user places them.
    """

    changed = pyqtSignal()
    """A part failed or was repaired."""

    def __init__(self, workspace: Workspace) -> None:
        super().__init__()
        self._flight = workspace.flight
        self._parts: tuple[Part, ...] = ()
        self.faults: dict[str, float] = {}
        self.part = choice("Part that fails")
        self.mode = choice("How it fails", SENSOR_MODES)
        self.share = NumberField("Thrust that the rotor still gives", 0, 5.0)
        self.share.set_range(Unit("%", 100.0), 0.0, 1.0)
        self.share.show_si(THRUST_LEFT)
        self.how = QStackedWidget()
        self.how.addWidget(self.mode)
        self.how.addWidget(self.share)
        self.button = button("Fail now", self.fail, "danger")
        self.repair = button("Repair", self._repair, help="Repair this part")
        self.buttons = (self.repair, self.button)
        grid(
            (buddy("&Part", self.part), buddy("&Fault", self.how)),
            (self.part, self.how),
            of=self,
            margins=NO_MARGINS,
            spacing=(SPACING, GAP),
            stretches=(1, 1),
        )
        self.part.currentIndexChanged.connect(self._show)

    def begin(self, values: Mapping[str, float]) -> None:
        """Show the parts of another flight.

        Args:
            values: its initial parameter values, by name.
        """
        parts = tuple(part for part in PARTS if part.parameter in values)
        self.faults = {
            part.parameter: values[part.parameter]
            for part in parts
            if values[part.parameter] != part.whole
        }
        if parts != self._parts:
            self._parts = parts
            with QSignalBlocker(self.part):
                self.part.clear()
                self.part.addItems([part.name for part in parts])
        self._show()

    def fail(self) -> None:
        """Make the selected part fail now."""
        part = self._part
        if part is None:
            return
        value = SENSOR_MODES[self.mode.currentText()] if part.modes else self.share.si
        self._set(part, value)

    @property
    def said(self) -> str:
        """The failed parts, in words; "" without any."""
        parts = (part for part in self._parts if part.parameter in self.faults)
        return ", ".join(part.fault(self.faults[part.parameter]) for part in parts)

    @property
    def _part(self) -> Part | None:
        place = self.part.currentIndex()
        return self._parts[place] if 0 <= place < len(self._parts) else None

    def _repair(self) -> None:
        part = self._part
        if part is not None:
            self._set(part, part.whole)

    def _set(self, part: Part, value: float) -> None:
        def done(_: object) -> None:
            self.faults.pop(part.parameter, None)
            if value != part.whole:
                self.faults[part.parameter] = value
            self._show()

        self._flight.order(lambda live: live.set_all({part.parameter: value}), done)

    def _show(self) -> None:
        part = self._part
        self.how.setCurrentWidget(self.mode if part is not None and part.modes else self.share)
        self.button.setEnabled(part is not None)
        self.repair.setEnabled(part is not None and part.parameter in self.faults)
        self.changed.emit()


class ExcitationCard(Card):
    """Starts and stops an excitation of the flight, sets its wind, and makes its parts fail.

    Args:
        workspace: its flight is excited, and its preferences store the choice.

    Attributes:
        is_running: whether the flight is excited.
    """

    chosen = pyqtSignal(object)
    """A new `ExcitationChoice`."""

    def __init__(self, workspace: Workspace) -> None:
        super().__init__("Excitation")
        self._flight = workspace.flight
        self._preferences = workspace.preferences
        store = workspace.preferences.store
        self._choices = {kind.name: load_choice(store, kind) for kind in KINDS}
        self.choice = self._choices[load_kind(store).name]
        self.is_running = False
        self._mode = FlightMode.OFF
        self._seen: tuple[object, ...] = ()
        self.tabs = QTabBar()
        for kind in KINDS:
            self.tabs.setTabToolTip(self.tabs.addTab(kind.name), tip_text(kind.help))
        self.tabs.setTabToolTip(self.tabs.addTab("Wind"), "Wind and turbulence that stay")
        self.tabs.setTabToolTip(self.tabs.addTab("Fault"), "A rotor or a sensor that fails")
        self.axis, self.shape = choice("Axis"), choice("Shape")
        self.amplitude = NumberField("Amplitude", 2, 0.1)
        self.period = NumberField("Period", 2, 0.1)
        self.wind = WindForm(workspace)
        self.fault = FaultForm(workspace)
        self.pages = QStackedWidget()
        self.repeats = QCheckBox("&Repeat")
        set_tip(self.repeats, "Repeat it until it is stopped")
        self.button = button("Start", self.start_or_stop, "primary", f"Start or stop ({KEY})")
        self.take_off = button(
            "Take off", self._take_off, help="The drone must fly before it can be excited"
        )
        self.take_off.setVisible(False)
        self._lay_out()
        self.tabs.setCurrentIndex(KINDS.index(self.choice.kind))
        self._show_kind()
        self.tabs.currentChanged.connect(self._choose_tab)
        self.fault.changed.connect(lambda: self._show_state(self._flight.view))
        self.wind.speed.refused.connect(lambda _: self._show_state(self._flight.view))
        self.axis.activated.connect(self._choose_axis)
        self.shape.activated.connect(self._choose_shape)
        self.amplitude.edited.connect(self._choose_amplitude)
        self.period.edited.connect(lambda value: self._take(replace(self.choice, period=value)))
        for field in (self.amplitude, self.period):
            field.refused.connect(lambda _: self._show_state(self._flight.view))
        self.repeats.toggled.connect(lambda on: self._take(replace(self.choice, repeats=on)))
        workspace.preferences.changed.connect(lambda name: self._show_choice())
        shortcut = QShortcut(QKeySequence(KEY), self)
        shortcut.setContext(Qt.ShortcutContext.WindowShortcut)
        shortcut.activated.connect(self.start_or_stop)
        self._show_state(workspace.flight.view)

    def show_view(self, view: LiveView) -> None:
        """Show the possible actions."""
        running = view.exciting is not None
        mode = view.snapshot.mode if view.snapshot is not None else FlightMode.OFF
        returning = view.exciting is not None and view.exciting.returning
        seen = (running, returning, view.excitation_ended, mode)
        if seen != self._seen or not self.said.text():
            self._seen, self.is_running, self._mode = seen, running, mode
            self._show_state(view)

    def start_or_stop(self) -> None:
        """Start or stop the excitation; does nothing if the drone cannot fly it."""
        if self.is_running:
            self._flight.order(lambda live: live.stop_exciting())
        elif self.button.isEnabled() and self.tabs.currentIndex() < len(KINDS):
            excitation = self.choice.excitation
            self._flight.order(lambda live: live.excite(excitation))

    def _take_off(self) -> None:
        self._flight.order(lambda live: live.request("take_off"))

    def _choose_tab(self, index: int) -> None:
        if index < len(KINDS):
            self._take(self._choices[KINDS[index].name])
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
        keep_choice(self._preferences.store, choice)
        self._show_choice()
        self._show_state(self._flight.view)
        self.chosen.emit(choice)
        if self.is_running and not other:  # show the running excitation
            excitation = choice.excitation
            self._flight.order(lambda live: live.excite(excitation))

    def _show_kind(self) -> None:
        """Show the fields of the selected tab."""
        index, kind = self.tabs.currentIndex(), self.choice.kind
        self.pages.setCurrentIndex(max(0, index - len(KINDS) + 1))
        if index >= len(KINDS):
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
        self.period.set_range(Unit("s"), kind.shortest, PERIODS[1])
        self._show_choice()

    def _show_choice(self) -> None:
        choice, axis = self.choice, find_excited(self.choice.axis)
        self.axis.setCurrentIndex(choice.kind.find(choice.axis))
        set_tip(self.axis, axis.label)
        self.shape.setCurrentIndex(choice.kind.shapes.index(choice.shape))
        row = parameter_table().find(axis.limit)
        most = row.maximum
        if not isinstance(axis, Load):  # the parameter that limits a load is the load itself
            most = self._flight.view.values.get(axis.limit, most)
        self.amplitude.set_range(unit_for(axis.unit, self._preferences), -most, most, LEAST)
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
        if abs(limited) >= LEAST and limited != self.choice.amplitude:
            self.choice = self.choice.with_amplitude(limited)
        self._show_state(self._flight.view)

    def _show_state(self, view: LiveView) -> None:
        flies = view.snapshot is not None and self._mode not in (*GROUNDED, *BUSY)
        excites = self.tabs.currentIndex() < len(KINDS)
        for part, shown in (
            *((each, excites or self.is_running) for each in (self.repeats, self.button)),
            *((each, self.tabs.currentIndex() == WIND) for each in self.wind.buttons),
            *((each, self.tabs.currentIndex() == FAULT) for each in self.fault.buttons),
        ):
            part.setVisible(shown)
        self.wind.set_enabled(view.snapshot is not None)
        self.button.setText("Stop" if self.is_running else self.choice.kind.start)
        set_class(self.button, "" if self.is_running else "primary")
        faults = self.amplitude.fault or self.period.fault
        self.button.setEnabled(self.is_running or (flies and not faults))
        self.take_off.setVisible(view.snapshot is not None and excites and self._mode in GROUNDED)
        if view.snapshot is None:
            self.said.say("Nothing flies yet.")
        elif not excites and not self.is_running:
            self._say_disturbed(view)
        elif view.exciting is not None and view.exciting.returning:
            self.said.say("Flying back to where it began.", "good")
        elif self.is_running:
            self.said.say("Running.", "good")
        elif faults:
            self.said.say(faults, "warning")
        elif self._mode in GROUNDED:
            self.said.say("The drone must hover: take off.", "warning")
        elif self._mode in BUSY:
            self.said.say(f"The drone is {self._mode.label}.")
        elif view.excitation_ended:
            self.said.say(f"Ended: {view.excitation_ended}.", "warning")
        else:
            self.said.say(reach_text(self.choice.excitation) or "Ready.")

    def _say_disturbed(self, view: LiveView) -> None:
        """Show the present wind, or what has failed."""
        if self.tabs.currentIndex() == WIND:
            self.said.say(self.wind.speed.fault or "It blows until you change it.")
        elif self.fault.said:
            self.said.say(f"Failed: {self.fault.said}.", "warning")
        else:
            self.said.say("Nothing has failed.")

    def _fields(self) -> tuple[QWidget, ...]:
        return self.axis, self.shape, self.amplitude, self.period

    def _lay_out(self) -> None:
        parts = (*self.wind.buttons, *self.fault.buttons, self.repeats, self.take_off, self.button)
        for part in parts:
            self.head.addWidget(part)
        for box in (self.axis, self.shape):
            box.setSizeAdjustPolicy(ELIDES)
        self.tabs.setStyleSheet(TABS)
        self.tabs.setDrawBase(False)
        self.tabs.setExpanding(False)
        self.tabs.setUsesScrollButtons(False)
        self.tabs.setAccessibleName("Kind of excitation")
        excitation = QWidget()
        for page in (excitation, self.wind, self.fault):
            self.pages.addWidget(page)
        names = ("A&xis", "&Shape", "&Amplitude", "&Period")
        fields = [*zip(names, self._fields(), strict=True)]
        fields_beside(fields, WIDTHS, of=excitation, gap=GAP)
        *_, self._time_label = excitation.findChildren(Label)  # of the period, the last one
        fill(self.body, self.tabs, self.pages)
        order = (*self._fields(), self.repeats)
        for one, other in zip(order, (*order[1:], self.take_off), strict=True):
            QWidget.setTabOrder(one, other)
        QWidget.setTabOrder(self.take_off, self.button)
