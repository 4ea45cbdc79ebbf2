"""The vehicle that an analyst evaluates, read once, with its models and flights."""

import threading
from collections.abc import Mapping
from concurrent.futures import Future
from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

from workbench.common.errors import WorkbenchError
from workbench.control.controller import Controller
from workbench.control.controller_file import load_controller
from workbench.control.schedule import split_label
from workbench.parameters.flight_parameters import SIGNAL_PATH, VEHICLE_SYSTEMS
from workbench.scenario.flown_controller import flown_controller
from workbench.scenario.scenario import Scenario

if TYPE_CHECKING:
    from workbench.design.fork import Forker
    from workbench.design.judge.loop_shaping import LoopShaper
    from workbench.design.judge.phase_budget import PhaseStudy
    from workbench.design.judge.pole_placing import PolePlacer
    from workbench.design.linear.model import LinearModel
    from workbench.design.linear.retuned import Models
    from workbench.design.linear.study import LinearStudy
    from workbench.design.linear_step import DecayTimes
    from workbench.design.rollout.engine import RolloutEngine
    from workbench.setup import Setup

STEP_SYSTEMS = ("controller", "air", "rotors", *VEHICLE_SYSTEMS, *SIGNAL_PATH)
"""Systems with parameters that affect a step from hover."""
WARM_UP_STEP_S = 0.1
"""Duration of the flight that loads the compiled code [s]."""


