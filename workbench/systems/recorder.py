"""The recorder: one log for all signals, because each log costs time at every step."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from pydrake.systems.framework import Context, DiagramBuilder, OutputPort
from pydrake.systems.primitives import LogVectorOutput, Multiplexer, VectorLogSink


@dataclass(frozen=True)
class Recorder:
    """A log of stacked signals, and the place of each signal in it."""

    log: VectorLogSink
    places: Mapping[str, slice]

    def now(self, root_context: Context) -> dict[str, np.ndarray]:
        """Return every signal's present value."""
        context = self.log.GetMyContextFromRoot(root_context)
        values = self.log.get_input_port().Eval(context)
        return {name: values[place] for name, place in self.places.items()}

    def times(self, root_context: Context) -> np.ndarray:
        """Return the recorded times (N) [s]."""
        return self.log.FindLog(root_context).sample_times().copy()

    def signals(self, root_context: Context) -> dict[str, np.ndarray]:
        """Return everything recorded, (N, size) each."""
        return self._parted(self.log.FindLog(root_context).data().T.copy())

    def with_rows(
        self, root_context: Context, flown: Sequence[tuple[np.ndarray, np.ndarray]]
    ) -> tuple[np.ndarray, dict[str, np.ndarray]]:
        """Return times (N) [s] and signals (N, size) with rows that compiled code flew.

        Args:
            root_context: of the diagram.
            flown: times and rows of each piece. If the Simulator continues after a piece, it
                records the last row again.
        """
        times = np.concatenate([self.times(root_context), *(each for each, _ in flown)])
        rows = np.concatenate(
            [self.log.FindLog(root_context).data().T, *(each for _, each in flown)]
        )
        times, first = np.unique(times, return_index=True)
        return times, self._parted(rows[first])

    def _parted(self, rows: np.ndarray) -> dict[str, np.ndarray]:
        return {name: rows[:, place] for name, place in self.places.items()}


def add_recorder(
    builder: DiagramBuilder, signals: Mapping[str, OutputPort], period: float
) -> Recorder:
    """Add a log that records all `signals` every `period` seconds."""
    sizes = [port.size() for port in signals.values()]
    ends = np.cumsum(sizes).tolist()
    stack = builder.AddNamedSystem("recorded_signals", Multiplexer(sizes))
    for index, port in enumerate(signals.values()):
        builder.Connect(port, stack.get_input_port(index))
    log = LogVectorOutput(stack.get_output_port(), builder, period)
    log.set_name("recorder")
    places = {
        name: slice(end - size, end) for name, size, end in zip(signals, sizes, ends, strict=True)
    }
    return Recorder(log, places)
