"""A flight record for identification: free flight on one even grid, motors by rotor."""

from collections.abc import Sequence

import numpy as np

from workbench.common.errors import WorkbenchError
from workbench.design.identify.flight import (
    LEAST_RATE,
    SHARE,
    SPEED,
    Flight,
    free_flight,
    held_on_grid,
)
from workbench.logs.flight_record import (
    FORCE,
    GYRO,
    SHARES,
    SPEED_COMMANDS,
    FlightRecord,
    Signal,
    parts,
)
from workbench.logs.readers.rotations import in_world

FILTERS = {"Crazyflie": ((30.0, 145.0), (80.0, 116.0))}
"""Cut-offs of accelerometer and gyro for logs with filtered samples, of firmware and chip [Hz]. A
Crazyflie 2.1 has low-passes of second order at 1 kHz (`ACCEL_LPF_CUTOFF_FREQ` 30,
`GYRO_LPF_CUTOFF_FREQ` 80), and its BMI088 those of `BMI088_ACCEL_BW_OSR4` at 1600 Hz, which is 145
Hz, and `BMI088_GYRO_BW_116_ODR_1000_HZ`: crazyflie-firmware, from 2021.06 to 2025.12.1,
src/hal/src/sensors_bmi088_bmp3xx.c, before 2024 sensors_bmi088_bmp388.c. A Crazyflie 2.0 has the
same low-passes behind an MPU-9250 at 41 and 98 Hz (sensors_mpu9250_lps25h.c). Logs do not state
which of the two flew; use the options of `identify`."""
BRIDGE = 2.5
"""Largest number of consecutive missing samples."""
SLOW_BRIDGE = 0.15
"""Longest gap in a flight with a log too slow for rates anyway [s]."""
LIFTED = 0.2
"""Height above the start of the motors that counts as flight [m]."""
VELOCITY_BRIDGE = 0.25
"""Longest gap in velocity and attitude [s]."""
_MOTIONS = (
    (("velocity_data.v_x", "velocity_data.v_y", "velocity_data.v_z"), "attitude"),
    (("estimate.v_x", "estimate.v_y", "estimate.v_z"), "estimate"),
)
"""Velocities in W, with the source of the quaternion to B, the best first."""


def measured_flight(
    record: FlightRecord,
    rotors: int,
    order: Sequence[int] = (),
    force_lowpass: float | None = None,
    gyro_lowpass: float | None = None,
) -> Flight:
    """Return the parts of a log that are useful to identify its vehicle.

    Args:
        record: of the log.
        rotors: number of rotors of the vehicle.
        order: for each rotor of the description the number of its motor in the log, from 1; empty
            for the order of the log.
        force_lowpass: cut-off of the accelerometer filter [Hz], 0 for none; by default that of the
            firmware, see `FILTERS`.
        gyro_lowpass: the same for the gyro.

    Raises:
        WorkbenchError: if the log has no gyro, accelerometer or commands, or no flight.
    """
    names, kind = _commands(record, rotors, order)
    usual = [in_series(cutoffs) for cutoffs in FILTERS.get(record.firmware.split(" ")[0], ((), ()))]
    for what, needed in (("a gyro", GYRO), ("an accelerometer", FORCE)):
        if not record.has(needed):
            raise WorkbenchError(
                f"{record.source}: has no signals of {what} ({needed[0]}): nothing can be "
                "identified from it; log the IMU, as fast as the flight controller can"
            )
    _refuse_grounded(record, names)
    clock = _slowest([record[GYRO[0]], record[FORCE[0]]])
    period = float(np.median(np.diff(clock.time)))
    sources = [record[name] for name in (*GYRO, *FORCE, *names)]
    begin = max(each.time[0] for each in sources)
    end = min(each.time[-1] for each in sources)
    if end - begin < 1.0:
        raise WorkbenchError(f"{record.source}: IMU and motors share {end - begin:.2g} s: fly more")
    grid = np.arange(begin, end, period)
    slow = min(each.rate for each in sources) < LEAST_RATE
    bridge = SLOW_BRIDGE if slow else BRIDGE * period
    gyro, gyro_known = _at(record, GYRO, grid, bridge)
    force, force_known = _at(record, FORCE, grid, bridge)
    told_every = float(np.median(np.diff(record[names[0]].time)))
    _, told = _at(record, names, grid, max(bridge, BRIDGE * told_every))
    commands = np.column_stack(
        [held_on_grid(record[name].time, record[name].values, grid) for name in names]
    )
    velocity, velocity_known = _velocity(record, grid)
    voltage = None
    if kind == SHARE and "battery.voltage" in record:
        battery = record["battery.voltage"]
        voltage = np.interp(grid, battery.time, battery.values)
    flight = Flight(
        time=grid,
        commands=commands,
        gyro=gyro,
        force=force,
        velocity=velocity,
        voltage=voltage,
        kind=kind,
        good=gyro_known & force_known & velocity_known & told,
        command_rate=record[names[0]].rate,
        force_lowpass=usual[0] if force_lowpass is None else force_lowpass,
        gyro_lowpass=usual[1] if gyro_lowpass is None else gyro_lowpass,
        name=record.name,
    )
    return free_flight(flight)


