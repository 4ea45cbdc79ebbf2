"""Signals of a flight that a spec can name.

Those of the recording are in `SIGNALS`. A name with a dot is that of a sensor: `imu.f_z` is the
last sample of the sensor `imu` at each time of the recording.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import partial

import numpy as np

from workbench.common.errors import WorkbenchError, find_row, unknown_name
from workbench.design.step_response import unwrapped_yaw
from workbench.scenario.loads import LOAD_ROWS, MOTIONS
from workbench.scenario.parameters import MOST_ROTORS
from workbench.session.recording import Recording
from workbench.systems.sensors.samples import Samples

USE = "use"
"""Name in `Signal.reads` for the speeds of rotors, or commanded shares of them in a log."""
POINT = "."
"""Separator between the name of a sensor and the channel of its samples."""
LATE = 1e-9
"""Tolerance of delivery times, as sums of periods have rounding errors [s]."""


@dataclass(frozen=True)
class Signal:
    """A signal.

    Attributes:
        name: its own.
        unit: SI.
        of: returns its values (N) from a recording.
        reads: arrays of the recording used, which a log may lack.
    """

    name: str
    unit: str
    of: Callable[[Recording], np.ndarray]
    reads: tuple[str, ...] = ()


def find_signal(name: str) -> Signal:
    """Return the signal with a name.

    Raises:
        WorkbenchError: if there is none.
    """
    return find_row("signal", name, SIGNALS)


def sensor_signal(name: str, samples: Iterable[Samples]) -> Signal:
    """Return the signal of a sensor's name and a channel of its samples.

    Args:
        name: such as `imu.f_z`.
        samples: of the sensors in the flight.

    Raises:
        WorkbenchError: if there is no such sensor or channel; the signal raises it, too, if the
            sensor has not delivered anything by the requested time.
    """
    sensor, _, channel_name = name.partition(POINT)
    found = {each.sensor: each for each in samples}
    if not found:
        raise WorkbenchError(
            f"there is no signal '{name}': name the sensor in the spec's sensors, use"
        )
    if sensor not in found:
        raise unknown_name("sensor of this flight", sensor, found)
    channel = find_row(f"signal of '{sensor}'", channel_name, found[sensor].channels)
    delivered = found[sensor].stamps + found[sensor].latency

    def held(recording: Recording) -> np.ndarray:
        last = np.searchsorted(delivered, recording.time + LATE, side="right") - 1
        if len(last) and last[0] < 0:
            when = f"first at {delivered[0]:.3g} s" if len(delivered) else "not at all"
            raise WorkbenchError(
                f"'{sensor}' delivers {when}, but is judged from {recording.time[0]:.3g} s on: "
                "give the case a later edge"
            )
        return channel.values[last]

    return Signal(name, channel.unit, held)


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
    reads = ("thrusts", "q_WB") if field == "force_W" else (field,)
    return [
        Signal(f"{name}_{axis}", unit, partial(_column, field=field, index=index), reads)
        for index, axis in enumerate("xyz")
    ]


def _rotors(name: str, unit: str, field: str) -> list[Signal]:
    return [
        Signal(f"{name}_{number + 1}", unit, partial(_column, field=field, index=number), (field,))
        for number in range(MOST_ROTORS)
    ]


SIGNALS: tuple[Signal, ...] = (
    *_vector("v", "m/s", "v_WB"),
    Signal("yaw_rate", "rad/s", lambda flown: flown.w_WB[:, 2], ("w_WB",)),
    *_vector("p", "m", "p_WB"),
    Signal("roll", "rad", _roll, ("q_WB",)),
    Signal("pitch", "rad", _pitch, ("q_WB",)),
    Signal("yaw", "rad", lambda flown: unwrapped_yaw(flown.q_WB), ("q_WB",)),
    Signal("tilt", "rad", lambda flown: flown.tilt, ("q_WB",)),
    *_vector("w", "rad/s", "w_WB"),
    *_vector("a", "m/s^2", "vdot_WB"),
    *_vector("force", "N", "force_W"),
    Signal("thrust", "N", lambda flown: flown.total_thrust, ("thrusts",)),
    Signal("rotor_use", "1", lambda flown: flown.rotor_use, (USE,)),
    Signal("charge", "1", lambda flown: flown.charge, ("charge",)),
    *_rotors("speed", "rad/s", "rotor_speeds"),
    *_rotors("thrust", "N", "thrusts"),
)
"""v, p, w, a and force in W: velocity, position, angular velocity, acceleration, total force of
rotors; a thrust is the mean over the past control period.
"""
_MOVED = dict(zip(MOTIONS, ("p_x", "p_y", "p_z", "roll", "pitch", "yaw_rate"), strict=True))
AXIS_SIGNALS = {"x": "v_x", "y": "v_y", "z": "v_z", "yaw": "yaw_rate"} | {
    row.name: _MOVED[row.response] for row in LOAD_ROWS
}
"""The signals of steps along each axis, and of responses to loads."""
