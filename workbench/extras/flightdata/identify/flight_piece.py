"""A piece of a flight on even grids, as a fit takes it."""

import math
from dataclasses import dataclass, replace

import numpy as np
from scipy.signal import butter, sosfiltfilt

from workbench.common.series import held_on_grid, interpolated_on_grid
from workbench.extras.flightdata.identify.flight import IdentificationFlight
from workbench.plant.vehicle import Vehicle

MIN_MODEL_STEP_S, MAX_MODEL_STEP_S = 0.5e-3, 2.1e-3
"""Step of the model [s]; between, there are `STEPS_PER_ROTOR_LAG` in a rotor's lag: with fewer of
them the lag of a fast rotor came out half a percent long, and the inertia about z four percent
small."""
STEPS_PER_ROTOR_LAG = 16
MAX_ROW_RATE_HZ = 250.0
"""Most rows a second; samples that come faster are averaged, of log and model alike."""
DRAG_CUTOFF_HZ = 3.0
"""Up to which velocity counts for drag [Hz]."""


@dataclass(frozen=True)
class Piece:
    """A run of samples as the model takes it, on its grid.

    Attributes:
        period: of the grid [s].
        early: how much before the mean time of measured samples the grid's lie [s].
        every: how many of its samples lie between those of the log.
        block: how many samples of the log make a row.
        force_delay: of the accelerometer's filters [s].
        commands: (M, n) on the grid; speeds [rad/s] or shares.
        gyro: (M, 3); so velocity.
        velocity: zeros where it is not known.
        voltage: (M) over its mean, ones where it is not known.
        turn: (K, 3) measured changes of the angular velocity over time [rad/s²].
        force: (K, 3) measured [m/s²].
    """

    period: float
    early: float
    every: int
    block: int
    kind: str
    force_delay: float
    commands: np.ndarray
    gyro: np.ndarray
    velocity: np.ndarray
    voltage: np.ndarray
    turn: np.ndarray
    force: np.ndarray

    @property
    def row(self) -> float:
        """Between rows [s]."""
        return self.period * self.every * self.block


def make_piece(
    flight: IdentificationFlight, vehicle: Vehicle, mean_voltage: float | None = None
) -> Piece:
    """Return a run of even samples as the model of a vehicle takes it.

    Args:
        flight: the run.
        vehicle: as it is described.
        mean_voltage: which counts as 1 [V]; without it the run's own.
    """
    own = 1.0 if flight.voltage is None else float(np.mean(flight.voltage))
    longest = min(MAX_MODEL_STEP_S, max(MIN_MODEL_STEP_S, vehicle.rotor_lag / STEPS_PER_ROTOR_LAG))
    early = -0.5 * flight.period
    flight = averaged_flight(flight, longest)
    early += 0.5 * flight.period
    every = max(1, math.ceil(flight.period / longest - 1e-6))
    block = max(1, math.ceil(flight.rate / MAX_ROW_RATE_HZ - 1e-6))
    grid = np.interp(
        np.arange((len(flight.time) - 1) * every + 1) / every,
        np.arange(len(flight.time)),
        flight.time,
    )
    velocity, voltage = flight.velocity, flight.voltage
    gyro = block_means(flight.gyro, block)
    return Piece(
        period=flight.period / every,
        early=early,
        every=every,
        block=block,
        kind=flight.kind,
        force_delay=lowpass_delay(flight.force_lowpass),
        commands=np.ascontiguousarray(held_on_grid(flight.time, flight.commands, grid)),
        gyro=interpolated_on_grid(flight.time, flight.gyro, grid),
        velocity=np.zeros((len(grid), 3))
        if velocity is None
        else interpolated_on_grid(flight.time, drag_smoothed(velocity, flight.period), grid),
        voltage=np.ones(len(grid))
        if voltage is None
        else interpolated_on_grid(flight.time, voltage, grid) / (mean_voltage or own),
        turn=np.diff(gyro, axis=0) / (flight.period * block),
        force=block_means(flight.force, block)[1:],
    )


def lowpass_delay(cutoff: float) -> float:
    """Return the delay of a low-pass of second order [s] with a cut-off [Hz], 0 for none."""
    return math.sqrt(2.0) / (2.0 * math.pi * cutoff) if cutoff else 0.0


def block_means(values: np.ndarray, size: int) -> np.ndarray:
    """Return the means of samples (N, k) in blocks of a size."""
    whole = len(values) // size
    return values[: whole * size].reshape(whole, size, -1).mean(axis=1)


def drag_smoothed(velocity: np.ndarray, period: float) -> np.ndarray:
    """Return velocities (N, 3) without what is faster than drag can show, and not late.

    Noise of what drag goes with would make drag look smaller than it is.
    """
    share = 2.0 * DRAG_CUTOFF_HZ * period
    if share > 0.9 or len(velocity) < 30:
        return velocity
    return np.asarray(sosfiltfilt(butter(2, share, output="sos"), velocity, axis=0))


def averaged_flight(flight: IdentificationFlight, longest: float) -> IdentificationFlight:
    """Return a flight with means of neighbours where its samples come faster than is needed [s]."""
    size = max(1, math.floor(longest / flight.period + 1e-6))
    if size == 1:
        return flight
    return replace(
        flight,
        time=block_means(flight.time[:, None], size)[:, 0],
        commands=block_means(flight.commands, size),
        gyro=block_means(flight.gyro, size),
        force=block_means(flight.force, size),
        velocity=None if flight.velocity is None else block_means(flight.velocity, size),
        voltage=None
        if flight.voltage is None
        else block_means(flight.voltage[:, None], size)[:, 0],
        good=np.empty(0, dtype=bool),
    )
