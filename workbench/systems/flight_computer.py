"""The sampled controller with the rotors it commands, as one LeafSystem.

It is the same law as the continuous controller, estimate and rotor lag, in one update event. They
are one system here because of what was measured: each entry into Python from Drake's step costs
some 20 µs, each further system half a microsecond at every physics step.
"""

import sys
from collections.abc import Sequence
from typing import Any, TypeAlias

import numpy as np
from pydrake.autodiffutils import AutoDiffXd
from pydrake.systems.framework import BasicVector_, LeafSystem_
from pydrake.systems.scalar_conversion import TemplateSystem

from workbench.plant.rotors import Rotor
from workbench.plant.vehicle import Vehicle
from workbench.systems.acceleration_estimate import sampled_estimate
from workbench.systems.cascade import Gains, Guidance, Reference
from workbench.systems.compiled import compile_cached
from workbench.systems.flight_law import (
    control_update,
    law_constants,
    packed,
    packed_update,
)
from workbench.systems.loop_points import CLOSED, COUNT, SIGNALS

THRUSTS, MEMORY = range(2)
"""Groups of the discrete state."""
GAINS, SHARES, PROBES = range(3)
"""Numeric parameters."""

compiled_update = compile_cached(packed_update, parts=72)


# A template is filled where it is first used: Drake looks through the stack for whose it is, which
# takes a tenth of a second each time within nested imports. Hence `scope`, too.
@TemplateSystem.define("FlightComputer_", [float, AutoDiffXd], scope=sys.modules[__name__])
def FlightComputer_(T: Any) -> Any:
    """Samples the state, runs the law, and steps the rotors along their closed form.

    Input ports:
        state (13): q_WB (w, x, y, z), p_WB [m], w_WB_W [rad/s], v_WB_W [m/s].
        reference (8): see `cascade.Reference`.
        guidance (22): see `cascade.Guidance`.
    Output ports, both of them state:
        thrusts (n): mean over the control period since the update [N].
        memory (2 n + 3): speeds of the rotors at its end and commands held in it [rad/s], and
            the acceleration estimate's filtered velocity [m/s].
    Numeric parameter 0: `cascade.Gains`.
    Numeric parameter 1: shares of their thrust that the rotors give (n), all of it to begin with.
    Numeric parameter 2: gates and injections of the loop points (30), see `loop_points`.

    The law knows `vehicle`; `rotors` are those that turn, where they differ from its own.

    With floats the law runs compiled, with AutoDiffXd as plain Python.
    """

    class Impl(LeafSystem_[T]):
        def _construct(
            self,
            *,
            vehicle: Vehicle,
            gains: Gains,
            period: float,
            rotors: Sequence[Rotor] | None = None,
            converter: Any = None,
        ) -> None:
            LeafSystem_[T].__init__(self, converter)
            self.vehicle = vehicle
            self.gains = gains
            self.period = period
            self._n = len(vehicle.rotors)
            self.rotors = rotors
            self._constants = law_constants(vehicle, period, rotors)
            self._body, self._rotors = packed(self._constants)
            self._estimate = sampled_estimate(period)
            self.DeclareNumericParameter(BasicVector_[T]([T(value) for value in gains]))
            self.DeclareNumericParameter(BasicVector_[T]([T(1.0)] * self._n))
            self.DeclareNumericParameter(BasicVector_[T]([T(value) for value in CLOSED]))
            self._state = self.DeclareVectorInputPort("state", 13)
            self._reference = self.DeclareVectorInputPort("reference", len(Reference._fields))
            self._guidance = self.DeclareVectorInputPort("guidance", len(Guidance._fields))
            self.DeclareStateOutputPort("thrusts", self.DeclareDiscreteState(self._n))
            self.DeclareStateOutputPort("memory", self.DeclareDiscreteState(2 * self._n + 3))
            update = self._update_compiled if T is float else self._update
            self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, update)

        def _construct_copy(self, other: Any, converter: Any = None) -> None:
            Impl._construct(
                self,
                vehicle=other.vehicle,
                gains=other.gains,
                period=other.period,
                rotors=other.rotors,
                converter=converter,
            )

        def set_rotors(self, context: Any, speeds: np.ndarray, velocity: np.ndarray) -> None:
            """Let the rotors turn steadily at `speeds` (n) [rad/s], flying at `velocity` [m/s]."""
            constants = np.array(self._constants.motor_constants)
            context.SetDiscreteState(THRUSTS, constants * speeds**2)
            context.SetDiscreteState(MEMORY, np.concatenate([speeds, speeds, velocity]))

        def _update_compiled(self, context: Any, discrete_state: Any) -> None:
            # Drake hands over the new state as a copy of the old one, and the law reads each number
            # before it writes it; asking for the old one besides would take some microseconds.
            memory = discrete_state.get_mutable_value(MEMORY)
            compiled_update(
                self._state.Eval(context),
                self._reference.Eval(context),
                self._guidance.Eval(context),
                context.get_numeric_parameter(GAINS).get_value(),
                context.get_numeric_parameter(SHARES).get_value(),
                self._body,
                self._rotors,
                context.get_numeric_parameter(PROBES).get_value(),
                self._estimate,
                memory,
                discrete_state.get_mutable_value(THRUSTS),
                memory,
            )

        def _update(self, context: Any, discrete_state: Any) -> None:
            thrusts, memory, _ = self.update(context)
            discrete_state.set_value(THRUSTS, thrusts)
            # a command cut to its limit has become a plain number
            memory = [value if isinstance(value, T) else T(value) for value in memory]
            discrete_state.set_value(MEMORY, memory)

        def update(self, context: Any) -> tuple[list[Any], list[Any], list[Any]]:
            """Return thrusts, memory and the signals at the loop points (15) of an update now."""
            thrusts: list[Any] = [0.0] * self._n
            memory: list[Any] = [0.0] * (2 * self._n + 3)
            probes = context.get_numeric_parameter(PROBES).CopyToVector().tolist()
            loops: list[Any] = [*probes, *[0.0] * COUNT]
            control_update(
                self._state.Eval(context).tolist(),
                self._reference.Eval(context).tolist(),
                self._guidance.Eval(context).tolist(),
                context.get_numeric_parameter(GAINS).CopyToVector().tolist(),
                context.get_numeric_parameter(SHARES).CopyToVector().tolist(),
                self._constants,
                loops,
                self._estimate,
                context.get_discrete_state(MEMORY).CopyToVector().tolist(),
                thrusts,
                memory,
            )
            return thrusts, memory, loops[SIGNALS:]

    return Impl


FlightComputer: TypeAlias = Any
"""An instance of `FlightComputer_`; what fills a template has no type of its own."""
