"""The best candidate of a sweep, flown on the full diagram before it is called so."""

from dataclasses import dataclass

import numpy as np

from workbench.design.sweep.full_flights import fly_one
from workbench.design.sweep.ranges import SEED, VARY
from workbench.design.sweep.table import SweepTable

MOST_TRIED = 5
"""Candidates that the full diagram is asked about."""


@dataclass(frozen=True)
class BestCandidate:
    """The best candidate that flies on the full diagram as well.

    Attributes:
        index: its row in the table.
        metric: by which it is the best.
        parameters: (P) its values of what was swept.
        values: (K) its metrics in the table.
        flown: (9) its metrics on the full diagram, see `metrics.FLOWN`.
        refused: rows that ranked before it, and were lost on the full diagram.
    """

    index: int
    metric: str
    parameters: np.ndarray
    values: np.ndarray
    flown: np.ndarray
    refused: tuple[int, ...]

    @property
    def difference(self) -> np.ndarray:
        """Metrics on the full diagram less those in the table, (9)."""
        return self.flown - self.values[: len(self.flown)]


def why_no_best(table: SweepTable) -> str:
    """Return why a sweep has no best candidate, "" if it may have one.

    A range of vary.* is what a drone may turn out to be, and a seed what the air may do: nothing
    to be chosen.
    """
    drones = [each.name for each in table.ranges if each.name.startswith(VARY)]
    if SEED in (each.name for each in table.ranges):
        return "no best is chosen: a seed is luck: sweep gains with one seed, or look at the spread"
    if not drones:
        return ""
    verb = "is" if len(drones) == 1 else "are"
    return (
        f"no best is chosen: {' and '.join(drones)} {verb} of the drone, not of its gains: sweep "
        "gains alone with --vary, or search over such drones with `workbench tune`"
    )


def prove_best(table: SweepTable, metric: str) -> BestCandidate | None:
    """Fly the best candidates on the full diagram until one flies to the end.

    Args:
        table: of a sweep.
        metric: by which a candidate is the best; see `SweepTable.ranking`.

    Returns:
        The best one, or None if none of the first five flies there, or vary.* or seed is swept,
        see `why_no_best`.

    Raises:
        WorkbenchError: if the metric is unknown or was not measured.
    """
    refused: tuple[int, ...] = ()
    ranking = table.ranking(metric)
    if why_no_best(table):
        return None
    for index in map(int, ranking[:MOST_TRIED]):
        flown, lost = fly_one(table.case, table.candidate(index))
        if np.isnan(lost):
            return BestCandidate(
                index=index,
                metric=metric,
                parameters=table.parameters[index],
                values=table.values[index],
                flown=np.array(flown),
                refused=refused,
            )
        refused = (*refused, index)
    return None
