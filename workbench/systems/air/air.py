"""The air around a flying drone as one sampled LeafSystem."""

import numpy as np
from pydrake.systems.framework import (
    BasicVector,
    Context,
    DiagramBuilder,
    DiscreteValues,
    InputPort,
    LeafSystem,
    OutputPort,
)

from workbench.plant.vehicle import Vehicle
from workbench.systems.air.drag import rotor_rows
from workbench.systems.air.settings import AirSettings
from workbench.systems.air.update import EDDIES, seeded_update
from workbench.systems.compiled import compile_cached
from workbench.systems.noise import noise_seed

SOURCES = ("air/drag.py", "air/normals.py", "air/turbulence.py", "air/update.py")
"""The files that the compiled update stands in."""

compiled_update = compile_cached(seeded_update, SOURCES, "the air", parts=25)


class Air(LeafSystem):
    """Wind, gust, turbulence, drag of body and rotors, and a push, at the control rate.

    It is one system with one update event, compiled, for the reason that `FlightComputer` is.

    Input ports:
        state (13): q_WB (w, x, y, z), p_WB [m], w_WB_W [rad/s], v_WB_W [m/s].
        speeds (m): whose first n are the rotors' speeds [rad/s].
    Output ports, both of them state:
        wrench (6): force [N] and moment about the body's origin [N·m], in B.
        wind (3): velocity of the air at the drone, in W [m/s].
    Numeric parameter 0: `AirSettings`; 1: seed of the turbulence, see `set_seed`.

    Args:
        vehicle: in the air.
        settings: to begin with.
        period: between updates [s].
        speeds: size m of the speeds port.
    """

    def __init__(
        self, *, vehicle: Vehicle, settings: AirSettings, period: float, speeds: int
    ) -> None:
        super().__init__()
        self._period = period
        self._p_BoBcm_B = np.array(vehicle.p_BoBcm_B, dtype=float)
        self._rotors = rotor_rows(vehicle.rotors)
        self.DeclareNumericParameter(BasicVector(list(settings)))
        self.DeclareNumericParameter(BasicVector([0.0]))
        self._state = self.DeclareVectorInputPort("state", 13)
        self._speeds = self.DeclareVectorInputPort("speeds", speeds)
        self._wrench_index = self.DeclareDiscreteState(6)
        self._wind_index = self.DeclareDiscreteState(3)
        self._eddies_index = self.DeclareDiscreteState(EDDIES)
        self.DeclareStateOutputPort("wrench", self._wrench_index)
        self.DeclareStateOutputPort("wind", self._wind_index)
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._update)

    def set_seed(self, context: Context, seed: int) -> None:
        """Let the turbulence be that of a flight's seed; equal seeds make equal turbulence."""
        own = float(noise_seed(seed, self.get_name()))
        context.get_mutable_numeric_parameter(1).SetAtIndex(0, own)

    def _update(self, context: Context, discrete_state: DiscreteValues) -> None:
        compiled_update(
            context.get_time(),
            context.get_numeric_parameter(1).get_value(),
            self._state.Eval(context),
            self._speeds.Eval(context),
            context.get_numeric_parameter(0).get_value(),
            self._p_BoBcm_B,
            self._rotors,
            self._period,
            context.get_discrete_state(self._eddies_index).get_value(),
            discrete_state.get_mutable_value(self._wrench_index),
            discrete_state.get_mutable_value(self._wind_index),
            discrete_state.get_mutable_value(self._eddies_index),
        )


def add_air(
    builder: DiagramBuilder,
    state: OutputPort,
    speeds: OutputPort,
    wrench: InputPort,
    vehicle: Vehicle,
    settings: AirSettings,
    period: float,
) -> Air:
    """Add the air between a plant's ports; see `Air`."""
    air = builder.AddNamedSystem(
        "air", Air(vehicle=vehicle, settings=settings, period=period, speeds=speeds.size())
    )
    builder.Connect(state, air.GetInputPort("state"))
    builder.Connect(speeds, air.GetInputPort("speeds"))
    builder.Connect(air.GetOutputPort("wrench"), wrench)
    return air