def motor_commands(
    record: FlightRecord, rotors: int, order: Sequence[int] = ()
) -> tuple[np.ndarray, np.ndarray, str]:
    """Return times (N) [s] and commands (N, n) of motors, by rotor, and their kind.

    Arguments and errors are those of `measured_flight`.
    """
    names, kind = _commands(record, rotors, order)
    time = record[names[0]].time
    columns = [held_on_grid(record[name].time, record[name].values, time) for name in names]
    return time, np.column_stack(columns), kind


def has_imu(record: FlightRecord) -> bool:
    """Return whether a log has gyro and accelerometer."""
    return record.has((*GYRO, *FORCE))


def _commands(record: FlightRecord, rotors: int, order: Sequence[int]) -> tuple[list[str], str]:
    """Return the names of the motor commands, by rotor, and their kind."""
    for beginning, kind in ((SPEED_COMMANDS, SPEED), (SHARES, SHARE)):
        names = record.motors(beginning)
        if len(names) >= rotors:
            if not order:
                return names[:rotors], kind
            if sorted(order) != list(range(1, rotors + 1)):
                raise WorkbenchError(
                    f"the order of motors is {','.join(map(str, order))}: give each of 1 .. "
                    f"{rotors} once, as {','.join(map(str, range(1, rotors + 1)))}"
                )
            return [names[number - 1] for number in order], kind
        if names:
            raise WorkbenchError(
                f"{record.source}: has the commands of {len(names)} of the model's "
                f"{rotors} motors: name the model that flew, with --model"
            )
    hint = (
        "; of a simulated flight take the CSV that `workbench fly --csv FILE` writes"
        if "rotors.speed.0" in record
        else ": log the motors' outputs"
    )
    raise WorkbenchError(f"{record.source}: has no motor commands{hint}")


def _refuse_grounded(record: FlightRecord, names: Sequence[str]) -> None:
    """Reject a log that begins on the ground and stays there.

    Raises:
        WorkbenchError: if the height is known and too small for a flight.
    """
    height = next((record[z] for z in ("position_data.z", "estimate.z") if z in record), None)
    turns = record[names[0]]
    running = turns.values > 0.05 * max(float(np.nanmax(turns.values, initial=0.0)), 1e-12)
    if height is None or running[:1].any() or not running.any():
        return
    z = height.values[np.isfinite(height.values) & (height.time >= turns.time[running.argmax()])]
    if len(z) and float(z.max() - z[0]) < LIFTED:
        raise WorkbenchError(
            f"{record.source}: rises by {float(z.max() - z[0]):.2f} m while its motors turn: it "
            "never leaves the ground; identify needs a flight"
        )


def in_series(cutoffs: Sequence[float]) -> float:
    """Return the cut-off of one low-pass with the delay of several [Hz], 0 for none."""
    return 1.0 / sum(1.0 / cutoff for cutoff in cutoffs) if cutoffs else 0.0


def _slowest(signals: Sequence[Signal]) -> Signal:
    return min(signals, key=lambda each: each.rate)


def _at(
    record: FlightRecord, names: Sequence[str], grid: np.ndarray, bridge: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return signals on a grid (N, k), and where all of them are known (N)."""
    found = [record[name].at(grid, bridge) for name in names]
    values = np.column_stack([np.nan_to_num(each) for each, _ in found])
    return values, np.all([known for _, known in found], axis=0)


def _velocity(record: FlightRecord, grid: np.ndarray) -> tuple[np.ndarray | None, np.ndarray]:
    """Return the velocity in B (N, 3), and where it is known (N); None if the log has none."""
    for names, whose in _MOTIONS:
        turn = parts(f"{whose}.q_", "wxyz")
        if record.has((*names, *turn)):
            v_W, known = _at(record, names, grid, VELOCITY_BRIDGE)
            q, turned = _at(record, turn, grid, VELOCITY_BRIDGE)
            q /= np.maximum(np.linalg.norm(q, axis=1, keepdims=True), 1e-9)
            return in_world(q * [1.0, -1.0, -1.0, -1.0], v_W), known & turned
    return None, np.ones(len(grid), dtype=bool)
