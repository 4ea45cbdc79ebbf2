"""The air at the vehicle: steady wind, gust, and turbulence of MIL-F-8785C, see `dynamics.air`."""

from collections.abc import Sequence

import numpy as np
from pydrake.systems.framework import BasicVector, Context, DiscreteValues

from workbench.dynamics.air.normals import drawn_normals
from workbench.dynamics.air.settings import WIND_FIELDS, AirSettings
from workbench.dynamics.air.update import (
    EDDIES_STARTED_INDEX,
    EDDY_MEMORY_SIZE,
    steady_wind,
    turbulent_wind,
)
from workbench.systems.discrete_system import DiscreteSystem
from workbench.systems.noise import noise_seed


class Wind(DiscreteSystem):
    """The velocity of the air at the vehicle, held over a control period.

    A gust is that of the middle of the period.

    Input port:
        state (13): of the body: q_WB (w, x, y, z), p_WB [m], w_WB_W [rad/s], v_WB_W [m/s].
    Output port, which is state:
        wind (3): in W [m/s].
    Discrete state: the filters of the turbulence (6), see `air.update`, and the wind (3).
    Numeric parameter 0: `WIND_FIELDS` of the settings.
    Numeric parameter 1: the seed of the turbulence.

    Args:
        settings: initial ones.
        period: of control [s].
    """

    def __init__(self, *, settings: AirSettings, period: float) -> None:
        super().__init__()
        self._period = period
        self._settings_index = self.DeclareNumericParameter(
            BasicVector(list(settings[: len(WIND_FIELDS)]))
        )
        self._seed = self.DeclareNumericParameter(BasicVector([0.0]))
        self._state = self.DeclareVectorInputPort("state", 13)
        self._filters = self.DeclareDiscreteState(EDDY_MEMORY_SIZE)
        self._wind = self.DeclareDiscreteState(3)
        self.DeclareStateOutputPort("wind", self._wind)
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._update)

    def set_seed(self, context: Context, seed: int) -> None:
        """Set the seed of the turbulence; equal seeds give equal air."""
        context.get_mutable_numeric_parameter(self._seed).SetAtIndex(
            0, float(noise_seed(seed, "air"))
        )

    def begin(self, context: Context) -> None:
        """Begin with wind and gust of now; turbulence starts with the first update."""
        context.SetDiscreteState(self._wind, self._steady(context, self._settings(context)))

    def _settings(self, context: Context) -> AirSettings:
        return AirSettings(*context.get_numeric_parameter(self._settings_index).value().tolist())

    def _steady(self, context: Context, settings: AirSettings) -> tuple[float, float, float]:
        """Return the velocity of mean wind and gust (3)."""
        return steady_wind(settings, context.get_time() + 0.5 * self._period)

    def _update(self, context: Context, discrete_state: DiscreteValues) -> None:
        settings = self._settings(context)
        wind: Sequence[float] = self._steady(context, settings)
        if settings.turbulence > 0.0:
            eddies = self._turbulence(context, discrete_state, settings)
            wind = [steady + eddy for steady, eddy in zip(wind, eddies, strict=True)]
        elif discrete_state.value(self._filters)[EDDIES_STARTED_INDEX]:
            # turbulence that starts later draws stationary states
            discrete_state.set_value(self._filters, np.zeros(EDDY_MEMORY_SIZE))
        discrete_state.set_value(self._wind, wind)

    def _turbulence(
        self, context: Context, discrete_state: DiscreteValues, settings: AirSettings
    ) -> tuple[float, float, float]:
        """Return the velocity of the turbulence in W, and step its filters."""
        number = round(context.get_time() / self._period)
        with np.errstate(over="ignore"):  # integers of the noise wrap around
            noise = drawn_normals(context.get_numeric_parameter(self._seed)[0], number)
        state = self._state.Eval(context).tolist()
        before = context.get_discrete_state(self._filters).value().tolist()
        after = [0.0] * EDDY_MEMORY_SIZE
        wind = turbulent_wind(settings, state, noise, before, self._period, after)
        discrete_state.set_value(self._filters, after)
        return wind
