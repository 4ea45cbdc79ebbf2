"""The result of a sweep: a table with rows of candidates, columns of parameters and metrics."""

import csv
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from workbench.common.errors import WorkbenchError, unknown_name
from workbench.design.metrics import SIGNAL_UNIT, SWEPT_METRICS, Metric, find_metric
from workbench.design.sweep.case import SweepCandidate, SweepCase
from workbench.design.sweep.ranges import SweepRange
from workbench.scenario.axes import find_axis

MAX_ARRIVED_ERROR_PCT = 5.0
"""Largest final error of a step that counts as having reached its command [%]."""
SAME_VALUE_TOLERANCE = 5e-4
"""Values with a smaller relative difference look alike in the digits shown, and count as equal."""
_MIN_UNIT_DIFFERENCE = {"s": 1e-4, "%": 0.01, SIGNAL_UNIT: 1e-4, "1": 1e-4, "rad": 1e-4}
"""Values with a smaller difference also count as equal, by unit; relative to the command for its
unit. An overshoot of 1e-14 % is a rounding error."""
SWEEP_TABLE_SUFFIXES = (".csv", ".parquet")
"""Suffixes of the file of a table."""
_TIE_BREAKERS = ("settling_time", "overshoot", "steady_state_error")
"""Metrics for the ranking of candidates with an equal metric."""


