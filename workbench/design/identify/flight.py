"""The flight of an identification: samples from a log, and the plan of a flight with excitation.

Samples are on one even grid, in SI units and in B. The plan has doublets and chirps on throttle,
roll, pitch and yaw.
"""

import math
from dataclasses import dataclass, field, replace

import numpy as np
from scipy.ndimage import binary_dilation, binary_erosion, uniform_filter1d

from workbench.common.errors import WorkbenchError
from workbench.control.controller import DEFAULT
from workbench.plant.gravity import GRAVITY
from workbench.plant.vehicle import Vehicle
from workbench.scenario.scenario import Action, Rates, Scenario, Start, VehicleConfig

FLYING = 0.5
"""Share of the usual mean command above which a drone flies, averaged over `STEADY`."""
STEADY = 1.0
"""[s]."""
HARD = 30.0
"""Specific force from which on a sample counts as an impact [m/s²]."""
FAST = 17.0
"""Angular velocity from which on a sample counts as a crash [rad/s]."""
AWAY = 1.0
"""Time left out before and after ground contact, impacts and crashes [s]."""
LEAST_RATE = 180.0
"""Rate of gyro and commands below which the commands of a rate loop are aliased [1/s]."""
SPEED, SHARE = "speed", "share"
"""Kinds of commands: rotor speeds [rad/s], or shares of the full command (0 .. 1)."""
LEAST, MOST = 20.0, 600.0
"""Limits of the duration of a plan [s]."""
REST = 2.0
"""Hover before and after a planned flight [s]."""
SLOWEST, FASTEST = 2.0, 0.125
"""Half periods of the first and the last doublet in a sweep [s]."""
LOG_RATE = 512
"""Rate of the states written by `workbench fly --csv` [1/s]."""
HEIGHT = 10.0
"""Height of a planned flight [m]."""
TICK = 1.0 / 64.0
"""Time step of the actions of a plan [s]."""


@dataclass(frozen=True)
class Flight:
    """A flight, or the usable parts of it; N samples at an even period, n rotors.

    Attributes:
        time: (N) [s].
        commands: (N, n) of the motors, each held until the next sample.
        gyro: (N, 3) angular velocity in B [rad/s].
        force: (N, 3) specific force of the accelerometer in B [m/s²].
        velocity: (N, 3) in B, relative to still air [m/s]; None if unknown.
        voltage: (N) of the battery under load [V]; None if unknown.
        kind: of the commands, `SPEED` or `SHARE`.
        good: (N) whether a sample is in free flight; by default all are.
        command_rate: rate of logged commands, 0 for that of the samples [1/s].
        force_lowpass: cut-off of the accelerometer's second-order filter, 0 if unknown [Hz].
        gyro_lowpass: the same for the gyro.
        name: of the log.
    """

    time: np.ndarray
    commands: np.ndarray
    gyro: np.ndarray
    force: np.ndarray
    velocity: np.ndarray | None = None
    voltage: np.ndarray | None = None
    kind: str = SPEED
    good: np.ndarray = field(default_factory=lambda: np.empty(0, dtype=bool))
    command_rate: float = 0.0
    force_lowpass: float = 0.0
    gyro_lowpass: float = 0.0
    name: str = ""

    def __post_init__(self) -> None:
        if not len(self.good):
            object.__setattr__(self, "good", np.ones(len(self.time), dtype=bool))

    @property
    def period(self) -> float:
        """Period of samples [s]."""
        return float(np.median(np.diff(self.time)))

    @property
    def rate(self) -> float:
        """Samples a second [1/s]."""
        return 1.0 / self.period

    def cut(self, keep: slice) -> "Flight":
        """Return a part of the flight."""
        names = ("time", "commands", "gyro", "force", "velocity", "voltage", "good")
        known = {name: getattr(self, name) for name in names if getattr(self, name) is not None}
        return replace(self, **{name: values[keep] for name, values in known.items()})

    def pieces(self, shortest: float) -> list["Flight"]:
        """Return the runs of good samples of a minimum duration [s]."""
        edges = np.flatnonzero(np.diff(np.concatenate(([0], self.good.astype(int), [0]))))
        runs = zip(edges[::2], edges[1::2], strict=True)
        least = shortest * self.rate
        return [self.cut(slice(a, b)) for a, b in runs if b - a >= least]


def on_even_grid(times: np.ndarray, values: np.ndarray, grid: np.ndarray) -> np.ndarray:
    """Return samples (M, ...), interpolated linearly at the times of a grid (N)."""
    flat = values.reshape(len(values), -1)
    columns = [np.interp(grid, times, column) for column in flat.T]
    return np.stack(columns, axis=1).reshape(len(grid), *values.shape[1:])


def held_on_grid(times: np.ndarray, values: np.ndarray, grid: np.ndarray) -> np.ndarray:
    """Return the last sample (M, ...) at each time of a grid (N)."""
    place = np.searchsorted(times, grid + 1e-9, side="right") - 1
    return values[np.clip(place, 0, len(values) - 1)]


