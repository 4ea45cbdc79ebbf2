"""The sampled controller as one LeafSystem, with the law compiled."""

import numpy as np
from pydrake.systems.framework import BasicVector, Context, DiscreteValues, LeafSystem

from workbench.common.compiled import compile_cached
from workbench.control.flight_law import SOURCES, law_constants, packed, packed_update
from workbench.control.guidance import Guidance, Reference
from workbench.control.loop_points import CLOSED
from workbench.control.pd import Gains
from workbench.plant.payload import NO_PAYLOAD, Payload
from workbench.plant.vehicle import Vehicle
from workbench.systems.acceleration_estimate import sampled_estimate

COMMANDS, FILTERED = range(2)
"""Groups of the discrete state."""
GAINS, SHARES, PROBES, PAYLOAD, KNOWN = range(5)
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
    Numeric parameter 3: `Payload`.
    Numeric parameter 4: what the law knows of vehicle and payload, which follows from these, see
    `set_payload`.

    Args:
        vehicle: as the law knows it, without its payload.
        gains: to begin with.
        period: between updates [s].
        payload: to begin with.

    Raises:
        WorkbenchError: if the law cannot hover with the payload that it knows.
    """

    def __init__(
        self, *, vehicle: Vehicle, gains: Gains, period: float, payload: Payload = NO_PAYLOAD
    ) -> None:
        super().__init__()
        n = len(vehicle.rotors)
        self._vehicle = vehicle
        self._estimate = sampled_estimate(period)
        self.DeclareNumericParameter(BasicVector(list(gains)))
        self.DeclareNumericParameter(BasicVector([1.0] * n))
        self.DeclareNumericParameter(BasicVector(list(CLOSED)))
        self.DeclareNumericParameter(BasicVector(list(payload)))
        self.DeclareNumericParameter(BasicVector(self._known(payload)))
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

    def set_payload(self, context: Context, payload: Payload) -> None:
        """Let the law know of a payload from now on.

        Raises:
            WorkbenchError: if it cannot hover with that; nothing is changed then.
        """
        known = self._known(payload)
        context.get_mutable_numeric_parameter(PAYLOAD).SetFromVector(list(payload))
        context.get_mutable_numeric_parameter(KNOWN).SetFromVector(known)

    def _known(self, payload: Payload) -> np.ndarray:
        """Return what the law knows, as `packed_update` takes it."""
        body, rotors = packed(law_constants(self._vehicle, payload))
        return np.concatenate([body, rotors.ravel()])

    def _update(self, context: Context, discrete_state: DiscreteValues) -> None:
        # Drake hands over the new state as a copy of the old one, and the law reads each number
        # before it writes it; asking for the old one besides would take some microseconds.
        compiled_update(
            self._state.Eval(context),
            self._reference.Eval(context),
            self._guidance.Eval(context),
            context.get_numeric_parameter(GAINS).get_value(),
            context.get_numeric_parameter(SHARES).get_value(),
            context.get_numeric_parameter(KNOWN).get_value(),
            context.get_numeric_parameter(PROBES).get_value(),
            self._estimate,
            discrete_state.get_mutable_value(FILTERED),
            discrete_state.get_mutable_value(COMMANDS),
        )
