"""Linear models of one vehicle, read once, at any point and with any gains."""

import dataclasses
from collections.abc import Mapping, Sequence

import numpy as np

from workbench.common.errors import WorkbenchError, drake_error_sentences
from workbench.control.controller import Controller
from workbench.design.linear.derivatives import Derivatives
from workbench.design.linear.estimation import EstimatorModel, estimator_model
from workbench.design.linear.flight_derivatives import FlightDerivatives
from workbench.design.linear.last_call import LastCall
from workbench.design.linear.model import (
    FILTER_PARAMETERS,
    LinearModel,
    ModelSignal,
    Trim,
    accel_states,
    estimator_signals,
    filter_signals,
    gyro_states,
    imu_signals,
    wrench_signals,
)
from workbench.design.linear.operating_point import HOVER_POINT, OperatingPoint
from workbench.design.linear.sampled_model import sampled_model
from workbench.design.linear.trim import find_trim, update_inputs
from workbench.design.linear.vehicle import built_in_values
from workbench.diagram.core import make_flight_core
from workbench.diagram.mounting import find_imu, mounting_of
from workbench.estimation.gyro import sample_steps
from workbench.estimation.samples import Mounting
from workbench.estimation.settings import AIDING_SENSORS
from workbench.plant.description import Description
from workbench.plant.variation import Delays
from workbench.plant.vehicle import Vehicle
from workbench.scenario.scenario import Scenario
from workbench.setup import Setup, make_setup
from workbench.systems.acceleration_estimate import sampled_estimate

REMOVABLE = frozenset(
    signal.name
    for signal in (
        *gyro_states(),
        *filter_signals()[3:],
        *accel_states(),
        *imu_signals(),
        *estimator_signals(),
    )
)
"""States of filters and estimators, which a model has only if they are on."""


