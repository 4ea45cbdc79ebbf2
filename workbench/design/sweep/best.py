"""Find the best candidate of a sweep, confirmed by a flight on the full diagram."""

from dataclasses import dataclass

import numpy as np

from workbench.common.quantity import display_unit
from workbench.design.sweep.case import axis_of
from workbench.design.sweep.ranges import SEED_NAME, VARIATION_PREFIX
from workbench.design.sweep.table import SweepTable, metric_resolution

_VEHICLE_PREFIXES = (VARIATION_PREFIX, "payload_")
"""Prefixes of names of ranges that are not design choices."""
MAX_PROVED_CANDIDATES = 5
"""Largest number of candidates to fly on the full diagram."""


@dataclass(frozen=True)
class BestCandidate:
    """The best candidate that also flies on the full diagram.

    Attributes:
        index: its row in the table.
        metric: the one used for the ranking.
        parameters: (P) its values of the swept numbers.
        values: (K) its metrics in the table.
        flown: (9) its metrics on the full diagram, see `FLOWN_METRICS`.
        refused: rows ranked before it that were lost on the full diagram.
        unmoved: names of the swept numbers that the metric does not depend on.
    """

    index: int
    metric: str
    parameters: np.ndarray
    values: np.ndarray
    flown: np.ndarray
    refused: tuple[int, ...]
    unmoved: tuple[str, ...] = ()

    @property
    def difference(self) -> np.ndarray:
        """Metrics on the full diagram minus those in the table, (9)."""
        return self.flown - self.values[: len(self.flown)]


def why_no_best(table: SweepTable, metric: str) -> str:
    """Return why a sweep has no best candidate, "" if it may have one.

    Ranges of vary.*, payload and seed describe uncertainty, not a design choice. There is also no
    best one among equal candidates.

    Raises:
        WorkbenchError: if the metric is unknown or was not measured.
    """
    tied = table.tied(metric)
    drones = [each.name for each in table.ranges if each.name.startswith(_VEHICLE_PREFIXES)]
    if SEED_NAME in (each.name for each in table.ranges):
        return (
            "no best is chosen: the seed is random: sweep gains with one seed, or look at the "
            "spread"
        )
    if drones:
        verb = "is" if len(drones) == 1 else "are"
        option = "--vary" if drones[0].startswith(VARIATION_PREFIX) else "--set"
        return (
            f"no best is chosen: {' and '.join(drones)} {verb} of the drone, not of its gains: "
            f"sweep gains alone with {option}, or search over such drones with `workbench tune`"
        )
    if not len(tied):
        return _why_none_counts(table, metric)
    unmoved = table.unmoved(metric)
    if len(unmoved) == len(table.ranges):
        return f"no best is chosen: {_all_equal(table, metric, tied)}"
    if len(_distinct_values(table, tied, unmoved)) > 1:
        return (
            f"no best is chosen: {len(tied)} candidates have the same "
            f"{_ranked_value(table, metric, tied)}"
            f", settle equally soon, and are equal in overshoot: {_spans(table, tied, unmoved)}; "
            "sweep by another --metric"
        )
    return ""


def unaffected_numbers_text(table: SweepTable, metric: str) -> str:
    """Return a sentence on the swept numbers that a metric does not depend on, or "".

    Raises:
        WorkbenchError: if the metric is unknown or was not measured.
    """
    names = table.unmoved(metric)
    if not names:
        return ""
    verb = "does" if len(names) == 1 else "do"
    axes = dict.fromkeys(
        axis for axis in (axis_of(each, table.case.controller) for each in names) if axis
    )
    other = [axis for axis in axes if axis != table.case.axis]
    hint = f"; try --axis {' or '.join(other)}" if other else ""
    listed = " and ".join(names)
    return f"{listed} {verb} not move {metric} on axis {table.case.axis}{hint}"


def _all_equal(table: SweepTable, metric: str, tied: np.ndarray) -> str:
    return (
        f"all {len(table)} candidates have the same {_ranked_value(table, metric, tied)}: "
        f"{unaffected_numbers_text(table, metric)}"
    )


def _ranked_value(table: SweepTable, metric: str, tied: np.ndarray) -> str:
    """Return a metric with the value that tied rows have."""
    unit = display_unit(table.units[table.names.index(metric)])
    value = unit.factor * float(table.column(metric)[tied[0]])
    least = unit.factor * metric_resolution(
        table.metric(metric), table.column(metric), table.case.amplitude
    )
    shown = f"{0.0 if abs(value) < least else value:.4g}"
    return f"{metric}, {shown} {unit.symbol}".rstrip()


def _why_none_counts(table: SweepTable, metric: str) -> str:
    """Return why no candidate is ranked."""
    withheld = int(table.withheld.sum())
    if not withheld:
        return f"no candidate flies to the end and has a {metric}"
    if np.isnan(table.column("steady_state_error")[table.withheld]).all():
        return (
            "no best is chosen: no candidate settles: sweep other values"
            if table.case.duration is None
            else f"no best is chosen: no candidate settles within {table.case.duration:g} s: leave "
            "--duration out, or sweep other values"
        )
    return "no best is chosen: no step begins at rest, as the drone drifts in the hover before it"


def _distinct_values(table: SweepTable, rows: np.ndarray, unmoved: tuple[str, ...]) -> np.ndarray:
    """Return the number of different values of relevant parameters among rows."""
    columns = [index for index, each in enumerate(table.ranges) if each.name not in unmoved]
    found: np.ndarray = np.unique(table.parameters[rows][:, columns], axis=0)
    return found


def _spans(table: SweepTable, rows: np.ndarray, unmoved: tuple[str, ...]) -> str:
    """Return the range of rows in each relevant parameter."""
    spans = []
    for index, each in enumerate(table.ranges):
        values = table.parameters[rows, index]
        if each.name not in unmoved:
            spans.append(f"{each.name} {values.min():.4g} .. {values.max():.4g}")
    return ", ".join(spans)


def _nearest_first(table: SweepTable, tied: np.ndarray) -> np.ndarray:
    """Return equal rows, those nearest to the present values first."""
    widths = np.array([each.high - each.low for each in table.ranges])
    away = np.abs((table.parameters[tied] - table.present) / widths).sum(axis=1)
    ordered: np.ndarray = tied[np.argsort(away, kind="stable")]
    return ordered


def prove_best(table: SweepTable, metric: str) -> BestCandidate | None:
    """Fly the best candidates on the full diagram until one flies to the end.

    Args:
        table: of a sweep.
        metric: the one used for the ranking, see `SweepTable.ranking`.

    Returns:
        The best one, or None if none of the first five flies there, or if there is none, see
        `why_no_best`.

    Raises:
        WorkbenchError: if the metric is unknown or was not measured.
    """
    refused: tuple[int, ...] = ()
    if why_no_best(table, metric):
        return None
    from workbench.design.sweep.full_flights import fly_one  # loads Drake

    tied = table.tied(metric)
    ranking = [*_nearest_first(table, tied), *table.ranking(metric)[len(tied) :]]
    for index in map(int, ranking[:MAX_PROVED_CANDIDATES]):
        flown, lost = fly_one(table.case, table.candidate(index))
        if np.isnan(lost):
            return BestCandidate(
                index=index,
                metric=metric,
                parameters=table.parameters[index],
                values=table.values[index],
                flown=np.array(flown),
                refused=refused,
                unmoved=table.unmoved(metric),
            )
        refused = (*refused, index)
    return None
