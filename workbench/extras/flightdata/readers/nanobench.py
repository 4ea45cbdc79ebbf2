"""Read NanoBench's CSV files: the log of a Crazyflie and motion capture, on one grid of 100 Hz.

The meaning of the columns was measured; it differs in places from that stated by their authors:

- On-board columns were received at 66 .. 100 Hz and interpolated linearly. Rows in which all
  columns of a stream lie on a straight line over `SIGNAL_GAP_PERIODS` periods were not measured,
  and are left out. So is the straight line by which a stream is extrapolated after the loss of the
  radio link.
- Accelerations are in g, including those of the estimate, the gyro in rad/s, `roll`, `pitch` and
  `yaw` of motion capture in rad, and `w*_vicon` in body axes.
- Attitudes of the firmware are in degrees, and its pitch is positive nose up.
- The PWM of the motors is that after battery compensation: a share of the voltage.
- `pid_controller_*` are attitude setpoints. They stay 0 if the Mellinger controller flew.

Source: Ullah and Baca, "NanoBench", arXiv:2603.09908 (2026), and its files.
"""

import math
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from workbench.common.errors import WorkbenchError
from workbench.common.flight import Flight
from workbench.common.series import SIGNAL_GAP_PERIODS, Series, make_series
from workbench.common.yaml_files import read_yaml
from workbench.extras.flightdata.readers.clock import SampleClock
from workbench.extras.flightdata.readers.states_csv import clocked_columns
from workbench.extras.flightdata.readers.topic_log import (
    MessageTable,
    SignalRow,
    attitude_rows,
    scaled,
)
from workbench.logs.logged_signal import SETPOINT_SIGNALS, component_names
from workbench.logs.readers.log_reader import LogReader, companion_file
from workbench.logs.readers.packed import PackedFile, log_stem
from workbench.logs.readers.rotations import (
    EULER_ANGLE_NAMES,
    QUATERNION_NAMES,
    continuous,
    vectors_in_world,
    without_jumps,
)
from workbench.plant.gravity import GRAVITY

METADATA_SUFFIX = "_metadata.yaml"
"""Ending of the file of metadata next to a log."""
NANOBENCH_FORMAT = "NanoBench CSV"
NANOBENCH_HEAD = b"t,px,py,pz,qx,qy,qz,qw,roll,pitch,yaw,"
"""First bytes of a file."""
NANOBENCH_FULL_PWM = 65535.0
NANOBENCH_STREAMS: Mapping[str, tuple[str, ...]] = {
    "imu": tuple(f"imu_{kind}_{axis}" for kind in ("acc", "gyro") for axis in "xyz"),
    "motor": tuple(f"motor_motor_m{i}" for i in (1, 2, 3, 4)),
    "estimator": tuple(f"est_stateEstimate_{x}" for x in ("x", "y", "z", "vx", "vy", "vz")),
    "estimator_acc": tuple(f"est_stateEstimate_a{axis}" for axis in "xyz"),
    "attitude": tuple(f"att_stateEstimate_{angle}" for angle in EULER_ANGLE_NAMES),
    "attitude_qw": tuple(f"att_stateEstimate_q{x}" for x in "wxyz"),
    "setpoint": tuple(f"sp_ctrltarget_{x}" for x in ("x", "y", "z", "yaw")),
    "pid_output": tuple(f"pid_controller_{x}" for x in ("roll", "pitch", "yaw", "cmd_thrust")),
    "power": ("pwr_pm_vbat",),
}
"""Columns that were sent in one packet, by their names in the row counts of the metadata."""
NOISY_STREAMS = ("imu", "estimator", "estimator_acc", "attitude", "attitude_qw")
"""Streams with noise, which are never straight: they end with the radio link."""
STRAIGHT_STREAMS = ("setpoint",)
"""Streams that may be straight, so that only their end is checked."""
_VALUE_ROUNDING = 2e-9
"""Twice the rounding error of a value in the file."""
_SLOPE_TOLERANCE = 1e-6
"""Relative error of a slope, from the rounding of times."""


