"""Gymnasium environments for learning: many drones that hover or track, in compiled flights.

Import this module explicitly, as Gymnasium is an extra: `pip install gymnasium`. The import
registers `workbench/Hover-v0` and `workbench/Track-v0`, see docs/batch.md.
"""

import math
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from workbench.common.errors import WorkbenchError, unknown_name
from workbench.control.installed_laws import DEFAULT_CONTROLLER
from workbench.design.rollout.batch import Batch
from workbench.design.rollout.batch_arrays import values_preview
from workbench.plant.gravity import GRAVITY
from workbench.plant.rotors import wrench_matrix

try:
    import gymnasium
    from gymnasium.spaces import Box
    from gymnasium.vector import AutoresetMode, VectorEnv
    from gymnasium.vector.utils import batch_space
except ImportError:
    raise WorkbenchError(
        "environments for learning need Gymnasium: `pip install gymnasium`"
    ) from None

TASKS = ("hover", "track")
OBSERVATION_SIZE = 18
"""Numbers of an observation."""
TARGET_HEIGHT_M = 10.0
"""Of targets, far above the ground [m]."""
EPISODE_RADIUS_M = 4.0
"""Distance from its target at which an episode ends [m]."""
START_SPREAD_M = 1.5
"""Episodes begin within this of their targets along each axis [m]."""
MAX_START_TILT_RAD, MAX_START_SPEED_M_S, MAX_START_RATE_RAD_S = 0.4, 1.0, 1.0
"""Range of initial tilt, velocity and angular velocity of each axis [rad, m/s, rad/s]."""
TRACK_RADIUS_M, TRACK_TURN_RAD_S = 1.5, 1.0
"""Radius of the circle to follow [m], and its angular velocity [rad/s]."""
ACTION_MOMENT_SHARE = 0.2
"""Share of the largest moment of the rotors that an action asks for at most."""


