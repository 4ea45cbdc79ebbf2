"""The flight mode as a LeafSystem: a slow, sampled state machine beside the fast controller."""

from pydrake.systems.framework import BasicVector, Context, DiscreteValues

from workbench.common.vectors import float_triple
from workbench.control.flight_mode import (
    EstimateHealth,
    FlightModeInputs,
    FlightModeSettings,
    ModeState,
    guidance,
    next_state,
    with_walls,
)
from workbench.control.guidance import Guidance, Reference
from workbench.control.mode import FlightMode
from workbench.control.obstacle_brake import MAX_WALLS
from workbench.systems.discrete_system import DiscreteSystem


class ModeManager(DiscreteSystem):
    """Runs `flight_mode` once a period; its outputs are state, so reading them is free.

    Input ports:
        state (13): of the plant.
        reference (8): see `guidance.Reference`.
        request (3): request (`mode.ModeRequest`), its serial number, take-off height [m].
        charge (1): of the battery, 0 .. 1.
        known_charge (1): the estimated charge, by which the drone lands; unconnected, the true one.
        walls (12): see `nearest_obstacle`; unconnected, nothing limits the speed.
        health (4): see `flight_mode.EstimateHealth`; unconnected, the state is the true one.
        ended (1): whether the program that runs the law has ended; unconnected, there is none.
        contact_forces (3 k): on the bodies of the drone in W [N]; unconnected, it touches nothing.
    Output ports:
        guidance (22): see `guidance.Guidance`.
        mode (10): see `flight_mode.ModeState`.
    Numeric parameter 0: `flight_mode.FlightModeSettings`.
    """

    def __init__(
        self,
        *,
        period: float,
        settings: FlightModeSettings,
        standing_height: float,
        wall_period: float | None = None,
        bodies: int = 1,
    ) -> None:
        """Declare ports, state and updates.

        Args:
            period: between updates of the mode [s].
            settings: initial ones.
            standing_height: of the base link's origin on the ground [m].
            wall_period: between updates of the walls, which are more urgent than the mode [s]; None
                without walls.
            bodies: number of bodies whose contact forces the port gets.
        """
        super().__init__()
        self._standing_height = standing_height
        self.DeclareNumericParameter(BasicVector(list(settings)))
        self._state = self.DeclareVectorInputPort("state", 13)
        self._reference = self.DeclareVectorInputPort("reference", len(Reference._fields))
        self._request = self.DeclareVectorInputPort("request", 3)
        self._charge = self.DeclareVectorInputPort("charge", 1)
        self._known_charge = self.DeclareVectorInputPort("known_charge", 1)
        self._walls = self.DeclareVectorInputPort("walls", 4 * MAX_WALLS)
        self._health = self.DeclareVectorInputPort("health", len(EstimateHealth._fields))
        self._ended = self.DeclareVectorInputPort("ended", 1)
        self._contact_forces = self.DeclareVectorInputPort("contact_forces", 3 * bodies)
        self.guidance_index = self.DeclareDiscreteState(len(Guidance._fields))
        self.mode_index = self.DeclareDiscreteState(len(ModeState._fields))
        self.DeclareStateOutputPort("guidance", self.guidance_index)
        self.DeclareStateOutputPort("mode", self.mode_index)
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._update)
        if wall_period is not None:
            self.DeclarePeriodicDiscreteUpdateEvent(wall_period, 0.0, self._update_walls)

    def set_mode(self, context: Context, state: ModeState, p_WB: list[float]) -> None:
        """Put a mode state, and the guidance that follows from it, into a Context."""
        settings = _settings(context)
        context.SetDiscreteState(self.mode_index, list(state))
        context.SetDiscreteState(self.guidance_index, list(guidance(state, p_WB, settings)))

    def _update(self, context: Context, discrete_state: DiscreteValues) -> None:
        settings = _settings(context)
        state = ModeState(*context.get_discrete_state(self.mode_index).CopyToVector().tolist())
        plant_state = self._state.Eval(context).tolist()
        request, serial, height = self._request.Eval(context).tolist()
        now = FlightModeInputs(
            time=context.get_time(),
            p_WB=plant_state[4:7],
            v_WB=plant_state[10:13],
            reference=Reference(*self._reference.Eval(context).tolist()),
            request=int(request),
            serial=serial,
            height=height,
            charge=float(self._charge.Eval(context)[0]),
            standing_height=self._standing_height,
            health=(
                EstimateHealth(*self._health.Eval(context).tolist())
                if self._health.HasValue(context)
                else None
            ),
            known_charge=(
                float(self._known_charge.Eval(context)[0])
                if self._known_charge.HasValue(context)
                else None
            ),
            ended=self._ended.HasValue(context) and bool(self._ended.Eval(context)[0]),
            contact_force=(
                float_triple(self._contact_forces.Eval(context).reshape(-1, 3).sum(axis=0))
                if self._contact_forces.HasValue(context)
                else (0.0, 0.0, 0.0)
            ),
        )
        state = next_state(state, now, settings)
        guide = guidance(state, now.p_WB, settings)
        if self._walls.HasValue(context):
            walls = self._walls.Eval(context).tolist()
            mode = FlightMode(int(state.mode))
            guide = with_walls(guide, walls, now.p_WB, mode, settings)
        discrete_state.set_value(self.mode_index, list(state))
        discrete_state.set_value(self.guidance_index, list(guide))

    def _update_walls(self, context: Context, discrete_state: DiscreteValues) -> None:
        """Update the walls of the guidance; a mode update at the same time has already done it."""
        settings = _settings(context)
        mode, *_ = discrete_state.get_vector(self.mode_index).CopyToVector().tolist()
        guide = Guidance(*discrete_state.get_vector(self.guidance_index).CopyToVector().tolist())
        walls = self._walls.Eval(context).tolist()
        p_WB = self._state.Eval(context)[4:7].tolist()
        guide = with_walls(guide, walls, p_WB, FlightMode(int(mode)), settings)
        discrete_state.set_value(self.guidance_index, list(guide))


def _settings(context: Context) -> FlightModeSettings:
    return FlightModeSettings(*context.get_numeric_parameter(0).CopyToVector().tolist())
