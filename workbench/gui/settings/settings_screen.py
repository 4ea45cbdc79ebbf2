"""The Settings screen: preferences, limits of the flight, and its set-up."""

import copy
import dataclasses
import math
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from itertools import groupby
from pathlib import Path
from typing import Any

from PyQt6.QtCore import QObject, QSignalBlocker, Qt, pyqtSignal
from PyQt6.QtGui import QWheelEvent
from PyQt6.QtWidgets import (
    QCheckBox,
    QComboBox,
    QFrame,
    QLineEdit,
    QSizePolicy,
    QWidget,
)

from workbench.common.errors import WorkbenchError
from workbench.common.plain_text import plain_text
from workbench.common.resources import list_worlds
from workbench.gui.errands import Answers
from workbench.gui.file_dialogs import choose_folder
from workbench.gui.first_flight import keep_setup, last_setup
from workbench.gui.help import explain
from workbench.gui.labels import Label
from workbench.gui.layout import (
    NO_MARGINS,
    FlowLayout,
    buddy,
    button,
    fill,
    hbox,
    label,
    named,
    scroll_area,
    vbox,
)
from workbench.gui.number_field import NumberField
from workbench.gui.preferences import PREFERENCES, Preference, Preferences, PreferenceValue
from workbench.gui.screens import Screen
from workbench.gui.signals import parameter_changes
from workbench.gui.units import Unit, unit_for
from workbench.gui.workspace import Workspace
from workbench.link.backplane import Published
from workbench.live.view import LiveView
from workbench.plant.vehicle import Vehicle
from workbench.scenario.parameters import Parameter, parameter_table
from workbench.scenario.scenario import SLOWEST, Rates, Scenario

MOST_DECIMALS = 6


class NumberBox(NumberField):
    """A number in SI, shown in the user's preferred unit.

    Args:
        preferences: source of the unit.
        si: SI unit of the number, as in the tables.
        minimum: smallest value, in SI.
        maximum: largest value, in SI.
        label: accessible name.
        changed: called with the new value in SI, once it is typed or stepped.
    """

    def __init__(
        self,
        preferences: Preferences,
        si: str,
        minimum: float,
        maximum: float,
        label: str,
        changed: Callable[[float], None],
    ) -> None:
        super().__init__(label)
        self._preferences, self._si_unit = preferences, si
        self._ends = minimum, maximum
        self._show_unit()
        self.edited.connect(changed)
        preferences.changed.connect(lambda _: self._show_unit())

    def show_value(self, value: float) -> None:
        """Show a value in SI, without a signal."""
        self.show_si(value)

    def _show_unit(self) -> None:
        """Show value and range in the preferred unit, without a signal."""
        unit = unit_for(self._si_unit, self._preferences)
        low, high = map(unit.shown, self._ends)
        self.show_decimals(decimals_of(high - low))
        self.setSingleStep(10.0 ** (math.floor(math.log10(high - low)) - 2))
        self.set_range(unit, *self._ends)


class Choices(QComboBox):
    """A choice of several texts."""

    def __init__(self, texts: Sequence[str], changed: Callable[[str], None]) -> None:
        super().__init__()
        for text in texts:
            self.addItem(plain_text(text), text)
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.activated.connect(lambda index: changed(str(self.itemData(index))))

    def show_value(self, text: str) -> None:
        """Show a text; if it is not among the choices, as a file's path, it is added."""
        if self.findData(text) < 0:
            self.addItem(plain_text(text), text)
        self.setCurrentIndex(self.findData(text))

    def wheelEvent(self, event: QWheelEvent | None) -> None:
        """Ignore the wheel: the page may be scrolling."""
        if event is not None and not self.hasFocus():
            event.ignore()
        else:
            super().wheelEvent(event)


class Switch(QCheckBox):
    """A switch, with its state as text beside the tick."""

    def __init__(self, changed: Callable[[bool], None]) -> None:
        super().__init__("off")
        self.toggled.connect(self._say)
        self.toggled.connect(changed)

    def show_value(self, on: bool) -> None:
        """Show whether it is on, without a signal."""
        with QSignalBlocker(self):
            self.setChecked(on)
        self._say(on)

    def _say(self, on: bool) -> None:
        self.setText("on" if on else "off")


