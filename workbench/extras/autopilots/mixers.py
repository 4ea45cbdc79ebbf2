"""Mixers of the autopilots, for up to eight motors: from torques and thrust to motor signals."""

from collections.abc import Callable, Iterable, Sequence
from typing import TypeVarTuple

import numpy as np

from workbench.common.jitable import give_unique_name, make_tuple_reader, register_jitable
from workbench.common.vectors import Numbers, Wrench
from workbench.control.guidance import Gains, KnownRotor
from workbench.plant.thrust_frame import ThrustFrame

Ts = TypeVarTuple("Ts")
EachMotor = tuple[float, float, float, float, float, float, float, float]
"""A number for each of eight motors."""
MixerColumns = tuple[Numbers, Numbers, Numbers, Numbers]
"""Eight numbers each: of roll, pitch, yaw and thrust, or of force and moments."""
Turns = tuple[float, float, float, float]
"""Roll, pitch, yaw and throttle."""

MAX_MIXER_MOTORS = 8
"""Maximum number of motors."""
MIXER_COLUMNS = ("roll", "pitch", "yaw", "thrust")
MIXER_EFFECTS = ("f", "x", "y", "z")
MIXER_NUMBER_NAMES = tuple(
    f"{name}_{k + 1}" for name in (*MIXER_COLUMNS, *MIXER_EFFECTS) for k in range(MAX_MIXER_MOTORS)
) + ("count",)
"""Names of the numbers of `column_numbers`."""
MIN_MOMENT_SHARE = 1e-9
"""A moment below this share of the largest one counts as zero."""
DEFAULTS_VALID_RATIO = 1.6
"""A vehicle within this factor of what an autopilot's defaults are for flies with them."""
TORQUE_SCALE_NAMES = ("roll_scale", "pitch_scale", "yaw_scale")
"""Torque in a column's unit over the moment for a thrust of 1 at each motor [1/m]."""


def moment_shares(rotors: Sequence[KnownRotor], most: float, mixer: str) -> np.ndarray:
    """Return the columns (n, 4) of Betaflight's and ArduPilot's mixers.

    They are the motors' moments in T over the largest one, times `most`, and 1 for throttle.

    Args:
        rotors: see `guidance.KnownRotor`.
        most: largest entry of roll, of pitch and of yaw: 1 in Betaflight, 0.5 in ArduPilot.
        mixer: its name, for the message.

    Raises:
        ValueError: if there are more than eight motors, or they cannot turn the vehicle.
    """
    moments = np.array([[each.m_x, each.m_y, each.m_z] for each in rotors])
    check_motors(np.column_stack([moments, [each.force for each in rotors]]), mixer)
    shares = moments / np.abs(moments).max(axis=0)
    shares[np.abs(shares) < MIN_MOMENT_SHARE] = 0.0
    return np.column_stack([most * shares, np.ones(len(rotors))])


def hover_authority(
    rotors: Sequence[KnownRotor],
    frame: ThrustFrame,
    mix: np.ndarray,
    *per_signal: float | np.ndarray,
) -> np.ndarray:
    """Return angular accelerations (3) and vertical force for a unit of each column, in hover.

    Args:
        rotors: see `guidance.KnownRotor`.
        frame: of the vehicle.
        mix: columns of roll, pitch, yaw and thrust (n, 4).
        per_signal: factors of the slope of a motor's speed over its signal, or of each motor's (n)
            [rad/s].

    Returns:
        [rad/s²] about x, y and z of T, and [N].
    """
    constants = np.array([each.motor_constant for each in rotors])
    linear = np.array([each.linear_speed for each in rotors])
    slopes = constants * (2.0 * frame.hover_speeds + linear)
    for factor in per_signal:
        slopes = slopes * factor
    effects = np.array([[each.m_x, each.m_y, each.m_z, each.force] for each in rotors])
    found = (effects * mix * slopes[:, None]).sum(axis=0)
    return found / [*np.diagonal(frame.inertia_T), 1.0]


def flies_with_defaults(own: Iterable[float], reference: Iterable[float]) -> list[bool]:
    """Return for each effect of a vehicle whether it is near that which defaults are for."""
    pairs = zip(own, reference, strict=True)
    return [1.0 / DEFAULTS_VALID_RATIO < a / b < DEFAULTS_VALID_RATIO for a, b in pairs]


def check_motors(effects: np.ndarray, mixer: str) -> None:
    """Check the number of motors, and that they can make all moments and the force.

    Args:
        effects: of each motor on moments and force (n, 4).
        mixer: its name, for the message.

    Raises:
        ValueError: if there are more than eight motors, or they cannot turn the vehicle.
    """
    if len(effects) > MAX_MIXER_MOTORS:
        raise ValueError(
            f"{mixer} here is for {MAX_MIXER_MOTORS} motors, and there are {len(effects)}"
        )
    if np.linalg.matrix_rank(effects) < len(MIXER_COLUMNS):
        raise ValueError("the rotors cannot make roll, pitch, yaw and thrust: check their places")


def column_numbers(rotors: Sequence[KnownRotor], mix: np.ndarray) -> list[float]:
    """Return columns and effects of eight motors, 0 for missing ones, and the number of motors.

    Args:
        rotors: see `guidance.KnownRotor`.
        mix: columns of roll, pitch, yaw and thrust (n, 4).
    """
    effects = np.array([[each.force, each.m_x, each.m_y, each.m_z] for each in rotors])
    padded = np.zeros((2 * len(MIXER_COLUMNS), MAX_MIXER_MOTORS))
    padded[:4, : len(rotors)], padded[4:, : len(rotors)] = mix.T, effects.T
    return [*padded.ravel().tolist(), float(len(rotors))]


def per_motor(function: Callable[[int, *Ts], float]) -> Callable[[*Ts], EachMotor]:
    """Return a function that returns what `function(i, ...)` returns for each motor (8).

    numba makes no tuple in a loop.
    """

    @register_jitable(forceinline=True)
    def run(*args: *Ts) -> EachMotor:
        return (
            function(0, *args),
            function(1, *args),
            function(2, *args),
            function(3, *args),
            function(4, *args),
            function(5, *args),
            function(6, *args),
            function(7, *args),
        )

    return give_unique_name(run, function.__name__)


_roll, _pitch, _yaw, _thrust, _force, _moment_x, _moment_y, _moment_z = (
    make_tuple_reader([f"{name}_{k + 1}" for k in range(MAX_MIXER_MOTORS)], name)
    for name in (*MIXER_COLUMNS, *MIXER_EFFECTS)
)


@register_jitable(forceinline=True)
def mixer_columns(g: Gains) -> MixerColumns:
    """Return the columns of roll, pitch, yaw and thrust, eight numbers each."""
    return _roll(g), _pitch(g), _yaw(g), _thrust(g)


@register_jitable(forceinline=True)
def effects_per_thrust(g: Gains) -> MixerColumns:
    """Return force and moments per thrust, eight numbers each."""
    return _force(g), _moment_x(g), _moment_y(g), _moment_z(g)


@register_jitable(forceinline=True)
def with_motor(wrench: Wrench, i: int, thrust: float, by: MixerColumns) -> Wrench:
    """Return a wrench, F [N] and m [N·m], plus the contribution of motor i.

    Args:
        wrench: of the previous motors (4).
        i: index of the motor.
        thrust: of the motor [N].
        by: see `effects_per_thrust`.
    """
    force, by_x, by_y, by_z = by
    return (
        wrench[0] + force[i] * thrust,
        wrench[1] + by_x[i] * thrust,
        wrench[2] + by_y[i] * thrust,
        wrench[3] + by_z[i] * thrust,
    )
