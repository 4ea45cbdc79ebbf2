"""Where charts take their series from: a flight, or a log."""

from collections.abc import Mapping
from typing import Protocol

import numpy as np


class SeriesSource(Protocol):
    """Series by their names."""

    @property
    def units(self) -> Mapping[str, str]:
        """SI unit of every series, by name."""

    def series(self, name: str, since: float = ...) -> tuple[np.ndarray, np.ndarray]:
        """Return times [s] and values from a time on (N).

        Raises:
            WorkbenchError: if there is no such series.
        """
