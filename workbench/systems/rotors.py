"""Rotors on a body: their lag, and the forces and moments with which they act on it.

A rotor at p_BR with the unit axis n has the speed w and the moment of inertia J about n; d is +1 if
it turns counter-clockwise. With its static thrust T = motor_constant w² + linear_motor_constant w
it acts on the body with

    thrust             (T (1 + g) - inflow_coefficient w u) n        at p_BR
    drag               -|w| rotor_drag_coefficient v                 at p_BR
    drag torque        -d moment_constant T n
    rolling moment     -|w| rolling_moment_coefficient v
    spin-up torque     -d J (dw/dt) n
    gyroscopic moment  -w_WB x d J w n

where u is the hub's air velocity along n, and v that across it. Sources: Mahony, Kumar and Corke,
"Multirotor Aerial Vehicles", IEEE Robotics & Automation Magazine, 2012, equations 4 to 8; Martin
and Salaun, "The True Role of Accelerometer Feedback in Quadrotor Control", ICRA 2010; for inflow
Forster, "System Identification of the Crazyflie 2.0 Nano Quadrocopter", ETH Zurich, 2015.

Ground effect: g = c (r / 4h)² at the height h of the hub above the ground, if n points upwards; at
most 4/15 (Cheeseman and Bennett, ARC R&M 3021, 1955, and gym-pybullet-drones).

Lag: the speed approaches the command u with dw/dt = e s / up + e (1 - s) / down, e = u - w. The
share s goes from 0 to 1 within some BLEND of e = 0, where a linear model of hover needs one rate:
s = (1 + (e² / (e² + BLEND²))^(3/2) sign e) / 2.

Battery: a rotor with the command u goes to s u, where s is the voltage under load over that of the
full battery without load, as speed controllers set a share of the voltage (ArduPilot's
SIM_Motor.cpp); a compensation of c divides the command by 1 + c (s - 1), as Betaflight's
vbat_sag_compensation does.
"""

import sys
from collections.abc import Sequence
from typing import Any, TypeAlias

import numpy as np
from pydrake.autodiffutils import AutoDiffXd
from pydrake.common.value import Value
from pydrake.multibody.math import SpatialForce_
from pydrake.multibody.plant import ExternallyAppliedSpatialForce_
from pydrake.multibody.tree import BodyIndex
from pydrake.systems.framework import BasicVector_, LeafSystem_
from pydrake.systems.scalar_conversion import TemplateSystem

from workbench.dynamics.rigid_body import cross, into_body, into_world, rotation
from workbench.dynamics.rotors import (
    compensated_share,
    hub_velocity,
    loaded_voltage,
    moving_thrust,
    power_share,
    rotor_load,
    speed_slope,
    static_thrusts,
    turning_share,
    within,
)
from workbench.plant.rotors import Rotor
from workbench.systems.cached import cached
from workbench.systems.weak_callback import weakly


