"""Recorded curves and their conditions: CSV files in a folder next to the spec."""

import csv
import dataclasses
import io
import math
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from workbench.common.errors import WorkbenchError
from workbench.common.plain_files import read_plain_text
from workbench.common.series import Series
from workbench.control.controller_file import load_controller
from workbench.design.regress.spec_names import slug, spec_name
from workbench.design.regress.verdict import ConditionChange, CurveComparison
from workbench.parameters.parameter_table import vehicle_parameters
from workbench.setup import Setup

MAX_BASELINE_BYTES = 64_000_000
"""Size limit of a file."""
_TIME_COLUMN = "t [s]"
BASELINE_REL_TOLERANCE, BASELINE_ABS_TOLERANCE = 1e-6, 1e-12
"""Largest difference, relative and absolute, between values that count as the same."""
_ROTOR_CONSTANTS = (
    "direction",
    "motor_constant",
    "moment_constant",
    "time_constant_up",
    "time_constant_down",
    "max_rot_velocity",
    "rotor_drag_coefficient",
    "rolling_moment_coefficient",
)
_OPTIONAL_ROTOR_CONSTANTS = (
    "inflow_coefficient",
    "ground_effect_coefficient",
    "propeller_radius",
    "linear_motor_constant",
)
"""Constants of rotors that are left out where they are 0: baselines may be older than these."""


def baseline_folder(spec: Path) -> Path:
    """Return the folder of a spec's baselines: NAME.baseline beside NAME.workbench.yaml."""
    return spec.parent / f"{spec_name(spec)}.baseline"


def curves_file(spec: Path, case: str) -> Path:
    """Return the file of the curves of a case."""
    return baseline_folder(spec) / f"{slug(case)}.csv"


def conditions_file(spec: Path) -> Path:
    """Return the file of the conditions of a spec's baselines."""
    return baseline_folder(spec) / "flown-with.csv"


def read_curves(path: Path) -> dict[str, Series]:
    """Return recorded curves by signal; empty without a file.

    Raises:
        WorkbenchError: if the file is invalid.
    """
    if not path.is_file():
        return {}
    try:
        names, *rows = csv.reader(io.StringIO(read_plain_text(path, MAX_BASELINE_BYTES)))
        table = np.array(rows, dtype=float)
    except (ValueError, csv.Error) as error:
        raise WorkbenchError(
            f"{path}: is not a table of curves: {error}: record it again with --update"
        ) from error
    if names[:1] != [_TIME_COLUMN] or len(table) < 2 or table.shape[1:] != (len(names),):
        raise WorkbenchError(f"{path}:1: is not a table of curves: record it again with --update")
    time = table[:, 0]
    if not (np.diff(time) > 0.0).all() or not np.isfinite(table).all():
        raise WorkbenchError(f"{path}: its times do not rise, or a value is not a number")
    heads = [name.removesuffix("]").partition(" [") for name in names[1:]]
    return {
        name: Series(name, unit, time, values)
        for (name, _, unit), values in zip(heads, table.T[1:], strict=True)
    }


def curves_text(curves: Sequence[CurveComparison]) -> str:
    """Return the table of the curves of one flight, with a row for each time."""
    names = [_TIME_COLUMN, *(f"{curve.signal} [{curve.unit}]" for curve in curves)]
    columns = [curves[0].flown.time, *(curve.flown.values for curve in curves)]
    rows = [",".join(f"{value:.7g}" for value in row) for row in zip(*columns, strict=True)]
    return "\n".join([",".join(names), *rows]) + "\n"


def read_conditions(path: Path) -> dict[str, float]:
    """Return the conditions of baselines by name; empty without a file.

    Raises:
        WorkbenchError: if the file is invalid.
    """
    if not path.is_file():
        return {}
    try:
        rows = list(csv.reader(io.StringIO(read_plain_text(path, MAX_BASELINE_BYTES))))
        return {name: float(value) for name, value in rows[1:]}
    except (ValueError, csv.Error) as error:
        raise WorkbenchError(f"{path}: has no NAME,VALUE lines: {error}") from error


def conditions_text(values: Mapping[str, float]) -> str:
    """Return the table of the conditions of baselines."""
    lines = [f"{name},{value:.9g}" for name, value in values.items()]
    return "\n".join(["name,value", *lines]) + "\n"


def conditions(setup: Setup) -> dict[str, float]:
    """Return all numbers common to the flights of a spec, by name."""
    vehicle = setup.vehicle
    rows = vehicle_parameters(vehicle, setup.table)
    found = {row.name: setup.values[row.name] for row in rows}
    found["mass"] = vehicle.mass
    found |= {f"center_of_mass_{axis}": p for axis, p in zip("xyz", vehicle.p_BoBcm_B, strict=True)}
    for i, row in enumerate("xyz"):
        for j, column in list(enumerate("xyz"))[i:]:
            found[f"inertia_{row}{column}"] = vehicle.I_BBcm_B[i][j]
    for number, rotor in enumerate(vehicle.rotors, start=1):
        for name in _ROTOR_CONSTANTS:
            found[f"rotor {number} {name}"] = float(getattr(rotor, name))
        stated = {name: float(getattr(rotor, name)) for name in _OPTIONAL_ROTOR_CONSTANTS}
        found |= {f"rotor {number} {name}": value for name, value in stated.items() if value}
        for axis, place in zip("xyz", rotor.p_BR, strict=True):
            found[f"rotor {number} p_{axis}"] = place
    if vehicle.battery:
        found["battery capacity"] = vehicle.battery.capacity
        found["battery resistance"] = vehicle.battery.resistance
        for index, point in enumerate(vehicle.battery.open_circuit_voltage):
            found[f"battery point {index} charge"], found[f"battery point {index} voltage"] = point
    for name, value in dataclasses.asdict(setup.rates).items():
        found[f"rates {name}"] = value
    for name, value in dataclasses.asdict(setup.variation).items():
        found[f"variation {name}"] = float(value)
    return found


def changed_conditions(
    baseline: Mapping[str, float], now: Mapping[str, float]
) -> tuple[ConditionChange, ...]:
    """Return the values that differ: present ones in order, then those that no longer exist.

    A live parameter that is newer than the baseline had its default.
    """
    known = {**load_controller().table.defaults(), **baseline}
    names = [*now, *(name for name in baseline if name not in now)]
    found = [
        ConditionChange(name, known.get(name, math.nan), now.get(name, math.nan)) for name in names
    ]
    return tuple(
        each
        for each in found
        if not math.isclose(
            each.baseline, each.now, rel_tol=BASELINE_REL_TOLERANCE, abs_tol=BASELINE_ABS_TOLERANCE
        )
    )