class Folder(QWidget):
    """A folder's path, typed or selected."""

    def __init__(self, label: str, empty: str, changed: Callable[[str], None]) -> None:
        super().__init__()
        self._changed = changed
        self.line = QLineEdit(self)
        self.line.setPlaceholderText(empty)
        self.line.setAccessibleName(label)
        self.line.editingFinished.connect(lambda: changed(self.line.text().strip()))
        browse = named(button("Choose…", self._choose), f"Choose the {label.lower()}")
        hbox((self.line, 1), browse, of=self, margins=NO_MARGINS)
        self.setFocusProxy(self.line)

    def show_value(self, path: str) -> None:
        """Show a path."""
        if self.line.text() != path:
            self.line.setText(path)

    def _choose(self) -> None:
        choose_folder(self, "Choose a folder", self._take, self.line.text())

    def _take(self, path: str) -> None:
        self.show_value(path)
        self._changed(path)


def decimals_of(span: float) -> int:
    """Return the number of decimals that show a thousandth of a range."""
    return min(MOST_DECIMALS, max(1, 2 - math.floor(math.log10(span))))


class Row(QWidget):
    """One setting.

    Args:
        text: text, and accessible name of the control.
        help: what it does, as a sentence.
        control: the control.

    Attributes:
        reset: restores the default.
    """

    def __init__(self, text: str, help: str, control: QWidget) -> None:
        super().__init__()
        self._words = f"{text} {help}".lower()
        self._mark = Label()
        self.reset = named(button("Default"), f"{text}: restore the default")
        control.setMinimumWidth(190)
        said = label(help, "muted", wraps=True)
        words = vbox(buddy(text, control, help, kind=""), said, spacing=1)
        hbox(
            (words, 1),
            (self._mark, Qt.AlignmentFlag.AlignVCenter),
            (control, Qt.AlignmentFlag.AlignVCenter),
            (self.reset, Qt.AlignmentFlag.AlignVCenter),
            of=self,
            margins=(0, 4, 0, 4),
            spacing=12,
        )
        self._mark.setFixedWidth(self.fontMetrics().horizontalAdvance("changed  "))
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Preferred)

    def mark(self, changed: bool) -> None:
        """Show whether it differs from the default."""
        self._mark.setText("changed" if changed else "")
        self.reset.setEnabled(changed)

    def matches(self, wanted: str) -> bool:
        """Return whether it contains all words of a search."""
        return all(word in self._words for word in wanted.lower().split())


RATES = {
    "physics_step": ("Physics step", "Between two steps of the simulation."),
    "control_period": ("Control period", "Between two updates of the controller."),
    "mode_period": ("Mode period", "Between two updates of the flight mode."),
}
"""Label and help text of each period."""
FACTORS = (1, 2, 4, 8, 16, 32, 64, 128, 256, 512, 1024)
"""Allowed ratios of a period to the physics step."""
STEPS = (1 / 4096, 1 / 2048, 1 / 1024, 1 / 512, 1 / 256)
"""Selectable physics steps; exact in binary, so that flights do not drift from their clock [s]."""
LARGEST_SEED = 2**31 - 1
"""Largest seed that every random number generator accepts."""
LIMITS = (
    "max_speed",
    "max_climb_rate",
    "max_height",
    "max_tilt",
    "max_yaw_rate",
    "take_off_speed",
    "landing_speed",
    "battery_reserve",
    "obstacle_brake",
    "stop_distance",
    "warning_distance",
)
"""Parameters that limit a flight; gains are on the tuning screen."""
GROUP = "limits"
WIDEST = 900
"""Largest width: longer lines are hard to follow [px]."""


def period_text(period: float) -> str:
    """Return a period as text, as 7.8125 ms (128 Hz)."""
    rate = 1.0 / period
    return f"{1e3 * period:.6g} ms ({rate:.6g} Hz)"


WIDEST_SENSORS = 380
"""Largest width of the boxes of sensors, which wrap [px]."""


