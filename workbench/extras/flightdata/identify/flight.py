"""The flight of an identification: samples from a log, and the plan of a flight with excitation.

Samples are on one even grid, in SI units and in B. The plan has doublets and chirps on throttle,
roll, pitch and yaw.
"""

import math
from dataclasses import dataclass, field, replace

import numpy as np
from scipy.ndimage import binary_dilation, binary_erosion, uniform_filter1d

from workbench.common.errors import WorkbenchError
from workbench.common.series import TimedArrays
from workbench.control.installed_laws import DEFAULT_CONTROLLER
from workbench.logs.motor_commands import ROTOR_SPEED_COMMANDS
from workbench.plant.gravity import GRAVITY
from workbench.plant.vehicle import Vehicle
from workbench.scenario.scenario import Action, Rates, Scenario, ScenarioStart, VehicleConfig

FLYING_COMMAND_SHARE = 0.5
"""Share of the usual mean command above which a drone flies, averaged over `COMMAND_AVERAGE_S`."""
COMMAND_AVERAGE_S = 1.0
"""[s]."""
IMPACT_FORCE_M_S2 = 30.0
"""Specific force from which on a sample counts as an impact [m/s²]."""
CRASH_RATE_RAD_S = 17.0
"""Angular velocity from which on a sample counts as a crash [rad/s]."""
CONTACT_MARGIN_S = 1.0
"""Time left out before and after ground contact, impacts and crashes [s]."""
MIN_COMMAND_RATE_HZ = 180.0
"""Rate of gyro and commands below which the commands of a rate loop are aliased [1/s]."""
MIN_PLAN_S, MAX_PLAN_S = 20.0, 600.0
"""Limits of the duration of a plan [s]."""
PLAN_REST_S = 2.0
"""Hover before and after a planned flight [s]."""
FIRST_HALF_PERIOD_S, LAST_HALF_PERIOD_S = 2.0, 0.125
"""Half periods of the first and the last doublet in a sweep [s]."""
PLAN_LOG_RATE_HZ = 512
"""Rate of the states written by `workbench fly --csv` [1/s]."""
PLAN_HEIGHT_M = 10.0
"""Height of a planned flight [m]."""
PLAN_TICK_S = 1.0 / 64.0
"""Time step of the actions of a plan [s]."""


@dataclass(frozen=True)
class IdentificationFlight(TimedArrays):
    """A flight, or the usable parts of it; N samples at an even period, n rotors.

    Attributes:
        time: (N) [s].
        commands: (N, n) of the motors, each held until the next sample.
        gyro: (N, 3) angular velocity in B [rad/s].
        force: (N, 3) specific force of the accelerometer in B [m/s²].
        velocity: (N, 3) in B, relative to still air [m/s]; None if unknown.
        voltage: (N) of the battery under load [V]; None if unknown.
        kind: of the commands, `ROTOR_SPEED_COMMANDS` or `FULL_SHARE_COMMANDS`.
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
    kind: str = ROTOR_SPEED_COMMANDS
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

    def pieces(self, shortest: float) -> list["IdentificationFlight"]:
        """Return the runs of good samples of a minimum duration [s]."""
        edges = np.flatnonzero(np.diff(np.concatenate(([0], self.good.astype(int), [0]))))
        runs = zip(edges[::2], edges[1::2], strict=True)
        least = shortest * self.rate
        return [self.only(slice(a, b)) for a, b in runs if b - a >= least]


def free_flight(flight: IdentificationFlight) -> IdentificationFlight:
    """Return a flight with the samples of free flight marked as good.

    Motors run, averaged over a second, and there is no impact or tumbling.

    Raises:
        WorkbenchError: if the motors never run.
    """
    mean = flight.commands.mean(axis=1)
    running = mean[mean > 0.05 * max(mean.max(), 1e-12)]
    if not len(running):
        raise WorkbenchError(f"{flight.name}: the motors never run, so it has no flight")
    many = max(1, round(COMMAND_AVERAGE_S * flight.rate))
    flies = uniform_filter1d(mean, many) > FLYING_COMMAND_SHARE * np.median(running)
    flies = binary_erosion(flies, np.ones(2 * round(CONTACT_MARGIN_S * flight.rate) + 1))
    hard = np.linalg.norm(flight.force, axis=1) > IMPACT_FORCE_M_S2
    hard |= np.linalg.norm(flight.gyro, axis=1) > CRASH_RATE_RAD_S
    hard = binary_dilation(hard, np.ones(2 * round(CONTACT_MARGIN_S * flight.rate) + 1))
    return replace(flight, good=flight.good & flies & ~hard)


def check_finite(flight: IdentificationFlight) -> None:
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
class PlanLimits:
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


def usual_limits(vehicle: Vehicle) -> PlanLimits:
    """Return limits suitable for a vehicle: a climb uses a third of its thrust reserve."""
    spare = GRAVITY * (vehicle.thrust_to_weight - 1.0)
    return PlanLimits(2.5, min(1.5, 0.15 * spare), 0.4)


def excitation(
    vehicle: Vehicle, model: str, limits: PlanLimits, duration: float, controller: str = ""
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
    if not MIN_PLAN_S <= duration <= MAX_PLAN_S:
        raise WorkbenchError(
            f"the plan lasts {duration:g} s: give {MIN_PLAN_S:g} .. {MAX_PLAN_S:g} s; a minute is "
            "usual"
        )
    amplitudes = (limits.speed, limits.speed, limits.climb, limits.yaw_rate)
    end = duration - PLAN_REST_S
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
        controller=controller or DEFAULT_CONTROLLER,
        rates=Rates(record_period=1.0 / PLAN_LOG_RATE_HZ),
        start=ScenarioStart(position=[0.0, 0.0, PLAN_HEIGHT_M]),
        duration=duration,
        script=script,
    )


def _sweeps(axis: int, amplitude: float, end: float) -> list[tuple[float, int, float]]:
    """Return times and values of an axis: repeated doublets, each a tenth shorter.

    Axes start at different positions in the sweep, so that they are not correlated.
    """
    edges = []
    time = PLAN_REST_S + 0.4 * axis
    half = FIRST_HALF_PERIOD_S * (LAST_HALF_PERIOD_S / FIRST_HALF_PERIOD_S) ** (0.25 * axis)
    sign = 1.0
    while time + 2.0 * half < end:
        # short doublets have little effect on a slow drone, and may use the full amplitude
        for value in (sign, -sign):
            edges.append((_on_plan_tick(time), axis, value * amplitude))
            time += half
        edges.append((_on_plan_tick(time), axis, 0.0))
        time += 0.25 * half
        sign = -sign
        half *= 0.9
        if half < LAST_HALF_PERIOD_S:
            half = FIRST_HALF_PERIOD_S
    return edges


def _on_plan_tick(time: float) -> float:
    return math.floor(time / PLAN_TICK_S + 0.5) * PLAN_TICK_S
