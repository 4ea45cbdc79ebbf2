"""Rotors on bodies: their lag, and the forces and moments with which they act on these.

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

Ground effect: g = ground_effect_coefficient (r / 4h)² at the height h of the hub above the ground,
if n points upwards; at most 4/15 (Cheeseman and Bennett, ARC R&M 3021, 1955, and
gym-pybullet-drones).

Lag: the speed approaches the command c with dw/dt = e s / up + e (1 - s) / down, e = c - w. The
share s goes from 0 to 1 within some BLEND of e = 0, where a linear model of hover needs one rate:
s = (1 + (e² / (e² + BLEND²))^(3/2) sign e) / 2.

Battery: a rotor with the command c goes to V c, where V is the voltage under load over that of the
full battery without load, as speed controllers set a share of the voltage (ArduPilot's
SIM_Motor.cpp); a compensation of k divides the command by 1 + k (V - 1), as Betaflight's
vbat_sag_compensation does.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from pydrake.multibody.tree import BodyIndex
from pydrake.systems.framework import (
    BasicVector,
    BasicVector_,
    Context,
    ContinuousState,
    LeafSystem,
    LeafSystem_,
)

from workbench.common.vectors import Matrix3, Vector3
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
    within_speed_limits,
)
from workbench.plant.rotors import Rotor
from workbench.systems.cached import cached
from workbench.systems.convertible import convertible
from workbench.systems.spatial_forces import BodyLoads, declare_spatial_forces


class HeldInputs(NamedTuple):
    """Parameters and inputs of rotors that change at updates only.

    Attributes:
        commands: (n) [rad/s].
        limited: (n) the same within the rotors' limits, and 0 of stopped rotors [rad/s].
        given: (n) shares of their thrust, 0 of stopped rotors.
        shares: (n) see `turning_share`.
        wind: velocity of the air in W (3) [m/s].
        supply: (4) see `Rotors_`; None for a full battery.
    """

    commands: list[float]
    limited: list[float]
    given: list[float]
    shares: list[float]
    wind: list[float]
    supply: list[float] | None


@convertible
def Rotors_(T: type) -> type[LeafSystem]:
    """The rotors of a vehicle; their continuous state is their speeds (n) [rad/s].

    Each acts on the body that carries it, whatever moves that: B is that body's frame.

    Input ports:
        commands (n): rotor speeds [rad/s], clipped to the rotors' range.
        state (13 k): of each body: q_WB (w, x, y, z), p_WB [m], w_WB_W [rad/s], v_WB_W [m/s].
        wind (3): velocity of the air in W [m/s]; zero if unconnected.
        supply (4): of the battery: its voltage without load, the drop of that per power, the share
            of sag that is compensated, and the voltage without load that the compensation assumes;
            voltages are over that of the full battery [1, N^-3/2]. A full battery if unconnected.
    Output ports:
        spatial_forces: of the rotors on each body (k), at its origin, for the plant.
        speeds (n) [rad/s].
        thrusts (n) [N].
        static_thrusts (n): at rest far from the ground; drag torque and power follow from them.
        voltage (1): of the battery under load over that of the full one without load.
    Numeric parameter 0: share of its thrust that each rotor gives (n), initially 1. A rotor with
    the share 0 does not turn up any more, and has its full thrust while it runs down.

    Args:
        T: the scalar type.
        rotors: in the order of the commands, with place and axis in the frames of their bodies.
        bodies: indices of the bodies in the plant (k).
        carriers: for each rotor, which of the bodies carries it (n).
    """

    class Impl(LeafSystem_[T]):
        def declare(
            self,
            *,
            rotors: Sequence[Rotor],
            bodies: Sequence[BodyIndex],
            carriers: Sequence[int],
        ) -> None:
            self._rotors, self.bodies, self._carriers = rotors, bodies, carriers
            self._carried = [
                [place for place, carrier in enumerate(carriers) if carrier == number]
                for number in range(len(bodies))
            ]
            n = len(rotors)
            self.DeclareNumericParameter(BasicVector_[T]([T(1.0)] * n))
            self._commands = self.DeclareVectorInputPort("commands", n)
            self._state = self.DeclareVectorInputPort("state", 13 * len(bodies))
            self._wind = self.DeclareVectorInputPort("wind", 3)
            self._supply = self.DeclareVectorInputPort("supply", 4)
            self.DeclareContinuousState(n)
            own = {self.xc_ticket(), self.pn_ticket()}
            driven = {self._commands.ticket(), self._supply.ticket()}
            self._held = cached(
                self._calc_held,
                "what changes at updates only",
                driven | {self.pn_ticket(), self._wind.ticket()},
            )
            self._turning = cached(
                self._calc_turning,
                "speeds, their derivatives, shares of the thrust, and static thrusts",
                own | driven,
            )
            moving = own | {self._state.ticket(), self._wind.ticket()}
            declare_spatial_forces(self, T, self._body_loads, moving | driven)
            self.DeclareVectorOutputPort("speeds", n, self._calc_speeds, {self.xc_ticket()})
            self.DeclareVectorOutputPort("thrusts", n, self._calc_thrusts, moving)
            self.DeclareVectorOutputPort("static_thrusts", n, self._calc_static_thrusts, own)
            self.DeclareVectorOutputPort(
                "voltage", 1, self._calc_voltage, own | {self._supply.ticket()}
            )

        def DoCalcTimeDerivatives(self, context: Context, derivatives: ContinuousState) -> None:
            _, slopes, _, _ = self._turning(context)
            derivatives.get_mutable_vector().SetFromVector(np.array(slopes))

        def _speeds(self, context: Context) -> list[float]:
            return context.get_continuous_state_vector().CopyToVector().tolist()

        def _calc_held(self, context: Context) -> HeldInputs:
            """Return what changes at updates only, so that six stages of a step share it."""
            given = context.get_numeric_parameter(0).CopyToVector().tolist()
            commands = self._commands.Eval(context).tolist()
            supplied = self._supply.HasValue(context)
            return HeldInputs(
                commands=commands,
                limited=self._limited(commands, given, 1.0, 1.0),
                given=given,
                shares=[turning_share(share) for share in given],
                wind=self._wind_velocity(context),
                supply=self._supply.Eval(context).tolist() if supplied else None,
            )

        def _wind_velocity(self, context: Context) -> list[float]:
            """Return the velocity of the air in W (3) [m/s]."""
            blows = self._wind.HasValue(context)
            return self._wind.Eval(context).tolist() if blows else [0.0, 0.0, 0.0]

        def _limited(
            self, commands: list[float], given: list[float], voltage: float, compensated: float
        ) -> list[float]:
            """Return the speeds to which rotors go (n) [rad/s]."""
            return [
                voltage * within_speed_limits(command / compensated, rotor) if share > 0.0 else 0.0
                for rotor, share, command in zip(self._rotors, given, commands, strict=True)
            ]

        def _calc_turning(
            self, context: Context
        ) -> tuple[list[float], list[float], list[float], list[float]]:
            """Return w (n) [rad/s], dw/dt (n) [rad/s²], shares (n), static thrusts (n) [N]."""
            commands, limited, given, shares, _, supply = self._held(context)
            speeds = self._speeds(context)
            statics = static_thrusts(self._rotors, shares, speeds)
            if supply:
                voltage = _voltage(supply, statics)
                open_circuit, _, compensation, known = supply
                compensated = compensated_share(voltage, open_circuit, compensation, known)
                limited = self._limited(commands, given, voltage, compensated)
            slopes = list(map(speed_slope, self._rotors, limited, speeds))
            return speeds, slopes, shares, statics

        def _statics(self, context: Context) -> tuple[list[float], list[float], list[float]]:
            """Return speeds, shares and static thrusts, from state and parameters alone."""
            given = context.get_numeric_parameter(0).CopyToVector().tolist()
            shares = [turning_share(share) for share in given]
            speeds = self._speeds(context)
            return speeds, shares, static_thrusts(self._rotors, shares, speeds)

        def _motions(
            self, context: Context, wind: list[float]
        ) -> list[tuple[Matrix3, Vector3, Vector3, float]]:
            """Return of each body R_WB row by row (9), velocities in the air in B, and height.

            The velocities are the angular one and that of its origin.
            """
            states = self._state.Eval(context).tolist()
            u_x, u_y, u_z = wind
            motions = []
            for first in range(0, len(states), 13):
                R_WB = rotation(states[first : first + 4])
                v_x, v_y, v_z = states[first + 10 : first + 13]
                v_W = v_x - u_x, v_y - u_y, v_z - u_z
                w_B = into_body(R_WB, states[first + 7 : first + 10])
                motions.append((R_WB, w_B, into_body(R_WB, v_W), states[first + 6]))
            return motions

        def _body_loads(self, context: Context) -> BodyLoads:
            turning = list(zip(self._rotors, *self._turning(context), strict=True))
            motions = self._motions(context, self._held(context).wind)
            for body, places, motion in zip(self.bodies, self._carried, motions, strict=True):
                R_WB, w_B, v_B, height = motion
                f_x = f_y = f_z = m_x = m_y = m_z = h_x = h_y = h_z = 0.0
                for place in places:
                    force, moment, momentum = rotor_load(*turning[place], w_B, v_B, R_WB, height)
                    f_x, f_y, f_z = f_x + force[0], f_y + force[1], f_z + force[2]
                    m_x, m_y, m_z = m_x + moment[0], m_y + moment[1], m_z + moment[2]
                    h_x, h_y, h_z = h_x + momentum[0], h_y + momentum[1], h_z + momentum[2]
                g_x, g_y, g_z = cross(w_B, (h_x, h_y, h_z))
                whole_moment = into_world(R_WB, (m_x - g_x, m_y - g_y, m_z - g_z))
                yield body, (*whole_moment, *into_world(R_WB, (f_x, f_y, f_z)))

        def _calc_speeds(self, context: Context, output: BasicVector) -> None:
            output.SetFromVector(self._speeds(context))

        def _calc_thrusts(self, context: Context, output: BasicVector) -> None:
            motions = self._motions(context, self._wind_velocity(context))
            speeds, shares, statics = self._statics(context)
            thrusts = []
            turning = zip(self._rotors, self._carriers, speeds, shares, statics, strict=True)
            for rotor, carrier, w, share, T_0 in turning:
                R_WB, w_B, v_B, height = motions[carrier]
                v_R = hub_velocity(rotor, w_B, v_B)
                u = sum(v * n for v, n in zip(v_R, rotor.axis_B, strict=True))
                thrusts.append(moving_thrust(rotor, w, share, T_0, u, R_WB, height))
            output.SetFromVector(thrusts)

        def _calc_static_thrusts(self, context: Context, output: BasicVector) -> None:
            output.SetFromVector(self._statics(context)[2])

        def _calc_voltage(self, context: Context, output: BasicVector) -> None:
            voltage = 1.0
            if self._supply.HasValue(context):
                supply = self._supply.Eval(context).tolist()
                voltage = _voltage(supply, self._statics(context)[2])
            output.SetFromVector([voltage])

    return Impl


def _voltage(supply: Sequence[float], statics: Sequence[float]) -> float:
    """Return the voltage of a supply (4) under the load of static thrusts (n)."""
    return loaded_voltage(supply[0], supply[1], sum(map(power_share, statics)))


Rotors: TypeAlias = Any
"""An instance of `Rotors_`; what fills a template has no type of its own."""
