"""Signals of a flight that a spec can name.

Those of the recording are in `RECORDED_SIGNALS`. A name with a dot is that of a sensor: `imu.f_z`
is the last sample of the sensor `imu` at each time of the recording. Or it is of a part that only
some vehicles have: `joint.arm_q`, `joint_setpoint.arm`, `tension.sling`, `contact.leg1_link.z`.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import partial

import numpy as np

from workbench.common.errors import WorkbenchError, find_named_row, unknown_name
from workbench.design.step_response import unwrapped_yaw
from workbench.parameters.flight_parameters import MAX_WEAKENED_ROTORS
from workbench.plant.vehicle import Vehicle
from workbench.scenario.attitude_axes import tilt_angles
from workbench.scenario.loads import LOAD_RESPONSES, LOAD_ROWS
from workbench.session.recording import PART_FIELDS, Recording, part_signals
from workbench.systems.sensors.samples import RecordedSamples

ROTOR_USE_INPUT = "use"
"""Name in `RecordedSignal.reads` for the speeds of rotors, or commanded shares of them in a log."""
SENSOR_SEPARATOR = "."
"""Separator between the name of a sensor and the channel of its samples."""
DELIVERY_TOLERANCE_S = 1e-9
"""Tolerance of delivery times, as sums of periods have rounding errors [s]."""


@dataclass(frozen=True)
class RecordedSignal:
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


def find_signal(name: str) -> RecordedSignal:
    """Return the signal with a name.

    Raises:
        WorkbenchError: if there is none.
    """
    return find_named_row("signal", name, RECORDED_SIGNALS)


def sensor_signal(name: str, samples: Iterable[RecordedSamples]) -> RecordedSignal:
    """Return the signal of a sensor's name and a channel of its samples.

    Args:
        name: such as `imu.f_z`.
        samples: of the sensors in the flight.

    Raises:
        WorkbenchError: if there is no such sensor or channel; the signal raises it, too, if the
            sensor has not delivered anything by the requested time.
    """
    sensor, _, channel_name = name.partition(SENSOR_SEPARATOR)
    found = {each.sensor: each for each in samples}
    if not found:
        raise WorkbenchError(
            f"there is no signal '{name}': name the sensor in the spec's sensors, use"
        )
    if sensor not in found:
        raise unknown_name("sensor of this flight", sensor, found)
    channel = find_named_row(f"signal of '{sensor}'", channel_name, found[sensor].channels)
    delivered = found[sensor].stamps + found[sensor].latency

    def held(recording: Recording) -> np.ndarray:
        last = np.searchsorted(delivered, recording.time + DELIVERY_TOLERANCE_S, side="right") - 1
        if len(last) and last[0] < 0:
            when = f"first at {delivered[0]:.3g} s" if len(delivered) else "not at all"
            raise WorkbenchError(
                f"'{sensor}' delivers {when}, but is judged from {recording.time[0]:.3g} s on: "
                "give the case a later edge"
            )
        return channel.values[last]

    return RecordedSignal(name, channel.unit, held)


def is_part_signal(name: str) -> bool:
    """Return whether a signal is one of joints, servos, cables or contacts."""
    return name.partition(SENSOR_SEPARATOR)[0] in PART_FIELDS


def part_signal(name: str, vehicle: Vehicle) -> RecordedSignal:
    """Return the signal of such a part, named as in the table of a recording.

    Args:
        name: such as `joint.arm_q`.
        vehicle: the flying one.

    Raises:
        WorkbenchError: if it has no such part.
    """
    group, _, part = name.partition(SENSOR_SEPARATOR)
    _, field, rows = next(each for each in part_signals(vehicle) if each[0] == group)
    names = [each for each, _ in rows]
    if part not in names:
        raise unknown_name(f"{group} of {vehicle.name}", part, names)
    index = names.index(part)
    return RecordedSignal(
        name, rows[index][1], lambda recording: getattr(recording, field)[:, index], (field,)
    )


def _recorded_column(recording: Recording, field: str, index: int) -> np.ndarray:
    columns: np.ndarray = getattr(recording, field)
    if index >= columns.shape[1]:
        raise WorkbenchError(
            f"{recording.vehicle.name} has {columns.shape[1]} rotors: there is no signal of "
            f"rotor {index + 1}"
        )
    return columns[:, index]


def _recorded_vector(name: str, unit: str, field: str) -> list[RecordedSignal]:
    """Return the three components of a recorded vector in W."""
    reads = ("thrusts", "q_WB") if field == "force_W" else (field,)
    return [
        RecordedSignal(
            f"{name}_{axis}", unit, partial(_recorded_column, field=field, index=index), reads
        )
        for index, axis in enumerate("xyz")
    ]


def _recorded_rotors(name: str, unit: str, field: str) -> list[RecordedSignal]:
    return [
        RecordedSignal(
            f"{name}_{number + 1}",
            unit,
            partial(_recorded_column, field=field, index=number),
            (field,),
        )
        for number in range(MAX_WEAKENED_ROTORS)
    ]


RECORDED_SIGNALS: tuple[RecordedSignal, ...] = (
    *_recorded_vector("v", "m/s", "v_WB"),
    RecordedSignal("yaw_rate", "rad/s", lambda flown: flown.w_WB[:, 2], ("w_WB",)),
    *_recorded_vector("p", "m", "p_WB"),
    RecordedSignal("roll", "rad", lambda flown: tilt_angles(flown.q_WB)[0], ("q_WB",)),
    RecordedSignal("pitch", "rad", lambda flown: tilt_angles(flown.q_WB)[1], ("q_WB",)),
    RecordedSignal("yaw", "rad", lambda flown: unwrapped_yaw(flown.q_WB), ("q_WB",)),
    RecordedSignal("tilt", "rad", lambda flown: flown.tilt, ("q_WB",)),
    *_recorded_vector("w", "rad/s", "w_WB"),
    *_recorded_vector("a", "m/s^2", "vdot_WB"),
    *_recorded_vector("force", "N", "force_W"),
    RecordedSignal("thrust", "N", lambda flown: flown.total_thrust, ("thrusts",)),
    RecordedSignal("rotor_use", "1", lambda flown: flown.rotor_use, (ROTOR_USE_INPUT,)),
    RecordedSignal("charge", "1", lambda flown: flown.charge, ("charge",)),
    *_recorded_rotors("speed", "rad/s", "rotor_speeds"),
    *_recorded_rotors("thrust", "N", "thrusts"),
)
"""v, p, w, a and force in W: velocity, position, angular velocity, acceleration, total force of
rotors; a thrust is the mean over the past control period.
"""
_MOTION_SIGNALS = dict(
    zip(LOAD_RESPONSES, ("p_x", "p_y", "p_z", "roll", "pitch", "yaw_rate"), strict=True)
)
AXIS_SIGNALS = {"x": "v_x", "y": "v_y", "z": "v_z", "yaw": "yaw_rate"} | {
    row.name: _MOTION_SIGNALS[row.response] for row in LOAD_ROWS
}
"""The signals of steps along each axis, and of responses to loads."""
