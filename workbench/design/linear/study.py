"""One vehicle, read once, and its linear models at any point with any gains."""

from collections.abc import Mapping

import numpy as np
from pydrake.autodiffutils import InitializeAutoDiff
from pydrake.systems.framework import Diagram

from workbench.common.errors import sentences
from workbench.control.controller import load_controller
from workbench.design.linear.attitude import reduced, state_seeds, turn_with_heading
from workbench.design.linear.autodiff import constants, gradient
from workbench.design.linear.continuous import ContinuousDerivatives
from workbench.design.linear.derivatives import STATE, Derivatives, LastCall
from workbench.design.linear.model import LinearModel, Trim
from workbench.design.linear.names import motion, numbered
from workbench.design.linear.operating_point import OperatingPoint
from workbench.design.linear.sampled import plant_input_model, sampled_model
from workbench.design.linear.trim import find_trim
from workbench.diagram.core import live_numbers, make_flight_core, make_vehicle_core
from workbench.gains.gains import flight_gains
from workbench.plant.description import Description
from workbench.plant.loading import make_vehicle
from workbench.plant.payload import Payload, payload_of
from workbench.plant.variation import Delays, varied
from workbench.plant.vehicle import Vehicle
from workbench.scenario.configured import read_configured
from workbench.scenario.parameters import parameter_table
from workbench.scenario.scenario import Scenario, check_scenario
from workbench.systems.acceleration_estimate import TIME_CONSTANT, sampled_estimate

HOVER = OperatingPoint()


class VehicleDerivatives:
    """An AutoDiff copy of a vehicle core, kept, whose Context is filled anew each time.

    Args:
        core: from `make_vehicle_core`.
        vehicle: as its law knows it.
    """

    def __init__(self, core: Diagram, vehicle: Vehicle) -> None:
        self._vehicle = vehicle
        self._diagram = core.ToAutoDiffXd()
        self._root = self._diagram.CreateDefaultContext()

    def model(self, trim: Trim, gains: Mapping[str, float]) -> LinearModel:
        """Return the continuous model at a trim, in the axes of the heading.

        Args:
            trim: where.
            gains: parameter values by name; those of the air are used.
        """
        air = self._diagram.GetSubsystemByName("forces").GetMyMutableContextFromRoot(self._root)
        live = live_numbers(self._vehicle, gains).values()
        air.get_mutable_numeric_parameter(0).SetFromVector(constants(live))
        n = trim.speeds.size
        seeds = np.eye(STATE + 2 * n)
        rows = np.vstack([state_seeds(trim.q_WB) @ seeds[:STATE], seeds[STATE : STATE + n]])
        values = np.concatenate([trim.state, trim.speeds])
        self._root.SetContinuousState(InitializeAutoDiff(values, rows))
        commands = InitializeAutoDiff(trim.commands, seeds[STATE + n :])
        self._diagram.GetInputPort("commands").FixValue(self._root, commands)
        slopes = gradient(self._diagram.EvalTimeDerivatives(self._root).CopyToVector(), len(seeds))
        slopes = np.vstack([reduced(trim.q_WB) @ slopes[:13], slopes[13:]])
        thrusts = gradient(self._diagram.GetOutputPort("thrusts").Eval(self._root), len(seeds))
        outputs = np.vstack([seeds[:STATE], thrusts, seeds[STATE : STATE + n]])
        known = STATE + n
        turn_with_heading(slopes, trim.point.yaw_rate, (3, 6, 9))
        return LinearModel(
            A=slopes[:, :known],
            input_matrix=slopes[:, known:],
            output_matrix=outputs[:, :known],
            feedthrough=outputs[:, known:],
            period=0.0,
            states=(*motion(), *numbered("speed", n, "rad/s")),
            inputs=numbered("command", n, "rad/s"),
            outputs=(*motion(), *numbered("thrust", n, "N"), *numbered("speed", n, "rad/s")),
            trim=trim,
        )


