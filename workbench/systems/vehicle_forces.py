"""Rotors and drag as a continuous LeafSystem, for linear models and to check the steps."""

import sys
from typing import Any, TypeAlias

from pydrake.autodiffutils import AutoDiffXd
from pydrake.systems.framework import BasicVector_, LeafSystem_
from pydrake.systems.scalar_conversion import TemplateSystem

from workbench.dynamics.rigid_body import rotation
from workbench.dynamics.rotor_response import speed_slope
from workbench.dynamics.vehicle_step import (
    LAG,
    ROW,
    rotor_rows,
    rotor_thrusts,
    supplied,
    vehicle_wrench,
    voltage_share,
)
from workbench.plant.description import Description


# A template is filled where it is first used: Drake looks through the stack for whose it is, which
# takes a tenth of a second each time within nested imports. Hence `scope`, too.
@TemplateSystem.define("VehicleForces_", [float, AutoDiffXd], scope=sys.modules[__name__])
def VehicleForces_(T: Any) -> Any:
    """The forces of `VehicleDynamics` for a continuous plant; its state is the rotor speeds.

    Input ports:
        state (13): q_WB (w, x, y, z), p_WB [m], w_WB_W [rad/s], v_WB_W [m/s].
        commands (n): rotor speeds [rad/s], within their limits.
        wind (3): velocity of the air in W [m/s]; zero if unconnected.
    Output ports:
        forces (6): moment about the origin [N·m] and force [N] in W, for the plant's port
            `applied_generalized_force`.
        thrusts (n) [N] and speeds (n) [rad/s].
    Numeric parameter 0: drag area of the body [m²], density of the air [kg/m³], the voltage drop
    per power of a full battery, see `vehicle_step.loaded`, and the share of it that commands
    compensate, see `vehicle_step.supplied`.
    """

    class Impl(LeafSystem_[T]):
        def _construct(
            self,
            *,
            description: Description,
            p_BoBcm_B: tuple[float, float, float],
            drag_area: float,
            air_density: float,
            voltage_drop: float = 0.0,
            sag_compensation: float = 0.0,
            converter: Any = None,
        ) -> None:
            LeafSystem_[T].__init__(self, converter)
            live = (drag_area, air_density, voltage_drop, sag_compensation)
            self._given = (description, p_BoBcm_B, *live)
            self._p_BoBcm_B = p_BoBcm_B
            self._rows = rotor_rows(description.rotors, 0.0).tolist()
            n = len(self._rows)
            self.DeclareNumericParameter(BasicVector_[T]([T(value) for value in live]))
            self._state = self.DeclareVectorInputPort("state", 13)
            self._commands = self.DeclareVectorInputPort("commands", n)
            self._wind = self.DeclareVectorInputPort("wind", 3)
            self.DeclareContinuousState(n)
            needs = {self.all_input_ports_ticket(), self.all_parameters_ticket(), self.xc_ticket()}
            self.DeclareVectorOutputPort("forces", 6, self._calc_forces, needs)
            self.DeclareVectorOutputPort("thrusts", n, self._calc_thrusts, needs)
            self.DeclareVectorOutputPort("speeds", n, self._calc_speeds, {self.xc_ticket()})

        def _construct_copy(self, other: Any, converter: Any = None) -> None:
            description, p_BoBcm_B, area, density, drop, compensation = other._given
            Impl._construct(
                self,
                description=description,
                p_BoBcm_B=p_BoBcm_B,
                drag_area=area,
                air_density=density,
                voltage_drop=drop,
                sag_compensation=compensation,
                converter=converter,
            )

        def DoCalcTimeDerivatives(self, context: Any, derivatives: Any) -> None:
            derivatives.get_mutable_vector().SetFromVector(self._slopes(context))

        def _speeds(self, context: Any) -> list[Any]:
            return context.get_continuous_state_vector().CopyToVector().tolist()

        def _slopes(self, context: Any) -> list[Any]:
            """Return the slopes of the rotors' speeds (n) [rad/s²]."""
            commands, speeds = self._commands.Eval(context).tolist(), self._speeds(context)
            _, _, drop, share = context.get_numeric_parameter(0).CopyToVector().tolist()
            supply = (1.0, drop, share, 1.0)
            voltage = voltage_share(speeds, [1.0] * len(speeds), supply, self._rows)
            turning = zip(commands, speeds, self._rows, strict=True)
            return [
                speed_slope(supplied(u, row[LAG], voltage, voltage, share), w, row[LAG:ROW])
                for u, w, row in turning
            ]

        def _calc_forces(self, context: Any, output: Any) -> None:
            state, wind = self._state.Eval(context).tolist(), self._wind_W(context)
            area, density, *_ = context.get_numeric_parameter(0).CopyToVector().tolist()
            R_WB = rotation(state[0:4])
            speeds = self._speeds(context)
            f_x, f_y, f_z, m_x, m_y, m_z = vehicle_wrench(
                R_WB,
                state[7:10],
                state[10:13],
                state[6],
                speeds,
                self._slopes(context),
                [1.0] * len(speeds),
                wind,
                0.5 * density * area,
                self._p_BoBcm_B,
                self._rows,
            )
            rows = R_WB[0:3], R_WB[3:6], R_WB[6:9]
            moment = [a * m_x + b * m_y + c * m_z for a, b, c in rows]
            output.SetFromVector(moment + [a * f_x + b * f_y + c * f_z for a, b, c in rows])

        def _wind_W(self, context: Any) -> list[Any]:
            return self._wind.Eval(context).tolist() if self._wind.HasValue(context) else [0.0] * 3

        def _calc_thrusts(self, context: Any, output: Any) -> None:
            state, wind = self._state.Eval(context).tolist(), self._wind_W(context)
            speeds = self._speeds(context)
            whole = [1.0] * len(speeds)
            output.SetFromVector(rotor_thrusts(state, speeds, whole, wind, self._rows))

        def _calc_speeds(self, context: Any, output: Any) -> None:
            output.SetFromVector(self._speeds(context))

    return Impl


VehicleForces: TypeAlias = Any
"""An instance of `VehicleForces_`; what fills a template has no type of its own."""
