"""The air at the vehicle: steady wind, gust, and turbulence of MIL-F-8785C, see `dynamics.air`."""

from typing import NamedTuple

import numpy as np
from pydrake.systems.framework import BasicVector, Context, DiscreteValues, LeafSystem

from workbench.dynamics.air.normals import COUNT, draw_normals
from workbench.dynamics.air.update import BEGUN, EDDIES, gust_share, step_filters, velocities
from workbench.systems.noise import noise_seed


class WindSettings(NamedTuple):
    """Live parameters of wind, turbulence and gust; see `workbench params`."""

    wind_x: float = 0.0
    wind_y: float = 0.0
    wind_z: float = 0.0
    turbulence: float = 0.0
    gust_x: float = 0.0
    gust_y: float = 0.0
    gust_z: float = 0.0
    gust_start: float = 0.0
    gust_duration: float = 1.0


class Wind(LeafSystem):
    """The velocity of the air at the vehicle.

    Turbulence has its axes along the mean wind's level part, left of it and up; without one it is
    that of a wind along x. It is held over a control period. The drone's airspeed, which says how
    fast it meets the eddies, is its speed relative to the mean wind.

    Input port:
        state (13): of the body: q_WB (w, x, y, z), p_WB [m], w_WB_W [rad/s], v_WB_W [m/s].
    Output port:
        wind (3): in W [m/s].
    Discrete state: the filters of the turbulence (6), see `air.update`, and its velocity in W (3).
    Numeric parameter 0: `WindSettings`.
    Numeric parameter 1: the seed of the turbulence.

    Args:
        settings: initial ones.
        period: of control [s].
    """

    def __init__(self, *, settings: WindSettings, period: float) -> None:
        super().__init__()
        self._period = period
        self._settings_index = self.DeclareNumericParameter(BasicVector(list(settings)))
        self._seed = self.DeclareNumericParameter(BasicVector([0.0]))
        self._state = self.DeclareVectorInputPort("state", 13)
        self._filters = self.DeclareDiscreteState(EDDIES)
        self._turbulence = self.DeclareDiscreteState(3)
        needs = {self.time_ticket(), self.xd_ticket(), self.pn_ticket()}
        self.DeclareVectorOutputPort("wind", 3, self._calc_wind, needs)
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._update)

    def set_seed(self, context: Context, seed: int) -> None:
        """Set the seed of the turbulence; equal seeds give equal air."""
        context.get_mutable_numeric_parameter(self._seed).SetAtIndex(
            0, float(noise_seed(seed, "air"))
        )

    def _settings(self, context: Context) -> WindSettings:
        return WindSettings(*context.get_numeric_parameter(self._settings_index).value().tolist())

    def _update(self, context: Context, discrete_state: DiscreteValues) -> None:
        settings = self._settings(context)
        if settings.turbulence == 0.0:  # turbulence that starts later draws stationary states
            if discrete_state.value(self._filters)[BEGUN]:
                discrete_state.set_value(self._filters, np.zeros(EDDIES))
                discrete_state.set_value(self._turbulence, np.zeros(3))
            return
        state = self._state.Eval(context)
        height, speed = state[6], np.linalg.norm(state[10:13] - settings[0:3])
        before = context.get_discrete_state(self._filters).CopyToVector()
        noise, after = np.empty(COUNT), np.empty(EDDIES)
        number = round(context.get_time() / self._period)
        with np.errstate(over="ignore"):  # integers of the noise wrap around
            draw_normals(context.get_numeric_parameter(self._seed)[0], number, noise)
        passed = self._period if before[BEGUN] > 0.0 else np.inf
        step_filters(before[:BEGUN], noise, height, speed, passed, after[:BEGUN])
        after[BEGUN] = 1.0
        u, v, w = velocities(after[:BEGUN], height, settings.turbulence)
        heading = np.arctan2(settings.wind_y, settings.wind_x)
        c, s = np.cos(heading), np.sin(heading)
        discrete_state.set_value(self._filters, after)
        discrete_state.set_value(self._turbulence, [c * u - s * v, s * u + c * v, w])

    def _calc_wind(self, context: Context, output: BasicVector) -> None:
        settings = self._settings(context)
        share = gust_share(context.get_time(), settings.gust_start, settings.gust_duration)
        turbulence = context.get_discrete_state(self._turbulence).value().tolist()
        output.SetFromVector(
            [
                mean + share * gust + eddy
                for mean, gust, eddy in zip(settings[0:3], settings[4:7], turbulence, strict=True)
            ]
        )