class DroneVectorEnv(VectorEnv[np.ndarray, np.ndarray, np.ndarray]):
    """Drones that hold a position ("hover") or follow a point around a circle ("track").

    An observation has 18 numbers: the vector to the target in W (3) [m], the target's velocity
    minus the drone's in W (3) [m/s], the drone's orientation R_WB in row order (9), and its angular
    velocity in B (3) [rad/s].

    Actions are within -1 .. 1. "setpoint": velocity in W and yaw rate (4), as fractions of the
    limits `max_speed`, `max_climb_rate` and `max_yaw_rate`. "wrench": force, from zero to twice the
    weight, and moments in the frame of upright hover (4), up to a fifth of the rotors' largest.
    "rotors": rotor speeds (n), from stopped through hover to the limit.

    The reward of a step is 1 - |vector to the target| / 4 m, and 0 if the drone is lost. An episode
    is terminated when the drone is lost, see `Batch`, or 4 m from its target, and truncated after
    `max_episode_steps`. Episodes start within 1.5 m of their targets along each axis, some 10 m
    high, tilted up to 0.4 rad, at any heading, and moving.

    A finished episode is reset in the next step (`AutoresetMode.NEXT_STEP`): the action of that
    step has no effect, its reward is 0, and the observation is the new start.

    Attributes:
        batch: the flights; its `parameters`, such as wind, may change at any time, and stay.
        target: (n, 3) target positions in W [m].

    Args:
        num_envs: how many drones.
        task: "hover" or "track".
        model: see `Batch`.
        controller: see `Batch`.
        actions: see `Batch`.
        periods: of control in a step, 4 of them 1/32 s.
        max_episode_steps: after which an episode is truncated.
        threads: see `Batch`.

    Raises:
        WorkbenchError: if something of that cannot be flown.
    """

    metadata = {"autoreset_mode": AutoresetMode.NEXT_STEP, "render_modes": []}

    def __init__(
        self,
        num_envs: int = 1,
        task: str = "hover",
        model: str = "dh_drone",
        controller: str = DEFAULT_CONTROLLER,
        actions: str = "setpoint",
        periods: int = 4,
        max_episode_steps: int = 320,
        threads: int | None = None,
    ) -> None:
        if task not in TASKS:
            raise unknown_name("task", task, TASKS)
        for many in (periods, max_episode_steps):
            if not isinstance(many, int | np.integer) or many < 1:
                raise WorkbenchError(
                    f"{periods!r:.30} control periods in a step and {max_episode_steps!r:.30} "
                    "steps in an episode make no flight: give a whole number from 1 on of each"
                )
        self.batch = Batch(num_envs, model, controller, actions=actions, threads=threads)
        self.num_envs = num_envs
        self._task, self._periods, self._most = task, periods, max_episode_steps
        self._scale = _action_scale(self.batch, actions)
        many = self._scale.shape[-1]
        self.single_action_space = Box(-1.0, 1.0, (many,), np.float32)
        self.single_observation_space = Box(-np.inf, np.inf, (OBSERVATION_SIZE,), np.float32)
        self.action_space = batch_space(self.single_action_space, num_envs)
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self._middle = np.array([0.0, 0.0, TARGET_HEIGHT_M])
        self._phase = np.zeros(num_envs)
        self._age = np.zeros(num_envs, dtype=int)
        self._ended = np.zeros(num_envs, dtype=bool)
        self.target = np.tile(self._middle, (num_envs, 1))

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[np.ndarray, dict[str, Any]]:
        """Begin all episodes.

        Args:
            seed: of where they begin, and of the turbulence.
            options: none are known.

        Returns:
            The observations (n, 18), and nothing else.
        """
        super().reset(seed=seed)
        self._begin(np.arange(self.num_envs))
        return self._observed(), {}

    def step(
        self, actions: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, dict[str, Any]]:
        """Fly on for a step.

        Args:
            actions: (n, actions); what is beyond -1 .. 1 is cut.

        Returns:
            Observations (n, 18), rewards (n), who is terminated and who truncated (n), and nothing
            else.

        Raises:
            WorkbenchError: if actions are not as many finite numbers.
        """
        self._ask(np.clip(self._checked(actions), -1.0, 1.0))
        self.batch.step(self._periods)
        self._age += 1
        again = np.flatnonzero(self._ended)
        if len(again):
            self._begin(again)
        self._aim()
        far = np.linalg.norm(self.target - self.batch.position, axis=1)
        out = self.batch.lost | ~(far < EPISODE_RADIUS_M)
        rewards = np.where(self.batch.lost, 0.0, np.maximum(0.0, 1.0 - far / EPISODE_RADIUS_M))
        late = (self._age >= self._most) & ~out
        rewards[again] = 0.0
        self._ended = out | late
        return self._observed(), rewards, out, late, {}

    def _checked(self, actions: ArrayLike) -> np.ndarray:
        """Return actions (n, actions) from outside."""
        shape = self.action_space.shape
        try:
            found = np.asarray(actions, dtype=float)
        except (TypeError, ValueError):
            found = np.array(np.nan)
        if found.shape != shape or not np.isfinite(found).all():
            raise WorkbenchError(
                f"actions are {values_preview(actions)}: give an array {shape} of finite numbers"
            )
        return found

    def _begin(self, which: np.ndarray) -> None:
        """Begin the episodes of some drones."""
        rng, many = self.np_random, len(which)
        self._age[which], self._ended[which] = 0, False
        self._phase[which] = rng.uniform(-math.pi, math.pi, many)
        self._aim()
        starts = self.batch.starts
        heading = rng.uniform(-math.pi, math.pi, many)
        axis, tilt = (
            rng.uniform(-math.pi, math.pi, many),
            rng.uniform(0.0, MAX_START_TILT_RAD, many),
        )
        starts[which, 0:4] = _attitude(heading, axis, tilt)
        starts[which, 4:7] = self.target[which] + rng.uniform(
            -START_SPREAD_M, START_SPREAD_M, (many, 3)
        )
        starts[which, 7:10] = rng.uniform(-MAX_START_RATE_RAD_S, MAX_START_RATE_RAD_S, (many, 3))
        starts[which, 10:13] = rng.uniform(-MAX_START_SPEED_M_S, MAX_START_SPEED_M_S, (many, 3))
        self.batch.reset(which, seeds=rng.integers(0, 2**31, many).tolist())

    def _angle(self) -> np.ndarray:
        """Return how far round their circles targets are (n) [rad]."""
        step = self._periods * self.batch.rates.control_period
        return self._phase + TRACK_TURN_RAD_S * step * self._age

    def _aim(self) -> None:
        """Let targets be where they are now."""
        if self._task == "track":
            angle = self._angle()
            self.target[:, 0], self.target[:, 1] = (
                TRACK_RADIUS_M * np.cos(angle),
                TRACK_RADIUS_M * np.sin(angle),
            )

    def _ask(self, actions: np.ndarray) -> None:
        """Ask the drones for actions (n, actions) within -1 .. 1."""
        batch = self.batch
        asked = actions * self._scale
        if batch.setpoint is not None:
            batch.setpoint.velocity[:], batch.setpoint.yaw_rate[:] = asked[:, 0:3], asked[:, 3]
        elif batch.wrench is not None:
            batch.wrench[:] = asked
            batch.wrench[:, 0] += self._scale[0]
        elif batch.rotor_commands is not None:
            hover = np.array(batch.vehicle.hover_speeds)
            batch.rotor_commands[:] = np.where(
                actions > 0.0, hover + asked, hover * (1.0 + actions)
            )

    def _observed(self) -> np.ndarray:
        """Return what is observed now (n, 18)."""
        batch, found = self.batch, np.empty((self.num_envs, OBSERVATION_SIZE), np.float32)
        found[:, 0:3] = self.target - batch.position
        found[:, 3:6] = -batch.velocity
        if self._task == "track":
            angle = self._angle()
            found[:, 3] -= TRACK_RADIUS_M * TRACK_TURN_RAD_S * np.sin(angle)
            found[:, 4] += TRACK_RADIUS_M * TRACK_TURN_RAD_S * np.cos(angle)
        R_WB = _rotations(batch.attitude)
        found[:, 6:15] = R_WB.reshape(-1, 9)
        found[:, 15:18] = np.einsum("nij,ni->nj", R_WB, batch.angular_velocity)
        return found


