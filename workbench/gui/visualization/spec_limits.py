"""The limits of a spec, as the process that reads logs and specs sends them to the app."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np


@dataclass(frozen=True, eq=False)
class CaseLimits:
    """Limits of a spec's case.

    Attributes:
        name: name of the case.
        signal: signal to check, by its name in specs, "" for none.
        command: commanded level of the signal, NaN without one.
        limits: smallest and largest value of metrics and statistics by name, in their units.
        bands: bands around its baseline, by the signal's name in specs: times (n) from the edge
            [s], lower and upper edge (n).
    """

    name: str
    signal: str
    command: float
    limits: Mapping[str, tuple[float, float]]
    bands: Mapping[str, tuple[np.ndarray, np.ndarray, np.ndarray]]


@dataclass(frozen=True, eq=False)
class SpecContents:
    """Limits of a spec for flights."""

    path: Path
    cases: tuple[CaseLimits, ...]
