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
full battery without load, as speed controllers set a share of the voltage (ArduPilot, SIM_Motor.cpp);
a compensation of c divides the command by 1 + c (s - 1), as Betaflight's vbat_sag_compensation.
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
        static_thrusts (n): those at rest far from the ground, which determine drag torque and power.
        voltage (1): of the battery under load over that of the full one without load.
    Numeric parameter 0: share of its thrust that each rotor gives (n), initially 1. A rotor with
    the share 0 does not turn up any more, and has its full thrust while it runs down.

    Args:
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
            self._p_BR = np.array([rotor.p_BR for rotor in rotors])
            self._n_B = np.array([rotor.axis_B for rotor in rotors])
            # cross products with p_BR as matrices, which take a tenth of the time of np.cross
            self._cross_p = np.array([skew(rotor.p_BR) for rotor in rotors])
            self._motor = np.array([rotor.motor_constant for rotor in rotors])
            self._linear = np.array([rotor.linear_speed for rotor in rotors])
            self._torque = np.array([r.direction * r.moment_constant for r in rotors])
            self._momentum = np.array([rotor.direction * rotor.inertia for rotor in rotors])
            self._drag = np.array([rotor.rotor_drag_coefficient for rotor in rotors])
            self._roll = np.array([rotor.rolling_moment_coefficient for rotor in rotors])
            self._inflow = np.array([rotor.inflow_coefficient for rotor in rotors])
            self._ground = np.array(
                [r.ground_effect_coefficient * (r.propeller_radius / 4.0) ** 2 for r in rotors]
            )
            self._top = np.array([rotor.max_rot_velocity for rotor in rotors])
            self._rate_up = np.array([1.0 / rotor.time_constant_up for rotor in rotors])
            self._rate_down = np.array([1.0 / rotor.time_constant_down for rotor in rotors])
            self._near_ground = bool(self._ground.any())
            self.DeclareNumericParameter(BasicVector_[T]([T(1.0)] * n))
            self._commands = self.DeclareVectorInputPort("commands", n)
            self._state = self.DeclareVectorInputPort("state", 13)
            self._wind = self.DeclareVectorInputPort("wind", 3)
            self._supply = self.DeclareVectorInputPort("supply", 4)
            self.DeclareContinuousState(n)
            own = {self.xc_ticket(), self.pn_ticket()}
            self._slopes = self.DeclareCacheEntry(
                "slopes of the speeds",
                ValueProducer(lambda: Value[object](()), weakly(self._calc_slopes)),
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
            slopes = self.get_cache_entry(self._slopes).Eval(context)
            derivatives.get_mutable_vector().SetFromVector(slopes)

        def _speeds(self, context: Any) -> Any:
            return context.get_continuous_state_vector().CopyToVector()

        def _calc_slopes(self, context: Any, output: Any) -> None:
            """Calculate dw/dt (n) [rad/s²]."""
            commands, speeds = self._commands.Eval(context), self._speeds(context)
            voltage = 1.0
            if self._supply.HasValue(context):
                open_circuit, _, compensation, known = self._supply.Eval(context)
                voltage = self._voltage(context, speeds)
                share = 1.0 + compensation * (voltage + (known - open_circuit) - 1.0)
                commands = commands / (share if share > LEAST_VOLTAGE else LEAST_VOLTAGE)
            error = voltage * np.minimum(np.maximum(commands, 0.0), self._top) - speeds
            side = error / (error * error + BLEND * BLEND) ** 0.5
            up = 0.5 * error * (1.0 + side * side * side)
            output.set_value(self._rate_up * up + self._rate_down * (error - up))

        def _voltage(self, context: Any, speeds: Any) -> Any:
            """Return the voltage under load, over that of the full battery."""
            if not self._supply.HasValue(context):
                return 1.0
            open_circuit, drop, *_ = self._supply.Eval(context)
            thrusts = self._static_thrusts(context, speeds)
            voltage = open_circuit - drop * (thrusts * (thrusts + TINY) ** 0.5).sum()
            return voltage if voltage > 0.0 else 0.0 * voltage

        def _static_thrusts(self, context: Any, speeds: Any) -> Any:
            shares = context.get_numeric_parameter(0).CopyToVector()
            shares = np.where(shares > 0.0, shares, 1.0)
            return shares * self._motor * speeds * (speeds + self._linear)

        def _motion(self, context: Any) -> tuple[Any, Any, Any, Any]:
            """Return R_WB, w_WB_B, and velocities of the hubs in the air, in B: all, along n."""
            state = self._state.Eval(context)
            v_W = state[10:13]
            if self._wind.HasValue(context):
                v_W = v_W - self._wind.Eval(context)
            R_WB = rotation(state)
            w_B = state[7:10] @ R_WB
            v_B = v_W @ R_WB - self._cross_p @ w_B  # w x p = -p x w
            return R_WB, w_B, v_B, (v_B * self._n_B).sum(axis=1)

        def _moving_thrusts(self, context: Any, speeds: Any, R_WB: Any, along: Any) -> Any:
            """Return static thrusts and thrusts (n) [N]."""
            static = self._static_thrusts(context, speeds)
            thrusts = static - self._inflow * speeds * along
            if self._near_ground:
                height = self._state.Eval(context)[6] + self._p_BR @ R_WB[2]
                least = self._ground / MOST_GROUND_EFFECT + TINY
                near = self._ground / np.maximum(height * height, least)
                thrusts = thrusts + np.where(self._n_B @ R_WB[2] > 0.0, near, 0.0) * static
            return static, thrusts

        def _calc_spatial_forces(self, context: Any, output: Any) -> None:
            speeds = self._speeds(context)
            R_WB, w_B, v_B, along = self._motion(context)
            static, thrusts = self._moving_thrusts(context, speeds, R_WB, along)
            slopes, size = self.get_cache_entry(self._slopes).Eval(context), abs(speeds)
            across = v_B - along[:, np.newaxis] * self._n_B
            forces = thrusts[:, np.newaxis] * self._n_B - (size * self._drag)[:, np.newaxis] * across
            torques = self._torque * static + self._momentum * slopes
            h_B = (self._momentum * speeds) @ self._n_B
            moment = -torques @ self._n_B - (size * self._roll) @ across - skew(w_B) @ h_B
            moment = moment + (self._cross_p @ forces[:, :, np.newaxis]).sum(axis=0)[:, 0]
            force = Force()
            force.body_index = self._body
            force.F_Bq_W = SpatialForce(R_WB @ moment, R_WB @ forces.sum(axis=0))
            output.set_value([force])

        def _calc_speeds(self, context: Any, output: Any) -> None:
            output.SetFromVector(self._speeds(context))

        def _calc_thrusts(self, context: Any, output: Any) -> None:
            R_WB, _, _, along = self._motion(context)
            _, thrusts = self._moving_thrusts(context, self._speeds(context), R_WB, along)
            output.SetFromVector(thrusts)

        def _calc_static_thrusts(self, context: Any, output: Any) -> None:
            output.SetFromVector(self._static_thrusts(context, self._speeds(context)))

        def _calc_voltage(self, context: Any, output: Any) -> None:
            output.SetFromVector([self._voltage(context, self._speeds(context))])

    return Impl


Rotors: TypeAlias = Any
"""An instance of `Rotors_`; what fills a template has no type of its own."""


def skew(p: Sequence[Any]) -> Any:
    """Return the matrix (3, 3) whose product with a vector is the cross product of p with it."""
    x, y, z = p
    return np.array([[0.0 * x, -z, y], [z, 0.0 * x, -x], [-y, x, 0.0 * x]])


def rotation(state: Sequence[Any]) -> Any:
    """Return R_WB (3, 3) of a state of the body whose quaternion need not be normalised."""
    w, x, y, z = state[:4]
    s = 2.0 / (w * w + x * x + y * y + z * z)
    return np.array(
        [
            [1.0 - s * (y * y + z * z), s * (x * y - w * z), s * (x * z + w * y)],
            [s * (x * y + w * z), 1.0 - s * (x * x + z * z), s * (y * z - w * x)],
            [s * (x * z - w * y), s * (y * z + w * x), 1.0 - s * (x * x + y * y)],
        ]
    )
