"""The flight that identifies best: doublets and chirps on throttle, roll, pitch and yaw."""

import math
from dataclasses import dataclass

from workbench.common.errors import WorkbenchError
from workbench.control.controller import DEFAULT
from workbench.plant.gravity import GRAVITY
from workbench.plant.vehicle import Vehicle
from workbench.scenario.scenario import Action, Rates, Scenario, Start, VehicleConfig

LEAST, MOST = 20.0, 600.0
"""Durations of a plan [s]."""
REST = 2.0
"""Hover before and after [s]."""
SLOWEST, FASTEST = 2.0, 0.125
"""Halves of doublets, from the first to the last of a sweep [s]."""
LOG_RATE = 512
"""Of the states that `workbench fly --csv` writes [1/s]."""
HEIGHT = 10.0
"""At which it is flown [m]."""
TICK = 1.0 / 64.0
"""Actions fall on multiples of it [s]."""


@dataclass(frozen=True)
class Limits:
    """What a plan may ask for.

    Attributes:
        speed: level [m/s].
        climb: [m/s].
        yaw_rate: [rad/s].
    """

    speed: float
    climb: float
    yaw_rate: float

    def check(self) -> None:
        """Refuse what cannot be flown.

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
    """Return limits that a vehicle holds: a climb that takes a third of its spare thrust."""
    spare = GRAVITY * (vehicle.thrust_to_weight - 1.0)
    return Limits(2.5, min(1.5, 0.15 * spare), 0.4)


def excitation(
    vehicle: Vehicle, model: str, limits: Limits, duration: float, controller: str = ""
) -> Scenario:
    """Return the flight: axes in turn with sweeps of doublets, then all of them at once.

    A sweep's doublets become shorter, each half by a tenth, so that it has the spectrum of a chirp
    of square waves; between sweeps the drone flies to and fro at full speed, which tells of drag.

    Args:
        vehicle: that flies.
        model: its name or path, for the scenario.
        limits: of what is asked for.
        duration: of all of it [s].
        controller: that flies it; the usual one without.

    Raises:
        WorkbenchError: for a duration or limits that cannot be.
    """
    limits.check()
    if not LEAST <= duration <= MOST:
        raise WorkbenchError(
            f"the plan is to last {duration:g} s: give {LEAST:g} .. {MOST:g} s; a minute is usual"
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
    """Return times and values of an axis: doublets over and over, each a tenth shorter.

    Axes begin at different places of the sweep, so that they do not go together.
    """
    edges = []
    time = REST + 0.4 * axis
    half = SLOWEST * (FASTEST / SLOWEST) ** (0.25 * axis)
    sign = 1.0
    while time + 2.0 * half < end:
        # what is as short as the drone is slow shows little: it may be asked for in full
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