class LinearStudy:
    """Reads a scenario's vehicle and gives its linear models in milliseconds.

    Args:
        scenario: its vehicle, variation, gains and rates are used; the air is calm.
        description: of its vehicle, if that has been read already.

    Raises:
        WorkbenchError: if the vehicle cannot be read.
    """

    def __init__(
        self, scenario: Scenario | None = None, description: Description | None = None
    ) -> None:
        self.scenario = scenario or Scenario()
        check_scenario(self.scenario)
        config = self.scenario.vehicle
        self._description = description or read_configured(config)
        self.vehicle = make_vehicle(self._description)
        self.controller = load_controller(self.scenario.controller)
        self.gains: Mapping[str, float] = flight_gains(
            self.vehicle, config.gains, controller=self.controller
        )
        self._flown = varied(self._description, self.vehicle, config.variation)
        self._derivatives = Derivatives(
            self.controller, self._flown, self.vehicle, self.gains, self.scenario.rates
        )
        _, self._rate = sampled_estimate(self.scenario.rates.control_period)
        self._bare_vehicle = LastCall(self._vehicle_with)
        self._continuous = LastCall(self._flight_with)

    def like(self, scenario: Scenario) -> "LinearStudy":
        """Return a study of the same description with another variation, gains or rates.

        Reading a description takes most of the time that a study does.
        """
        return LinearStudy(scenario, self._description)

    def trim(self, point: OperatingPoint = HOVER, gains: Mapping[str, float] | None = None) -> Trim:
        """Return the trim of an operating point.

        Args:
            point: to be reached.
            gains: parameter values by name that differ from the scenario's.

        Raises:
            WorkbenchError: if it does not fly like that.
        """
        values = self._values(gains)
        self._derivatives.set_gains(values)
        with sentences("there is no trim"):
            return find_trim(self._derivatives, self.vehicle, values, point, self._rate)

    def sampled(
        self, point: OperatingPoint = HOVER, gains: Mapping[str, float] | None = None
    ) -> LinearModel:
        """Return the exact model of what flies, from one control update to the next.

        Arguments and exceptions are those of `trim`.
        """
        trim = self.trim(point, gains)
        return sampled_model(self._derivatives, trim, self.scenario.rates, self._rate, self._delays)

    def plant_input(
        self, point: OperatingPoint = HOVER, gains: Mapping[str, float] | None = None
    ) -> LinearModel:
        """Return the sampled model from the plant's input to it, see `plant_input_model`.

        Arguments and exceptions are those of `trim`.
        """
        model = self.sampled(point, gains)
        return plant_input_model(
            self._derivatives, model, self.scenario.rates, self._rate, self._delays
        )

    def continuous(
        self, point: OperatingPoint = HOVER, gains: Mapping[str, float] | None = None
    ) -> LinearModel:
        """Return the model of the continuous core, which has no sampling, hold or delay.

        Arguments and exceptions are those of `trim`.
        """
        trim, values = self.trim(point, gains), self._values(gains)
        core = self._continuous(np.array(payload_of(values)))
        return core.model(trim, values, 1.0 / TIME_CONSTANT)

    def bare_vehicle(
        self, point: OperatingPoint = HOVER, gains: Mapping[str, float] | None = None
    ) -> LinearModel:
        """Return the continuous model of the vehicle alone, from rotor commands to motion.

        Arguments and exceptions are those of `trim`.
        """
        trim, values = self.trim(point, gains), self._values(gains)
        core = self._bare_vehicle(np.array(payload_of(values)))
        return core.model(trim, values)

    @property
    def _delays(self) -> Delays:
        rates = self.scenario.rates
        return self.scenario.vehicle.variation.delays(rates.physics_step, rates.control_period)

    def _vehicle_with(self, payload: np.ndarray) -> VehicleDerivatives:
        """Return the vehicle with a payload, see `Payload` (8)."""
        values = {**self.gains, **Payload(*payload.tolist())._asdict()}
        return VehicleDerivatives(
            make_vehicle_core(self._flown, self.vehicle, values), self.vehicle
        )

    def _flight_with(self, payload: np.ndarray) -> ContinuousDerivatives:
        """Return vehicle and law with a payload, see `Payload` (8)."""
        values = {**self.gains, **Payload(*payload.tolist())._asdict()}
        core = make_flight_core(self.controller, self._flown, self.vehicle, values)
        return ContinuousDerivatives(core, self.controller, self.vehicle)

    def _values(self, gains: Mapping[str, float] | None) -> dict[str, float]:
        return {**self.gains, **parameter_table(self.controller).checked(gains or {})}