# A template is filled where it is first used: Drake looks through the stack for whose it is, which
# takes a tenth of a second each time within nested imports. Hence `scope`, too.
@TemplateSystem.define("Rotors_", [float, AutoDiffXd], scope=sys.modules[__name__])
def Rotors_(T: Any) -> Any:
    """The rotors of a body; their continuous state is their speeds (n) [rad/s].

    Input ports:
        commands (n): rotor speeds [rad/s], clipped to the rotors' range.
        state (13): of the body: q_WB (w, x, y, z), p_WB [m], w_WB_W [rad/s], v_WB_W [m/s].
        wind (3): velocity of the air in W [m/s]; zero if unconnected.
        supply (4): of the battery: its voltage without load, the drop of that per power, the share
            of sag that is compensated, and the voltage without load that the compensation assumes;
            voltages are over that of the full battery [1, N^-3/2]. A full battery if unconnected.
    Output ports:
        spatial_forces: of all rotors on the body, at its origin, for the plant.
        speeds (n) [rad/s].
        thrusts (n) [N].
        static_thrusts (n): at rest far from the ground; drag torque and power follow from them.
        voltage (1): of the battery under load over that of the full one without load.
    Numeric parameter 0: share of its thrust that each rotor gives (n), initially 1. A rotor with
    the share 0 does not turn up any more, and has its full thrust while it runs down.

    Args:
        T: the scalar type.
        rotors: in the order of the commands.
        body: index of the body in the plant.
    """
    Force, SpatialForce = ExternallyAppliedSpatialForce_[T], SpatialForce_[T]
    origin = np.array([T(0.0)] * 3)

    class Impl(LeafSystem_[T]):
        def _construct(
            self, *, rotors: Sequence[Rotor], body: BodyIndex, converter: Any = None
        ) -> None:
            LeafSystem_[T].__init__(self, converter)
            self._rotors, self._body = rotors, body
            n = len(rotors)
            self.DeclareNumericParameter(BasicVector_[T]([T(1.0)] * n))
            self._commands = self.DeclareVectorInputPort("commands", n)
            self._state = self.DeclareVectorInputPort("state", 13)
            self._wind = self.DeclareVectorInputPort("wind", 3)
            self._supply = self.DeclareVectorInputPort("supply", 4)
            self.DeclareContinuousState(n)
            own = {self.xc_ticket(), self.pn_ticket()}
            self._held = cached(
                self._calc_held,
                "what changes at updates only",
                {self.pn_ticket(), self._commands.ticket(), self._supply.ticket()},
            )
            self._turning = cached(
                self._calc_turning,
                "speeds, their derivatives, shares of the thrust, and static thrusts",
                own | {self._commands.ticket(), self._supply.ticket()},
            )
            moving = own | {self._state.ticket(), self._wind.ticket()}
            self.DeclareAbstractOutputPort(
                "spatial_forces",
                lambda: Value[list[Force]]([Force()]),
                weakly(self._calc_spatial_forces),
                moving | {self._commands.ticket(), self._supply.ticket()},
            )
            self.DeclareVectorOutputPort("speeds", n, self._calc_speeds, {self.xc_ticket()})
            self.DeclareVectorOutputPort("thrusts", n, self._calc_thrusts, moving)
            self.DeclareVectorOutputPort("static_thrusts", n, self._calc_static_thrusts, own)
            self.DeclareVectorOutputPort(
                "voltage", 1, self._calc_voltage, own | {self._supply.ticket()}
            )

        def _construct_copy(self, other: Any, converter: Any = None) -> None:
            Impl._construct(self, rotors=other._rotors, body=other._body, converter=converter)

        def DoCalcTimeDerivatives(self, context: Any, derivatives: Any) -> None:
            _, slopes, _, _ = self._turning(context)
            derivatives.get_mutable_vector().SetFromVector(np.array(slopes))

        def _speeds(self, context: Any) -> list[Any]:
            return context.get_continuous_state_vector().CopyToVector().tolist()

        def _calc_held(self, context: Any) -> tuple[Any, ...]:
            """Return commands (n) [rad/s], given shares (n), and the supply or None (4)."""
            given = context.get_numeric_parameter(0).CopyToVector().tolist()
            supplied = self._supply.HasValue(context)
            supply = self._supply.Eval(context).tolist() if supplied else None
            return self._commands.Eval(context).tolist(), given, supply

        def _calc_turning(self, context: Any) -> tuple[Any, ...]:
            """Return w (n) [rad/s], dw/dt (n) [rad/s²], shares (n), static thrusts (n) [N]."""
            commands, given, supply = self._held(context)
            speeds, shares = self._speeds(context), [turning_share(share) for share in given]
            statics, slopes = static_thrusts(self._rotors, shares, speeds), []
            voltage, compensated = 1.0, 1.0
            if supply:
                voltage = _voltage(supply, statics)
                open_circuit, _, compensation, known = supply
                compensated = compensated_share(voltage, open_circuit, compensation, known)
            for rotor, share, u, w in zip(self._rotors, given, commands, speeds, strict=True):
                command = voltage * within(u / compensated, rotor) if share > 0.0 else 0.0
                slopes.append(speed_slope(rotor, command, w))
            return speeds, slopes, shares, statics

        def _statics(self, context: Any) -> tuple[list[Any], list[Any], list[Any]]:
            """Return speeds, shares and static thrusts, from state and parameters alone."""
            given = context.get_numeric_parameter(0).CopyToVector().tolist()
            shares = [turning_share(share) for share in given]
            speeds = self._speeds(context)
            return speeds, shares, static_thrusts(self._rotors, shares, speeds)

        def _motion(self, context: Any) -> tuple[Any, Any, Any, Any]:
            """Return R_WB row by row (9), angular velocity and air velocity in B, and height."""
            state = self._state.Eval(context).tolist()
            R_WB, v_W = rotation(state[0:4]), state[10:13]
            if self._wind.HasValue(context):
                u_x, u_y, u_z = self._wind.Eval(context).tolist()
                v_x, v_y, v_z = v_W
                v_W = v_x - u_x, v_y - u_y, v_z - u_z
            return R_WB, into_body(R_WB, state[7:10]), into_body(R_WB, v_W), state[6]

        def _calc_spatial_forces(self, context: Any, output: Any) -> None:
            R_WB, w_B, v_B, height = self._motion(context)
            speeds, slopes, shares, statics = self._turning(context)
            f_x = f_y = f_z = m_x = m_y = m_z = h_x = h_y = h_z = 0.0
            turning = zip(self._rotors, speeds, slopes, shares, statics, strict=True)
            for each in turning:
                force, moment, momentum = rotor_load(*each, w_B, v_B, R_WB, height)
                f_x, f_y, f_z = f_x + force[0], f_y + force[1], f_z + force[2]
                m_x, m_y, m_z = m_x + moment[0], m_y + moment[1], m_z + moment[2]
                h_x, h_y, h_z = h_x + momentum[0], h_y + momentum[1], h_z + momentum[2]
            g_x, g_y, g_z = cross(w_B, (h_x, h_y, h_z))
            whole_moment = into_world(R_WB, (m_x - g_x, m_y - g_y, m_z - g_z))
            found = Force()
            found.body_index = self._body
            found.p_BoBq_B = origin  # without, it is not a number in Drake 1.51
            # from an array: a tenth of the time that two tuples take
            whole = np.array([*whole_moment, *into_world(R_WB, (f_x, f_y, f_z))])
            found.F_Bq_W = SpatialForce(whole)
            output.set_value([found])

        def _calc_speeds(self, context: Any, output: Any) -> None:
            output.SetFromVector(self._speeds(context))

        def _calc_thrusts(self, context: Any, output: Any) -> None:
            R_WB, w_B, v_B, height = self._motion(context)
            speeds, shares, statics = self._statics(context)
            thrusts = []
            for rotor, w, share, T_0 in zip(self._rotors, speeds, shares, statics, strict=True):
                v_R = hub_velocity(rotor, w_B, v_B)
                u = sum(v * n for v, n in zip(v_R, rotor.axis_B, strict=True))
                thrusts.append(moving_thrust(rotor, w, share, T_0, u, R_WB, height))
            output.SetFromVector(thrusts)

        def _calc_static_thrusts(self, context: Any, output: Any) -> None:
            output.SetFromVector(self._statics(context)[2])

        def _calc_voltage(self, context: Any, output: Any) -> None:
            voltage = 1.0
            if self._supply.HasValue(context):
                supply = self._supply.Eval(context).tolist()
                voltage = _voltage(supply, self._statics(context)[2])
            output.SetFromVector([voltage])

    return Impl


def _voltage(supply: Sequence[Any], statics: Sequence[Any]) -> Any:
    """Return the voltage of a supply (4) under the load of static thrusts (n)."""
    return loaded_voltage(supply[0], supply[1], sum(map(power_share, statics)))


Rotors: TypeAlias = Any
"""An instance of `Rotors_`; what fills a template has no type of its own."""
