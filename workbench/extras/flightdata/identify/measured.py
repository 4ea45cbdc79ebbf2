"""A flight for identification: free flight on one even grid, motors by rotor."""

from collections.abc import Sequence

import numpy as np

from workbench.common.errors import WorkbenchError
from workbench.common.flight import Flight
from workbench.common.series import Series, held_on_grid
from workbench.extras.flightdata.identify.flight import (
    MIN_COMMAND_RATE_HZ,
    IdentificationFlight,
    free_flight,
)
from workbench.logs.logged_signal import ACCELEROMETER_SIGNALS, GYRO_SIGNALS, component_names
from workbench.logs.motor_commands import FULL_SHARE_COMMANDS, command_names
from workbench.logs.readers.rotations import vectors_in_world

FIRMWARE_CUTOFFS_HZ = {"Crazyflie": ((30.0, 145.0), (80.0, 116.0))}
"""Cut-offs of accelerometer and gyro for logs with filtered samples, of firmware and chip [Hz]. A
Crazyflie 2.1 has low-passes of second order at 1 kHz (`ACCEL_LPF_CUTOFF_FREQ` 30,
`GYRO_LPF_CUTOFF_FREQ` 80), and its BMI088 those of `BMI088_ACCEL_BW_OSR4` at 1600 Hz, which is 145
Hz, and `BMI088_GYRO_BW_116_ODR_1000_HZ`: crazyflie-firmware, from 2021.06 to 2025.12.1,
src/hal/src/sensors_bmi088_bmp3xx.c, before 2024 sensors_bmi088_bmp388.c. A Crazyflie 2.0 has the
same low-passes behind an MPU-9250 at 41 and 98 Hz (sensors_mpu9250_lps25h.c). Logs do not state
which of the two flew; use the options of `identify`."""
MAX_MISSING_SAMPLES = 2.5
"""Largest number of consecutive missing samples."""
MAX_SLOW_LOG_GAP_S = 0.15
"""Longest gap in a flight with a log too slow for rates anyway [s]."""
MIN_FLIGHT_HEIGHT_M = 0.2
"""Height above the start of the motors that counts as flight [m]."""
MAX_VELOCITY_GAP_S = 0.25
"""Longest gap in velocity and attitude [s]."""
_VELOCITY_SOURCES = (
    (("velocity_data.v_x", "velocity_data.v_y", "velocity_data.v_z"), "attitude"),
    (("estimate.v_x", "estimate.v_y", "estimate.v_z"), "estimate"),
)
"""Velocities in W, with the source of the quaternion to B, the best first."""


def measured_flight(
    record: Flight,
    rotors: int,
    order: Sequence[int] = (),
    force_lowpass: float | None = None,
    gyro_lowpass: float | None = None,
) -> IdentificationFlight:
    """Return the parts of a log that are useful to identify its vehicle.

    Args:
        record: of the log.
        rotors: number of rotors of the vehicle.
        order: for each rotor of the description the number of its motor in the log, from 1; empty
            for the order of the log.
        force_lowpass: cut-off of the accelerometer filter [Hz], 0 for none; by default that of the
            firmware, see `FIRMWARE_CUTOFFS_HZ`.
        gyro_lowpass: the same for the gyro.

    Raises:
        WorkbenchError: if the log has no gyro, accelerometer or commands, or no flight.
    """
    names, kind = command_names(record, rotors, order)
    usual = [
        combined_cutoff(cutoffs)
        for cutoffs in FIRMWARE_CUTOFFS_HZ.get(record.firmware.split(" ")[0], ((), ()))
    ]
    for what, needed in (("a gyro", GYRO_SIGNALS), ("an accelerometer", ACCELEROMETER_SIGNALS)):
        if not record.has(needed):
            raise WorkbenchError(
                f"{record.source}: has no signals of {what} ({needed[0]}): nothing can be "
                "identified from it; log the IMU, as fast as the flight controller can"
            )
    _refuse_grounded(record, names)
    clock = _slowest([record[GYRO_SIGNALS[0]], record[ACCELEROMETER_SIGNALS[0]]])
    period = float(np.median(np.diff(clock.time)))
    sources = [record[name] for name in (*GYRO_SIGNALS, *ACCELEROMETER_SIGNALS, *names)]
    begin = max(each.time[0] for each in sources)
    end = min(each.time[-1] for each in sources)
    if end - begin < 1.0:
        raise WorkbenchError(f"{record.source}: IMU and motors share {end - begin:.2g} s: fly more")
    grid = np.arange(begin, end, period)
    slow = min(each.rate for each in sources) < MIN_COMMAND_RATE_HZ
    bridge = MAX_SLOW_LOG_GAP_S if slow else MAX_MISSING_SAMPLES * period
    gyro, gyro_known = _signals_on_grid(record, GYRO_SIGNALS, grid, bridge)
    force, force_known = _signals_on_grid(record, ACCELEROMETER_SIGNALS, grid, bridge)
    told_every = float(np.median(np.diff(record[names[0]].time)))
    _, told = _signals_on_grid(record, names, grid, max(bridge, MAX_MISSING_SAMPLES * told_every))
    commands = np.column_stack(
        [held_on_grid(record[name].time, record[name].values, grid) for name in names]
    )
    velocity, velocity_known = _velocity(record, grid)
    voltage = None
    if kind == FULL_SHARE_COMMANDS and "battery.voltage" in record:
        battery = record["battery.voltage"]
        voltage = np.interp(grid, battery.time, battery.values)
    flight = IdentificationFlight(
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


def has_imu(record: Flight) -> bool:
    """Return whether a log has gyro and accelerometer."""
    return record.has((*GYRO_SIGNALS, *ACCELEROMETER_SIGNALS))


def _refuse_grounded(record: Flight, names: Sequence[str]) -> None:
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
    if len(z) and float(z.max() - z[0]) < MIN_FLIGHT_HEIGHT_M:
        raise WorkbenchError(
            f"{record.source}: rises by {float(z.max() - z[0]):.2f} m while its motors turn: it "
            "never leaves the ground; identify needs a flight"
        )


def combined_cutoff(cutoffs: Sequence[float]) -> float:
    """Return the cut-off of one low-pass with the delay of several [Hz], 0 for none."""
    return 1.0 / sum(1.0 / cutoff for cutoff in cutoffs) if cutoffs else 0.0


def _slowest(signals: Sequence[Series]) -> Series:
    return min(signals, key=lambda each: each.rate)


def _signals_on_grid(
    record: Flight, names: Sequence[str], grid: np.ndarray, bridge: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return signals on a grid (N, k), and where all of them are known (N)."""
    found = [record[name].at(grid, bridge) for name in names]
    values = np.column_stack([np.nan_to_num(each) for each, _ in found])
    return values, np.all([known for _, known in found], axis=0)


def _velocity(record: Flight, grid: np.ndarray) -> tuple[np.ndarray | None, np.ndarray]:
    """Return the velocity in B (N, 3), and where it is known (N); None if the log has none."""
    for names, whose in _VELOCITY_SOURCES:
        turn = component_names(f"{whose}.q_", "wxyz")
        if record.has((*names, *turn)):
            v_W, known = _signals_on_grid(record, names, grid, MAX_VELOCITY_GAP_S)
            q, turned = _signals_on_grid(record, turn, grid, MAX_VELOCITY_GAP_S)
            q /= np.maximum(np.linalg.norm(q, axis=1, keepdims=True), 1e-9)
            return vectors_in_world(q * [1.0, -1.0, -1.0, -1.0], v_W), known & turned
    return None, np.ones(len(grid), dtype=bool)
