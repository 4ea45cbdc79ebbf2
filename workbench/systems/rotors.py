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
from pydrake.systems.framework import BasicVector_, LeafSystem_, ValueProducer
from pydrake.systems.scalar_conversion import TemplateSystem

from workbench.dynamics.rigid_body import cross, into_body, into_world, rotation
from workbench.plant.rotors import Rotor
from workbench.systems.weak_callback import weakly

BLEND = 3.0
"""Less than half a percent of usual hover speeds [rad/s]."""
MOST_GROUND_EFFECT = 4.0 / 15.0
"""Largest share of thrust by ground effect."""
LEAST_VOLTAGE = 0.1
"""Share of the full voltage below which sag is not compensated."""
FULL = (1.0, 0.0, 0.0, 1.0)
"""A supply with the constant voltage of a full battery."""
TINY = 1e-30
"""Added to a radicand, because a root has no derivative at 0."""


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
            self._turning = self.DeclareCacheEntry(
                "speeds, their derivatives, shares of the thrust, and static thrusts",
                ValueProducer(lambda: Value[object](()), weakly(self._calc_turning)),
                own | {self._commands.ticket(), self._supply.ticket()},
            ).cache_index()
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
            _, slopes, _, _ = self.get_cache_entry(self._turning).Eval(context)
            derivatives.get_mutable_vector().SetFromVector(np.array(slopes))

        def _speeds(self, context: Any) -> list[Any]:
            return context.get_continuous_state_vector().CopyToVector().tolist()

        def _calc_turning(self, context: Any, output: Any) -> None:
            """Calculate w (n) [rad/s], dw/dt (n) [rad/s²], shares (n), static thrusts (n) [N]."""
            commands, speeds = self._commands.Eval(context).tolist(), self._speeds(context)
            given = context.get_numeric_parameter(0).value().tolist()
            shares = [share if share > 0.0 else 1.0 for share in given]
            statics = self._static_thrusts(shares, speeds)
            voltage, compensated = 1.0, 1.0
            if self._supply.HasValue(context):
                open_circuit, _, compensation, known = self._supply.Eval(context).tolist()
                voltage = self._voltage(context, statics)
                compensated = 1.0 + compensation * (voltage + (known - open_circuit) - 1.0)
                compensated = max(compensated, LEAST_VOLTAGE)
            slopes = []
            for rotor, share, u, w in zip(self._rotors, given, commands, speeds, strict=True):
                command = voltage * within(u / compensated, rotor) if share > 0.0 else 0.0
                slopes.append(speed_slope(rotor, command, w))
            output.set_value((speeds, slopes, shares, statics))

        def _voltage(self, context: Any, statics: Sequence[Any]) -> Any:
            """Return the voltage under load, over that of the full battery."""
            if not self._supply.HasValue(context):
                return 1.0
            open_circuit, drop, *_ = self._supply.Eval(context).tolist()
            voltage = open_circuit - drop * sum(T * (T + TINY) ** 0.5 for T in statics)
            return voltage if voltage > 0.0 else 0.0 * voltage

        def _shares(self, context: Any) -> list[Any]:
            """Return the shares of their thrust that the rotors give while they turn."""
            shares = context.get_numeric_parameter(0).value().tolist()
            return [share if share > 0.0 else 1.0 for share in shares]

        def _static_thrusts(self, shares: Sequence[Any], speeds: Sequence[Any]) -> list[Any]:
            turning = zip(self._rotors, shares, speeds, strict=True)
            return [
                share * rotor.motor_constant * w * (w + rotor.linear_speed)
                for rotor, share, w in turning
            ]

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
            speeds, slopes, shares, statics = self.get_cache_entry(self._turning).Eval(context)
            f_x = f_y = f_z = m_x = m_y = m_z = h_x = h_y = h_z = 0.0
            turning = zip(self._rotors, speeds, slopes, shares, statics, strict=True)
            for rotor, w, slope, share, T_0 in turning:
                p_x, p_y, p_z = rotor.p_BR
                n_x, n_y, n_z = rotor.axis_B
                v_x, v_y, v_z = hub_velocity(rotor, w_B, v_B)
                u = v_x * n_x + v_y * n_y + v_z * n_z
                thrust = moving_thrust(rotor, w, share, T_0, u, R_WB, height)
                turned, size = w * rotor.direction * rotor.inertia, abs(w)
                torque = rotor.direction * (rotor.moment_constant * T_0 + rotor.inertia * slope)
                drag = size * rotor.rotor_drag_coefficient
                roll = size * rotor.rolling_moment_coefficient
                # thrust is along the axis, drag opposes the rest of the velocity
                thrust, torque = thrust + drag * u, torque - roll * u
                F_x = thrust * n_x - drag * v_x
                F_y = thrust * n_y - drag * v_y
                F_z = thrust * n_z - drag * v_z
                f_x, f_y, f_z = f_x + F_x, f_y + F_y, f_z + F_z
                m_x = m_x + p_y * F_z - p_z * F_y - torque * n_x - roll * v_x
                m_y = m_y + p_z * F_x - p_x * F_z - torque * n_y - roll * v_y
                m_z = m_z + p_x * F_y - p_y * F_x - torque * n_z - roll * v_z
                h_x, h_y, h_z = h_x + turned * n_x, h_y + turned * n_y, h_z + turned * n_z
            g_x, g_y, g_z = cross(w_B, (h_x, h_y, h_z))
            moment = into_world(R_WB, (m_x - g_x, m_y - g_y, m_z - g_z))
            force = Force()
            force.body_index = self._body
            # from an array: a tenth of the time that two tuples take
            force.F_Bq_W = SpatialForce(np.array([*moment, *into_world(R_WB, (f_x, f_y, f_z))]))
            output.set_value([force])

        def _calc_speeds(self, context: Any, output: Any) -> None:
            output.SetFromVector(self._speeds(context))

        def _calc_thrusts(self, context: Any, output: Any) -> None:
            R_WB, w_B, v_B, height = self._motion(context)
            speeds, shares = self._speeds(context), self._shares(context)
            statics, thrusts = self._static_thrusts(shares, speeds), []
            for rotor, w, share, T_0 in zip(self._rotors, speeds, shares, statics, strict=True):
                v_R = hub_velocity(rotor, w_B, v_B)
                u = sum(v * n for v, n in zip(v_R, rotor.axis_B, strict=True))
                thrusts.append(moving_thrust(rotor, w, share, T_0, u, R_WB, height))
            output.SetFromVector(thrusts)

        def _calc_static_thrusts(self, context: Any, output: Any) -> None:
            output.SetFromVector(self._static_thrusts(self._shares(context), self._speeds(context)))

        def _calc_voltage(self, context: Any, output: Any) -> None:
            statics = self._static_thrusts(self._shares(context), self._speeds(context))
            output.SetFromVector([self._voltage(context, statics)])

    return Impl


