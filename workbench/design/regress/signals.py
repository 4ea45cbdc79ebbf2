"""Signals of a flight that a spec can name."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from workbench.common.errors import WorkbenchError, find_row
from workbench.design.step_response import unwrapped_yaw
from workbench.scenario.parameters import MOST_ROTORS
from workbench.session.recording import Recording


@dataclass(frozen=True)
class Signal:
    """A signal: its name, its unit, and how it is read off a recording as (N)."""

    name: str
    unit: str
    of: Callable[[Recording], np.ndarray]


def find_signal(name: str) -> Signal:
    """Return the signal of a name.

    Raises:
        WorkbenchError: if there is none.
    """
    return find_row("signal", name, SIGNALS)


def _roll(recording: Recording) -> np.ndarray:
    w, x, y, z = recording.q_WB.T
    return np.arctan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y))


def _pitch(recording: Recording) -> np.ndarray:
    w, x, y, z = recording.q_WB.T
    return np.arcsin(np.clip(2 * (w * y - x * z), -1.0, 1.0))


def _column(recording: Recording, field: str, index: int) -> np.ndarray:
    columns: np.ndarray = getattr(recording, field)
    if index >= columns.shape[1]:
        raise WorkbenchError(
            f"{recording.vehicle.name} has {columns.shape[1]} rotors: there is no signal of "
            f"rotor {index + 1}"
        )
    return columns[:, index]


def _vector(name: str, unit: str, field: str) -> list[Signal]:
    """Return the three components of a recorded vector in W."""
    return [
        Signal(f"{name}_{axis}", unit, partial(_column, field=field, index=index))
        for index, axis in enumerate("xyz")
    ]


def _rotors(name: str, unit: str, field: str) -> list[Signal]:
    return [
        Signal(f"{name}_{number + 1}", unit, partial(_column, field=field, index=number))
        for number in range(MOST_ROTORS)
    ]


SIGNALS: tuple[Signal, ...] = (
    *_vector("v", "m/s", "v_WB"),
    Signal("yaw_rate", "rad/s", lambda flown: flown.w_WB[:, 2]),
    *_vector("p", "m", "p_WB"),
    Signal("roll", "rad", _roll),
    Signal("pitch", "rad", _pitch),
    Signal("yaw", "rad", lambda flown: unwrapped_yaw(flown.q_WB)),
    Signal("tilt", "rad", lambda flown: flown.tilt),
    *_vector("w", "rad/s", "w_WB"),
    *_vector("a", "m/s^2", "vdot_WB"),
    *_vector("force", "N", "force_W"),
    Signal("thrust", "N", lambda flown: flown.total_thrust),
    Signal("rotor_use", "1", lambda flown: flown.rotor_use),
    *_rotors("speed", "rad/s", "rotor_speeds"),
    *_rotors("thrust", "N", "thrusts"),
)
"""v, p, w, a and force in W: velocity, position, angular velocity, acceleration, force of all
rotors; a thrust is the mean over the control period that ends."""
AXIS_SIGNALS = {"x": "v_x", "y": "v_y", "z": "v_z", "yaw": "yaw_rate"}
"""What a step along or about an axis commands."""
