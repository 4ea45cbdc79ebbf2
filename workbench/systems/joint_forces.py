"""What acts in the joints of a vehicle besides Drake's damping and springs.

With the position q and the velocity v of a freedom, in rad or m:

    limit      -(k d + c v), if that pushes back, d being how far q is beyond the limit
    friction   -F v / sqrt(v² + V²): dry friction F, smoothed over the velocity V
    mimic      -(k e + c de/dt) with e = q - (a q_l + b) on the follower, and that times -a on the
               leader l: the forces of a stiff spring do no work on what follows exactly
    servo      see `Servo`: within its limit of effort

Drake's continuous plant has no constraints and ignores limits; hence stiff springs. Their
stiffness k and damping c come from the inertia that each moves, see `joint_rows`.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from pydrake.common.eigen_geometry import Quaternion_
from pydrake.math import RollPitchYaw_
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.framework import BasicVector, BasicVector_, Context, LeafSystem, LeafSystem_

from workbench.plant.model import Model
from workbench.plant.multibody import mobility
from workbench.plant.servo import Servo
from workbench.systems.ball_forces import (
    FRICTION_SPEED,
    STOP_DAMPING_RATIO,
    STOP_RATE_RAD_S,
    BallRow,
    ball_quaternion,
    ball_torque,
)
from workbench.systems.convertible import convertible

MIMIC_RATE_RAD_S = 3000.0
"""Natural frequency of the error of a joint that follows another one."""


class JointRow(NamedTuple):
    """A freedom with forces; places are those in the state and the forces of the plant.

    Attributes:
        name: of the freedom.
        position: place of q.
        velocity: place of v among the velocities.
        lower: limit, -inf without.
        upper: limit, inf without.
        stop_stiffness: k of a limit.
        stop_damping: c of a limit.
        friction: F.
        damping: Drake's, in the plant.
        stiffness: of Drake's spring in the plant.
        leader: row of the freedom that it follows, -1 for none.
        multiplier: a.
        offset: b.
        mimic_stiffness: k of a follower.
        mimic_damping: c of a follower.
        servo: that drives it, with its gains.
    """

    name: str
    position: int
    velocity: int
    lower: float
    upper: float
    stop_stiffness: float
    stop_damping: float
    friction: float
    damping: float = 0.0
    stiffness: float = 0.0
    leader: int = -1
    multiplier: float = 0.0
    offset: float = 0.0
    mimic_stiffness: float = 0.0
    mimic_damping: float = 0.0
    servo: Servo | None = None

    @property
    def acts(self) -> bool:
        """Whether there is any force."""
        return (
            bool(self.friction or self.leader >= 0 or self.servo)
            or self.lower > -np.inf
            or self.upper < np.inf
        )


def joint_rows(plant: MultibodyPlant, model: Model) -> tuple[JointRow, ...]:
    """Return the freedoms of a finalised plant, but those of ball and free joints.

    Args:
        plant: with the vehicle.
        model: of bodies, from `merged_model`, of which it was made.
    """
    context = plant.CreateDefaultContext()
    joints = [joint for joint in model.joints if joint.freedoms[0].count == 1]
    if not joints:
        return ()
    inverse = mobility(plant, context)
    made = [plant.GetJointByName(joint.name) for joint in joints]
    numbers = {joint.name: number for number, joint in enumerate(joints)}
    rows = []
    for joint, drakes in zip(joints, made, strict=True):
        (freedom,), place = joint.freedoms, drakes.velocity_start()
        inertia = 1.0 / inverse[place, place]
        row = JointRow(
            name=joint.name,
            position=drakes.position_start(),
            velocity=place,
            lower=freedom.lower,
            upper=freedom.upper,
            stop_stiffness=inertia * STOP_RATE_RAD_S**2,
            stop_damping=2.0 * STOP_DAMPING_RATIO * inertia * STOP_RATE_RAD_S,
            friction=freedom.friction,
            damping=freedom.damping,
            stiffness=freedom.stiffness,
            servo=freedom.servo and freedom.servo.driving(inertia),
        )
        if joint.mimic:
            leader = numbers[joint.mimic.joint]
            across = np.zeros(len(inverse))
            across[made[leader].velocity_start()] = -joint.mimic.multiplier
            across[place] = 1.0
            inertia = 1.0 / float(across @ inverse @ across)
            row = row._replace(
                leader=leader,
                multiplier=joint.mimic.multiplier,
                offset=joint.mimic.offset,
                mimic_stiffness=inertia * MIMIC_RATE_RAD_S**2,
                mimic_damping=2.0 * inertia * MIMIC_RATE_RAD_S,
            )
        rows.append(row)
    return tuple(rows)


@convertible
def JointForces_(T: type) -> type[LeafSystem]:
    """The forces of limits, friction, mimic joints and servos, and those in ball joints.

    Input ports:
        state (nq + nv): of the plant.
        setpoints (c): of the servos that are commanded; if there are any.
    Output ports:
        generalized_forces (nv) [N m or N].
        joint_state (nq + nv): of the plant, with roll, pitch and yaw of the children of ball joints
            in their parents, the pitch within 90°, in place of Drake's angles; if there are any.
    Numeric parameters: for each ball joint the quaternion q_MC (4), see `ball_forces`.

    Attributes:
        turn_indices: of those parameters.

    Args:
        T: the scalar type.
        rows: of the freedoms.
        balls: the ball joints.
        commanded: names of freedoms whose servos are commanded; the others hold their start.
        positions: nq of the plant.
        velocities: nv of the plant.
    """

    class Impl(LeafSystem_[T]):
        def declare(
            self,
            *,
            rows: Sequence[JointRow],
            balls: Sequence[BallRow] = (),
            positions: int,
            velocities: int,
            commanded: Sequence[str] = (),
        ) -> None:
            self.rows, self._sizes = tuple(rows), (positions, velocities)
            self.balls = tuple(balls)
            names = [row.name for row in rows]
            self._places = [names.index(name) for name in commanded]
            self._starts = [row.servo.start if row.servo else 0.0 for row in rows]
            no_turn = [T(1.0), T(0.0), T(0.0), T(0.0)]
            self.turn_indices = [
                int(self.DeclareNumericParameter(BasicVector_[T](no_turn))) for _ in self.balls
            ]
            self._state = self.DeclareVectorInputPort("state", positions + velocities)
            self._setpoints = None
            if commanded:
                self._setpoints = self.DeclareVectorInputPort("setpoints", len(commanded))
            needs = {self.all_input_ports_ticket(), self.all_parameters_ticket()}
            self.DeclareVectorOutputPort("generalized_forces", velocities, self._calc_forces, needs)
            if balls:
                self.DeclareVectorOutputPort(
                    "joint_state", positions + velocities, self._calc_joint_state, needs
                )

        def _calc_forces(self, context: Context, output: BasicVector) -> None:
            state = self._state.Eval(context).tolist()
            positions, velocities = self._sizes
            moving = [(state[row.position], state[positions + row.velocity]) for row in self.rows]
            forces = [T(0.0)] * velocities
            setpoints: list[Any] = list(self._starts)
            if self._setpoints:
                given = self._setpoints.Eval(context).tolist()
                for place, setpoint in zip(self._places, given, strict=True):
                    setpoints[place] = setpoint
            for row, (q, v), setpoint in zip(self.rows, moving, setpoints, strict=True):
                forces[row.velocity] += _own_force(row, q, v)
                if row.servo:
                    forces[row.velocity] += servo_effort(row.servo, setpoint, q, v)
                if row.leader >= 0:
                    leader, (q_l, v_l) = self.rows[row.leader], moving[row.leader]
                    error = q - (row.multiplier * q_l + row.offset)
                    change = v - row.multiplier * v_l
                    force = row.mimic_stiffness * error + row.mimic_damping * change
                    forces[row.velocity] -= force
                    forces[leader.velocity] += row.multiplier * force
            for ball, index in zip(self.balls, self.turn_indices, strict=True):
                if ball.acts:
                    own = slice(ball.velocity, ball.velocity + 3)
                    q_PC = self._quaternion(context, state, ball, index)
                    forces[own] = ball_torque(ball, q_PC, state[positions:][own])
            output.SetFromVector(forces)

        def _quaternion(
            self, context: Context, state: Sequence[Any], ball: BallRow, index: int
        ) -> list[Any]:
            q_MC = context.get_numeric_parameter(index).CopyToVector().tolist()
            return ball_quaternion(state[ball.position : ball.position + 3], q_MC)

        def _calc_joint_state(self, context: Context, output: BasicVector) -> None:
            state = self._state.Eval(context).tolist()
            for ball, index in zip(self.balls, self.turn_indices, strict=True):
                q_PC = Quaternion_[T](*self._quaternion(context, state, ball, index))
                angles = RollPitchYaw_[T](q_PC).vector()
                state[ball.position : ball.position + 3] = angles.tolist()
            output.SetFromVector(state)

    return Impl


JointForces: TypeAlias = Any
"""An instance of `JointForces_`."""


def _own_force(row: JointRow, q: Any, v: Any) -> Any:
    """Return the force of limits and friction on a freedom."""
    force = 0.0 * v
    if row.friction:
        force = force - row.friction * v / (v * v + FRICTION_SPEED**2) ** 0.5
    if q > row.upper:
        stop = row.stop_stiffness * (q - row.upper) + row.stop_damping * v
        return force - stop if stop > 0.0 else force
    if q < row.lower:
        stop = row.stop_stiffness * (q - row.lower) + row.stop_damping * v
        return force - stop if stop < 0.0 else force
    return force


def servo_effort(servo: Servo, setpoint: Any, q: Any, v: Any) -> Any:
    """Return the effort of a servo with gains [N m or N]."""
    if servo.kind == "position":
        effort = servo.spring * (setpoint - q) - servo.damper * v
    elif servo.kind == "velocity":
        effort = servo.damper * (setpoint - v)
    else:
        effort = setpoint + 0.0 * v
    if effort > servo.max_effort:
        return servo.max_effort + 0.0 * v
    return -servo.max_effort + 0.0 * v if effort < -servo.max_effort else effort
