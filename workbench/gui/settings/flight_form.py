"""What the next flight is built from: world, sensors, noise and rates."""

import copy
import dataclasses
from dataclasses import dataclass

from PyQt6.QtCore import pyqtSignal
from PyQt6.QtWidgets import QCheckBox, QHBoxLayout, QWidget

from workbench.common.resources import list_worlds
from workbench.gui.number_field import NumberField
from workbench.gui.settings.controls import Choices, Switch
from workbench.gui.settings.row import Row
from workbench.gui.units import Unit
from workbench.live.view import LiveView
from workbench.scenario.scenario import SLOWEST, Rates, Scenario

RATES = {
    "physics_step": ("Physics step", "Between two steps of the simulation."),
    "control_period": ("Control period", "Between two updates of the controller."),
    "mode_period": ("Mode period", "Between two looks of the flight mode."),
}
"""Label and help of each period."""
FACTORS = (1, 2, 4, 8, 16, 32, 64, 128, 256, 512, 1024)
"""A period is one of these times the physics step."""
STEPS = (1 / 4096, 1 / 2048, 1 / 1024, 1 / 512, 1 / 256)
"""Physics steps that are offered; exact in binary, so that no flight drifts from its clock [s]."""

LARGEST_SEED = 2**31 - 1
"""That every generator of random numbers takes."""


@dataclass(frozen=True)
class FlightSetup:
    """The part of a scenario that can be chosen here.

    Attributes:
        world: name or path.
        sensors: that measure, by name or kind.
        noise: whether they are noisy.
        seed: of noise and turbulence.
        rates: periods [s].
    """

    world: str
    sensors: tuple[str, ...]
    noise: bool
    seed: int
    rates: tuple[float, float, float]

    def scenario(self, base: Scenario) -> Scenario:
        """Return a scenario with this in place of its own."""
        made = copy.deepcopy(base)
        made.world = self.world
        made.sensors = dataclasses.replace(
            made.sensors, use=list(self.sensors), noise=self.noise, seed=self.seed
        )
        made.rates = Rates(*self.rates, record_period=self.rates[1])
        return made


def setup_of(scenario: Scenario, kinds: tuple[str, ...]) -> FlightSetup:
    """Return what a scenario is built from.

    Args:
        scenario: as it is.
        kinds: of sensor that its vehicle has; "all" stands for these.
    """
    use = tuple(scenario.sensors.use)
    rates = scenario.rates
    return FlightSetup(
        world=scenario.world,
        sensors=kinds if "all" in use else use,
        noise=scenario.sensors.noise,
        seed=scenario.sensors.seed,
        rates=(rates.physics_step, rates.control_period, rates.mode_period),
    )


def period_text(period: float) -> str:
    """Return a period in words, as 7.8125 ms (128 Hz)."""
    rate = 1.0 / period
    return f"{1e3 * period:.6g} ms ({rate:.6g} Hz)"


