"""Drag of a body, and a push on it.

With v the velocity of the centre of mass relative to the air, drag is -ρ A |v| v / 2 there, with
the air's density ρ and the body's drag area A. A push is a force in W at a point of the body, and a
torque in B, for a time. Its impulse is exact: in the control period in which it begins or ends it
acts with the share of the period that it lasts.
"""

import sys
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from pydrake.autodiffutils import AutoDiffXd
from pydrake.common.value import Value
from pydrake.multibody.math import SpatialForce_
from pydrake.multibody.plant import ExternallyAppliedSpatialForce_
from pydrake.multibody.tree import BodyIndex
from pydrake.systems.framework import BasicVector_, LeafSystem_
from pydrake.systems.scalar_conversion import TemplateSystem

from workbench.plant.drag import AIR_DENSITY
from workbench.systems.rotors import rotation
from workbench.systems.weak_callback import weakly

STILL = 1e-12
"""Added to squared speeds, so that their roots have derivatives in still air [m²/s²]."""


class BodyForceSettings(NamedTuple):
    """Live parameters of push and drag; see `workbench params`."""

    push_x: float = 0.0
    push_y: float = 0.0
    push_z: float = 0.0
    push_at_x: float = 0.0
    push_at_y: float = 0.0
    push_at_z: float = 0.0
    push_torque_x: float = 0.0
    push_torque_y: float = 0.0
    push_torque_z: float = 0.0
    push_start: float = 0.0
    push_duration: float = 0.1
    drag_area: float = 0.0
    air_density: float = AIR_DENSITY


# See `rotors` for `scope`.
@TemplateSystem.define("BodyForces_", [float, AutoDiffXd], scope=sys.modules[__name__])
def BodyForces_(T: Any) -> Any:
    """Drag and push; the discrete state (1) is the share of this period in which the push acts.

    Input ports:
        state (13): of the body: q_WB (w, x, y, z), p_WB [m], w_WB_W [rad/s], v_WB_W [m/s].
        wind (3): velocity of the air in W [m/s]; zero if unconnected.
    Output port:
        spatial_forces: at the body's origin, for the plant.
    Numeric parameter 0: `BodyForceSettings`.
    Numeric parameter 1: the centre of mass p_BoBcm_B (3) [m].

    Args:
        body: index of the body in the plant.
        settings: initial ones.
        p_BoBcm_B: initial centre of mass (3) [m].
        period: of control [s].
    """

    Force, SpatialForce = ExternallyAppliedSpatialForce_[T], SpatialForce_[T]

    class Impl(LeafSystem_[T]):
        def _construct(
            self,
            *,
            body: BodyIndex,
            settings: BodyForceSettings,
            p_BoBcm_B: tuple[float, float, float],
            period: float,
            converter: Any = None,
        ) -> None:
            LeafSystem_[T].__init__(self, converter)
            self._given = (body, settings, p_BoBcm_B, period)
            self._body, self._period = body, period
            self.DeclareNumericParameter(BasicVector_[T]([T(value) for value in settings]))
            self.DeclareNumericParameter(BasicVector_[T]([T(value) for value in p_BoBcm_B]))
            self._state = self.DeclareVectorInputPort("state", 13)
            self._wind = self.DeclareVectorInputPort("wind", 3)
            self.DeclareDiscreteState(1)
            self.DeclareAbstractOutputPort(
                "spatial_forces",
                lambda: Value[list[Force]]([Force()]),
                weakly(self._calc_spatial_forces),
                {self.xd_ticket(), self.pn_ticket(), self._state.ticket(), self._wind.ticket()},
            )
            self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._update)

        def _construct_copy(self, other: Any, converter: Any = None) -> None:
            body, settings, center, period = other._given
            Impl._construct(
                self,
                body=body,
                settings=settings,
                p_BoBcm_B=center,
                period=period,
                converter=converter,
            )

        def _update(self, context: Any, discrete_state: Any) -> None:
            settings = BodyForceSettings(*context.get_numeric_parameter(0).CopyToVector())
            begin = context.get_time()
            first = max(begin, settings.push_start)
            last = min(begin + self._period, settings.push_start + settings.push_duration)
            discrete_state.set_value([max(0.0, last - first) / self._period])

        def _calc_spatial_forces(self, context: Any, output: Any) -> None:
            *_, drag_area, air_density = context.get_numeric_parameter(0).CopyToVector()
            state, p_BoBcm_B = self._state.Eval(context), context.get_numeric_parameter(1).value()
            R_WB = rotation(state)
            v_W = state[10:13]
            if self._wind.HasValue(context):
                v_W = v_W - self._wind.Eval(context)
            arm = R_WB @ p_BoBcm_B
            v_W = v_W + cross(state[7:10], arm)
            speed = (v_W @ v_W + STILL) ** 0.5
            force = (-0.5 * air_density * drag_area * speed) * v_W
            moment = cross(arm, force)
            share = context.get_discrete_state(0).value()[0]
            if share != 0.0:
                push = share * context.get_numeric_parameter(0).CopyToVector()[:9]
                point = context.get_numeric_parameter(0).CopyToVector()[3:6]
                moment = moment + cross(R_WB @ point, push[0:3]) + R_WB @ push[6:9]
                force = force + push[0:3]
            found = Force()
            found.body_index = self._body
            found.F_Bq_W = SpatialForce(moment, force)
            output.set_value([found])

    return Impl


BodyForces: TypeAlias = Any
"""An instance of `BodyForces_`; what fills a template has no type of its own."""


def cross(a: Any, b: Any) -> Any:
    """Return the cross product of two vectors (3), in a tenth of the time of np.cross."""
    return np.array(
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    )
