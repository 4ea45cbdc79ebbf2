"""Gyro and accelerometer of a ULog without `sensor_combined`."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from workbench.extras.flightdata.readers.axes import flu
from workbench.extras.flightdata.readers.topic_log import ColumnConversion, MessageTable, SignalRow
from workbench.extras.flightdata.readers.ulog_tables import ulog_instances
from workbench.extras.flightdata.readers.ulog_topics import item_names
from workbench.logs.logged_signal import ACCELEROMETER_SIGNALS, GYRO_SIGNALS

MAX_FIFO_SAMPLES = 32
"""Largest number of samples in a message of `sensor_gyro_fifo`."""


def ulog_imu_rows(
    tables: dict[str, MessageTable], parameters: Mapping[str, Any], remarks: list[str]
) -> list[SignalRow]:
    """Return the rows of gyro and accelerometer of a log without `sensor_combined`.

    The samples in messages of the topics sensor_*_fifo become tables of their own.
    """
    if "sensor_combined" in tables:
        return []
    selection = tables.get("sensor_selection")
    rotation = parameters.get("SENS_BOARD_ROT", 0)
    rows = []
    for sensor, names, integral in (
        ("gyro", GYRO_SIGNALS, "angle"),
        ("accel", ACCELEROMETER_SIGNALS, "velocity"),
    ):
        found: list[str] = []
        used = selection.fields.get(f"{sensor}_device_id") if selection else None
        for topic in (f"sensor_{sensor}_fifo", f"sensor_{sensor}"):
            several = ulog_instances(tables, topic)
            devices = {name: tables[name].fields.get("device_id") for name in several}
            known = [
                name
                for name, device in devices.items()
                if used is not None and device is not None and np.isin(device, used).any()
            ]
            for name in (known or several)[:1]:
                found.append(_samples(tables, name) if "fifo" in name else name)
        found = [name for name in (*found, "vehicle_imu") if name in tables]
        if not found:
            continue
        best = max(found, key=lambda name: len(tables[name].ticks))
        unit = "rad/s" if sensor == "gyro" else "m/s^2"
        if best == "vehicle_imu":
            fields = (*item_names(f"delta_{integral}"), f"delta_{integral}_dt")
            rows.append(SignalRow(best, fields, names, unit, _over_time))
        elif rotation in range(len(_BOARD_YAWS_RAD)):
            rows.append(SignalRow(best, ("x", "y", "z"), names, unit, _turned_board(int(rotation))))
            remarks.append(f"{names[0][:-2]} is {best}'s: without the autopilot's calibration")
        else:
            remarks.append(
                f"{best} keeps its name: the board is mounted with SENS_BOARD_ROT {rotation:g}, "
                "and only turns about its vertical axis (0 to 7) are known here"
            )
    return rows


_BOARD_YAWS_RAD = tuple(np.radians(45.0 * i) for i in range(8))
"""Angles of the first values of SENS_BOARD_ROT, about the axis down [rad]."""


def _turned_board(rotation: int) -> ColumnConversion:
    """Return a conversion from the axes of a turned board to forward, left, up."""
    cos, sin = np.cos(_BOARD_YAWS_RAD[rotation]), np.sin(_BOARD_YAWS_RAD[rotation])
    turn = np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])
    return lambda board: flu(board @ turn.T)


def _over_time(values: np.ndarray) -> np.ndarray:
    """Return the means (n, 3), forward, left, up, of integrals with their durations [us] (n, 4)."""
    duration = np.where(values[:, 3:] > 0.0, values[:, 3:], np.nan)
    return flu(values[:, :3] / (1e-6 * duration))


def _samples(tables: dict[str, MessageTable], topic: str) -> str:
    """Add a table of the single samples in the messages of a topic; return its name, or "".

    A message has up to `MAX_FIFO_SAMPLES` samples; its time is that of the last one.
    """
    table = tables[topic]
    axes = [[f"{axis}[{i}]" for i in range(MAX_FIFO_SAMPLES)] for axis in "xyz"]
    needed = ["dt", "scale", "samples", *(name for each in axes for name in each)]
    if not all(name in table.fields for name in needed):
        return ""
    count = np.clip(np.nan_to_num(table.fields["samples"]), 0, MAX_FIFO_SAMPLES).astype(int)
    message = np.repeat(np.arange(len(count)), count)
    number = np.arange(len(message)) - np.repeat(np.cumsum(count) - count, count)
    after = count[message] - 1 - number
    places = np.arange(len(count)) if table.places is None else table.places
    name = f"{topic}_samples"
    tables[name] = MessageTable(
        table.ticks[message] - after * table.fields["dt"][message],
        {
            axis: np.column_stack([table.fields[field] for field in each])[message, number]
            * table.fields["scale"][message]
            for axis, each in zip("xyz", axes, strict=True)
        },
        places[message] + number / MAX_FIFO_SAMPLES,
    )
    return name
