"""The cascaded controller as a continuous LeafSystem: ports and gains around the pure law."""

import sys
from typing import Any

from pydrake.autodiffutils import AutoDiffXd
from pydrake.systems.framework import BasicVector_, LeafSystem_
from pydrake.systems.scalar_conversion import TemplateSystem

from workbench.control.flight_law import SPIN_UP, law_constants, rotor_commands
from workbench.control.guidance import Guidance, Reference
from workbench.control.loop_points import CLOSED, COUNT, SIGNALS
from workbench.control.pd import Gains
from workbench.plant.payload import NO_PAYLOAD, Payload
from workbench.plant.vehicle import Vehicle

GAINS, PROBES = range(2)
"""Numeric parameters."""
_FAST = 100.0
"""[1/s]"""


# A template is filled where it is first used: Drake looks through the stack for whose it is, which
# takes a tenth of a second each time within nested imports. Hence `scope`, too.
@TemplateSystem.define("CascadedController_", [float, AutoDiffXd], scope=sys.modules[__name__])
def CascadedController_(T: Any) -> Any:
    """Velocity PD -> attitude PD -> mixer, for whole rotors.

    Where rotors have an inertia, it has a state (1): the yaw moment asked for, which follows the
    wanted one late enough for their spin-up torque to make up for it [N·m], see
    `flight_law.kept_share`.

    Input ports:
        state (13): q_WB (w, x, y, z), p_WB [m], w_WB_W [rad/s], v_WB_W [m/s].
        acceleration (3): estimate in W [m/s²], for the derivative terms.
        reference (8): see `guidance.Reference`.
        guidance (22): see `guidance.Guidance`.
    Output port:
        commands (n): rotor speeds [rad/s].
    Numeric parameter 0: `pd.Gains`.
    Numeric parameter 1: gates and injections of the loop points (30), see `loop_points`.
    """

    class Impl(LeafSystem_[T]):
        def _construct(
            self,
            *,
            vehicle: Vehicle,
            gains: Gains,
            payload: Payload = NO_PAYLOAD,
            converter: Any = None,
        ) -> None:
            LeafSystem_[T].__init__(self, converter)
            self.vehicle = vehicle
            self.gains = gains
            self.payload = payload
            self._constants = law_constants(vehicle, payload)
            self._shares = [1.0] * len(vehicle.rotors)
            self.DeclareNumericParameter(BasicVector_[T]([T(value) for value in gains]))
            self.DeclareNumericParameter(BasicVector_[T]([T(value) for value in CLOSED]))
            self._state = self.DeclareVectorInputPort("state", 13)
            self._acceleration = self.DeclareVectorInputPort("acceleration", 3)
            self._reference = self.DeclareVectorInputPort("reference", len(Reference._fields))
            self._guidance = self.DeclareVectorInputPort("guidance", len(Guidance._fields))
            self.DeclareContinuousState(1 if self._constants.spin_up_time > 0.0 else 0)
            needs = {self.all_input_ports_ticket(), self.all_parameters_ticket(), self.xc_ticket()}
            self.DeclareVectorOutputPort(
                "commands", len(vehicle.rotors), self._calc_commands, needs
            )

        def _construct_copy(self, other: Any, converter: Any = None) -> None:
            Impl._construct(
                self,
                vehicle=other.vehicle,
                gains=other.gains,
                payload=other.payload,
                converter=converter,
            )

        def loop_signals(self, context: Any) -> list[Any]:
            """Return what comes to each of the loop points (15) now."""
            return self._run(context)[1]

        def wanted_yaw_moment(self, context: Any) -> Any:
            """Return the yaw moment that is wanted now [N·m]: the state of a steady flight."""
            return self._run(context)[2]

        def DoCalcTimeDerivatives(self, context: Any, derivatives: Any) -> None:
            if self._constants.spin_up_time == 0.0:
                return
            moment = context.get_continuous_state_vector().GetAtIndex(0)
            lead = self._lead(context)
            # the law that reckons with none does not use its state, which then follows quickly
            rate = 1.0 / lead if lead > 0.0 else _FAST
            change = rate * (self.wanted_yaw_moment(context) - moment)
            derivatives.get_mutable_vector().SetFromVector([change])

        def _calc_commands(self, context: Any, output: Any) -> None:
            output.SetFromVector(self._run(context)[0])

        def _lead(self, context: Any) -> Any:
            """Return by how much the law reckons with spin-up torque to lead drag torque [s]."""
            share = context.get_numeric_parameter(GAINS).GetAtIndex(SPIN_UP)
            return share * self._constants.spin_up_time

        def _run(self, context: Any) -> tuple[list[Any], list[Any], Any]:
            """Return commands, signals at the loop points, and the wanted yaw moment."""
            commands = [0.0] * len(self.vehicle.rotors)
            kept, before = 0.0, 0.0
            if self._lead(context) > 0.0:
                kept, before = 1.0, context.get_continuous_state_vector().GetAtIndex(0)
            probes = context.get_numeric_parameter(PROBES).CopyToVector().tolist()
            loops = [*probes, *[0.0] * COUNT]
            wanted = rotor_commands(
                self._state.Eval(context).tolist(),
                self._acceleration.Eval(context).tolist(),
                self._reference.Eval(context).tolist(),
                self._guidance.Eval(context).tolist(),
                context.get_numeric_parameter(GAINS).CopyToVector().tolist(),
                self._shares,
                self._constants,
                loops,
                kept,
                before,
                commands,
            )
            return commands, loops[SIGNALS:], wanted

    return Impl