class DroneEnv(gymnasium.Env[np.ndarray, np.ndarray]):
    """One drone of `DroneVectorEnv`, which has the arguments; it resets when it is asked to."""

    metadata: dict[str, Any] = {"render_modes": []}

    def __init__(self, **arguments: Any) -> None:
        self._one = DroneVectorEnv(1, **arguments)
        self.action_space = self._one.single_action_space
        self.observation_space = self._one.single_observation_space

    @property
    def batch(self) -> Batch:
        """The flight."""
        return self._one.batch

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[np.ndarray, dict[str, Any]]:
        """Begin an episode, see `DroneVectorEnv.reset`."""
        super().reset(seed=seed)
        observed, more = self._one.reset(seed=seed)
        return observed[0], more

    def step(self, action: np.ndarray) -> tuple[np.ndarray, float, bool, bool, dict[str, Any]]:
        """Fly on for a step, see `DroneVectorEnv.step`."""
        observed, rewards, out, late, more = self._one.step(np.asarray(action)[None])
        return observed[0], float(rewards[0]), bool(out[0]), bool(late[0]), more


def _action_scale(batch: Batch, actions: str) -> np.ndarray:
    """Return what an action of 1 asks for, see `DroneVectorEnv` (actions) or (n, actions)."""
    vehicle = batch.vehicle
    if actions == "setpoint":
        names = ("max_speed", "max_speed", "max_climb_rate", "max_yaw_rate")
        return np.stack([batch.parameters[name] for name in names], axis=1)
    most = np.array([rotor.max_rot_velocity for rotor in vehicle.rotors])
    if actions == "rotors":
        return most - np.array(vehicle.hover_speeds)
    thrusts = np.array([rotor.max_thrust for rotor in vehicle.rotors])
    moments = np.abs(wrench_matrix(vehicle.rotors, vehicle.p_BoBcm_B)[3:]) @ thrusts
    return np.array([vehicle.mass * GRAVITY, *(0.5 * ACTION_MOMENT_SHARE * moments)])


def _attitude(heading: np.ndarray, axis: np.ndarray, tilt: np.ndarray) -> np.ndarray:
    """Return unit quaternions (n, 4) that turn to headings, and then about level axes [rad]."""
    c, s, h = np.cos(0.5 * tilt), np.sin(0.5 * tilt), 0.5 * heading
    turned = axis - h  # of a turn about an axis, followed by one about z
    return np.stack([c * np.cos(h), s * np.cos(turned), s * np.sin(turned), c * np.sin(h)], axis=1)


def _rotations(q_WB: np.ndarray) -> np.ndarray:
    """Return R_WB (n, 3, 3) of unit quaternions (n, 4)."""
    w, x, y, z = q_WB.T
    rows = (
        (1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)),
        (2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)),
        (2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)),
    )
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


for _task in TASKS:
    gymnasium.register(
        f"workbench/{_task.title()}-v0",
        entry_point="workbench.gym:DroneEnv",
        vector_entry_point="workbench.gym:DroneVectorEnv",
        kwargs={"task": _task},
    )
