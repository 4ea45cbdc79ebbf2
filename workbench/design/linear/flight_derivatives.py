"""Derivatives of a vehicle and of its control law at an operating point."""

import math
from collections.abc import Mapping

import numpy as np
from pydrake.autodiffutils import InitializeAutoDiff
from pydrake.systems.framework import Diagram

from workbench.common.errors import WorkbenchError
from workbench.control.controller import Controller
from workbench.design.linear.derivatives import HELD_SIZE, HOLD_X_INDEX, REFERENCE_SIZE
from workbench.design.linear.model import (
    LinearModel,
    ModelSignal,
    Trim,
    filter_signals,
    law_memory_signals,
    loop_point_signals,
    motion_signals,
    output_signals,
    reference_signals,
    rotor_signals,
)
from workbench.design.linear.seeds import MOTION_STATE_SIZE, gradient, turn_with_heading
from workbench.design.linear.trim import guidance_of, reference_of
from workbench.design.linear.vehicle import VehicleDerivatives
from workbench.diagram.core import law_gains
from workbench.plant.vehicle import Vehicle
from workbench.systems.acceleration_estimate import ESTIMATE_TIME_CONSTANT_S


class FlightDerivatives(VehicleDerivatives):
    """The same for a flight core: vehicle and law.

    Args:
        core: from `make_flight_core`.
        controller: with the law that flies.
        vehicle: as known to its law.
        loaded: see `VehicleDerivatives`.
    """

    def __init__(
        self,
        core: Diagram,
        controller: Controller,
        vehicle: Vehicle,
        loaded: Vehicle | None = None,
    ) -> None:
        super().__init__(core, vehicle, loaded=loaded)
        self._law = controller
        self._controller = self._diagram.GetSubsystemByName("controller")
        self._in_controller = self._controller.GetMyMutableContextFromRoot(self._root)

    def model(self, trim: Trim, gains: Mapping[str, float]) -> LinearModel:
        """Return the continuous model at a trim, in the axes of the heading.

        Args:
            trim: where.
            gains: parameter values by name.
        """
        n, k, joints = trim.speeds.size, trim.memory.size, 2 * trim.joints.size
        count, closed = len(self._law.points), np.array(self._law.closed)
        # the law remembers a yaw moment only if rotors have an inertia
        moments = self._controller.num_continuous_states() - k
        states = MOTION_STATE_SIZE + n + joints + 3 + moments + k
        inputs = REFERENCE_SIZE + HELD_SIZE + count
        seeds = np.eye(states + inputs)
        at_states, at_inputs = seeds[:states], seeds[states:]
        self._fix("reference", reference_of(trim), 0, at_inputs[:REFERENCE_SIZE])
        held = at_inputs[REFERENCE_SIZE : REFERENCE_SIZE + HELD_SIZE]
        self._fix("guidance", guidance_of(trim), HOLD_X_INDEX, held)
        flown = law_gains(self._law, self._vehicle, gains)
        self._set("controller", self._controller.gains_index, flown)
        self.set_air(gains)
        probes = np.zeros((closed.size, states + inputs))
        probes[count:] = at_inputs[REFERENCE_SIZE + HELD_SIZE :]
        loops = self._in_controller.get_mutable_numeric_parameter(self._controller.probes_index)
        loops.SetFromVector(InitializeAutoDiff(closed, probes).ravel())
        filtered = trim.v_WB - trim.vdot_WB * ESTIMATE_TIME_CONSTANT_S
        known = [trim.state, trim.speeds, trim.joints, np.zeros_like(trim.joints), filtered]
        self._set_state(
            [*known, np.zeros(moments), trim.memory], trim.q_WB, np.zeros_like(at_states)
        )
        moment = self._controller.wanted_yaw_moment(self._in_controller).value()
        if math.isnan(moment):
            raise WorkbenchError(
                f"{self._law.name} uses the previously commanded wrench, so it has no continuous "
                "model: leave --time continuous out"
            )
        self._set_state([*known, np.full(moments, moment), trim.memory], trim.q_WB, at_states)
        _, slopes = self._slopes(trim.q_WB, states + inputs)
        signals = gradient(self._controller.loop_signals(self._in_controller), states + inputs)
        moving = slice(MOTION_STATE_SIZE + n, MOTION_STATE_SIZE + n + joints)
        rotors = self._rotors(states + inputs)
        shown = np.vstack([seeds[:MOTION_STATE_SIZE], signals, *rotors, seeds[moving]])
        A = slopes[:, :states]
        turn_with_heading(A, trim.point.yaw_rate, (3, 6, 9, moving.stop))
        return LinearModel(
            A=A,
            input_matrix=slopes[:, states:],
            output_matrix=shown[:, :states],
            feedthrough=shown[:, states:],
            period=0.0,
            states=(
                *motion_signals(),
                *rotor_signals("speed", n, "rad/s"),
                *self.joint_signals,
                *filter_signals()[:3],
                *(ModelSignal("yaw_moment", "N*m"),) * moments,
                *law_memory_signals(self._law),
            ),
            inputs=(*reference_signals(), *loop_point_signals(self._law)),
            outputs=(*output_signals(n, self._law), *self.joint_signals),
            trim=trim,
            controller=self._law,
        )
