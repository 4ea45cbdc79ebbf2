"""The sampled controller as one LeafSystem, with the law compiled."""

import numpy as np
from pydrake.systems.framework import BasicVector, Context, DiscreteValues, LeafSystem

from workbench.common.compiled import compile_cached
from workbench.control.flight_law import SOURCES, law_constants, packed, packed_update
from workbench.control.guidance import Guidance, Reference
from workbench.control.loop_points import CLOSED
from workbench.control.pd import Gains
from workbench.plant.vehicle import Vehicle
from workbench.systems.acceleration_estimate import sampled_estimate

COMMANDS, FILTERED = range(2)
"""Groups of the discrete state."""
GAINS, SHARES, PROBES = range(3)
"""Numeric parameters."""

compiled_update = compile_cached(packed_update, SOURCES, "the control law", parts=72)


class FlightComputer(LeafSystem):
    """Samples the state, runs the law, and holds the commands of the rotors.

    Input ports:
        state (13): q_WB (w, x, y, z), p_WB [m], w_WB_W [rad/s], v_WB_W [m/s].
        reference (8): see `guidance.Reference`.
        guidance (22): see `guidance.Guidance`.
    Output port, which is state:
        commands (n): of the rotors' speeds [rad/s].
    Numeric parameter 0: `pd.Gains`.
    Numeric parameter 1: shares of their thrust that the rotors give (n), all of it to begin with.
    Numeric parameter 2: gates and injections of the loop points (30), see `loop_points`.

    Args:
        vehicle: as the law knows it.
        gains: to begin with.
        period: between updates [s].
    """

    def __init__(self, *, vehicle: Vehicle, gains: Gains, period: float) -> None:
        super().__init__()
        n = len(vehicle.rotors)
        self._body, self._rotors = packed(law_constants(vehicle))
        self._estimate = sampled_estimate(period)
        self.DeclareNumericParameter(BasicVector(list(gains)))
        self.DeclareNumericParameter(BasicVector([1.0] * n))
        self.DeclareNumericParameter(BasicVector(list(CLOSED)))
        self._state = self.DeclareVectorInputPort("state", 13)
        self._reference = self.DeclareVectorInputPort("reference", len(Reference._fields))
        self._guidance = self.DeclareVectorInputPort("guidance", len(Guidance._fields))
        self.DeclareStateOutputPort("commands", self.DeclareDiscreteState(n))
        self.DeclareDiscreteState(3)
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._update)

    def begin(self, context: Context, speeds: np.ndarray, velocity: np.ndarray) -> None:
        """Begin with rotors that turn steadily at `speeds` (n) [rad/s], at `velocity` [m/s]."""
        context.SetDiscreteState(COMMANDS, speeds)
        context.SetDiscreteState(FILTERED, velocity)

    def _update(self, context: Context, discrete_state: DiscreteValues) -> None:
        # Drake hands over the new state as a copy of the old one, and the law reads each number
        # before it writes it; asking for the old one besides would take some microseconds.
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
            discrete_state.get_mutable_value(FILTERED),
            discrete_state.get_mutable_value(COMMANDS),
        )
