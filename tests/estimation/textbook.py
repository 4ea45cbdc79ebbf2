"""An error-state Kalman filter as the textbook has it: whole matrices, and scipy's rotations.

After J. Solà, Quaternion kinematics for the error-state Kalman filter, arXiv:1711.02508, chapters 5
and 6, with local angular errors. Every Jacobian is a central difference of the function that it is
of, called once for all errors; measurements of one time come in as one vector, in Joseph's form.
"""

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

GRAVITY = np.array([0.0, 0.0, -9.81])
STEP = 1e-6


@dataclass
class State:
    """Attitude, place and velocity of the IMU in the world, biases of gyro and accelerometer."""

    turn: Rotation
    p: np.ndarray
    v: np.ndarray
    b_g: np.ndarray
    b_a: np.ndarray

    def plus(self, error):
        """Return the state with an error (15) composed, or states with many (N, 15)."""
        angle, p, v, b_g, b_a = np.split(np.asarray(error, dtype=float), 5, axis=-1)
        turn = self.turn * Rotation.from_rotvec(angle)
        return State(turn, self.p + p, self.v + v, self.b_g + b_g, self.b_a + b_a)

    def minus(self, other):
        """Return the error (15) that composed with `other` gives this."""
        angle = (other.turn.inv() * self.turn).as_rotvec()
        rest = (self.p - other.p, self.v - other.v, self.b_g - other.b_g, self.b_a - other.b_a)
        return np.concatenate([angle, *rest], axis=-1)


def moved(state, w, f, dt):
    """Return the state after a period of mean rates and specific forces."""
    rate, force = w - state.b_g, f - state.b_a
    middle = state.turn * Rotation.from_rotvec(0.5 * dt * rate)
    a = middle.apply(force) + GRAVITY
    return State(
        state.turn * Rotation.from_rotvec(dt * rate),
        state.p + dt * state.v + 0.5 * dt * dt * a,
        state.v + dt * a,
        state.b_g,
        state.b_a,
    )


def difference(function, size=15):
    """Return the Jacobian at 0 of a function of errors (N, size)."""
    steps = STEP * np.eye(size)
    ahead, back = np.split(function(np.concatenate([steps, -steps])), 2)
    return (ahead - back).T / (2.0 * STEP)


class TextbookFilter:
    """Predicts and corrects; `measure` gives what sensors should say of a state."""

    def __init__(self, state, P, densities):
        self.state, self.P = state, np.array(P, dtype=float)
        self.gyro, self.accel, self.gyro_walk, self.accel_walk = densities

    def predict(self, w, f, dt):
        before = self.state
        after = moved(before, w, f, dt)
        F = difference(lambda e: moved(before.plus(e), w, f, dt).minus(after))
        Q = np.zeros((15, 15))
        one = np.eye(3)
        Q[0:3, 0:3] = self.gyro**2 * dt * one
        # white noise of acceleration through the double integrator, exactly
        Q[3:6, 3:6] = self.accel**2 * dt**3 / 3.0 * one
        Q[3:6, 6:9] = Q[6:9, 3:6] = self.accel**2 * dt**2 / 2.0 * one
        Q[6:9, 6:9] = self.accel**2 * dt * one
        Q[9:12, 9:12] = self.gyro_walk**2 * dt * one
        Q[12:15, 12:15] = self.accel_walk**2 * dt * one
        self.state, self.P = after, F @ self.P @ F.T + Q

    def correct(self, measure, said, variances, expected):
        """Take in numbers that sensors said.

        `measure(state)` is what they should have said; `expected` the same of sensors without
        noise, of which the Jacobian is.
        """
        before = self.state
        H = difference(lambda e: expected(before.plus(e)))
        R = np.diag(variances)
        S = H @ self.P @ H.T + R
        K = self.P @ H.T @ np.linalg.inv(S)
        self.state = before.plus(K @ (said - measure(before)))
        rest = np.eye(15) - K @ H
        self.P = rest @ self.P @ rest.T + K @ R @ K.T
