"""Margins of one loop for every candidate of a sweep, from the linear model of its hover."""

import copy
from collections.abc import Sequence

import numpy as np

from workbench.common.errors import WorkbenchError
from workbench.control.controller import Loop
from workbench.design.judge.margins import loop_margins
from workbench.design.linear.operating_point import OperatingPoint
from workbench.design.linear.study import LinearStudy
from workbench.design.metrics import MARGINS
from workbench.design.sweep.case import Candidate, SweepCase
from workbench.design.sweep.flown import Progress, Stop
from workbench.plant.variation import Variation
from workbench.scenario.scenario import Scenario


def candidate_margins(
    case: SweepCase,
    candidates: Sequence[Candidate],
    wanted: np.ndarray,
    loop: Loop,
    progress: Progress | None = None,
    stop: Stop | None = None,
) -> np.ndarray:
    """Return the margins of a loop, opened at its actuator, in the sampled model of hover.

    Args:
        case: its scenario and settings are used.
        candidates: (N) whose margins are computed.
        wanted: (N) for which of them.
        loop: whose margins.
        progress: called with the share done.
        stop: True ends with what is done.

    Returns:
        (N, 4) see `metrics.MARGINS`; NaN where they are not wanted, not known yet, or where the
        candidate cannot hover.
    """
    margins = np.full((len(candidates), len(MARGINS)), np.nan)
    point = OperatingPoint(hold=loop.hold)
    own = case.values(case.vehicle())
    study: LinearStudy | None = None
    study_of = Variation()
    todo = np.flatnonzero(wanted)
    for count, index in enumerate(map(int, todo), start=1):
        if stop and stop():
            break
        candidate = candidates[index]
        if study is None or study_of != candidate.variation:
            study_of = candidate.variation
            varied = _varied(case.scenario, study_of)
            study = study.like(varied) if study else LinearStudy(varied)
        try:
            model = study.sampled(point, {**own, **candidate.settings})
            found = loop_margins(model, loop.actuator)
        except WorkbenchError:
            continue
        margins[index] = [getattr(found, metric.name) for metric in MARGINS]
        if progress:
            progress(count / len(todo))
    return margins


def _varied(scenario: Scenario, variation: Variation) -> Scenario:
    """Return a scenario with another variation."""
    other = copy.deepcopy(scenario)
    other.vehicle.variation = variation
    return other
