"""Environments for learning; the oracle of their order is Gymnasium's own vector environment."""

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from gymnasium.vector import SyncVectorEnv

from workbench.common.errors import WorkbenchError
from workbench.gym import TASKS, DroneEnv, DroneVectorEnv

SHORT = 40
"""Steps in an episode."""


@pytest.mark.filterwarnings("ignore:.*A Box observation space m:UserWarning")
@pytest.mark.parametrize(
    "actions", ["setpoint", "rotors", pytest.param("wrench", marks=pytest.mark.slow)]
)
def test_gymnasiums_checker_finds_nothing(actions):
    for task in TASKS:
        env = gymnasium.make(f"workbench.gym:workbench/{task.title()}-v0", actions=actions)
        check_env(env.unwrapped, skip_render_check=True)


def test_resets_are_those_of_gymnasiums_own_vector_environment():
    """Rotor commands that tumble it, and others, so that episodes end by loss and by length."""
    arguments = {"task": "track", "actions": "rotors", "max_episode_steps": SHORT}
    theirs = SyncVectorEnv([lambda: DroneEnv(**arguments)])
    ours = DroneVectorEnv(1, **arguments)
    assert ours.metadata["autoreset_mode"] == theirs.metadata["autoreset_mode"]
    assert ours.single_action_space == theirs.single_action_space
    assert ours.observation_space == theirs.observation_space
    rng = np.random.default_rng(1)
    first, other = ours.reset(seed=3)[0], theirs.reset(seed=3)[0]
    assert np.array_equal(first, other)
    ends = np.zeros(2, dtype=int)
    for step in range(240):
        action = rng.uniform(-0.1, 0.1, (1, 4)).astype(np.float32)
        if step % 120 < 60:
            action[0, :2] += 0.8
        for one, two in zip(ours.step(action)[:4], theirs.step(action)[:4], strict=True):
            assert np.array_equal(one, two)
            assert np.shape(one) == np.shape(two)
        ends += ours._ended[0], ours._ended[0] and ours._age[0] < SHORT
    assert ends.min() > 1  # and some of each


def test_what_is_observed_and_rewarded_is_what_flies():
    env = DroneVectorEnv(3, task="hover")
    seen, _ = env.reset(seed=0)
    assert env.observation_space.contains(seen)
    batch, way = env.batch, seen[:, 0:3]
    assert way == pytest.approx([0.0, 0.0, 10.0] - batch.position, abs=1e-6)
    assert seen[:, 3:6] == pytest.approx(-batch.velocity, abs=1e-6)
    R_WB = seen[:, 6:15].reshape(3, 3, 3)
    assert R_WB @ R_WB.transpose(0, 2, 1) == pytest.approx(np.tile(np.eye(3), (3, 1, 1)), abs=1e-6)
    assert R_WB[:, 2, 2].min() > np.cos(0.4) and np.linalg.det(R_WB) == pytest.approx(1.0)
    w_B = (R_WB.transpose(0, 2, 1) @ batch.angular_velocity[:, :, None])[:, :, 0]
    assert seen[:, 15:18] == pytest.approx(w_B, abs=1e-6)
    seen, rewards, terminated, truncated, _ = env.step(np.zeros((3, 4)))
    assert rewards == pytest.approx(1.0 - np.linalg.norm(seen[:, 0:3], axis=1) / 4.0)
    assert not terminated.any() and not truncated.any()
    batch.position[1] += [5.0, 0.0, 0.0]
    batch.state[2, 0] = np.nan
    _, rewards, terminated, *_ = env.step(np.zeros((3, 4)))
    assert terminated.tolist() == [False, True, True] and rewards[1:].tolist() == [0.0, 0.0]
    seen, rewards, terminated, *_ = env.step(np.zeros((3, 4)))
    assert not terminated.any() and rewards[1:].tolist() == [0.0, 0.0] and rewards[0] > 0.0
    assert batch.time[1:].tolist() == [0.0, 0.0] and np.isfinite(seen).all()


def test_a_drone_that_is_led_follows():
    """By the law's own velocities: the way to the target and its speed."""
    env = gymnasium.make_vec("workbench.gym:workbench/Track-v0", num_envs=32, max_episode_steps=96)
    seen, _ = env.reset(seed=0)
    for step in range(96):
        fastest = env.unwrapped.batch.parameters["max_speed"][0]
        wanted = 1.5 * seen[:, 0:3] + seen[:, 3:6] + env.unwrapped.batch.velocity
        action = np.clip(np.column_stack([wanted / fastest, np.zeros(32)]), -1.0, 1.0)
        seen, rewards, terminated, truncated, _ = env.step(action)
        assert not terminated.any() and truncated.all() == (step == 95)
    assert rewards.min() > 0.9


def test_what_makes_no_environment_is_said(case):
    table = [
        ({"task": "land"}, "'land'.*hover"),
        ({"periods": 0}, "0 control periods"),
        ({"periods": 1.5}, "1.5 control periods"),
        ({"max_episode_steps": 0}, "0 steps"),
        ({"actions": "thrust"}, "thrust"),
    ]
    for arguments, said in table:
        with case(said), pytest.raises(WorkbenchError, match=said):
            DroneVectorEnv(2, **arguments)
    env = DroneVectorEnv(2)
    env.reset(seed=1)
    for actions in (np.zeros((3, 4)), np.zeros(4), np.full((2, 4), np.nan), "up"):
        with case(actions), pytest.raises(WorkbenchError, match=r"give an array \(2, 4\)"):
            env.step(actions)