MAX_COUNTED_PER_ROW = 1.05
"""Largest number of received samples for a row; the metadata of more are of a longer record."""


def read_nanobench(path: Path) -> Flight:
    """Read a flight of NanoBench, which may be compressed, and the metadata next to it, if any.

    Raises:
        WorkbenchError: if it cannot be read, or is not such a file.
    """
    file = PackedFile(path)
    table, clock, damage = _nanobench_table(file)
    time, end = table["t"], clock.end
    metadata, said = _metadata(path)
    counts = metadata.pop("row_counts", {})
    rates = {
        stream: count / end
        for stream, count in (counts.items() if isinstance(counts, dict) else ())
        if isinstance(count, int) and end > 0.0 and count <= MAX_COUNTED_PER_ROW * len(time)
    }
    streams = {
        name: np.column_stack([table[column] for column in columns])
        for name, columns in NANOBENCH_STREAMS.items()
        if all(column in table for column in columns)
    }
    measured, remarks = _measured_rows(time, streams, rates)
    controller = _controller(streams)
    known = {*streams, *(("vicon",) if table.keys() >= NANOBENCH_MOTION else ())}
    known -= {"pid_output"} if controller == "Mellinger" else set()
    signals: dict[str, Series] = {}
    for row in NANOBENCH_SIGNAL_ROWS:
        if row.topic not in known or not all(field in table for field in row.fields):
            continue
        rows = measured.get(row.topic, np.ones(len(time), bool))
        values = row.values_of(MessageTable(time, table))[rows]
        for name, column in zip(row.names, values.T, strict=True):
            signals[name] = make_series(
                name,
                row.unit,
                time[rows],
                column,
                end=end,
                rate=rates.get(row.topic),
                breaks=clock.breaks,
            )
    remarks = [
        *filter(None, (file.remark, damage, said)),
        *clock.remarks,
        *remarks,
        "the motors' commands are shares of the voltage: the firmware has compensated the battery",
        "velocity_data was computed from positions by a smoother: it depends on up to 0.1 s of "
        "the future",
    ]
    if controller == "Mellinger":
        remarks.append("wanted attitudes are constant: the Mellinger controller flew, not the PID")
    return Flight(
        name=log_stem(path),
        source=path,
        format=NANOBENCH_FORMAT,
        firmware=f"Crazyflie {metadata.pop('firmware_version', '')}".strip(),
        parameters={"controller": controller, **_flat(metadata)},
        remarks=tuple(remarks),
        signals=without_jumps(signals),
        end=end,
        clock_start=clock.begin,
    )


def _nanobench_table(file: PackedFile) -> tuple[dict[str, np.ndarray], SampleClock, str]:
    """Return the columns by name, the clock, and a remark on rows left out."""
    path, lines = file.path, file.lines()
    head = next(lines, "")
    if not head.startswith(NANOBENCH_HEAD.decode()):
        raise WorkbenchError(f"{path}: is not a NanoBench file: its first line differs")
    names = head.split(",")
    if len(set(names)) < len(names):
        raise WorkbenchError(f"{path}: a column comes twice in its first line")
    begin = None

    def parse(line: str) -> list[float]:
        nonlocal begin
        row = line.split(",")
        whole, _, rest = row[0].partition(".")
        if begin is None and len(row) == len(names) and row[0][:1].isdigit():
            begin = int(whole) if whole.isdigit() and len(whole) < 16 else 0
        # Convert whole seconds separately: as one number, the time would be rounded to 0.2 us.
        values = [int(whole) - (begin or 0) + float(f"0.{rest}"), *map(float, row[1:])]
        return values if all(map(math.isfinite, values)) else []

    return clocked_columns(file, lines, names, parse)