class FlightForm(QWidget):
    """Rows that describe a flight; they change nothing until one is begun with them."""

    edited = pyqtSignal()
    """Something is not as it flies now, or is again."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._flown: FlightSetup | None = None
        self._base: Scenario | None = None
        self._world = Choices(list_worlds(), lambda _: self._show_changes())
        self._sensors = QWidget()
        self._sensors_layout = QHBoxLayout(self._sensors)
        self._sensors_layout.setContentsMargins(0, 0, 0, 0)
        self._boxes: dict[str, QCheckBox] = {}
        self._noise = Switch(lambda _: self._show_changes())
        self._seed = NumberField("Seed", 0, whole=True)
        self._seed.set_range(Unit(""), 0, LARGEST_SEED)
        self._seed.edited.connect(self._show_changes)
        self._seed.refused.connect(self._show_changes)
        self._periods = {name: Choices([], self._choose_period) for name in RATES}
        self.rows = [
            Row("World", "What is around the drone.", self._world),
            Row("Sensors", "Those that measure; each costs time.", self._sensors),
            Row("Noise", "Whether sensors are noisy, as the description says.", self._noise),
            Row("Seed", "Of noise and turbulence; equal seeds give equal flights.", self._seed),
            *(Row(*RATES[name], self._periods[name]) for name in RATES),
        ]
        for row in self.rows:
            row.reset.setText("As flown")
            row.reset.clicked.connect(self._back)
        self.setEnabled(False)

    @property
    def is_changed(self) -> bool:
        """Whether it describes another flight than the present one, and one that can be flown."""
        return self._flown is not None and self.setup != self._flown and not self._seed.fault

    @property
    def setup(self) -> FlightSetup:
        """What is described."""
        return FlightSetup(
            world=self._world.currentText(),
            sensors=tuple(kind for kind, box in self._boxes.items() if box.isChecked()),
            noise=self._noise.isChecked(),
            seed=int(self._seed.si),
            rates=self._rates(),
        )

    def scenario(self) -> Scenario:
        """Return the scenario that is flown, with what is described in it."""
        base, setup = self._base or Scenario(), self.setup
        made = setup.scenario(base)
        if self._flown is not None and setup.sensors == self._flown.sensors:
            made.sensors.use = list(base.sensors.use)  # which may name one of several of a kind
        return made

    def begin(self, view: LiveView) -> None:
        """Show what flies."""
        if view.scenario is None or view.vehicle is None:
            return
        kinds = tuple(dict.fromkeys(sensor.kind for sensor in view.vehicle.sensors))
        named = {sensor.name: sensor.kind for sensor in view.vehicle.sensors}
        found = setup_of(view.scenario, kinds)
        use = dict.fromkeys(named.get(name, name) for name in found.sensors)
        self._base = view.scenario
        self._show_kinds(kinds)
        self._flown = FlightSetup(
            found.world, tuple(kind for kind in kinds if kind in use), *_rest(found)
        )
        self.setEnabled(True)
        self.show_setup(self._flown)

    def show_setup(self, wanted: FlightSetup) -> None:
        """Show a set-up."""
        self._world.show_value(wanted.world)
        for kind, box in self._boxes.items():
            box.setChecked(kind in wanted.sensors)
        self._noise.show_value(wanted.noise)
        self._seed.show_si(wanted.seed)
        self._show_rates(*wanted.rates)
        self._show_changes()

    def _back(self) -> None:
        if self._flown is not None:
            self.show_setup(self._flown)

    def _show_kinds(self, kinds: tuple[str, ...]) -> None:
        """Show a box for every kind of sensor that the vehicle has."""
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
        """Offer steps, and periods that are whole numbers of them."""
        boxes = list(self._periods.values())
        _offer(boxes[0], sorted({*STEPS, step}), step)
        limits = (SLOWEST["control_period"], SLOWEST["mode_period"])
        for box, period, most in zip(boxes[1:], periods, limits, strict=True):
            offered = {step * factor for factor in FACTORS if step * factor <= most} | {period}
            _offer(box, sorted(offered), period)

    def _choose_period(self, _: str) -> None:
        step, *periods = self._rates()
        # a period that the new step does not divide becomes the nearest that it does
        self._show_rates(step, *(max(1, round(period / step)) * step for period in periods))
        self._show_changes()

    def _show_changes(self) -> None:
        if self._flown is None:
            return
        now, flown = self.setup, self._flown
        same = [
            now.world == flown.world,
            now.sensors == flown.sensors,
            now.noise == flown.noise,
            now.seed == flown.seed,
            *(a == b for a, b in zip(now.rates, flown.rates, strict=True)),
        ]
        for row, equal in zip(self.rows, same, strict=True):
            row.mark(not equal)
        self.edited.emit()


def _rest(setup: FlightSetup) -> tuple[bool, int, tuple[float, float, float]]:
    return setup.noise, setup.seed, setup.rates


def _offer(box: Choices, periods: list[float], chosen: float) -> None:
    box.clear()
    for period in periods:
        box.addItem(period_text(period), period)
    box.setCurrentText(period_text(chosen))
