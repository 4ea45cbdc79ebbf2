"""The linear model of the continuous flight core: exact, without sampling, hold and delay."""

import numpy as np
from pydrake.autodiffutils import InitializeAutoDiff
from pydrake.systems.framework import Diagram

from workbench.control.loop_points import CLOSED, COUNT, INJECTIONS
from workbench.design.linear.attitude import reduced, state_seeds, turn_with_heading
from workbench.design.linear.autodiff import constants, gradient
from workbench.design.linear.derivatives import HELD, HOLD_X, REFERENCE, STATE
from workbench.design.linear.model import LinearModel, Trim
from workbench.design.linear.names import (
    filtered,
    motion,
    numbered,
    outputs,
    points,
    references,
    yaw_moment,
)
from workbench.design.linear.trim import guidance_of, reference_of
from workbench.diagram.core import live_numbers, parameter_values
from workbench.plant.vehicle import Vehicle
from workbench.systems.controller import GAINS, PROBES


class ContinuousDerivatives:
    """An AutoDiff copy of a flight core, kept, whose Context is filled anew each time.

    Args:
        core: from `make_flight_core`.
        vehicle: as its law knows it.
    """

    def __init__(self, core: Diagram, vehicle: Vehicle) -> None:
        self._vehicle = vehicle
        self._diagram = core.ToAutoDiffXd()
        self._root = self._diagram.CreateDefaultContext()
        self._controller = self._diagram.GetSubsystemByName("controller")
        self._in_controller = self._controller.GetMyMutableContextFromRoot(self._root)

    def model(self, trim: Trim, gains: dict[str, float], rate: float) -> LinearModel:
        """Return the linear model at a trim.

        Args:
            trim: where.
            gains: parameter values by name.
            rate: of the acceleration estimate [1/s].
        """
        n = trim.speeds.size
        # the law remembers a yaw moment only where rotors have an inertia
        moments = self._controller.num_continuous_states()
        states, inputs = STATE + n + 3 + moments, REFERENCE + HELD + COUNT
        seeds = np.eye(states + inputs)
        at_states, at_inputs = seeds[:states], seeds[states:]
        rows = np.vstack([state_seeds(trim.q_WB) @ at_states[:STATE], at_states[STATE:]])
        self._fix("reference", reference_of(trim), 0, at_inputs[:REFERENCE])
        held = at_inputs[REFERENCE : REFERENCE + HELD]
        self._fix("guidance", guidance_of(trim), HOLD_X, held)
        self._set(GAINS, constants(parameter_values("controller", gains).values()))
        air = self._diagram.GetSubsystemByName("forces").GetMyMutableContextFromRoot(self._root)
        live = live_numbers(self._vehicle, gains).values()
        air.get_mutable_numeric_parameter(0).SetFromVector(constants(live))
        probes = np.zeros((len(CLOSED), states + inputs))
        probes[INJECTIONS:] = at_inputs[REFERENCE + HELD :]
        self._set(PROBES, InitializeAutoDiff(np.array(CLOSED), probes))
        known = [trim.state, trim.speeds, trim.v_WB - trim.vdot_WB / rate]
        self._root.SetContinuousState(constants(np.concatenate([*known, [0.0] * moments])))
        moment = self._controller.wanted_yaw_moment(self._in_controller).value()
        values = np.concatenate([*known, [moment] * moments])
        self._root.SetContinuousState(InitializeAutoDiff(values, rows))

        slopes = gradient(
            self._diagram.EvalTimeDerivatives(self._root).CopyToVector(), states + inputs
        )
        slopes = np.vstack([reduced(trim.q_WB) @ slopes[:13], slopes[13:]])
        signals = gradient(self._controller.loop_signals(self._in_controller), states + inputs)
        thrusts, speeds = (
            gradient(self._diagram.GetOutputPort(name).Eval(self._root), states + inputs)
            for name in ("thrusts", "speeds")
        )
        shown = np.vstack([seeds[:STATE], signals, thrusts, speeds])
        A = slopes[:, :states]
        turn_with_heading(A, trim.point.yaw_rate, (3, 6, 9, STATE + n))
        return LinearModel(
            A=A,
            input_matrix=slopes[:, states:],
            output_matrix=shown[:, :states],
            feedthrough=shown[:, states:],
            period=0.0,
            states=(
                *motion(),
                *numbered("speed", n, "rad/s"),
                *filtered(),
                *yaw_moment()[:moments],
            ),
            inputs=(*references(), *points()),
            outputs=outputs(n),
            trim=trim,
        )

    def _fix(self, port: str, values: np.ndarray, start: int, seeds: np.ndarray) -> None:
        """Give an input port values, of which some have derivatives."""
        rows = np.zeros((values.size, seeds.shape[1]))
        rows[start : start + seeds.shape[0]] = seeds
        self._diagram.GetInputPort(port).FixValue(self._root, InitializeAutoDiff(values, rows))

    def _set(self, index: int, values: np.ndarray) -> None:
        self._in_controller.get_mutable_numeric_parameter(index).SetFromVector(values.ravel())
