"""Margins and damping over two of speed, tilt, climb, yaw rate and payload."""

import csv
import dataclasses
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from workbench.common.errors import WorkbenchError, find_named_row
from workbench.design.judge.loop_judgement import judge_loops
from workbench.design.judge.modes import least_damping, modes
from workbench.design.linear.operating_point import OperatingPoint
from workbench.design.linear.study import LinearStudy
from workbench.plant.gravity import GRAVITY
from workbench.scenario.scenario import Scenario
from workbench.setup import Setup, make_setup

OPERATING_MAP_VALUES = 9
"""Default number of values along each direction."""


@dataclass(frozen=True)
class MapDirection:
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


MAP_DIRECTIONS = (
    MapDirection("speed", "m/s", 0.0, 7.5, "steady flight along x"),
    MapDirection("tilt", "rad", 0.0, 0.5, "an instant of acceleration along x at this tilt"),
    MapDirection("climb", "m/s", -3.0, 3.0, "steady climb"),
    MapDirection("yaw_rate", "rad/s", 0.0, 0.36, "steady turn about the vertical"),
    MapDirection("payload", "1", 0.8, 1.3, "mass as a multiple of what the controller knows"),
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
    first: MapDirection
    second: MapDirection
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
                [*heads, "phase_margin_deg [deg]", "disk_margin [1]", "damping [1]", "weakest_loop"]
            )
            for row, second in enumerate(self.second_values):
                for column, first in enumerate(self.first_values):
                    numbers = (
                        first,
                        second,
                        math.degrees(self.phase_margin[row, column]),
                        self.disk_margin[row, column],
                        self.damping[row, column],
                    )
                    writer.writerow([*(f"{x:.9g}" for x in numbers), self.weakest[row][column]])


def find_direction(name: str) -> MapDirection:
    """Return a direction.

    Raises:
        WorkbenchError: if there is none with that name.
    """
    return find_named_row("direction of a map", name, MAP_DIRECTIONS)


def operating_map(
    first: str,
    second: str,
    *,
    first_values: Sequence[float] | None = None,
    second_values: Sequence[float] | None = None,
    scenario: Scenario | Setup | None = None,
    settings: Mapping[str, float] | None = None,
    progress: Callable[[float], None] | None = None,
) -> OperatingMap:
    """Return margins and damping over a grid.

    Args:
        first: name of one of `MAP_DIRECTIONS`.
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
    across, up = _direction_values(columns, first_values), _direction_values(rows, second_values)
    shape = (len(up), len(across))
    phase, disk, damping = (np.full(shape, math.nan) for _ in range(3))
    weakest = [[""] * shape[1] for _ in range(shape[0])]
    setup = make_setup(scenario, settings)
    studies: dict[float, LinearStudy] = {}
    for row, column in np.ndindex(shape):
        values = {columns.name: float(across[column]), rows.name: float(up[row])}
        factor = values.get("payload", 1.0)
        if factor not in studies:
            loaded = dataclasses.replace(setup.variation, mass=factor * setup.variation.mass)
            studies[factor] = LinearStudy(setup.varied(loaded))
        if progress:
            progress((row * shape[1] + column) / (shape[0] * shape[1]))
        try:
            model = studies[factor].sampled(_point(values))
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
        vehicle=setup.vehicle.name,
        first=columns,
        second=rows,
        first_values=across,
        second_values=up,
        phase_margin=phase,
        disk_margin=disk,
        damping=damping,
        weakest=tuple(map(tuple, weakest)),
    )


def _direction_values(direction: MapDirection, values: Sequence[float] | None) -> np.ndarray:
    """Return the values along a direction."""
    if values is None:
        return np.linspace(direction.low, direction.high, OPERATING_MAP_VALUES)
    found = np.asarray(values, dtype=float)
    if not len(found) or not np.isfinite(found).all():
        raise WorkbenchError(f"the map has no values along {direction.name}: give finite numbers")
    return found


def _point(values: Mapping[str, float]) -> OperatingPoint:
    """Return the operating point of a position in the map."""
    return OperatingPoint(
        velocity=(values.get("speed", 0.0), 0.0, values.get("climb", 0.0)),
        yaw_rate=values.get("yaw_rate", 0.0),
        acceleration=(GRAVITY * math.tan(values.get("tilt", 0.0)), 0.0, 0.0),
    )
