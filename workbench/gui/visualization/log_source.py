"""The series of a log, for charts."""

from collections.abc import Mapping

import numpy as np

from workbench.common.errors import unknown_name
from workbench.gui.visualization.log_messages import LogContents


class LogSource:
    """Series of a log by the names that a flight has.

    Args:
        contents: of the log.
    """

    def __init__(self, contents: LogContents) -> None:
        self._contents = contents

    @property
    def units(self) -> Mapping[str, str]:
        """SI unit of every series, by name."""
        return self._contents.units

    def series(self, name: str, since: float = -np.inf) -> tuple[np.ndarray, np.ndarray]:
        """Return times [s] and values from a time on (N): views.

        Raises:
            WorkbenchError: if there is no such series.
        """
        if name not in self._contents.values:
            raise unknown_name("signal", name, self._contents.values)
        time = self._contents.times[self._contents.topic_of[name]]
        first = int(np.searchsorted(time, since))
        return time[first:], self._contents.values[name][first:]