def _metadata(path: Path) -> tuple[dict[str, object], str]:
    """Return the metadata in the file next to a log, and a remark if it cannot be read."""
    beside = companion_file(path, METADATA_SUFFIX)
    if not beside.is_file():
        return {}, ""
    try:
        found = read_yaml(beside).data
    except WorkbenchError:
        return {}, f"{beside.name} cannot be read and was left alone"
    return {str(name): value for name, value in found.items()}, ""


def _flat(said: object, before: str = "") -> dict[str, float | str]:
    """Return nested values by names such as params.altitude_m."""
    if not isinstance(said, dict):
        plain = isinstance(said, int | float) and not isinstance(said, bool)
        return {before: said if plain else str(said)}
    found: dict[str, float | str] = {}
    for name, value in said.items():
        found |= _flat(value, f"{before}.{name}" if before else str(name))
    return found


def _measured_rows(
    time: np.ndarray, streams: Mapping[str, np.ndarray], rates: Mapping[str, float]
) -> tuple[dict[str, np.ndarray], list[str]]:
    """Return which rows of each stream were measured, and remarks."""
    bends = {name: _bends(time, values) for name, values in streams.items()}
    noisy = [bends[name][-1] for name in NOISY_STREAMS if name in bends and len(bends[name])]
    last = min(noisy, default=len(time) - 1)  # end of the on-board data
    if time[-1] - time[last] < SIGNAL_GAP_PERIODS * np.median(np.diff(time)):
        last = len(time) - 1
    measured, shares = {}, []
    for name, values in streams.items():
        found = bends[name]
        held = np.ptp(values[last:], axis=0).max() == 0.0  # such as motors on the ground
        whole = held or not len(found) or last == len(time) - 1
        end = last if whole else int(found[-1])
        rows = np.arange(len(time)) <= end
        if name not in STRAIGHT_STREAMS:
            period = 1.0 / rates[name] if rates.get(name) else float(np.median(np.diff(time)))
            knots = np.unique(np.concatenate([[0], found[found <= end], [end]]))
            for begin, stop in zip(knots[:-1], knots[1:], strict=True):
                moved = (values[begin] != values[stop]).any()
                if moved and time[stop] - time[begin] >= SIGNAL_GAP_PERIODS * period - 1e-6:
                    rows[begin + 1 : stop] = False
        measured[name] = rows
        lost = int(end + 1 - rows.sum())
        if lost:
            shares.append(f"{name} {100.0 * lost / (end + 1):.1f} %")
    remarks = []
    if last < len(time) - 1:
        remarks.append(
            f"the on-board columns end at {time[last]:.2f} s and were extrapolated for "
            f"{time[-1] - time[last]:.2f} s: the extrapolated part was cut off"
        )
    if shares:
        remarks.append(f"rows that were interpolated across gaps are left out: {', '.join(shares)}")
    return measured, remarks


