"""The cascaded controller as a continuous LeafSystem: ports and gains around the pure law."""

import sys
from typing import Any

from pydrake.autodiffutils import AutoDiffXd
from pydrake.systems.framework import BasicVector_, LeafSystem_
from pydrake.systems.scalar_conversion import TemplateSystem

from workbench.plant.vehicle import Vehicle
from workbench.systems.cascade import Gains, Guidance, Reference
from workbench.systems.flight_law import law_constants, rotor_commands
from workbench.systems.loop_points import CLOSED, COUNT, SIGNALS

GAINS, PROBES = range(2)
"""Numeric parameters."""


# A template is filled where it is first used: Drake looks through the stack for whose it is, which
# takes a tenth of a second each time within nested imports. Hence `scope`, too.
@TemplateSystem.define("CascadedController_", [float, AutoDiffXd], scope=sys.modules[__name__])
def CascadedController_(T: Any) -> Any:
    """Velocity PD -> attitude PD -> mixer, without state or time of its own, for whole rotors.

    Input ports:
        state (13): q_WB (w, x, y, z), p_WB [m], w_WB_W [rad/s], v_WB_W [m/s].
        acceleration (3): estimate in W [m/s²], for the derivative terms.
        reference (8): see `cascade.Reference`.
        guidance (22): see `cascade.Guidance`.
    Output port:
        commands (n): rotor speeds [rad/s].
    Numeric parameter 0: `cascade.Gains`.
    Numeric parameter 1: gates and injections of the loop points (30), see `loop_points`.
    """

    class Impl(LeafSystem_[T]):
        def _construct(self, *, vehicle: Vehicle, gains: Gains, converter: Any = None) -> None:
            LeafSystem_[T].__init__(self, converter)
            self.vehicle = vehicle
            self.gains = gains
            self._constants = law_constants(vehicle, 0.0)
            self._shares = [1.0] * len(vehicle.rotors)
            self.DeclareNumericParameter(BasicVector_[T]([T(value) for value in gains]))
            self.DeclareNumericParameter(BasicVector_[T]([T(value) for value in CLOSED]))
            self._state = self.DeclareVectorInputPort("state", 13)
            self._acceleration = self.DeclareVectorInputPort("acceleration", 3)
            self._reference = self.DeclareVectorInputPort("reference", len(Reference._fields))
            self._guidance = self.DeclareVectorInputPort("guidance", len(Guidance._fields))
            self.DeclareVectorOutputPort(
                "commands",
                len(vehicle.rotors),
                self._calc_commands,
                {self.all_input_ports_ticket(), self.all_parameters_ticket()},
            )

        def _construct_copy(self, other: Any, converter: Any = None) -> None:
            Impl._construct(self, vehicle=other.vehicle, gains=other.gains, converter=converter)

        def loop_signals(self, context: Any) -> list[Any]:
            """Return what comes to each of the loop points (15) now."""
            return self._run(context)[1]

        def _calc_commands(self, context: Any, output: Any) -> None:
            output.SetFromVector(self._run(context)[0])

        def _run(self, context: Any) -> tuple[list[Any], list[Any]]:
            """Return commands and signals at the loop points."""
            commands = [0.0] * len(self.vehicle.rotors)
            probes = context.get_numeric_parameter(PROBES).CopyToVector().tolist()
            loops = [*probes, *[0.0] * COUNT]
            rotor_commands(
                self._state.Eval(context).tolist(),
                self._acceleration.Eval(context).tolist(),
                self._reference.Eval(context).tolist(),
                self._guidance.Eval(context).tolist(),
                context.get_numeric_parameter(GAINS).CopyToVector().tolist(),
                self._shares,
                self._constants,
                loops,
                commands,
            )
            return commands, loops[SIGNALS:]

    return Impl
