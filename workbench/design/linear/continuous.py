"""The linear model of the continuous flight core: exact, without sampling, hold and delay."""

import math

import numpy as np
from pydrake.autodiffutils import InitializeAutoDiff
from pydrake.systems.framework import Diagram

from workbench.common.errors import WorkbenchError
from workbench.control.controller import Controller
from workbench.design.linear.attitude import reduced, state_seeds, turn_with_heading
from workbench.design.linear.autodiff import constants, gradient
from workbench.design.linear.derivatives import HELD, HOLD_X, REFERENCE, STATE
from workbench.design.linear.model import LinearModel, Trim
from workbench.design.linear.names import (
    filtered,
    memory_of,
    motion,
    numbered,
    outputs,
    references,
    yaw_moment,
)
from workbench.design.linear.names import points as points_of
from workbench.design.linear.trim import guidance_of, reference_of
from workbench.diagram.core import law_gains, live_numbers
from workbench.plant.vehicle import Vehicle
from workbench.systems.controller import GAINS, PROBES


class ContinuousDerivatives:
    """An AutoDiff copy of a flight core, kept, whose Context is filled anew each time.

    Args:
        core: from `make_flight_core`.
        controller: whose law flies.
        vehicle: as its law knows it.
    """

    def __init__(self, core: Diagram, controller: Controller, vehicle: Vehicle) -> None:
        self._law = controller
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
        n, k = trim.speeds.size, trim.memory.size
        points, closed = len(self._law.points), np.array(self._law.closed)
        # the law remembers a yaw moment only where rotors have an inertia
        moments = self._controller.num_continuous_states() - k
        states, inputs = STATE + n + 3 + moments + k, REFERENCE + HELD + points
        seeds = np.eye(states + inputs)
        at_states, at_inputs = seeds[:states], seeds[states:]
        rows = np.vstack([state_seeds(trim.q_WB) @ at_states[:STATE], at_states[STATE:]])
        self._fix("reference", reference_of(trim), 0, at_inputs[:REFERENCE])
        held = at_inputs[REFERENCE : REFERENCE + HELD]
        self._fix("guidance", guidance_of(trim), HOLD_X, held)
        self._set(GAINS, constants(law_gains(self._law, self._vehicle, gains)))
        air = self._diagram.GetSubsystemByName("forces").GetMyMutableContextFromRoot(self._root)
        live = live_numbers(self._vehicle, gains).values()
        air.get_mutable_numeric_parameter(0).SetFromVector(constants(live))
        probes = np.zeros((closed.size, states + inputs))
        probes[points:] = at_inputs[REFERENCE + HELD :]
        self._set(PROBES, InitializeAutoDiff(closed, probes))
        known = [trim.state, trim.speeds, trim.v_WB - trim.vdot_WB / rate]
        rest = [[0.0] * moments, trim.memory]
        self._root.SetContinuousState(constants(np.concatenate([*known, *rest])))
        moment = self._controller.wanted_yaw_moment(self._in_controller).value()
        if math.isnan(moment):
            raise WorkbenchError(
                f"{self._law.name} looks at the wrench that was commanded before, so it has no "
                "model without sampling: leave --time continuous out"
            )
        values = np.concatenate([*known, [moment] * moments, trim.memory])
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
                *memory_of(self._law),
            ),
            inputs=(*references(), *points_of(self._law)),
            outputs=outputs(n, self._law),
            trim=trim,
            controller=self._law,
        )

    def _fix(self, port: str, values: np.ndarray, start: int, seeds: np.ndarray) -> None:
        """Give an input port values, of which some have derivatives."""
        rows = np.zeros((values.size, seeds.shape[1]))
        rows[start : start + seeds.shape[0]] = seeds
        self._diagram.GetInputPort(port).FixValue(self._root, InitializeAutoDiff(values, rows))

    def _set(self, index: int, values: np.ndarray) -> None:
        self._in_controller.get_mutable_numeric_parameter(index).SetFromVector(values.ravel())
