"""What the flights of a sweep give, and when a flight counts as lost."""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from workbench.design.metrics import FLOWN
from workbench.design.sweep.case import Candidate, SweepCase
from workbench.plant.vehicle import Vehicle

Progress = Callable[[float], None]
"""Takes the share done, 0 .. 1."""
Stop = Callable[[], bool]
"""Asked from time to time; True ends the work with what is done."""


class Flown(NamedTuple):
    """What N candidates did.

    Attributes:
        done: (N) whether a candidate was flown.
        values: (N, 9) metrics, see `metrics.FLOWN`; NaN where there is none.
        diverged_at: (N) when it was lost, from the command's edge on [s], NaN if it flew on.
    """

    done: np.ndarray
    values: np.ndarray
    diverged_at: np.ndarray


FlySweep = Callable[[SweepCase, Vehicle, Sequence[Candidate], Progress | None, Stop | None], Flown]
"""Flies candidates: `fly_compiled` or `fly_full`."""


def nothing_flown(count: int) -> Flown:
    """Return places for so many candidates."""
    return Flown(
        np.zeros(count, dtype=bool),
        np.full((count, len(FLOWN)), np.nan),
        np.full(count, np.nan),
    )
