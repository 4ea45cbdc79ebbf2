"""The positions in which joints come to rest below a body that is held level."""

import numpy as np
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import BallRpyJoint, QuaternionFloatingJoint
from pydrake.systems.framework import Diagram

from workbench.common.errors import WorkbenchError
from workbench.common.plain_text import plain_name
from workbench.plant.thrust_frame import thrust_frame
from workbench.plant.vehicle import Vehicle

_HEIGHT_M = 10.0
"""Height of the body, far from the ground."""
_RESTING_ACCELERATION = 1e-6
"""Acceleration of joints below which they rest [rad/s² or m/s²]."""
_MAX_ROUNDS = 60
_MAX_STEP = 0.3
"""Largest change of a joint in a round [rad or m]."""
_DIFFERENCE = 1e-6
"""Change of a joint by which stiffnesses are computed [rad or m]."""
_STEEPEST_COSINE = 0.01
"""Cosine of the pitch of a ball joint below which it has no linear model: the rates of its angles
grow with the inverse."""
_MIN_RATE_RAD_S = 1.0
"""Natural frequency that a motion has at least for the length of a step."""


def resting_positions(core: Diagram, vehicle: Vehicle, positions: np.ndarray) -> np.ndarray:
    """Return positions of a plant (q) with its joints at rest.

    The energy of weight, springs, limits and servos falls with each step: along each mode of the
    joints by its force over its stiffness, or over a small one where that is negative. So the
    search ends where joints hang, and not where they balance, as Newton's method alone may. Joints
    that no position keeps at rest end anywhere.

    Args:
        core: from `make_vehicle_core`.
        vehicle: as known to its law, which gives the speeds of its rotors.
        positions: from which the search starts (q).

    Raises:
        WorkbenchError: if a ball joint rests where its angles have no rates.
    """
    held = _HeldBody(core, vehicle)
    q = held.levelled(positions)
    for _ in range(_MAX_ROUNDS):
        force, mass = held.force(q), held.mass()
        if np.abs(np.linalg.solve(mass, force)).max() < _RESTING_ACCELERATION:
            break
        step = _descent(force, mass, held.stiffness(q, force))
        step *= min(1.0, _MAX_STEP / max(float(np.abs(step).max()), 1e-300))
        q = held.moved(q, step)
    return q


def _descent(force: np.ndarray, mass: np.ndarray, stiffness: np.ndarray) -> np.ndarray:
    """Return a step along which the energy falls (v)."""
    back = np.linalg.inv(np.linalg.cholesky(mass))
    squares, modes = np.linalg.eigh(back @ (0.5 * (stiffness + stiffness.T)) @ back.T)
    sizes = np.maximum(squares, _MIN_RATE_RAD_S**2)
    step: np.ndarray = back.T @ modes @ (modes.T @ back @ force / sizes)
    return step


class _HeldBody:
    """A vehicle core whose base link does not move, with rotors as in hover.

    Attributes:
        loose: places of the velocities of joints (v).
    """

    def __init__(self, core: Diagram, vehicle: Vehicle) -> None:
        self._core = core
        self._plant: MultibodyPlant = core.GetSubsystemByName("plant")
        self._root = core.CreateDefaultContext()
        self._context = self._plant.GetMyMutableContextFromRoot(self._root)
        base = self._plant.GetBodyByName(vehicle.base_link)
        own = base.floating_velocities_start_in_v() + np.arange(6)
        self._base = base.floating_positions_start()
        self.loose = np.setdiff1d(np.arange(self._plant.num_velocities()), own)
        joints = [self._plant.get_joint(index) for index in self._plant.GetJointIndices()]
        self._balls = [each for each in joints if each.type_name() == BallRpyJoint.kTypeName]
        self._quaternions = [
            slice(joint.position_start(), joint.position_start() + 4)
            for joint in joints
            if joint.type_name() == QuaternionFloatingJoint.kTypeName
        ]
        speeds = thrust_frame(vehicle).hover_speeds
        port = core.GetInputPort("commands")
        port.FixValue(self._root, np.concatenate([speeds, np.zeros(port.size() - speeds.size)]))
        state = self._root.get_continuous_state_vector().CopyToVector()
        first = self._plant.num_multibody_states()
        state[first : first + speeds.size] = speeds
        self._root.SetContinuousState(state)

    def levelled(self, positions: np.ndarray) -> np.ndarray:
        """Return positions with the body level, above the ground."""
        q = positions.copy()
        q[self._base : self._base + 7] = [1.0, 0.0, 0.0, 0.0, 0.0, 0.0, _HEIGHT_M]
        return q

    def force(self, q: np.ndarray) -> np.ndarray:
        """Return the forces that accelerate the joints, at rest at some positions (v)."""
        self._plant.SetPositions(self._context, q)
        for ball in self._balls:
            if abs(np.cos(ball.get_angles(self._context)[1])) < _STEEPEST_COSINE:
                raise WorkbenchError(
                    f"there is no trim: the ball joint '{plain_name(ball.name())}' rests near a "
                    "pitch of 90°, where roll, pitch and yaw have no rates: describe its link as "
                    "it hangs"
                )
        slopes = self._core.EvalTimeDerivatives(self._root).CopyToVector()
        count = self._plant.num_positions()
        accelerations = slopes[count : count + self._plant.num_velocities()]
        forces: np.ndarray = self._plant.CalcMassMatrix(self._context) @ accelerations
        return forces[self.loose]

    def mass(self) -> np.ndarray:
        """Return the mass matrix of the joints at the last positions (v, v)."""
        mass: np.ndarray = self._plant.CalcMassMatrix(self._context)
        return mass[np.ix_(self.loose, self.loose)]

    def stiffness(self, q: np.ndarray, force: np.ndarray) -> np.ndarray:
        """Return the negative derivatives of the forces by small motions of the joints (v, v)."""
        steps = _DIFFERENCE * np.eye(self.loose.size)
        columns = [(force - self.force(self.moved(q, step))) / _DIFFERENCE for step in steps]
        return np.array(columns).T

    def moved(self, q: np.ndarray, step: np.ndarray) -> np.ndarray:
        """Return positions after a small motion of the joints (v)."""
        motion = np.zeros(self._plant.num_velocities())
        motion[self.loose] = step
        self._plant.SetPositions(self._context, q)
        found: np.ndarray = q + self._plant.MapVelocityToQDot(self._context, motion)
        for place in self._quaternions:
            found[place] /= np.linalg.norm(found[place])
        return found
