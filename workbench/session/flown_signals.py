"""What a flight has recorded, also across a change of its controller."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class FlownSignals:
    """Signals and samples of a flight, or of a part of it.

    Attributes:
        time: recorded times (N) [s].
        signals: (N, size) each, by name.
        samples: rows of each kept sensor, the time first.
    """

    time: np.ndarray
    signals: Mapping[str, np.ndarray]
    samples: Sequence[np.ndarray]

    def followed_by(self, part: "FlownSignals") -> "FlownSignals":
        """Return these and those of the next part; both may have the instant between them."""
        new = part.time > _last(self.time)
        return FlownSignals(
            np.concatenate([self.time, part.time[new]]),
            {
                name: np.concatenate([self.signals[name], values[new]])
                for name, values in part.signals.items()
            },
            [
                np.vstack([before, rows[rows[:, 0] > _last(before[:, 0])]])
                for before, rows in zip(self.samples, part.samples, strict=True)
            ],
        )


def _last(times: np.ndarray) -> float:
    """Return the last of some times [s]; less than any without one."""
    return float(times[-1:].max(initial=-math.inf))