@dataclass(frozen=True)
class SweepTable:
    """N candidates of P swept numbers with K metrics each.

    Attributes:
        case: the step flown.
        vehicle: its name.
        ranges: (P) of the sweep.
        method: used to choose candidates.
        seed: of random numbers.
        planned: planned number of candidates; larger than N if the sweep was stopped.
        metrics: (K) measured.
        parameters: (N, P) values of the swept numbers.
        values: (N, K) of the metrics, NaN for none.
        diverged_at: (N) time from the edge to the loss [s], NaN without a loss.
        present: (P) values of the swept numbers without a sweep.
        present_values: (K) metrics with the present values.
    """

    case: SweepCase
    vehicle: str
    ranges: tuple[SweepRange, ...]
    method: str
    seed: int
    planned: int
    metrics: tuple[Metric, ...]
    parameters: np.ndarray
    values: np.ndarray
    diverged_at: np.ndarray
    present: np.ndarray
    present_values: np.ndarray

    def __repr__(self) -> str:
        names = ", ".join(each.name for each in self.ranges)
        return f"<SweepTable of {len(self)} candidates over {names}>"

    def __len__(self) -> int:
        return len(self.diverged_at)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of all columns: swept numbers, metrics, diverged_at."""
        swept = (each.name for each in self.ranges)
        return (*swept, *(metric.name for metric in self.metrics), "diverged_at")

    @property
    def units(self) -> tuple[str, ...]:
        """Units of all columns."""
        command = find_axis(self.case.axis).unit
        swept = (each.unit for each in self.ranges)
        return (*swept, *(metric.unit_for(command) for metric in self.metrics), "s")

    @property
    def rows(self) -> np.ndarray:
        """All columns, (N, P + K + 1)."""
        return np.column_stack([self.parameters, self.values, self.diverged_at])

    @property
    def file_names(self) -> tuple[str, ...]:
        """Names of all columns in files and JSON."""
        return (
            *self.names[: len(self.ranges)],
            *(m.file_name for m in self.metrics),
            self.names[-1],
        )

    @property
    def file_units(self) -> tuple[str, ...]:
        """Units of all columns in files and JSON."""
        command = find_axis(self.case.axis).unit
        own = (m.file_unit.replace(SIGNAL_UNIT, command) for m in self.metrics)
        return (*self.units[: len(self.ranges)], *own, self.units[-1])

    @property
    def file_rows(self) -> np.ndarray:
        """All columns in the units of files and JSON, (N, P + K + 1)."""
        factors = [m.file_factor for m in self.metrics]
        return np.column_stack([self.parameters, self.values * factors, self.diverged_at])

    def column(self, name: str) -> np.ndarray:
        """Return a column (N) by name.

        Raises:
            WorkbenchError: if there is none.
        """
        if name not in self.names:
            raise unknown_name("column", name, self.names)
        column: np.ndarray = self.rows[:, self.names.index(name)]
        return column

    def metric(self, name: str) -> Metric:
        """Return the metric of a column.

        Raises:
            WorkbenchError: if it is not a metric, or was not measured.
        """
        found = find_metric(name, SWEPT_METRICS)
        if found not in self.metrics:
            raise WorkbenchError(
                f"{name} was not measured: ask for margins too, or use one of "
                f"{', '.join(each.name for each in self.metrics)}"
            )
        return found

    @property
    def withheld(self) -> np.ndarray:
        """Which rows (N) flew to the end, but did not begin at rest or have not settled."""
        return np.isnan(self.diverged_at) & np.isnan(self.column("settling_time"))

    def ranking(self, metric: str) -> np.ndarray:
        """Return the rows that flew to the end and settled, as indices, the best metric first.

        Those that came within 5 % of the command are first. If values are equal, see
        `metric_resolution`, those that settle sooner, overshoot less, and end nearer to the command
        are first.

        Raises:
            WorkbenchError: if the metric is unknown or was not measured.
        """
        keys = self._keys(metric)
        order = np.lexsort(keys[::-1])
        counts = np.isnan(self.diverged_at) & ~self.withheld & np.isfinite(keys[1])
        ranked: np.ndarray = order[counts[order]]
        return ranked

    def tied(self, metric: str) -> np.ndarray:
        """Return the rows, as indices, that tie with the first of `ranking`.

        Raises:
            WorkbenchError: if the metric is unknown or was not measured.
        """
        ranked = self.ranking(metric)
        keys = self._keys(metric)[:, ranked]
        tied: np.ndarray = ranked[(np.abs(keys - keys[:, :1]) <= 1.0).all(axis=0)]
        return tied

    @property
    def missed(self) -> np.ndarray:
        """Which rows (N) settled more than 5 % from the command; they rank last."""
        return np.isfinite(self.column("settling_time")) & self._away

    @property
    def _away(self) -> np.ndarray:
        return np.asarray(~(self.column("steady_state_error") <= MAX_ARRIVED_ERROR_PCT))

    def present_is_better(self, metric: str, index: int) -> bool:
        """Return whether the present values rank before a row.

        Raises:
            WorkbenchError: if the metric is unknown or was not measured.
        """
        both = replace(
            self,
            parameters=np.stack([self.present, self.parameters[index]]),
            values=np.stack([self.present_values, self.values[index]]),
            diverged_at=np.full(2, np.nan),
        )
        return both.tied(metric).tolist() == [0]

    def unmoved(self, metric: str) -> tuple[str, ...]:
        """Return the names of swept numbers that a metric does not depend on in this table.

        This means that the metric is equal between rows that differ in nothing else, as on a grid,
        or in all rows.

        Raises:
            WorkbenchError: if the metric is unknown or was not measured.
        """
        shown = self.metric(metric)
        values = self.column(metric)
        least = metric_resolution(shown, values, self.case.amplitude)
        everything = np.zeros(len(values), dtype=int)
        if len(values) > 1 and _widest(values, everything) <= least:
            return tuple(each.name for each in self.ranges)
        if len(self.ranges) == 1:
            return ()
        found = []
        for index, each in enumerate(self.ranges):
            others = np.delete(self.parameters, index, axis=1)
            _, groups = np.unique(others, axis=0, return_inverse=True)
            if _widest(values, groups.ravel()) <= least:
                found.append(each.name)
        return tuple(found)

    def _keys(self, metric: str) -> np.ndarray:
        """Return the ranking keys of rows (4, N), most important first, in whole resolutions."""
        command = self.case.amplitude
        keys = [2.0 * self._away]
        for each in dict.fromkeys(map(self.metric, (metric, *_TIE_BREAKERS))):
            values = self.column(each.name)
            costs = metric_cost(each, values, command)
            keys.append(np.round(costs / metric_resolution(each, values, command)))
        return np.array(keys)

    def candidate(self, index: int) -> SweepCandidate:
        """Return the candidate of a row."""
        return self.case.candidate(self.ranges, self.parameters[index])


def _widest(values: np.ndarray, groups: np.ndarray) -> float:
    """Return the largest spread of values (N) within a group; groups of one do not count.

    It is infinite if only some values of a group exist, or if there is nothing to compare.
    """
    known = np.isfinite(values)
    size, there = np.bincount(groups), np.bincount(groups, weights=known)
    if not known.any() or not (size > 1).any() or ((there > 0) & (there < size)).any():
        return float("inf")
    high, low = np.full(len(size), -np.inf), np.full(len(size), np.inf)
    np.maximum.at(high, groups[known], values[known])
    np.minimum.at(low, groups[known], values[known])
    return float((high - low)[there > 0].max(initial=0.0))


def metric_cost(metric: Metric, values: np.ndarray, command: float) -> np.ndarray:
    """Return values as costs: smaller is better, infinite without a value."""
    far = np.abs(np.abs(values) - abs(command))
    costs = -metric.better * values if metric.better else far
    return np.where(np.isnan(costs), np.inf, costs)


def metric_resolution(metric: Metric, values: np.ndarray, command: float) -> float:
    """Return the smallest significant difference between values of a metric."""
    finite = np.abs(values[np.isfinite(values)])
    least = _MIN_UNIT_DIFFERENCE[metric.unit] * (
        abs(command) if metric.unit == SIGNAL_UNIT else 1.0
    )
    return max(least, SAME_VALUE_TOLERANCE * float(finite.max(initial=0.0)))


def check_table_path(path: Path) -> None:
    """Check that a table can be written, before anything is flown.

    Raises:
        WorkbenchError: if the suffix is unknown, or Parquet cannot be written here.
    """
    if path.suffix not in SWEEP_TABLE_SUFFIXES:
        raise WorkbenchError(f"{path}: a table's name ends in {' or '.join(SWEEP_TABLE_SUFFIXES)}")
    if path.suffix == ".parquet":
        try:
            import pyarrow.parquet  # noqa: F401
        except ImportError:
            raise WorkbenchError(
                f"{path}: Parquet needs pyarrow: `pip install pyarrow`, or name a .csv"
            ) from None


def write_sweep_table(table: SweepTable, path: Path) -> None:
    """Write the table of a sweep, with a row for each candidate; unknown values are left empty.

    CSV has names with units in its first line, such as "kp_roll [1/s^2]"; Parquet has names, with
    the unit in the metadata of each field.

    Raises:
        WorkbenchError: if it cannot be written.
    """
    check_table_path(path)
    try:
        if path.suffix == ".parquet":
            _write_sweep_parquet(table, path)
        else:
            _write_sweep_csv(table, path)
    except OSError as error:
        reason = error.strerror or str(error)
        raise WorkbenchError(f"{path}: cannot be written: {reason}") from error


def _write_sweep_csv(table: SweepTable, path: Path) -> None:
    with path.open("w", newline="", encoding="utf-8") as stream:
        writer = csv.writer(stream)
        heads = zip(table.file_names, table.file_units, strict=True)
        writer.writerow(f"{name} [{unit}]" for name, unit in heads)
        for row in table.file_rows:
            writer.writerow("" if np.isnan(value) else repr(float(value)) for value in row)


def _write_sweep_parquet(table: SweepTable, path: Path) -> None:
    import pyarrow
    import pyarrow.parquet

    fields = [
        pyarrow.field(name, pyarrow.float64(), metadata={"unit": unit})
        for name, unit in zip(table.file_names, table.file_units, strict=True)
    ]
    columns = [
        pyarrow.array(column, mask=np.isnan(column))
        for column in np.ascontiguousarray(table.file_rows.T)
    ]
    pyarrow.parquet.write_table(
        pyarrow.Table.from_arrays(columns, schema=pyarrow.schema(fields)), path
    )
