"""The CSV of a simulated flight that `workbench fly --csv` writes: states, and what was commanded.

It has the true motion; gyro and accelerometer are those of a perfect IMU at the base link's origin.
"""

import csv
from pathlib import Path

import numpy as np

from workbench.common.errors import WorkbenchError
from workbench.logs.flight_record import FlightRecord, make_signal
from workbench.logs.readers.packed import read_packed, stem
from workbench.logs.readers.rotations import QUATERNION, continuous, in_world
from workbench.plant.gravity import GRAVITY

FORMAT = "states of a simulated flight"
HEAD = b"t [s],p_W.x [m],"


def read_states(path: Path) -> FlightRecord:
    """Read the states of a flight.

    Raises:
        WorkbenchError: if it cannot be read, or lacks what such a file has.
    """
    data, cut = read_packed(path)
    lines = data.decode("utf-8", "replace").splitlines()
    head = next(csv.reader(lines[:1]))
    try:
        table = np.array([row for row in csv.reader(lines[1:]) if row], dtype=float)
        columns = dict(zip((name.split(" [")[0] for name in head), table.T, strict=True))
        time = columns["t"]
        q = continuous(_three(columns, "q_WB", "wxyz"))
        back = q * [1.0, -1.0, -1.0, -1.0]
        gyro = in_world(back, _three(columns, "w_W"))
        force = in_world(back, _three(columns, "vdot_W") + [0.0, 0.0, GRAVITY])
        groups = [
            (tuple(f"position_data.{axis}" for axis in "xyz"), "m", _three(columns, "p_W")),
            (tuple(f"velocity_data.v_{axis}" for axis in "xyz"), "m/s", _three(columns, "v_W")),
            (tuple(f"attitude.{part}" for part in QUATERNION), "1", q),
            (tuple(f"attitude.w_{axis}" for axis in "xyz"), "rad/s", gyro),
            (tuple(f"imu.angular_velocity.{axis}" for axis in "xyz"), "rad/s", gyro),
            (tuple(f"imu.linear_acceleration.{axis}" for axis in "xyz"), "m/s^2", force),
        ]
    except (KeyError, ValueError) as error:
        raise WorkbenchError(
            f"{path}: is no whole CSV of states as `workbench fly --csv` writes it: {error}"
        ) from error
    end = float(time[-1]) if len(time) else 0.0
    signals = {
        name: make_signal(name, unit, time, values, end=end, delay=0.0)
        for names, unit, table in groups
        for name, values in zip(names, table.T, strict=True)
    }
    number = 1
    while f"speed_command.{number}" in columns:
        for source, name in (("speed_command", "speed_command"), ("speed", "speed")):
            values = columns[f"{source}.{number}"]
            if source == "speed_command":  # a row has what was asked for until then
                values = np.append(values[1:], values[-1:])
            name = f"rotors.{name}.{number - 1}"
            signals[name] = make_signal(name, "rad/s", time, values, end=end, delay=0.0)
        number += 1
    return FlightRecord(
        name=stem(path),
        source=path,
        format=FORMAT,
        firmware="workbench",
        remarks=tuple(filter(None, (cut,))),
        signals=signals,
        end=end,
    )


def _three(columns: dict[str, np.ndarray], name: str, axes: str = "xyz") -> np.ndarray:
    return np.column_stack([columns[f"{name}.{axis}"] for axis in axes])
