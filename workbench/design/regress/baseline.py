"""Recorded curves and what they were flown with: CSV files in a folder beside the spec."""

import csv
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from workbench.common.errors import WorkbenchError
from workbench.design.regress.band import Curve
from workbench.design.regress.spec_names import slug, spec_name
from workbench.design.regress.verdict import Comparison

_TIME = "t [s]"


def baseline_folder(spec: Path) -> Path:
    """Return the folder of a spec's baselines: NAME.baseline beside NAME.spec.yaml."""
    return spec.parent / f"{spec_name(spec)}.baseline"


def curves_file(spec: Path, case: str) -> Path:
    """Return where the curves of a case are kept."""
    return baseline_folder(spec) / f"{slug(case)}.csv"


def conditions_file(spec: Path) -> Path:
    """Return where is kept what a spec's baselines were flown with."""
    return baseline_folder(spec) / "flown-with.csv"


def read_curves(path: Path) -> dict[str, Curve]:
    """Return recorded curves by signal; none if there is no such file.

    Raises:
        WorkbenchError: if the file is not such a table.
    """
    if not path.is_file():
        return {}
    try:
        with path.open(newline="", encoding="utf-8") as file:
            names, *rows = csv.reader(file)
        table = np.array(rows, dtype=float)
    except (OSError, ValueError) as error:
        raise WorkbenchError(
            f"{path}: is no table of curves: {error}: record it anew with --update"
        ) from error
    if names[:1] != [_TIME] or len(table) < 2 or table.shape[1:] != (len(names),):
        raise WorkbenchError(f"{path}:1: is no table of curves: record it anew with --update")
    time = table[:, 0]
    if not (np.diff(time) > 0.0).all() or not np.isfinite(table).all():
        raise WorkbenchError(f"{path}: its times do not rise, or a value is no number")
    return {
        name.split(" [")[0]: Curve(time, table[:, index])
        for index, name in enumerate(names)
        if index
    }


def curves_text(curves: Sequence[Comparison]) -> str:
    """Return the table of the curves of one flight, a row each time."""
    names = [_TIME, *(f"{curve.signal} [{curve.unit}]" for curve in curves)]
    columns = [curves[0].flown.time, *(curve.flown.values for curve in curves)]
    rows = [",".join(f"{value:.7g}" for value in row) for row in zip(*columns, strict=True)]
    return "\n".join([",".join(names), *rows]) + "\n"


def read_conditions(path: Path) -> dict[str, float]:
    """Return what baselines were flown with, by name; none if there is no such file.

    Raises:
        WorkbenchError: if the file is not such a table.
    """
    if not path.is_file():
        return {}
    try:
        with path.open(newline="", encoding="utf-8") as file:
            return {name: float(value) for name, value in list(csv.reader(file))[1:]}
    except (OSError, ValueError) as error:
        raise WorkbenchError(f"{path}: has no NAME,VALUE lines: {error}") from error


def conditions_text(values: Mapping[str, float]) -> str:
    """Return the table of what baselines were flown with."""
    lines = [f"{name},{value:.9g}" for name, value in values.items()]
    return "\n".join(["name,value", *lines]) + "\n"
