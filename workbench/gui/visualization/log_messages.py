"""Messages of the process that reads logs and specs to the app, other than its progress."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from workbench.common.errors import unknown_name


@dataclass(frozen=True, eq=False)
class LogContents:
    """All series of a log that can be drawn.

    Attributes:
        path: path of the log.
        vehicle: the flown vehicle.
        begin: time of the first sample [s]; not 0 if recording began in flight.
        end: time of the last sample [s].
        remark: what is missing, "" for nothing.
        units: SI unit of each series, by its name in a flight.
        times: times of the samples of each topic, by its name (n) [s].
        values: values of each series (n), 32-bit if the log has no more.
        topic_of: name of the topic with a series' times.
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
