"""Drag of a body, and a push on it.

With v the velocity of the centre of mass relative to the air, drag is -ρ A |v| v / 2 there, with
the air's density ρ and the body's drag area A.
"""

from collections.abc import Sequence
from typing import Any, TypeAlias

from pydrake.multibody.tree import BodyIndex
from pydrake.systems.framework import (
    BasicVector_,
    Context,
    LeafSystem,
    LeafSystem_,
)

from workbench.common.vectors import Vector3
from workbench.dynamics.air.drag import drag_force
from workbench.dynamics.rigid_body import cross, into_world, rotation
from workbench.systems.cached import cached
from workbench.systems.convertible import convertible
from workbench.systems.spatial_forces import BodyLoads, declare_spatial_forces


@convertible
def BodyForces_(T: type) -> type[LeafSystem]:
    """Drag and push on a body.

    Input ports:
        state (13): of the body: q_WB (w, x, y, z), p_WB [m], w_WB_W [rad/s], v_WB_W [m/s].
        wind (3): velocity of the air in W [m/s]; zero if unconnected.
        push (9): force in W [N], its point in B [m], and torque in B [N·m]; none if unconnected.
    Output port:
        spatial_forces: at the body's origin, for the plant.
    Numeric parameter 0: drag area of the body [m²], density of the air [kg/m³].
    Numeric parameter 1: the centre of mass p_BoBcm_B (3) [m].

    Args:
        T: the scalar type.
        body: index of the body in the plant.
        drag_area: initial one.
        air_density: initial one.
        p_BoBcm_B: initial centre of mass (3) [m].
    """

    class Impl(LeafSystem_[T]):
        def declare(
            self,
            *,
            body: BodyIndex,
            drag_area: float,
            air_density: float,
            p_BoBcm_B: tuple[float, float, float],
        ) -> None:
            self._body = body
            self.DeclareNumericParameter(BasicVector_[T]([T(drag_area), T(air_density)]))
            self.DeclareNumericParameter(BasicVector_[T]([T(value) for value in p_BoBcm_B]))
            self._state = self.DeclareVectorInputPort("state", 13)
            self._wind = self.DeclareVectorInputPort("wind", 3)
            self._push = self.DeclareVectorInputPort("push", 9)
            self._held = cached(
                self._calc_held,
                "what changes at updates only",
                {self.pn_ticket(), self._wind.ticket(), self._push.ticket()},
            )
            needs = {self.pn_ticket(), self.all_input_ports_ticket()}
            declare_spatial_forces(self, T, self._body_loads, needs)

        def _calc_held(
            self, context: Context
        ) -> tuple[float, list[float], Vector3, Sequence[float]]:
            """Return ρ A / 2 [kg/m], p_BoBcm_B [m], the wind in W [m/s], and the push if any."""
            drag_area, air_density = context.get_numeric_parameter(0).CopyToVector().tolist()
            center = context.get_numeric_parameter(1).CopyToVector().tolist()
            blows, pushed = self._wind.HasValue(context), self._push.HasValue(context)
            wind = self._wind.Eval(context).tolist() if blows else (0.0, 0.0, 0.0)
            push = self._push.Eval(context).tolist() if pushed else ()
            return 0.5 * air_density * drag_area, center, wind, push if any(push) else ()

        def _body_loads(self, context: Context) -> BodyLoads:
            half_drag, center, (u_x, u_y, u_z), push = self._held(context)
            state = self._state.Eval(context).tolist()
            R_WB, (v_x, v_y, v_z) = rotation(state[0:4]), state[10:13]
            arm = into_world(R_WB, center)
            t_x, t_y, t_z = cross(state[7:10], arm)
            f_W = drag_force(half_drag, (v_x - u_x + t_x, v_y - u_y + t_y, v_z - u_z + t_z))
            forces = [*cross(arm, f_W), *f_W]
            if push:
                f_W = push[0:3]
                lever = cross(into_world(R_WB, push[3:6]), f_W)
                torque = into_world(R_WB, push[6:9])
                moment = [a + b for a, b in zip(lever, torque, strict=True)]
                forces = [a + b for a, b in zip(forces, [*moment, *f_W], strict=True)]
            return [(self._body, forces)]

    return Impl


BodyForces: TypeAlias = Any
"""An instance of `BodyForces_`; what fills a template has no type of its own."""
