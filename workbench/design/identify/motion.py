"""What a vehicle's model says of a flight: accelerations and specific forces from its commands.

The rotors follow the commands from the log (`dynamics.rotor_response`); with their speeds, and the
angular velocity and velocity that were measured, `dynamics.vehicle_step` has force and moment,
`dynamics.rigid_body` the accelerations, and `estimation.imu` what the accelerometer shows. All of
it is the source that flies.
"""

import math
from typing import Any

import numpy as np

from workbench.common.compiled import compile_cached
from workbench.dynamics.rigid_body import accelerations
from workbench.dynamics.rotor_response import step_rotor, within
from workbench.dynamics.vehicle_step import ANSWER, ROW, vehicle_wrench
from workbench.estimation.imu import measured

SOURCES = ("design/identify/motion.py", "dynamics", "estimation")
FAR = 1e6
"""Above the ground, which has no effect there [m]."""


def _follow(commands: Any, rotors: Any, period: float, speeds: Any, slopes: Any) -> None:
    """Write speeds in the middle of every step, and their mean slopes, that follow commands.

    A slope jumps with the command: its mean is what spins the body up.

    Args:
        commands: (N, n) held from each sample to the next [rad/s].
        rotors: rows of `rotor_rows` for the period.
        period: between samples [s].
        speeds: (N, n) places [rad/s]; the first row is where they begin.
        slopes: (N, n) places [rad/s²].
    """
    for i in range(commands.shape[1]):
        constants = rotors[i][ANSWER:ROW]
        speed = speeds[0, i]
        for k in range(len(commands)):
            command = within(commands[k, i], constants[0])
            speeds[k, i], _, end = step_rotor(command, speed, constants)
            slopes[k, i] = (end - speed) / period
            speed = end


def _answers(
    speeds: Any, slopes: Any, gyro: Any, velocity: Any, pressure: float, body: Any, rotors: Any,
    p_BI: Any, alpha: Any, force: Any,
) -> None:  # fmt: skip
    """Write angular accelerations (N, 3) [rad/s²] and specific forces at p_BI (N, 3) [m/s²]."""
    n = speeds.shape[1]
    shares = np.ones(n)
    still = np.zeros(3)
    none = np.zeros(6)
    level = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)
    state = np.zeros(13)
    state[0] = 1.0
    acceleration = np.zeros(6)
    for k in range(len(speeds)):
        wrench = vehicle_wrench(
            level,
            gyro[k],
            velocity[k],
            FAR,
            speeds[k],
            slopes[k],
            shares,
            still,
            pressure,
            body[13:16],
            rotors,
        )
        six = accelerations(
            level, gyro[k], none, 0.0, wrench, body[0], body[1:7], body[7:13], body[13:16]
        )
        for i in range(3):
            state[7 + i] = gyro[k, i]
            acceleration[i] = six[i]
            acceleration[3 + i] = six[3 + i]
        shown = measured(state, acceleration, p_BI)
        for i in range(3):
            alpha[k, i] = six[i]
            force[k, i] = shown[3 + i]


compiled_follow = compile_cached(_follow, SOURCES, "the rotors of a log", nogil=True)
compiled_answers = compile_cached(_answers, SOURCES, "the motion of a log", nogil=True)


def shifted(values: np.ndarray, late: float) -> np.ndarray:
    """Return samples (N, ...) as they were so many periods before, between samples on lines."""
    whole = math.floor(late)
    share = late - whole
    rows = np.arange(len(values))
    first = values[np.clip(rows - whole, 0, len(values) - 1)]
    second = values[np.clip(rows - whole - 1, 0, len(values) - 1)]
    return (1.0 - share) * first + share * second
