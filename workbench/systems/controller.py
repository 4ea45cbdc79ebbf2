"""A controller as a continuous LeafSystem: ports, gains and memory around the pure law."""

import math
import sys
from collections.abc import Sequence
from typing import Any

from pydrake.autodiffutils import AutoDiffXd
from pydrake.systems.framework import BasicVector_, LeafSystem_
from pydrake.systems.scalar_conversion import TemplateSystem

from workbench.control.controller import Controller
from workbench.control.flight_law import allocate, flight_law, law_constants
from workbench.control.guidance import LIFT, MOTORS, Guidance, Reference, Setpoint
from workbench.plant.payload import NO_PAYLOAD, Payload
from workbench.plant.vehicle import Vehicle

_FAST = 100.0
"""[1/s]"""
SHORT = 1e-6
"""Time of an update whose change of memory, over this time, is the memory's derivative [s]."""


# A template is filled where it is first used: Drake looks through the stack for whose it is, which
# takes a tenth of a second each time within nested imports. Hence `scope`, too.
@TemplateSystem.define("ContinuousController_", [float, AutoDiffXd], scope=sys.modules[__name__])
def ContinuousController_(T: Any) -> Any:
    """A controller's law without sampling, and the mixer, without rotor faults.

    Its state is the law's memory. If rotors have an inertia, the first state is the commanded yaw
    moment [N·m]: it follows the wanted one with a lag that spin-up torque compensates, see
    `flight_law.kept_share`.

    Input ports:
        state (13): q_WB (w, x, y, z), p_WB [m], w_WB_W [rad/s], v_WB_W [m/s].
        acceleration (3): estimate in W [m/s²], for the derivative terms.
        reference (8): see `guidance.Reference`.
        guidance (22): see `guidance.Guidance`.
    Output port:
        commands (n): rotor speeds [rad/s].
    Numeric parameter 0: `Controller.gains`.
    Numeric parameter 1: gates and injections of the loop points, see `loop_points`.

    `Measured.wrench` is NaN, because without updates there are no previous commands.
    """

    class Impl(LeafSystem_[T]):
        def _construct(
            self,
            *,
            controller: Controller,
            vehicle: Vehicle,
            gains: Sequence[float],
            payload: Payload = NO_PAYLOAD,
            converter: Any = None,
        ) -> None:
            LeafSystem_[T].__init__(self, converter)
            self.controller = controller
            self.vehicle = vehicle
            self.gains = gains
            self.payload = payload
            self._law = flight_law(controller)
            self._constants = law_constants(vehicle, payload)
            self._shares = [1.0] * len(vehicle.rotors)
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
            self.DeclareVectorOutputPort(
                "commands", len(vehicle.rotors), self._calc_commands, needs
            )

        def _construct_copy(self, other: Any, converter: Any = None) -> None:
            Impl._construct(
                self,
                controller=other.controller,
                vehicle=other.vehicle,
                gains=other.gains,
                payload=other.payload,
                converter=converter,
            )

        def loop_signals(self, context: Any) -> list[Any]:
            """Return the signal before each loop point now."""
            return self._run(context)[1]

        def wanted_yaw_moment(self, context: Any) -> Any:
            """Return the wanted yaw moment now [N·m], which is the state in a steady flight."""
            return self._run(context)[2]

        def DoCalcTimeDerivatives(self, context: Any, derivatives: Any) -> None:
            states = context.get_continuous_state_vector().CopyToVector().tolist()
            if not states:
                return
            _, _, wanted, after = self._run(context)
            slopes = []
            if self._moments:
                lead = self._lead(context)
                # the law that reckons with none does not use its state, which then follows quickly
                rate = 1.0 / lead if lead > 0.0 else _FAST
                slopes = [rate * (wanted - states[0])]
            remembered = states[self._moments :]
            slopes += [(new - old) / SHORT for new, old in zip(after, remembered, strict=True)]
            derivatives.get_mutable_vector().SetFromVector(slopes)

        def _calc_commands(self, context: Any, output: Any) -> None:
            output.SetFromVector(self._run(context)[0])

        def _lead(self, context: Any) -> Any:
            """Return the lead of spin-up torque over drag torque that the law assumes [s]."""
            gains = context.get_numeric_parameter(self.gains_index).CopyToVector().tolist()
            return self._law.gains(gains).spin_up_feedforward * self._constants.spin_up_time

        def _run(self, context: Any) -> tuple[list[Any], list[Any], Any, Any]:
            """Return commands, signals at the loop points, wanted yaw moment, and memory."""
            commands = [0.0] * len(self.vehicle.rotors)
            states = context.get_continuous_state_vector().CopyToVector().tolist()
            kept, before = 0.0, 0.0
            if self._lead(context) > 0.0:
                kept, before = 1.0, states[0]
            probes = context.get_numeric_parameter(self.probes_index).CopyToVector().tolist()
            loops = [*probes, *[0.0] * len(self.controller.points)]
            guidance = self._guidance.Eval(context).tolist()
            reference = self._reference.Eval(context).tolist()
            wanted, after = (0.0, 0.0, 0.0, 0.0), self.controller.initial_memory
            if guidance[LIFT] > 0.0:
                wanted, after = self._law.wrench(
                    self._state.Eval(context).tolist(),
                    self._acceleration.Eval(context).tolist(),
                    1.0,
                    Setpoint(reference, guidance, (0.0, 0.0, 0.0)),
                    self._law.gains(
                        context.get_numeric_parameter(self.gains_index).CopyToVector().tolist()
                    ),
                    self._law.memory(states[self._moments :]),
                    (math.nan, math.nan, math.nan, before),
                    SHORT,
                    self._constants,
                    loops,
                )
            force, m_x, m_y, m_z = wanted
            wrench = (force, m_x, m_y, m_z + kept * (before - m_z))
            allocate(
                wrench, guidance[LIFT], guidance[MOTORS], self._shares, self._constants, commands
            )
            return commands, loops[len(probes) :], m_z, after

    return Impl