class FlightForm(QObject):
    """Rows that describe a flight; they have no effect until a flight is started with them."""

    edited = pyqtSignal()
    """A row differs from the present flight, or equals it again."""

    def __init__(self) -> None:
        super().__init__()
        self._flown: tuple[Any, ...] = ()  # what the rows show of the present flight, in order
        self._base = Scenario()
        self._world = Choices(list_worlds(), lambda _: self._show_changes())
        self._sensors = QWidget()
        self._sensors.setMaximumWidth(WIDEST_SENSORS)
        self._sensors_layout = FlowLayout(self._sensors, spacing=12)
        self._boxes: dict[str, QCheckBox] = {}
        self._noise = Switch(lambda _: self._show_changes())
        self._seed = NumberField("Seed", 0, whole=True)
        self._seed.set_range(Unit(""), 0, LARGEST_SEED)
        self._seed.edited.connect(self._show_changes)
        self._seed.refused.connect(self._show_changes)
        self._periods = {name: Choices([], self._choose_period) for name in RATES}
        self.rows = [
            Row("World", "What is around the drone.", self._world),
            Row("Sensors", "Sensors that are on; each costs time.", self._sensors),
            Row("Noise", "Whether sensors are noisy, as the description says.", self._noise),
            Row("Seed", "Of noise and turbulence; equal seeds give equal flights.", self._seed),
            *(Row(*RATES[name], self._periods[name]) for name in RATES),
        ]
        for row in self.rows:
            row.reset.setText("As flown")
            row.reset.clicked.connect(self._back)

    @property
    def is_changed(self) -> bool:
        """Whether it describes a valid flight that differs from the present one."""
        return bool(self._flown) and self._shown != self._flown and not self._seed.fault

    @property
    def _shown(self) -> tuple[Any, ...]:
        """What each row shows."""
        kinds = tuple(kind for kind, box in self._boxes.items() if box.isChecked())
        seed = int(self._seed.si)
        return str(self._world.currentData()), kinds, self._noise.isChecked(), seed, *self._rates()

    def scenario(self) -> Scenario:
        """Return the present scenario with what is shown."""
        made = copy.deepcopy(self._base)
        made.world, kinds, noise, seed, *periods = self._shown
        made.sensors = dataclasses.replace(made.sensors, noise=noise, seed=seed)
        if kinds != self._flown[1]:  # else it may name one of several of a kind
            made.sensors.use = list(kinds)
        made.rates = Rates(*periods, record_period=periods[1])
        return made

    def begin(self, view: LiveView) -> None:
        """Show the present flight."""
        if view.scenario is None or view.vehicle is None:
            return
        self._base = view.scenario
        kinds = tuple(dict.fromkeys(sensor.kind for sensor in view.vehicle.sensors))
        self._show_kinds(kinds)
        kind_of = {sensor.name: sensor.kind for sensor in view.vehicle.sensors}
        sensors, rates = view.scenario.sensors, view.scenario.rates
        use = {kind_of.get(name, name) for name in sensors.use}
        measuring = tuple(kind for kind in kinds if kind in use or "all" in use)
        periods = (getattr(rates, name) for name in RATES)
        self._flown = view.scenario.world, measuring, sensors.noise, sensors.seed, *periods
        self._back()

    def _back(self) -> None:
        """Show the present flight again."""
        if not self._flown:
            return
        world, kinds, noise, seed, *periods = self._flown
        self._world.show_value(world)
        for kind, box in self._boxes.items():
            box.setChecked(kind in kinds)
        self._noise.show_value(noise)
        self._seed.show_si(seed)
        self._show_rates(*periods)
        self._show_changes()

    def _show_kinds(self, kinds: tuple[str, ...]) -> None:
        """Show a box for every kind of sensor of the vehicle."""
        if tuple(self._boxes) == kinds:
            return
        for box in self._boxes.values():
            box.deleteLater()
        self._boxes = {kind: QCheckBox(kind.replace("_", " ")) for kind in kinds}
        for kind, box in self._boxes.items():
            box.setAccessibleName(f"{kind.replace('_', ' ')} measures")
            box.toggled.connect(self._show_changes)
            self._sensors_layout.addWidget(box)

    def _rates(self) -> tuple[float, float, float]:
        step, control, mode = (box.currentData() or 0.0 for box in self._periods.values())
        return (step, control, mode)

    def _show_rates(self, step: float, *periods: float) -> None:
        """Offer steps, and periods that are whole multiples of them."""
        boxes = list(self._periods.values())
        _offer(boxes[0], sorted({*STEPS, step}), step)
        limits = (SLOWEST["control_period"], SLOWEST["mode_period"])
        for box, period, most in zip(boxes[1:], periods, limits, strict=True):
            offered = {step * factor for factor in FACTORS if step * factor <= most} | {period}
            _offer(box, sorted(offered), period)

    def _choose_period(self, _: str) -> None:
        step, *periods = self._rates()
        # a period that is not a multiple of the new step becomes the nearest one that is
        self._show_rates(step, *(max(1, round(period / step)) * step for period in periods))
        self._show_changes()

    def _show_changes(self) -> None:
        if not self._flown:
            return
        for row, now, flown in zip(self.rows, self._shown, self._flown, strict=True):
            row.mark(now != flown)
        self.edited.emit()


