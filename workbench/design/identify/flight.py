"""What identification reads of a log: samples on one even grid, in SI units and in B."""

from dataclasses import dataclass, field, replace

import numpy as np
from scipy.ndimage import binary_dilation, binary_erosion, uniform_filter1d

from workbench.common.errors import WorkbenchError

FLYING = 0.5
"""Share of the usual mean command above which a drone flies, over `STEADY`."""
STEADY = 1.0
"""[s]."""
HARD = 30.0
"""Specific force that is a blow, not flying [m/s²]."""
FAST = 17.0
"""Angular velocity that is a crash [rad/s]."""
AWAY = 1.0
"""Before and after ground, blows and crashes that is left out [s]."""
LEAST_RATE = 180.0
"""Of gyro and commands, below which a rate loop's commands are aliased [1/s]."""
SPEED, SHARE = "speed", "share"
"""What commands are: speeds of rotors [rad/s], or shares of what motors can (0 .. 1)."""


@dataclass(frozen=True)
class Flight:
    """A flight, or the parts of it that can be used; N samples at an even period, n rotors.

    Attributes:
        time: (N) [s].
        commands: (N, n) of the motors, each from its sample on until the next.
        gyro: (N, 3) angular velocity in B [rad/s].
        force: (N, 3) specific force of the accelerometer in B [m/s²].
        velocity: (N, 3) in B, through the air where that is still [m/s]; None where it is not
            known.
        voltage: (N) of the battery under load [V]; None where it is not known.
        kind: of the commands, `SPEED` or `SHARE`.
        good: (N) whether a sample is one of free flight; all are where it is left out.
        command_rate: at which commands were logged, 0 for that of the samples [1/s].
        force_lowpass: cut-off of the accelerometer's second-order filter, 0 if unknown [Hz].
        gyro_lowpass: the same of the gyro.
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
        """Between samples [s]."""
        return float(np.median(np.diff(self.time)))

    @property
    def rate(self) -> float:
        """Samples a second [1/s]."""
        return 1.0 / self.period

    def cut(self, keep: slice) -> "Flight":
        """Return a part of it."""
        names = ("time", "commands", "gyro", "force", "velocity", "voltage", "good")
        known = {name: getattr(self, name) for name in names if getattr(self, name) is not None}
        return replace(self, **{name: values[keep] for name, values in known.items()})

    def pieces(self, shortest: float) -> list["Flight"]:
        """Return the runs of good samples that last at least so long [s]."""
        edges = np.flatnonzero(np.diff(np.concatenate(([0], self.good.astype(int), [0]))))
        runs = zip(edges[::2], edges[1::2], strict=True)
        least = shortest * self.rate
        return [self.cut(slice(a, b)) for a, b in runs if b - a >= least]


def on_even_grid(times: np.ndarray, values: np.ndarray, grid: np.ndarray) -> np.ndarray:
    """Return samples (M, ...) at the times of a grid (N), on straight lines between them."""
    flat = values.reshape(len(values), -1)
    columns = [np.interp(grid, times, column) for column in flat.T]
    return np.stack(columns, axis=1).reshape(len(grid), *values.shape[1:])


def held_on_grid(times: np.ndarray, values: np.ndarray, grid: np.ndarray) -> np.ndarray:
    """Return the sample (M, ...) that was the last one at each time of a grid (N)."""
    place = np.searchsorted(times, grid + 1e-9, side="right") - 1
    return values[np.clip(place, 0, len(values) - 1)]


def free_flight(flight: Flight) -> Flight:
    """Return a flight whose good samples are those of free flight.

    Motors run, in the mean over a second, and nothing hits hard or tumbles.

    Raises:
        WorkbenchError: where the motors never run.
    """
    mean = flight.commands.mean(axis=1)
    running = mean[mean > 0.05 * max(mean.max(), 1e-12)]
    if not len(running):
        raise WorkbenchError(f"{flight.name}: the motors never run: there is no flight in it")
    many = max(1, round(STEADY * flight.rate))
    flies = uniform_filter1d(mean, many) > FLYING * np.median(running)
    flies = binary_erosion(flies, np.ones(2 * round(AWAY * flight.rate) + 1))
    hard = np.linalg.norm(flight.force, axis=1) > HARD
    hard |= np.linalg.norm(flight.gyro, axis=1) > FAST
    hard = binary_dilation(hard, np.ones(2 * round(AWAY * flight.rate) + 1))
    return replace(flight, good=flight.good & flies & ~hard)


def check_finite(flight: Flight) -> None:
    """Refuse a flight with numbers that are none where it is good.

    Raises:
        WorkbenchError: naming what and when.
    """
    named = (("commands", flight.commands), ("gyro", flight.gyro), ("force", flight.force))
    for what, values in named:
        bad = flight.good & ~np.isfinite(values).all(axis=1)
        if bad.any():
            when = flight.time[np.argmax(bad)]
            raise WorkbenchError(f"{flight.name}: {what} are no numbers at {when:.3f} s")
