"""A controller as a continuous LeafSystem: ports, gains and memory around the pure law."""

import math
from collections.abc import Sequence

from pydrake.systems.framework import (
    BasicVector,
    BasicVector_,
    Context,
    ContinuousState,
    LeafSystem,
    LeafSystem_,
)

from workbench.control.controller import Controller
from workbench.control.flight_law import allocate, flight_law
from workbench.control.guidance import LIFT_FIELD, MOTORS_FIELD, Guidance, LawSetpoint, Reference
from workbench.control.law_constants import law_constants
from workbench.plant.payload import NO_PAYLOAD, Payload
from workbench.plant.vehicle import Vehicle
from workbench.systems.cached import cached
from workbench.systems.convertible import convertible

_ZERO_LEAD_RATE = 100.0
"""Rate at which the yaw moment follows the wanted one if the law assumes no lead [1/s]."""
DERIVATIVE_STEP_S = 1e-6
"""Time of an update whose change of memory, over this time, is the memory's derivative [s]."""


@convertible
def ContinuousController_(T: type) -> type[LeafSystem]:
    """A controller's law without sampling, and the mixer.

    Its state is the law's memory. If rotors have an inertia, the first state is the commanded yaw
    moment [N·m]: it follows the wanted one with a lag that spin-up torque compensates, see
    `flight_law.yaw_moment_weight`.

    Input ports:
        state (13): q_WB (w, x, y, z), p_WB [m], w_WB_W [rad/s], v_WB_W [m/s].
        acceleration (3): estimate in W [m/s²], for the derivative terms.
        reference (8): see `guidance.Reference`.
        guidance (22): see `guidance.Guidance`.
    Output port:
        commands (n + m): rotor speeds [rad/s], and angles of tilts [rad].
    Numeric parameter 0: `Controller.gains`.
    Numeric parameter 1: gates and injections of the loop points, see `loop_points`.

    `MeasuredMotion.wrench` is NaN, because without updates there are no previous commands.
    """

    class Impl(LeafSystem_[T]):
        def declare(
            self,
            *,
            controller: Controller,
            vehicle: Vehicle,
            gains: Sequence[float],
            payload: Payload = NO_PAYLOAD,
        ) -> None:
            self.controller = controller
            self._law = flight_law(controller)
            self._constants = law_constants(vehicle, payload)
            self._moments = 1 if self._constants.spin_up_time > 0.0 else 0
            self.gains_index = self.DeclareNumericParameter(
                BasicVector_[T]([T(value) for value in gains])
            )
            self.probes_index = self.DeclareNumericParameter(
                BasicVector_[T]([T(x) for x in controller.closed])
            )
            self._state = self.DeclareVectorInputPort("state", 13)
            self._acceleration = self.DeclareVectorInputPort("acceleration", 3)
            self._reference = self.DeclareVectorInputPort("reference", len(Reference._fields))
            self._guidance = self.DeclareVectorInputPort("guidance", len(Guidance._fields))
            initial = [0.0] * self._moments + controller.initial_memory
            if initial:
                self.DeclareContinuousState(BasicVector_[T]([T(value) for value in initial]))
            needs = {self.all_input_ports_ticket(), self.all_parameters_ticket(), self.xc_ticket()}
            self._updated = cached(self._calc_update, "update of the law", needs)
            self.DeclareVectorOutputPort(
                "commands", len(self._constants.allocation), self._calc_commands, needs
            )

        def loop_signals(self, context: Context) -> list[float]:
            """Return the signal before each loop point now."""
            return self._updated(context)[1]

        def wanted_yaw_moment(self, context: Context) -> float:
            """Return the wanted yaw moment now [N·m], which is the state in a steady flight."""
            return self._updated(context)[2]

        def DoCalcTimeDerivatives(self, context: Context, derivatives: ContinuousState) -> None:
            states = context.get_continuous_state_vector().CopyToVector().tolist()
            if not states:
                return
            _, _, wanted, after = self._updated(context)
            slopes = []
            if self._moments:
                lead = self._lead(context)
                # the law that reckons with none does not use its state, which then follows quickly
                rate = 1.0 / lead if lead > 0.0 else _ZERO_LEAD_RATE
                slopes = [rate * (wanted - states[0])]
            remembered = states[self._moments :]
            slopes += [
                (new - old) / DERIVATIVE_STEP_S for new, old in zip(after, remembered, strict=True)
            ]
            derivatives.get_mutable_vector().SetFromVector(slopes)

        def _calc_commands(self, context: Context, output: BasicVector) -> None:
            output.SetFromVector(self._updated(context)[0])

        def _lead(self, context: Context) -> float:
            """Return the lead of spin-up torque over drag torque that the law assumes [s]."""
            gains = context.get_numeric_parameter(self.gains_index).CopyToVector().tolist()
            return self._law.gains(gains).spin_up_feedforward * self._constants.spin_up_time

        def _calc_update(
            self, context: Context
        ) -> tuple[list[float], list[float], float, Sequence[float]]:
            """Return commands, signals at the loop points, wanted yaw moment, and memory."""
            commands = [0.0] * len(self._constants.allocation)
            states = context.get_continuous_state_vector().CopyToVector().tolist()
            has_lead = self._lead(context) > 0.0
            before = states[0] if has_lead else 0.0
            probes = context.get_numeric_parameter(self.probes_index).CopyToVector().tolist()
            loops = [*probes, *[0.0] * len(self.controller.points)]
            guidance = self._guidance.Eval(context).tolist()
            reference = self._reference.Eval(context).tolist()
            wanted, after = (0.0, 0.0, 0.0, 0.0), self.controller.initial_memory
            if guidance[LIFT_FIELD] > 0.0:
                wanted, after = self._law.wrench(
                    self._state.Eval(context).tolist(),
                    self._acceleration.Eval(context).tolist(),
                    1.0,
                    LawSetpoint(reference, guidance, (0.0, 0.0, 0.0)),
                    self._law.gains(
                        context.get_numeric_parameter(self.gains_index).CopyToVector().tolist()
                    ),
                    self._law.memory(states[self._moments :]),
                    (math.nan, math.nan, math.nan, before),
                    DERIVATIVE_STEP_S,
                    self._constants,
                    loops,
                )
            force, m_x, m_y, m_z = wanted
            wrench = (force, m_x, m_y, before if has_lead else m_z)
            allocate(
                wrench, guidance[LIFT_FIELD], guidance[MOTORS_FIELD], self._constants, commands
            )
            return commands, loops[len(probes) :], m_z, after

    return Impl