def free_flight(flight: Flight) -> Flight:
    """Return a flight with the samples of free flight marked as good.

    Motors run, averaged over a second, and there is no impact or tumbling.

    Raises:
        WorkbenchError: if the motors never run.
    """
    mean = flight.commands.mean(axis=1)
    running = mean[mean > 0.05 * max(mean.max(), 1e-12)]
    if not len(running):
        raise WorkbenchError(f"{flight.name}: the motors never run, so it has no flight")
    many = max(1, round(STEADY * flight.rate))
    flies = uniform_filter1d(mean, many) > FLYING * np.median(running)
    flies = binary_erosion(flies, np.ones(2 * round(AWAY * flight.rate) + 1))
    hard = np.linalg.norm(flight.force, axis=1) > HARD
    hard |= np.linalg.norm(flight.gyro, axis=1) > FAST
    hard = binary_dilation(hard, np.ones(2 * round(AWAY * flight.rate) + 1))
    return replace(flight, good=flight.good & flies & ~hard)


def check_finite(flight: Flight) -> None:
    """Check that all good samples of a flight are finite.

    Raises:
        WorkbenchError: with the quantity and the time.
    """
    named = (("command", flight.commands), ("gyro", flight.gyro), ("force", flight.force))
    for what, values in named:
        bad = flight.good & ~np.isfinite(values).all(axis=1)
        if bad.any():
            when = flight.time[np.argmax(bad)]
            raise WorkbenchError(f"{flight.name}: {what} is not a number at {when:.3f} s")


@dataclass(frozen=True)
class Limits:
    """The limits of a plan.

    Attributes:
        speed: level [m/s].
        climb: [m/s].
        yaw_rate: [rad/s].
    """

    speed: float
    climb: float
    yaw_rate: float

    def check(self) -> None:
        """Check that the limits are valid.

        Raises:
            WorkbenchError: for the first number that is not positive and finite.
        """
        bounds = (
            ("speed", self.speed, 8.0, "m/s"),
            ("climb", self.climb, 4.0, "m/s"),
            ("yaw rate", self.yaw_rate, 3.0, "rad/s"),
        )
        for name, value, most, unit in bounds:
            if not 0.0 < value <= most:
                raise WorkbenchError(
                    f"the largest {name} is {value:g} {unit}: give more than 0, at most {most:g}"
                )


def usual_limits(vehicle: Vehicle) -> Limits:
    """Return limits suitable for a vehicle: a climb uses a third of its thrust reserve."""
    spare = GRAVITY * (vehicle.thrust_to_weight - 1.0)
    return Limits(2.5, min(1.5, 0.15 * spare), 0.4)


def excitation(
    vehicle: Vehicle, model: str, limits: Limits, duration: float, controller: str = ""
) -> Scenario:
    """Return a flight with excitation: sweeps of doublets on each axis, then on all at once.

    The doublets of a sweep become shorter, each half by a tenth, which yields the spectrum of a
    square-wave chirp. Between sweeps the drone flies back and forth at full speed, to identify
    drag.

    Args:
        vehicle: the one to fly.
        model: its name or path, for the scenario.
        limits: of commands.
        duration: of the flight [s].
        controller: the one to fly it; by default the usual one.

    Raises:
        WorkbenchError: for an invalid duration or limits.
    """
    limits.check()
    if not LEAST <= duration <= MOST:
        raise WorkbenchError(
            f"the plan lasts {duration:g} s: give {LEAST:g} .. {MOST:g} s; a minute is usual"
        )
    amplitudes = (limits.speed, limits.speed, limits.climb, limits.yaw_rate)
    end = duration - REST
    edges: list[tuple[float, int, float]] = []
    for axis, amplitude in enumerate(amplitudes):
        edges += _sweeps(axis, amplitude, end)
    asked = [0.0, 0.0, 0.0, 0.0]
    script: list[Action] = []
    for time in sorted({edge[0] for edge in edges}):
        for when, axis, value in edges:
            if when == time:
                asked[axis] = value
        script.append(Action(at=time, velocity=asked[:3], yaw_rate=asked[3]))
    script.append(Action(at=end, velocity=[0.0, 0.0, 0.0], yaw_rate=0.0))
    return Scenario(
        title=f"Excitation of {vehicle.name} for workbench identify",
        vehicle=VehicleConfig(model=model),
        controller=controller or DEFAULT,
        rates=Rates(record_period=1.0 / LOG_RATE),
        start=Start(position=[0.0, 0.0, HEIGHT]),
        duration=duration,
        script=script,
    )


def _sweeps(axis: int, amplitude: float, end: float) -> list[tuple[float, int, float]]:
    """Return times and values of an axis: repeated doublets, each a tenth shorter.

    Axes start at different positions in the sweep, so that they are not correlated.
    """
    edges = []
    time = REST + 0.4 * axis
    half = SLOWEST * (FASTEST / SLOWEST) ** (0.25 * axis)
    sign = 1.0
    while time + 2.0 * half < end:
        # short doublets have little effect on a slow drone, and may use the full amplitude
        for value in (sign, -sign):
            edges.append((_tick(time), axis, value * amplitude))
            time += half
        edges.append((_tick(time), axis, 0.0))
        time += 0.25 * half
        sign = -sign
        half *= 0.9
        if half < FASTEST:
            half = SLOWEST
    return edges


def _tick(time: float) -> float:
    return math.floor(time / TICK + 0.5) * TICK
