"""The result of a sweep: a row a candidate, a column a parameter and a metric."""

from dataclasses import dataclass

import numpy as np

from workbench.design.step_response import UNITS
from workbench.design.sweep.case import Candidate, SweepCase
from workbench.design.sweep.metrics import ARRIVED, SweepMetric, cost, find_metric
from workbench.design.sweep.ranges import SweepRange
from workbench.errors import WorkbenchError, unknown_name


@dataclass(frozen=True)
class SweepTable:
    """N candidates of P swept numbers with K metrics each.

    Attributes:
        case: the step that they flew.
        vehicle: its name.
        ranges: (P) what was swept.
        method: how candidates were chosen.
        seed: of chance.
        planned: how many were to be flown; more than N where the sweep was stopped.
        metrics: (K) what was measured.
        parameters: (N, P) values of what was swept.
        values: (N, K) of the metrics, NaN where there is none.
        diverged_at: (N) when a candidate was lost, from the edge on [s], NaN if it flew on.
        present: (P) values of what was swept, as they are without a sweep.
        present_values: (K) metrics of the present.
    """

    case: SweepCase
    vehicle: str
    ranges: tuple[SweepRange, ...]
    method: str
    seed: int
    planned: int
    metrics: tuple[SweepMetric, ...]
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
        """Of all columns: what was swept, the metrics, diverged_at."""
        swept = (each.name for each in self.ranges)
        return (*swept, *(metric.name for metric in self.metrics), "diverged_at")

    @property
    def units(self) -> tuple[str, ...]:
        """Of all columns."""
        command = UNITS[self.case.axis]
        swept = (each.unit for each in self.ranges)
        return (*swept, *(metric.unit or command for metric in self.metrics), "s")

    @property
    def rows(self) -> np.ndarray:
        """All columns, (N, P + K + 1)."""
        return np.column_stack([self.parameters, self.values, self.diverged_at])

    def column(self, name: str) -> np.ndarray:
        """Return a column (N) by its name.

        Raises:
            WorkbenchError: if there is none.
        """
        if name not in self.names:
            raise unknown_name("column", name, self.names)
        column: np.ndarray = self.rows[:, self.names.index(name)]
        return column

    def metric(self, name: str) -> SweepMetric:
        """Return the metric of a column.

        Raises:
            WorkbenchError: if it is no metric, or was not measured.
        """
        found = find_metric(name)
        if found not in self.metrics:
            raise WorkbenchError(
                f"{name} was not measured: ask for margins too, or use one of "
                f"{', '.join(each.name for each in self.metrics)}"
            )
        return found

    def ranking(self, metric: str) -> np.ndarray:
        """Return the rows that flew to the end, as indices, those with the best metric first.

        Those that came within 5 % of the command go first; where the metric is equal, what settles
        sooner.

        Raises:
            WorkbenchError: if the metric is unknown or was not measured.
        """
        costs = cost(self.metric(metric), self.column(metric), self.case.amplitude)
        settling = np.nan_to_num(self.column("settling_time"), nan=np.inf)
        missed = ~(self.column("steady_state_error") <= ARRIVED)
        order = np.lexsort((settling, costs, missed))
        flew: np.ndarray = order[np.isnan(self.diverged_at[order]) & np.isfinite(costs[order])]
        return flew

    def candidate(self, index: int) -> Candidate:
        """Return the candidate of a row."""
        return self.case.candidate(self.ranges, self.parameters[index])