class AnalysedVehicle:
    """A scenario's vehicle; each part of it is made on first use.

    Args:
        scenario: source of vehicle, variation and rates; only forks use its script, as that may be
            for a controller from which another has taken over.
        settings: values of the live parameters, over those of the scenario's gains.

    Scheduled gains are evaluated set by set: a question about them uses the names of one set, and
    those gains fly without the schedule.

    Attributes:
        flown: the scenario's controller.
        judged: the scenario to evaluate: without the schedule of the controller's gains.
        controller: the judged one's.
        table: of its parameters.
        law: names of the controller's own parameters, gains and limits.
        shaper: the last shaper of a loop, and its key.
        kept: what functions of other packages keep for their next question.
        placer: the last placer of a pole, and its key.
    """

    def __init__(self, scenario: Scenario, settings: Mapping[str, float]) -> None:
        self._scripted = scenario
        self.scenario = self.judged = scenario = replace(scenario, script=[])
        self.flown = flown_controller(scenario)
        self.settings = dict(settings)
        if self.flown.schedule is not None:
            # the settings include its gain file
            vehicle = replace(scenario.vehicle, gains="")
            controller, _ = split_label(scenario.controller)
            self.judged = replace(scenario, controller=controller, vehicle=vehicle)
        self.controller = flown_controller(self.judged)
        self.table = self.controller.table
        self.law = tuple(row.name for row in self.controller.parameters)
        self._around = tuple(row.name for system in SIGNAL_PATH for row in self.table.of(system))
        self._models: tuple[dict[str, float], Models] | None = None
        self.shaper: tuple[object, LoopShaper] | None = None
        self.kept: dict[str, Any] = {}
        self.placer: tuple[object, PolePlacer] | None = None
        self._loading: Future[RolloutEngine] | None = None
        self._others: dict[str, AnalysedVehicle] = {}

    @cached_property
    def setup(self) -> "Setup":
        """What is judged, with those settings that change the vehicle; dropped loads are left out.

        Raises:
            WorkbenchError: if it cannot be read.
        """
        return self._with_vehicle_settings(self.judged, self.controller).without_dropped_loads()

    @cached_property
    def flown_setup(self) -> "Setup":
        """The same with the schedule of the controller's gains, and with dropped loads.

        Raises:
            WorkbenchError: if it cannot be read.
        """
        return self._with_vehicle_settings(self.scenario, self.flown)

    @property
    def vehicle_settings(self) -> dict[str, float]:
        """Those settings by which the vehicle differs from the scenario's.

        Raises:
            WorkbenchError: if it cannot be read.
        """
        from workbench.setup import make_setup

        before = make_setup(self.scenario, controller=self.flown).values
        now = self.flown_setup.values
        return {name: value for name, value in now.items() if value != before[name]}

    def _with_vehicle_settings(self, scenario: Scenario, controller: Controller) -> "Setup":
        """Return a setup with the payload, hooks and setpoints of servos of the settings."""
        from workbench.setup import make_setup

        setup = make_setup(scenario, controller=controller)
        carried = {
            name: value
            for name, value in self.settings.items()
            if name in setup.values and setup.controller.table.find(name).system in VEHICLE_SYSTEMS
        }
        return replace(setup, values={**setup.values, **carried})

    @cached_property
    def study(self) -> "LinearStudy":
        """The vehicle and its linear models.

        Raises:
            WorkbenchError: if the vehicle cannot be read.
        """
        from workbench.design.linear.study import LinearStudy

        return LinearStudy(self.setup)

    @cached_property
    def decay_times(self) -> "DecayTimes":
        """The decay times of its steps."""
        from workbench.design.linear_step import DecayTimes

        return DecayTimes(self.setup)

    @cached_property
    def own(self) -> dict[str, float]:
        """Values of all parameters of the vehicle and its settings."""
        acting = {
            name: value
            for name, value in self.settings.items()
            if name in self.table and self.table.find(name).system in STEP_SYSTEMS
        }
        return {**self.study.gains, **acting}

    def model(self, gains: Mapping[str, float]) -> "LinearModel":
        """Return the sampled closed loop in hover while the position is held, see `gains`."""
        from workbench.design.linear.operating_point import HOLDING_POINT
        from workbench.design.linear.retuned import retuned_models

        around = {name: gains[name] for name in self._around if name in gains}
        if self._models is None or self._models[0] != around:
            # a change of gains takes a fraction of the time of a change of filters
            values = {**self.study.gains, **self.linear_gains(around)}
            self._models = around, retuned_models(self.study, HOLDING_POINT, values)
        return self._models[1](gains)

    @cached_property
    def phases(self) -> "PhaseStudy":
        """The phase budgets of the loops."""
        from workbench.design.judge.phase_budget import PhaseStudy

        return PhaseStudy(self.study)

    @cached_property
    def forker(self) -> "Forker":
        """Continues flights from a checkpoint of the scenario's flight; built in half a second.

        Raises:
            WorkbenchError: if the scenario cannot be built.
        """
        from workbench.design.fork import Forker

        return Forker(self._scripted)

    def other(self, controller: str) -> "AnalysedVehicle":
        """Return the same vehicle with another controller and that controller's own gains.

        Raises:
            WorkbenchError: if the controller cannot be read.
        """
        law = load_controller(controller)
        if law.digest not in self._others:
            scenario = replace(
                self.scenario,
                controller=controller,
                vehicle=replace(self.scenario.vehicle, gains=""),
            )
            present = self.setup.controller.table  # also of servos
            around = {
                name: value
                for name, value in self.settings.items()
                if name in present and present.find(name).system != "controller"
            }
            self._others[law.digest] = AnalysedVehicle(scenario, around)
        return self._others[law.digest]

    def gains(self, asked: Mapping[str, float]) -> dict[str, float]:
        """Return all values of the controller: the vehicle's own, overridden by the question's.

        They include values of filters and of the estimator in the question or the settings.

        Raises:
            WorkbenchError: for an unknown name, or a value out of range.
        """
        values = {self.flown.gain_of(name): value for name, value in asked.items()}
        for name in self.table.checked(values):
            if name not in (*self.law, *self._around):
                raise WorkbenchError(f"{name} is not a gain of the controller: leave it out")
        around = [name for name in self._around if name in values or name in self.settings]
        return {name: values.get(name, self.own[name]) for name in (*self.law, *around)}

    def asked_names(self, asked: Mapping[str, float]) -> dict[str, str]:
        """Return a question's names by the controller's gains; those of a set lose its suffix."""
        return {self.flown.gain_of(name): name for name in asked}

    def linked(self, asked: Mapping[str, str]) -> dict[str, str]:
        """Return the gains that equal another gain of the controller, by its name."""
        return {self.flown.gain_of(one): self.flown.gain_of(two) for one, two in asked.items()}

    def flown_gains(self, asked: Mapping[str, float]) -> dict[str, float]:
        """Return values of the controller that flies, of all sets of its gains.

        Raises:
            WorkbenchError: for an unknown name, or a value out of range.
        """
        if self.flown.schedule is None:
            return self.gains(asked)
        return self.flown.table.checked(asked)

    def linear_gains(self, asked: Mapping[str, float]) -> dict[str, float]:
        """Return the parameters of linear models: the payload, and the gains, see `gains`."""
        payload = {row.name: self.own[row.name] for row in self.table.of("payload")}
        return {**payload, **self.gains(asked)}

    def load_engine(self) -> "Future[RolloutEngine]":
        """Return a Future of the engine of compiled flights, which takes a second to load.

        A thread loads it, so that margins need not wait.
        """
        failed = self._loading is not None and self._loading.done() and self._loading.exception()
        if self._loading is None or failed:
            self._loading = Future()
            self.study  # is not made in two threads  # noqa: B018
            load = threading.Thread(target=self._load_engine, args=(self._loading,), daemon=True)
            load.start()
        return self._loading

    def _load_engine(self, loading: "Future[RolloutEngine]") -> None:
        """Make the engine, and fly once to load the compiled code."""
        try:
            from workbench.design.rollout.engine import RolloutEngine
            from workbench.design.rollout.sensor_set import why_not_compiled

            setup = replace(self.setup, values=self.own)
            # an estimate that cannot be compiled is replaced by the truth
            if why_not_compiled(setup):
                setup = replace(setup, estimator=None)
            engine = RolloutEngine.of(setup, threads=1)  # the other core is for the flight
            engine.fly([{}], "x", 1.0, duration=WARM_UP_STEP_S)
            engine.measure([{}], "x", 1.0, duration=WARM_UP_STEP_S)
        except BaseException as error:  # the caller gets the error
            loading.set_exception(error)
        else:
            loading.set_result(engine)
