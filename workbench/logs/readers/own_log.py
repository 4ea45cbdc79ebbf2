"""Our own logs as flight records: those of simulated flights, and those that were imported."""

import numpy as np

from workbench.common.errors import WorkbenchError
from workbench.logs.flight_record import FlightRecord, Signal, make_signal
from workbench.logs.imported import flight_of
from workbench.logs.readers.rotations import QUATERNION, continuous, in_world
from workbench.logs.record import LogRecord

FORMAT = "workbench log"
_TOPICS = (
    "position_data",
    "velocity_data",
    "acceleration_data",
    "force_torque_data",
    "command_velocity",
    "rotors",
    "imu",
    "gps",
    "gps_velocity",
    "magnetometer",
    "estimate",
    "wind",
)
"""Whose numbers are signals."""
_UNWANTED = ("covariance", "lease", "axes", "frame", "orientation", "status")


def flight_record(record: LogRecord) -> FlightRecord:
    """Return a log as a flight record; the true motion is the simulation's.

    Raises:
        WorkbenchError: if a message cannot be decoded.
    """
    try:
        return flight_of(record) if record.imported else _flown(record)
    except WorkbenchError as error:  # of a damaged topic, which does not know its file
        said = str(error)
        raise WorkbenchError(
            said if said.startswith(str(record.path)) else f"{record.path}: {said}"
        ) from error


def _flown(record: LogRecord) -> FlightRecord:
    """Return the log of a flight of ours."""
    end = record.duration
    signals: dict[str, Signal] = {}
    for name in _TOPICS:
        topic = record.topics.get(name)
        for series in topic.columns.values() if topic else ():
            numbers = series.values.dtype.kind in "fiu"
            if numbers and not any(part in series.name for part in _UNWANTED):
                signals[series.name] = make_signal(
                    series.name, series.unit, series.time, series.values, end=end, delay=0.0
                )
    states, time = record.states, np.array(record.state_ns, dtype=float) * 1e-9
    if len(states):
        q = continuous(states[:, 0:4])
        back = q * [1.0, -1.0, -1.0, -1.0]
        for field, values in zip(QUATERNION, q.T, strict=True):
            name = f"attitude.{field}"
            signals[name] = make_signal(name, "1", time, values, end=end, delay=0.0)
        for axis, values in zip("xyz", in_world(back, states[:, 7:10]).T, strict=True):
            name = f"attitude.w_{axis}"
            signals[name] = make_signal(name, "rad/s", time, values, end=end, delay=0.0)
    points = _points(record, time)
    if points is not None:
        for axis, values in zip("xyz", points.T, strict=True):
            name = f"setpoint.{axis}"
            signals[name] = make_signal(name, "m", time, values, end=end, delay=0.0)
    return FlightRecord(
        name=record.path.stem,
        source=record.path,
        format=FORMAT,
        firmware=f"workbench {record.versions.get('workbench', '')}".strip(),
        parameters={
            "vehicle": record.vehicle,
            **({"controller": record.controller["name"]} if "name" in record.controller else {}),
            **record.values,
        },
        remarks=tuple(filter(None, (record.remark,))),
        signals=signals,
        end=end,
    )


def _points(record: LogRecord, time: np.ndarray) -> np.ndarray | None:
    """Return the points that a pilot went to (n, 3); None where he flew in another way, too.

    Until the first one it is the place of the start, which the mode holds.
    """
    try:
        script = record.scenario().script
    except WorkbenchError:
        return None
    actions = sorted((*script, *(each.action for each in record.done)), key=lambda each: each.at)
    flown = [each for each in actions if each.flies]
    if not flown or not len(time) or any(each.go_to is None for each in flown):
        return None
    goals = [each.go_to for each in flown if each.go_to is not None]
    points = np.vstack([record.states[0, 4:7], *map(np.array, goals)])
    return points[np.searchsorted([each.at for each in flown], time, side="right")]