class LinearStudy:
    """Reads the vehicle of a scenario, and computes its linear models in milliseconds.

    Args:
        scenario: its vehicle, variation, gains and rates are used; the air is calm. Or its setup.
        description: of its vehicle, if already read.
        vehicle: of that description, if already made.
        controller: in place of the scenario's.
        like: derivatives of a like study, see `Derivatives`.

    Raises:
        WorkbenchError: if the vehicle cannot be read.
    """

    def __init__(
        self,
        scenario: Scenario | Setup | None = None,
        description: Description | None = None,
        vehicle: Vehicle | None = None,
        controller: Controller | None = None,
        like: Derivatives | None = None,
    ) -> None:
        setup = make_setup(
            scenario, description=description, vehicle=vehicle, controller=controller
        )
        self.setup, self.scenario = setup, setup.scenario
        self.vehicle = setup.without_dropped_loads().vehicle
        self.controller = setup.controller
        self.gains = setup.values
        self._derivatives = Derivatives(setup, like)
        _, self._rate = sampled_estimate(setup.rates.control_period)
        self._mounting: Mounting | None = None
        self._duties: dict[str, float] = {}
        if setup.estimator:
            imu = find_imu(setup.vehicle, noise=False)
            self._mounting = mounting_of(imu, setup.sensors, setup.home)
            self._duties = {
                each.sensor.kind: min(1.0, setup.rates.control_period / each.period)
                for each in reversed(setup.sensors)
                if each.sensor.kind in AIDING_SENSORS
            }
            self._derivatives.p_BI = imu.p_BS
        self._estimators = LastCall(self._estimator_with)
        self._continuous = LastCall(self._flight_with)

    def like(
        self, scenario: Scenario | Setup, controller: Controller | None = None
    ) -> "LinearStudy":
        """Return a study of the same description with another variation, gains, rates or law.

        Most of the time of a study is for reading the description and for the plant. Parameter
        values are those of the scenario: settings of this study are not among them.
        """
        return LinearStudy(
            scenario, self.setup.description, self.setup.vehicle, controller, self._derivatives
        )

    def trim(
        self, point: OperatingPoint = HOVER_POINT, gains: Mapping[str, float] | None = None
    ) -> Trim:
        """Return the trim of an operating point.

        Args:
            point: the operating point.
            gains: parameter values by name that differ from the scenario's.

        Raises:
            WorkbenchError: if the vehicle cannot fly like that.
        """
        values = self._values(gains)
        self._derivatives.set_gains(values)
        with drake_error_sentences("there is no trim"):
            vehicle = self._derivatives.vehicle
            return find_trim(self._derivatives, vehicle, values, point, self._rate)

    def sampled(
        self, point: OperatingPoint = HOVER_POINT, gains: Mapping[str, float] | None = None
    ) -> LinearModel:
        """Return the exact model of the flight, from one control update to the next.

        Arguments and exceptions are those of `trim`.
        """
        return self._sampled(point, gains).lean(REMOVABLE)

    def noisy(
        self, point: OperatingPoint = HOVER_POINT, gains: Mapping[str, float] | None = None
    ) -> LinearModel:
        """Return the sampled model, with the noise of every sample of every sensor as inputs.

        Arguments and exceptions are those of `trim`.
        """
        values, rates = self._values(gains), self.scenario.rates
        every = sample_steps(values["gyro_rate"], rates.physics_step, rates.control_steps)
        return self._sampled(point, gains, rates.control_steps // every).lean(REMOVABLE)

    def plant_input(
        self, point: OperatingPoint = HOVER_POINT, gains: Mapping[str, float] | None = None
    ) -> LinearModel:
        """Return the closed sampled loop from the plant's input to it.

        The plant's input is the wrench that an update commands: force along z and moment in T. The
        wrench is the output, and an injection is added on its way to the rotors, unknown to the
        law. So every law is judged at the same point, even one that uses its own commands.

        Arguments and exceptions are those of `trim`.
        """
        signals = wrench_signals()
        model = self._sampled(point, gains, injected=signals)
        loop = dataclasses.replace(
            model,
            input_matrix=model.B([signal.name for signal in signals]),
            output_matrix=self._wrench(model, model.A),
            feedthrough=np.zeros((len(signals), len(signals))),
            inputs=signals,
            outputs=signals,
        )
        return loop.lean(REMOVABLE)

    def wrench_by(
        self, points: Sequence[str], gains: Mapping[str, float] | None = None
    ) -> np.ndarray:
        """Return the wrench that an update of all parts commands in hover per injection (4, P).

        Args:
            points: of the injections.
            gains: parameter values by name that differ from the scenario's.
        """
        trim, known = self.trim(HOVER_POINT, gains), list(self.controller.points)
        update = self._derivatives.whole_update(
            *update_inputs(trim, self._rate, self._derivatives.measured_joints)
        )
        first = update.commands_by.shape[1] - trim.memory.size - len(known)
        by_commands, _ = self._derivatives.allocation_at(trim.commands)
        columns = [first + known.index(point) for point in points]
        found: np.ndarray = by_commands @ update.commands_by[:, columns]
        return found

    def _wrench(self, model: LinearModel, rows: np.ndarray) -> np.ndarray:
        """Return rows (4, k) of the wrench that an update commands, by those of states (m, k)."""
        by_commands, _ = self._derivatives.allocation_at(model.trim.commands)
        first = model.state_names.index("command_1")
        found: np.ndarray = by_commands @ rows[first : first + by_commands.shape[1]]
        return found

    def continuous(
        self, point: OperatingPoint = HOVER_POINT, gains: Mapping[str, float] | None = None
    ) -> LinearModel:
        """Return the model of the continuous core, which has no sampling, hold or delay.

        Arguments and exceptions are those of `trim`.
        """
        trim, values = self.trim(point, gains), self._values(gains)
        if self.setup.estimator:
            raise WorkbenchError(
                f"the estimator {self.scenario.estimator} is sampled, so it has no continuous "
                "model: leave --time continuous out, or use `--estimator truth`"
            )
        if any(values[name] for name in FILTER_PARAMETERS):
            raise WorkbenchError(
                "filters are sampled, so they have no continuous model: leave --time "
                "continuous out, or switch off "
                + ", ".join(n for n in FILTER_PARAMETERS if values[n])
            )
        if self._derivatives.setpoint_filter.states:
            raise WorkbenchError(
                "delays and low-passes of servos are sampled, so they have no continuous model: "
                "leave --time continuous out"
            )
        built_in = built_in_values(self.controller, values)
        core = self._continuous(np.array(list(built_in.values())))
        return core.model(trim, values)

    def bare_vehicle(
        self, point: OperatingPoint = HOVER_POINT, gains: Mapping[str, float] | None = None
    ) -> LinearModel:
        """Return the continuous model of the vehicle alone, from rotor commands to motion.

        Its servos have no delay and no low-pass. Arguments and exceptions are those of `trim`.
        """
        trim, values = self.trim(point, gains), self._values(gains)
        return self._derivatives.plant.model(trim, values)

    def _sampled(
        self,
        point: OperatingPoint,
        gains: Mapping[str, float] | None,
        samples: int = 0,
        injected: tuple[ModelSignal, ...] = (),
    ) -> LinearModel:
        trim = self.trim(point, gains)
        estimator = self._estimator_at(trim, self._values(gains))
        rates, delays = self.setup.rates, self._delays
        return sampled_model(
            self._derivatives, trim, rates, self._rate, delays, estimator, samples, injected
        )

    def _estimator_at(self, trim: Trim, values: Mapping[str, float]) -> EstimatorModel | None:
        """Return the model of the estimator at a trim; the last one is cached.

        Raises:
            WorkbenchError: in a turn, which has no such model.
        """
        estimator = self.setup.estimator
        if not estimator:
            return None
        if trim.point.yaw_rate:
            raise WorkbenchError(
                f"a turn cannot be linearised with the estimator {estimator.name}: set the yaw "
                "rate to 0, or use the true state"
            )
        settings = np.array([values[name] for name in estimator.settings._fields])
        return self._estimators(settings, trim.state, trim.vdot_WB)

    def _estimator_with(
        self, settings: np.ndarray, state: np.ndarray, vdot_WB: np.ndarray
    ) -> EstimatorModel:
        estimator, period = self.setup.estimator, self.setup.rates.control_period
        assert estimator and self._mounting
        return estimator_model(
            estimator, settings, self._mounting, self._duties, period, state, vdot_WB
        )

    @property
    def _delays(self) -> Delays:
        rates = self.setup.rates
        return self.setup.variation.delays(rates.physics_step, rates.control_period)

    def _flight_with(self, built_in: np.ndarray) -> FlightDerivatives:
        """Return the derivatives of a continuous core with other `built_in_values`."""
        names = built_in_values(self.controller, self.gains)
        values = {**self.gains, **dict(zip(names, built_in.tolist(), strict=True))}
        setup = dataclasses.replace(self.setup, values=values).without_dropped_loads()
        core = make_flight_core(setup)
        return FlightDerivatives(core, self.controller, setup.vehicle, self.setup.vehicle)

    def _values(self, gains: Mapping[str, float] | None) -> dict[str, float]:
        return {**self.gains, **self.setup.table.checked(gains or {})}
