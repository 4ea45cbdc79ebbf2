"""Margins and damping over two of speed, tilt, climb, yaw rate and payload."""

import copy
import csv
import dataclasses
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from workbench.common.errors import WorkbenchError, find_row
from workbench.design.judge.loop_judgement import judge_loops
from workbench.design.judge.modes import least_damping, modes
from workbench.design.linear.operating_point import OperatingPoint
from workbench.design.linear.study import LinearStudy
from workbench.gains.gains import flight_gains
from workbench.plant.gravity import GRAVITY
from workbench.scenario.scenario import Scenario

COUNT = 9
"""Default number of values along each direction."""


@dataclass(frozen=True)
class Direction:
    """An axis of a map.

    Attributes:
        name: of the quantity.
        unit: of its values.
        low: default first value.
        high: default last value.
        words: its meaning.
    """

    name: str
    unit: str
    low: float
    high: float
    words: str


DIRECTIONS = (
    Direction("speed", "m/s", 0.0, 7.5, "steady flight along x"),
    Direction("tilt", "rad", 0.0, 0.5, "an instant of acceleration along x at this tilt"),
    Direction("climb", "m/s", -3.0, 3.0, "steady climb"),
    Direction("yaw_rate", "rad/s", 0.0, 0.36, "steady turn about the vertical"),
    Direction("payload", "1", 0.8, 1.3, "mass as a multiple of what the controller knows"),
)


@dataclass(frozen=True)
class OperatingMap:
    """Margins of all loops over a grid of operating points; NaN where there is no such flight.

    Attributes:
        vehicle: its name.
        first: direction of the columns.
        second: direction of the rows.
        first_values: (c).
        second_values: (r).
        phase_margin: (r, c) smallest of all loops [rad], 0 where unstable.
        disk_margin: (r, c) smallest of all loops, 0 where unstable.
        damping: (r, c) smallest of all modes, negative where unstable.
        weakest: (r) rows of (c) names of the loop with the smallest disk margin, "" for none.
    """

    vehicle: str
    first: Direction
    second: Direction
    first_values: np.ndarray
    second_values: np.ndarray
    phase_margin: np.ndarray
    disk_margin: np.ndarray
    damping: np.ndarray
    weakest: tuple[tuple[str, ...], ...]

    def write_csv(self, path: Path) -> None:
        """Write a row for each point."""
        with path.open("w", newline="", encoding="utf-8") as file:
            writer = csv.writer(file)
            heads = [f"{each.name} [{each.unit}]" for each in (self.first, self.second)]
            writer.writerow(
                [*heads, "phase_margin [rad]", "disk_margin [1]", "damping [1]", "weakest_loop"]
            )
            for row, second in enumerate(self.second_values):
                for column, first in enumerate(self.first_values):
                    numbers = (
                        first,
                        second,
                        self.phase_margin[row, column],
                        self.disk_margin[row, column],
                        self.damping[row, column],
                    )
                    writer.writerow([*(f"{x:.9g}" for x in numbers), self.weakest[row][column]])


def find_direction(name: str) -> Direction:
    """Return a direction.

    Raises:
        WorkbenchError: if there is none with that name.
    """
    return find_row("direction of a map", name, DIRECTIONS)


def operating_map(
    first: str,
    second: str,
    *,
    first_values: Sequence[float] | None = None,
    second_values: Sequence[float] | None = None,
    scenario: Scenario | None = None,
    settings: Mapping[str, float] | None = None,
    progress: Callable[[float], None] | None = None,
) -> OperatingMap:
    """Return margins and damping over a grid.

    Args:
        first: name of one of `DIRECTIONS`.
        second: name of another one.
        first_values: (c) in its unit; None for even steps over its usual range.
        second_values: (r), the same for the second.
        scenario: its vehicle and rates are used.
        settings: parameter values.
        progress: called with the share done, 0 .. 1.

    Raises:
        WorkbenchError: if a direction is unknown or both are the same, or the vehicle cannot be
            read.
    """
    columns, rows = find_direction(first), find_direction(second)
    if first == second:
        raise WorkbenchError(f"a map goes along two directions: name another one beside {first}")
    across, up = _values(columns, first_values), _values(rows, second_values)
    shape = (len(up), len(across))
    phase, disk, damping = (np.full(shape, math.nan) for _ in range(3))
    weakest = [[""] * shape[1] for _ in range(shape[0])]
    scenario = scenario or Scenario()
    empty = LinearStudy(scenario)
    studies: dict[float, LinearStudy] = {}
    for row, column in np.ndindex(shape):
        values = {columns.name: float(across[column]), rows.name: float(up[row])}
        factor = values.get("payload", 1.0)
        if factor not in studies:
            studies[factor] = empty.like(_loaded(scenario, factor))
        study = studies[factor]
        gains = flight_gains(study.vehicle, scenario.vehicle.gains, settings, study.controller)
        if progress:
            progress((row * shape[1] + column) / (shape[0] * shape[1]))
        try:
            model = study.sampled(_point(values), gains)
        except WorkbenchError:
            continue  # no such flight: the map is empty there
        found = [
            (margins.disk_margin, margins.phase_margin, judged.loop)
            for judged in judge_loops(model)
            for margins in (judged.actuator, judged.error)
        ]
        disk[row, column], _, weakest[row][column] = min(found)
        phase[row, column] = min(each[1] for each in found)
        damping[row, column] = least_damping(modes(model))
    return OperatingMap(
        vehicle=study.vehicle.name,
        first=columns,
        second=rows,
        first_values=across,
        second_values=up,
        phase_margin=phase,
        disk_margin=disk,
        damping=damping,
        weakest=tuple(map(tuple, weakest)),
    )


def _values(direction: Direction, values: Sequence[float] | None) -> np.ndarray:
    """Return the values along a direction."""
    if values is None:
        return np.linspace(direction.low, direction.high, COUNT)
    found = np.asarray(values, dtype=float)
    if not len(found) or not np.isfinite(found).all():
        raise WorkbenchError(f"the map has no values along {direction.name}: give finite numbers")
    return found


def _loaded(scenario: Scenario, factor: float) -> Scenario:
    """Return a scenario with a multiple of its mass, unknown to the controller."""
    loaded = copy.deepcopy(scenario)
    variation = loaded.vehicle.variation
    loaded.vehicle.variation = dataclasses.replace(variation, mass=factor * variation.mass)
    return loaded


def _point(values: Mapping[str, float]) -> OperatingPoint:
    """Return the operating point of a position in the map."""
    return OperatingPoint(
        velocity=(values.get("speed", 0.0), 0.0, values.get("climb", 0.0)),
        yaw_rate=values.get("yaw_rate", 0.0),
        acceleration=(GRAVITY * math.tan(values.get("tilt", 0.0)), 0.0, 0.0),
    )