def _offer(box: Choices, periods: list[float], chosen: float) -> None:
    box.clear()
    for period in periods:
        box.addItem(period_text(period), period)
    box.setCurrentText(period_text(chosen))


class LimitRow(Row):
    """One limit of the flight; a value set here is stored, and set again in later flights.

    Args:
        workspace: the flight's workspace.
        parameter: the parameter's row of the table.
    """

    def __init__(self, workspace: Workspace, parameter: Parameter) -> None:
        self._workspace, self._parameter = workspace, parameter
        label = words(parameter.name)
        self._box = NumberBox(
            workspace.preferences,
            parameter.unit,
            parameter.minimum,
            parameter.maximum,
            label,
            self._set,
        )
        super().__init__(label, f"{parameter.help[0].upper()}{parameter.help[1:]}.", self._box)
        self.reset.clicked.connect(self._forget)
        self._start = parameter.default
        self._vehicle = ""
        self.setEnabled(False)
        self.mark(False)

    def begin(self, vehicle: str, values: Mapping[str, float]) -> bool:
        """Note a new flight; return whether a stored value was set.

        Args:
            vehicle: the flying vehicle; limits are stored for each vehicle.
            values: initial parameter values.
        """
        name = self._parameter.name
        self._vehicle = vehicle
        self.setEnabled(name in values)
        if name not in values:
            return False
        self._start = values[name]
        kept = self._workspace.preferences.store.value(self._key)
        value = self._start if kept is None else _number(kept, self._parameter, self._start)
        self.show_value(value)
        if value != self._start:
            self._order(value)
        return value != self._start

    def show_value(self, value: float) -> None:
        """Show the present value."""
        self._box.show_value(value)
        self.mark(abs(value - self._start) > 1e-9 * max(1.0, abs(self._start)))

    @property
    def name(self) -> str:
        """Name of the parameter."""
        return self._parameter.name

    @property
    def _key(self) -> str:
        return f"{GROUP}/{self._vehicle}/{self._parameter.name}"

    def _set(self, value: float) -> None:
        self._workspace.preferences.store.setValue(self._key, value)
        self._order(value)

    def _forget(self) -> None:
        self._workspace.preferences.store.remove(self._key)
        self._order(self._start)

    def _order(self, value: float) -> None:
        name = self._parameter.name
        self._workspace.flight.order(
            lambda live: live.set(name, value), lambda _: self.show_value(value)
        )


def limit_rows(workspace: Workspace) -> list[LimitRow]:
    """Return a row for every limit."""
    return [LimitRow(workspace, parameter_table().find(name)) for name in LIMITS]


def words(name: str) -> str:
    """Return a parameter's name in words, as Max climb rate."""
    return name.replace("_", " ").capitalize()


def _number(kept: object, parameter: Parameter, otherwise: float) -> float:
    """Return a stored number if it is still valid."""
    try:
        value = float(str(kept))
    except ValueError:
        return otherwise
    return value if parameter.minimum <= value <= parameter.maximum else otherwise


class PreferenceRow(Row):
    """One preference, with its present value.

    Args:
        workspace: has the preferences.
        preference: the preference's row of the table.
    """

    def __init__(self, workspace: Workspace, preference: Preference) -> None:
        self.preference = preference
        self._preferences, self._notices = workspace.preferences, workspace.notices
        self._control = self._make(workspace)
        super().__init__(preference.label, preference.help, self._control)
        self.reset.clicked.connect(lambda: self._preferences.reset(preference.name))
        self._preferences.changed.connect(self._hear)
        self.show_present()

    def show_present(self) -> None:
        """Show the present value."""
        value: Any = self._preferences.value(self.preference.name)
        self._control.show_value(value)
        self.mark(value != self.preference.default)

    def _hear(self, name: str) -> None:
        if name == self.preference.name:
            self.show_present()

    def _make(self, workspace: Workspace) -> Switch | NumberBox | Choices | Folder:
        row, change = self.preference, self._set
        if isinstance(row.default, bool):
            return Switch(change)
        if isinstance(row.default, float):
            assert math.isfinite(row.maximum - row.minimum)
            preferences = workspace.preferences
            return NumberBox(preferences, row.unit, row.minimum, row.maximum, row.label, change)
        if row.choices:
            return Choices(row.choices, change)
        return Folder(row.label, str(Path.cwd()), change)

    def _set(self, value: PreferenceValue) -> None:
        if self.preference.folder and value and not Path(str(value)).is_dir():
            self._notices.warn(f"There is no folder {value}.", "Choose an existing one.")
            self.show_present()
            return
        try:
            self._preferences.set(self.preference.name, value)
        except WorkbenchError as error:
            self._notices.warn(str(error))
            self.show_present()


