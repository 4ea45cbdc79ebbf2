"""Mixer columns of up to eight motors, and their contributions to the wrench."""

from typing import Any

import numpy as np

from workbench.common.jitable import register_jitable

MOST = 8
"""Motors there may be."""
COLUMNS = ("roll", "pitch", "yaw", "thrust")
EFFECTS = ("f", "x", "y", "z")
NAMES = tuple(f"{name}_{k + 1}" for name in (*COLUMNS, *EFFECTS) for k in range(MOST)) + ("count",)
"""Of what `column_numbers` returns."""
LEAST = 1e-9
"""A motor whose moment is less than this share of the largest one counts as having none."""


def moment_shares(rotors: Any, most: float, mixer: str) -> np.ndarray:
    """Return columns (n, 4) that are the motors' moments over the largest one, and thrust of 1.

    Args:
        rotors: see `guidance.KnownRotor`.
        most: the largest entry of roll, of pitch and of yaw.
        mixer: whose it is, for the message.

    Raises:
        ValueError: if there are more motors than eight, or they cannot turn the vehicle.
    """
    moments = np.array([[each.m_x, each.m_y, each.m_z] for each in rotors])
    check_motors(np.column_stack([moments, [each.force for each in rotors]]), mixer)
    shares = moments / np.abs(moments).max(axis=0)
    shares[np.abs(shares) < LEAST] = 0.0
    return np.column_stack([most * shares, np.ones(len(rotors))])


def check_motors(effects: np.ndarray, mixer: str) -> None:
    """Check that there are not too many motors, and that they can make all moments and force.

    Args:
        effects: of each motor on moments and force (n, 4).
        mixer: whose it is, for the message.

    Raises:
        ValueError: if there are more motors than eight, or they cannot turn the vehicle.
    """
    if len(effects) > MOST:
        raise ValueError(f"{mixer} here is for {MOST} motors, and there are {len(effects)}")
    if np.linalg.matrix_rank(effects) < len(COLUMNS):
        raise ValueError("the rotors cannot make roll, pitch, yaw and thrust: check their places")


def column_numbers(rotors: Any, mix: np.ndarray) -> list[float]:
    """Return columns and effects of the motors, 0 where there is none, and how many there are.

    Args:
        rotors: see `guidance.KnownRotor`.
        mix: columns of roll, pitch, yaw and thrust (n, 4).
    """
    effects = np.array([[each.force, each.m_x, each.m_y, each.m_z] for each in rotors])
    padded = np.zeros((2 * len(COLUMNS), MOST))
    padded[:4, : len(rotors)], padded[4:, : len(rotors)] = mix.T, effects.T
    return [*padded.ravel().tolist(), float(len(rotors))]


@register_jitable(forceinline=True)
def columns(g: Any) -> Any:
    """Return the columns of roll, pitch, yaw and thrust, eight numbers each."""
    return (
        (g.roll_1, g.roll_2, g.roll_3, g.roll_4, g.roll_5, g.roll_6, g.roll_7, g.roll_8),
        (g.pitch_1, g.pitch_2, g.pitch_3, g.pitch_4, g.pitch_5, g.pitch_6, g.pitch_7, g.pitch_8),
        (g.yaw_1, g.yaw_2, g.yaw_3, g.yaw_4, g.yaw_5, g.yaw_6, g.yaw_7, g.yaw_8),
        (
            g.thrust_1,
            g.thrust_2,
            g.thrust_3,
            g.thrust_4,
            g.thrust_5,
            g.thrust_6,
            g.thrust_7,
            g.thrust_8,
        ),
    )


@register_jitable(forceinline=True)
def effects(g: Any) -> Any:
    """Return force and moments per thrust, eight numbers each."""
    return (
        (g.f_1, g.f_2, g.f_3, g.f_4, g.f_5, g.f_6, g.f_7, g.f_8),
        (g.x_1, g.x_2, g.x_3, g.x_4, g.x_5, g.x_6, g.x_7, g.x_8),
        (g.y_1, g.y_2, g.y_3, g.y_4, g.y_5, g.y_6, g.y_7, g.y_8),
        (g.z_1, g.z_2, g.z_3, g.z_4, g.z_5, g.z_6, g.z_7, g.z_8),
    )


@register_jitable(forceinline=True)
def with_motor(wrench: Any, i: Any, thrust: Any, by: Any) -> Any:
    """Return a wrench, F [N] and m [N·m], plus the contribution of motor i.

    Args:
        wrench: of the motors before (4).
        i: place of the motor.
        thrust: that it gives [N].
        by: see `effects`.
    """
    force, by_x, by_y, by_z = by
    return (
        wrench[0] + force[i] * thrust,
        wrench[1] + by_x[i] * thrust,
        wrench[2] + by_y[i] * thrust,
        wrench[3] + by_z[i] * thrust,
    )
