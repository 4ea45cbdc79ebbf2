"""The frames of ball joints, which flights turn: no joint is where its angles have no rates."""

import math

from pydrake.common.eigen_geometry import Quaternion
from pydrake.math import RigidTransform
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import BallRpyJoint
from pydrake.systems.framework import Context, OutputPort

from workbench.common.errors import FlightBrokenError
from workbench.common.plain_text import plain_name
from workbench.systems.ball_forces import MAX_BALL_PITCH_RAD
from workbench.systems.joint_forces import JointForces


class BallFrames:
    """The frames M in the children of ball joints, see `systems.ball_forces`.

    Args:
        plant: finalised.
        forces: what acts in its joints; its parameters have the frames.
    """

    def __init__(self, plant: MultibodyPlant, forces: JointForces) -> None:
        self._plant, self._forces = plant, forces
        self._joints: list[BallRpyJoint] = [
            plant.GetJointByName(ball.name) for ball in forces.balls
        ]

    @property
    def state(self) -> OutputPort:
        """The state of the plant, with the angles of the children themselves."""
        port: OutputPort = self._forces.GetOutputPort("joint_state")
        return port

    def turn(self, root: Context, period: float) -> bool:
        """Let angles begin at zero anew where a pitch may exceed `MAX_BALL_PITCH_RAD`.

        Args:
            root: of the diagram.
            period: until it is called again [s].

        Returns:
            Whether there are any.

        Raises:
            FlightBrokenError: if a joint is too fast.
        """
        context = self._plant.GetMyMutableContextFromRoot(root)
        forces, turned = self._forces.GetMyMutableContextFromRoot(root), False
        for joint, index in zip(self._joints, self._forces.turn_indices, strict=True):
            w_x, w_y, _ = joint.get_angular_velocity(context)
            further = math.hypot(w_x, w_y) * period  # the largest change of the pitch
            if abs(joint.get_angles(context)[1]) + further <= MAX_BALL_PITCH_RAD:
                continue
            if further > MAX_BALL_PITCH_RAD:
                raise FlightBrokenError(
                    f"the ball joint '{plain_name(joint.name())}' turns by more than "
                    f"{math.degrees(MAX_BALL_PITCH_RAD):.0f}° in a control period: give it damping"
                )
            parent, child = joint.frame_on_parent(), joint.child_body().body_frame()
            q_PC = child.CalcRotationMatrix(context, parent).ToQuaternion().wxyz()
            forces.get_mutable_numeric_parameter(index).SetFromVector(q_PC)
            joint.set_angles(context, [0.0, 0.0, 0.0])
            turned = True
        if turned:
            self.place(root)
        return turned

    def place(self, root: Context) -> None:
        """Give the plant the frames that the parameters have."""
        context = self._plant.GetMyMutableContextFromRoot(root)
        forces = self._forces.GetMyContextFromRoot(root)
        for joint, index in zip(self._joints, self._forces.turn_indices, strict=True):
            q_MC = forces.get_numeric_parameter(index).CopyToVector()
            X_CM = RigidTransform(Quaternion(q_MC), [0.0, 0.0, 0.0]).inverse()
            frame = self._plant.GetFrameByName(joint.frame_on_child().name())
            frame.SetPoseInParentFrame(context, X_CM)