def _bends(time: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Return the rows (k) at which a column of a stream (n, c) is not straight."""
    slopes = np.diff(values, axis=0) / np.diff(time)[:, None]
    bend = np.abs(np.diff(slopes, axis=0))
    step = float(np.diff(time).min())
    straight = bend <= 2.0 * _VALUE_ROUNDING / step + _SLOPE_TOLERANCE * (1.0 + np.abs(slopes[1:]))
    return 1 + np.nonzero(~straight.all(axis=1))[0]


def _firmware_angles(degrees: np.ndarray) -> np.ndarray:
    """Return roll, pitch and yaw (n, 3) [rad] for those of the firmware [deg], pitch nose up."""
    return np.asarray(np.radians(degrees) * [1.0, -1.0, 1.0])


def _motor_shares(pwm: np.ndarray) -> np.ndarray:
    return pwm / NANOBENCH_FULL_PWM


_TURN, _RATES = ("qw", "qx", "qy", "qz"), ("wx_vicon", "wy_vicon", "wz_vicon")
_ANGLE_ROW, _TURN_ROW = attitude_rows("vicon", _TURN, "position_data", continuous, "attitude")
NANOBENCH_MOTION = {"px", "py", "pz", *_TURN, "vx", "vy", "vz"}
"""Columns without which a file has no motion capture."""
NANOBENCH_SIGNAL_ROWS = (
    SignalRow("vicon", ("px", "py", "pz"), component_names("position_data."), "m"),
    _ANGLE_ROW,
    SignalRow("vicon", ("vx", "vy", "vz"), component_names("velocity_data.v_"), "m/s"),
    _TURN_ROW,
    SignalRow("vicon", _RATES, component_names("attitude.w_"), "rad/s"),
    SignalRow(
        "vicon",
        (*_TURN, *_RATES),
        component_names("velocity_data.w_"),
        "rad/s",
        lambda v: vectors_in_world(continuous(v[:, :4]), v[:, 4:]),
    ),
    *(
        SignalRow("imu", (f"imu_{kind}_{axis}",), (f"imu.{name}.{axis}",), unit, scaled(factor))
        for axis in "xyz"
        for kind, name, unit, factor in (
            ("acc", "linear_acceleration", "m/s^2", GRAVITY),
            ("gyro", "angular_velocity", "rad/s", 1.0),
        )
    ),
    SignalRow(
        "motor",
        NANOBENCH_STREAMS["motor"],
        component_names("motors.command_", "1234"),
        "1",
        _motor_shares,
    ),
    *(
        SignalRow("estimator", (f"est_stateEstimate_{of}{x}",), (f"estimate.{name}{x}",), unit)
        for x in "xyz"
        for of, name, unit in (("", "", "m"), ("v", "v_", "m/s"))
    ),
    SignalRow(
        "estimator_acc",
        NANOBENCH_STREAMS["estimator_acc"],
        component_names("estimate.a_"),
        "m/s^2",
        scaled(GRAVITY),
    ),
    SignalRow(
        "attitude",
        NANOBENCH_STREAMS["attitude"],
        component_names("estimate.", EULER_ANGLE_NAMES),
        "rad",
        _firmware_angles,
    ),
    SignalRow(
        "attitude_qw",
        NANOBENCH_STREAMS["attitude_qw"],
        component_names("estimate.", QUATERNION_NAMES),
        "1",
        continuous,
    ),
    SignalRow("setpoint", NANOBENCH_STREAMS["setpoint"][:3], SETPOINT_SIGNALS, "m"),
    SignalRow("setpoint", ("sp_ctrltarget_yaw",), ("setpoint.yaw",), "rad", np.radians),
    SignalRow(
        "pid_output",
        NANOBENCH_STREAMS["pid_output"][:3],
        component_names("attitude_setpoint.", EULER_ANGLE_NAMES),
        "rad",
        _firmware_angles,
    ),
    SignalRow(
        "pid_output",
        ("pid_controller_cmd_thrust",),
        ("attitude_setpoint.thrust",),
        "1",
        _motor_shares,
    ),
    SignalRow("power", ("pwr_pm_vbat",), ("battery.voltage",), "V"),
)
"""Signals of the columns; those of motion capture are a stream without gaps."""


def _controller(streams: Mapping[str, np.ndarray]) -> str:
    """Return the controller that flew; setpoints of the PID are constant if it did not."""
    if "motor" not in streams or "pid_output" not in streams or streams["motor"].max() <= 0.0:
        return "?"
    return "Mellinger" if np.ptp(streams["pid_output"], axis=0).max() == 0.0 else "PID"


LOG_READER = LogReader(
    NANOBENCH_FORMAT,
    "a CSV of NanoBench",
    lambda _, head: head.startswith(NANOBENCH_HEAD),
    lambda file: read_nanobench(file.path),
    place=50,
    companions=(METADATA_SUFFIX,),
)
