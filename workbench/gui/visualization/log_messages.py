"""What the process that reads logs and specs sends to the app, besides the share that is read."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from workbench.common.errors import unknown_name


@dataclass(frozen=True, eq=False)
class LogContents:
    """All series of a log that can be drawn.

    Attributes:
        path: of the log.
        vehicle: what flew.
        begin: time of the first sample [s]; not 0 where recording began in flight.
        end: time of the last one [s].
        remark: what is missing, "" if nothing is.
        units: SI unit of each series, by its name in a flight.
        times: of the samples of each topic, by its name (n) [s].
        values: of each series (n), 32-bit where the log has no more.
        topic_of: name of the topic whose times a series has.
    """

    path: Path
    vehicle: str
    begin: float
    end: float
    remark: str
    units: Mapping[str, str]
    times: Mapping[str, np.ndarray]
    values: Mapping[str, np.ndarray]
    topic_of: Mapping[str, str]

    def series(self, name: str, since: float = -np.inf) -> tuple[np.ndarray, np.ndarray]:
        """Return times [s] and values from a time on (N): views.

        Raises:
            WorkbenchError: if there is no such series.
        """
        if name not in self.values:
            raise unknown_name("signal", name, self.values)
        time = self.times[self.topic_of[name]]
        first = int(np.searchsorted(time, since))
        return time[first:], self.values[name][first:]


@dataclass(frozen=True)
class MetricLimit:
    """What a spec demands of a metric: its name, a smallest and a largest value, in its unit."""

    metric: str
    least: float
    most: float


@dataclass(frozen=True, eq=False)
class BaselineBand:
    """Within what a signal may be: its name in specs, times (n) from the edge [s], and ends (n)."""

    signal: str
    time: np.ndarray
    low: np.ndarray
    high: np.ndarray


@dataclass(frozen=True, eq=False)
class CaseLimits:
    """What a case of a spec demands.

    Attributes:
        name: of the case.
        signal: that is judged, by its name in specs, "" for none.
        command: how far it should come, NaN where nothing is said of that.
        limits: of metrics and statistics.
        bands: around its baseline.
    """

    name: str
    signal: str
    command: float
    limits: tuple[MetricLimit, ...]
    bands: tuple[BaselineBand, ...]


@dataclass(frozen=True, eq=False)
class SpecContents:
    """What a spec demands of flights."""

    path: Path
    cases: tuple[CaseLimits, ...]