class Group(QFrame):
    """Settings under one heading."""

    def __init__(self, heading: str, rows: Sequence[Row], note: str = "") -> None:
        super().__init__()
        self.setProperty("class", "card")
        explain(self, f"Settings: {heading}")
        self.rows = rows
        notes = [label(note, "muted", wraps=True)] if note else []
        self.box = vbox(label(heading, "heading"), *notes, *rows, of=self)

    def show_matching(self, wanted: str) -> int:
        """Show the rows that contain all words, and return their number."""
        found = [row for row in self.rows if row.matches(wanted)]
        for row in self.rows:
            row.setVisible(row in found)
        self.setVisible(bool(found))
        return len(found)


class SettingsScreen(Screen):
    """All settings other than gains, made from tables and searchable."""

    def __init__(self, workspace: Workspace) -> None:
        super().__init__(workspace)
        self._answers = Answers(workspace.notices.warn, self)
        self._search = named(QLineEdit(), "Search settings")
        self._search.setPlaceholderText("Search settings")
        self._search.setClearButtonEnabled(True)
        self._search.textChanged.connect(self._find)
        self._none = Label("No setting matches.")
        self._none.hide()
        self._to_keep: Scenario | None = None
        self._vehicle: Vehicle | None = None
        self._limits = limit_rows(workspace)
        self._form = FlightForm()
        self._form.edited.connect(self._show_edited)
        self._fly = button("Fly with these", self._begin_flight, "primary")
        self._fly.setAccessibleDescription("Ends the present flight and starts another")
        self._groups = [
            *(
                Group(heading, [PreferenceRow(workspace, row) for row in rows])
                for heading, rows in groupby(PREFERENCES, lambda row: row.group)
            ),
            Group(
                "Limits", self._limits, "They take effect at once, and are saved for each vehicle."
            ),
            Group("The flight", self._form.rows, "Another flight starts with these settings."),
        ]
        workspace.flight.streamed.connect(self._follow)
        self._lay_out()
        self._show_edited()

    def begin(self, view: LiveView) -> None:
        """Show the present flight, and set the limits stored for it."""
        self._form.begin(view)
        if self._to_keep is not None and view.scenario == self._to_keep:  # it can be flown
            path = last_setup(self.workspace.preferences.store)
            keep = partial(keep_setup, path, self._to_keep)
            self._answers.expect(self.workspace.errands.run(keep))
            self._to_keep = None
        vehicle = view.vehicle.name if view.vehicle else ""
        kept = [row.name for row in self._limits if row.begin(vehicle, view.values)]
        anew, self._vehicle = view.vehicle is not self._vehicle, view.vehicle
        if kept and anew:
            names = ", ".join(kept)
            self.workspace.notices.inform(f"Your limits from last time apply again: {names}.")

    def _follow(self, published: list[Published]) -> None:
        """Follow limits that others change."""
        for _, name, value in parameter_changes(published):
            for row in self._limits:
                if row.name == name:
                    row.show_value(value)

    def _lay_out(self) -> None:
        page = QWidget()
        vbox(*self._groups, self._none, 1, of=page, margins=(8, 0, 8, 8), spacing=12)
        fill(self._groups[-1].box, (self._fly, Qt.AlignmentFlag.AlignRight))
        page.setMaximumWidth(WIDEST)
        area = scroll_area(page)
        area.setFocusPolicy(Qt.FocusPolicy.StrongFocus)  # for keys that scroll
        area.setAlignment(Qt.AlignmentFlag.AlignHCenter)
        self._search.setMaximumWidth(WIDEST - 16)
        # aligned with the cards below
        top = hbox(1, (self._search, 1000), 1, margins=(8, 0, 16, 0))
        vbox(top, (area, 1), of=self, margins=(0, 8, 0, 0))

    def _find(self, wanted: str) -> None:
        found = sum([group.show_matching(wanted) for group in self._groups])
        self._none.setVisible(not found)

    def _show_edited(self) -> None:
        self._fly.setEnabled(self._form.is_changed)

    def _begin_flight(self) -> None:
        scenario = self._form.scenario()
        draw = self.workspace.preferences.switch("draw_3d")
        self._to_keep = scenario
        self.workspace.flight.fly(scenario, draw=draw)
