"""Motions known in closed form, and what an IMU gives of them that a filter integrates exactly."""

import numpy as np
from scipy.spatial.transform import Rotation

from tests.estimation.textbook import GRAVITY

PERIOD = 1 / 128


def hover(t):
    return np.stack([0.0 * t, 0.0 * t, 10.0 + 0.0 * t], axis=1)


def figure_eight(t):
    a = 2.0 * np.pi * t / 6.0
    return np.stack([4.0 * np.sin(a), 2.0 * np.sin(2.0 * a), 10.0 + 0.5 * np.cos(a)], axis=1)


def full_speed(t):
    a = 8.0 / 12.0 * t  # a circle of 12 m at 8 m/s
    return np.stack([12.0 * np.cos(a), 12.0 * np.sin(a), 10.0 + 0.0 * t], axis=1)


def made(path, duration):
    """Return attitudes, places and velocities (N + 1), and mean rates and forces (N) between.

    The attitude is the one that a multirotor needs, its heading turns slowly. Forces are those
    that make the velocities; places follow as the filter integrates them, to within a millimetre
    a second squared of the path.
    """
    count = round(duration / PERIOD)
    t = PERIOD * np.arange(count + 1)
    h = 1e-3
    v = (path(t + h) - path(t - h)) / (2.0 * h)
    a = (path(t + h) - 2.0 * path(t) + path(t - h)) / (h * h)
    up = a - GRAVITY
    up /= np.linalg.norm(up, axis=1, keepdims=True)
    ahead = np.stack([np.cos(0.3 * t), np.sin(0.3 * t), 0.0 * t], axis=1)
    left = np.cross(up, ahead)
    left /= np.linalg.norm(left, axis=1, keepdims=True)
    turns = Rotation.from_matrix(np.stack([np.cross(left, up), left, up], axis=2))
    w = (turns[:-1].inv() * turns[1:]).as_rotvec() / PERIOD
    middle = turns[:-1] * Rotation.from_rotvec(0.5 * PERIOD * w)
    pull = np.diff(v, axis=0) / PERIOD
    f = middle.inv().apply(pull - GRAVITY)
    p = np.vstack([path(t[:1]), path(t[:1]) + np.cumsum(PERIOD * (v[:-1] + v[1:]) / 2.0, axis=0)])
    return turns, p, v, w, f
