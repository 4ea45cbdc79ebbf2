"""The form that describes the next flight: world, sensors, estimator, noise and periods."""

import copy
import dataclasses
from typing import Any

from PyQt6.QtCore import QObject, pyqtSignal
from PyQt6.QtWidgets import QCheckBox, QWidget

from workbench.common.quantity import DisplayUnit
from workbench.common.resources import list_worlds
from workbench.estimation.settings import ESTIMATORS
from workbench.gui.flow_layout import FlowLayout
from workbench.gui.number_field import NumberField
from workbench.gui.settings.setting_field import ChoiceBox, Switch
from workbench.gui.settings.setting_row import SettingRow
from workbench.live.view import LiveView
from workbench.scenario.scenario import Rates, Scenario
from workbench.scenario.scenario_check import MAX_SCENARIO_PERIODS_S

PERIOD_SETTINGS = {
    "physics_step": ("Physics step", "Between two steps of the simulation."),
    "control_period": ("Control period", "Between two updates of the controller."),
    "mode_period": ("Mode period", "Between two updates of the flight mode."),
}
"""Label and help text of each period."""
PERIOD_RATIOS = (1, 2, 4, 8, 16, 32, 64, 128, 256, 512, 1024)
"""Allowed ratios of a period to the physics step."""
PHYSICS_STEPS_S = (1 / 4096, 1 / 2048, 1 / 1024, 1 / 512, 1 / 256)
"""Selectable physics steps; exact in binary, so that flights do not drift from their clock [s]."""
MAX_NOISE_SEED = 2**31 - 1
"""Largest seed that every random number generator accepts."""


def period_text(period: float) -> str:
    """Return a period as text, as 7.8125 ms (128 Hz)."""
    rate = 1.0 / period
    return f"{1e3 * period:.6g} ms ({rate:.6g} Hz)"


MAX_SENSORS_WIDTH_PX = 380
"""Largest width of the boxes of sensors, which wrap [px]."""


class FlightForm(QObject):
    """Rows that describe a flight; they have no effect until a flight is started with them."""

    edited = pyqtSignal()
    """A row differs from the present flight, or equals it again."""

    def __init__(self) -> None:
        super().__init__()
        self._flown: tuple[Any, ...] = ()  # what the rows show of the present flight, in order
        self._base = Scenario()
        self._world = ChoiceBox(list_worlds(), lambda _: self._show_changes())
        self._sensors = QWidget()
        self._sensors.setMaximumWidth(MAX_SENSORS_WIDTH_PX)
        self._sensors_layout = FlowLayout(self._sensors, spacing=12)
        self._boxes: dict[str, QCheckBox] = {}
        self._estimator = ChoiceBox(ESTIMATORS, lambda _: self._show_changes())
        self._noise = Switch(lambda _: self._show_changes())
        self._seed = NumberField("Seed", 0, whole=True)
        self._seed.set_range(DisplayUnit(""), 0, MAX_NOISE_SEED)
        self._seed.edited.connect(self._show_changes)
        self._seed.refused.connect(self._show_changes)
        self._periods = {name: ChoiceBox([], self._choose_period) for name in PERIOD_SETTINGS}
        self.rows = [
            SettingRow("World", "What is around the drone.", self._world),
            SettingRow(
                "Sensors",
                "Sensors that are on; each costs time. Those of an estimator are on anyway.",
                self._sensors,
            ),
            SettingRow(
                "Estimator",
                "Gives the controller the motion: the truth, or an estimate from sensors.",
                self._estimator,
            ),
            SettingRow("Noise", "Whether sensors are noisy, as the description says.", self._noise),
            SettingRow(
                "Seed", "Of noise and turbulence; equal seeds give equal flights.", self._seed
            ),
            *(SettingRow(*PERIOD_SETTINGS[name], self._periods[name]) for name in PERIOD_SETTINGS),
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
        world, estimator = (str(box.currentData()) for box in (self._world, self._estimator))
        return world, kinds, estimator, self._noise.isChecked(), seed, *self._rates()

    def scenario(self) -> Scenario:
        """Return the present scenario with what is shown."""
        made = copy.deepcopy(self._base)
        made.world, kinds, made.estimator, noise, seed, *periods = self._shown
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
        periods = (getattr(rates, name) for name in PERIOD_SETTINGS)
        noise, seed, estimator = sensors.noise, sensors.seed, view.scenario.estimator
        self._flown = view.scenario.world, measuring, estimator, noise, seed, *periods
        self._back()

    def _back(self) -> None:
        """Show the present flight again."""
        if not self._flown:
            return
        world, kinds, estimator, noise, seed, *periods = self._flown
        self._world.show_value(world)
        for kind, box in self._boxes.items():
            box.setChecked(kind in kinds)
        self._estimator.show_value(estimator)
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
        _set_periods(boxes[0], sorted({*PHYSICS_STEPS_S, step}), step)
        limits = (MAX_SCENARIO_PERIODS_S["control_period"], MAX_SCENARIO_PERIODS_S["mode_period"])
        for box, period, most in zip(boxes[1:], periods, limits, strict=True):
            offered = {step * factor for factor in PERIOD_RATIOS if step * factor <= most} | {
                period
            }
            _set_periods(box, sorted(offered), period)

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


def _set_periods(box: ChoiceBox, periods: list[float], chosen: float) -> None:
    box.clear()
    for period in periods:
        box.addItem(period_text(period), period)
    box.setCurrentText(period_text(chosen))