Rotors: TypeAlias = Any
"""An instance of `Rotors_`; what fills a template has no type of its own."""


def within(command: Any, rotor: Rotor) -> Any:
    """Return a command limited to the speeds of a rotor [rad/s]."""
    if command < 0.0:
        return 0.0 * command
    return command if command < rotor.max_rot_velocity else rotor.max_rot_velocity


def speed_slope(rotor: Rotor, command: Any, speed: Any) -> Any:
    """Return dw/dt of a rotor on its way to a command [rad/s²]."""
    error = command - speed
    side = error / (error * error + BLEND * BLEND) ** 0.5
    up = 0.5 * error * (1.0 + side * side * side)
    return up / rotor.time_constant_up + (error - up) / rotor.time_constant_down


def hub_velocity(rotor: Rotor, w_B: Sequence[Any], v_B: Sequence[Any]) -> tuple[Any, Any, Any]:
    """Return the velocity of a hub, in B, from the motion of the body in B."""
    p_x, p_y, p_z = rotor.p_BR
    w_x, w_y, w_z = w_B
    v_x, v_y, v_z = v_B
    return v_x + w_y * p_z - w_z * p_y, v_y + w_z * p_x - w_x * p_z, v_z + w_x * p_y - w_y * p_x


def moving_thrust(
    rotor: Rotor,
    speed: Any,
    share: Any,
    static: Any,
    along: Any,
    R_WB: Sequence[Any],
    height: Any,
) -> Any:
    """Return the thrust of a rotor near the ground and in moving air [N].

    Args:
        rotor: which.
        speed: its speed [rad/s].
        share: of its thrust that it gives.
        static: its static thrust [N].
        along: velocity of its hub in the air along its axis [m/s].
        R_WB: attitude of the body, row by row (9).
        height: of the body's origin above the ground [m].
    """
    thrust = static
    if rotor.inflow_coefficient:
        thrust = thrust - share * rotor.inflow_coefficient * speed * along
    if rotor.ground_effect_coefficient > 0.0:
        toward = R_WB[6:9]
        if sum(z * n for z, n in zip(toward, rotor.axis_B, strict=True)) > 0.0:
            hub = height + sum(z * p for z, p in zip(toward, rotor.p_BR, strict=True))
            near = rotor.ground_effect_coefficient * (rotor.propeller_radius / 4.0) ** 2
            least = near / MOST_GROUND_EFFECT
            thrust = thrust + static * (near / hub**2 if hub**2 > least else MOST_GROUND_EFFECT)
    return thrust
