"""The recorder: one log for all signals, because each log costs time at every step."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from pydrake.systems.framework import Context, DiagramBuilder, OutputPort
from pydrake.systems.primitives import LogVectorOutput, Multiplexer, VectorLogSink


@dataclass(frozen=True)
class SignalRecorder:
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
        return self._recorded(root_context)[0]

    def signals(self, root_context: Context) -> dict[str, np.ndarray]:
        """Return everything recorded, (N, size) each."""
        _, rows = self._recorded(root_context)
        return {name: rows[:, place] for name, place in self.places.items()}

    def _recorded(self, root_context: Context) -> tuple[np.ndarray, np.ndarray]:
        """Return times (N) and rows (N, all); a change of integrator records its time again."""
        log = self.log.FindLog(root_context)
        times, first = np.unique(log.sample_times(), return_index=True)
        return times, log.data().T[first]


def add_recorder(
    builder: DiagramBuilder, signals: Mapping[str, OutputPort], period: float
) -> SignalRecorder:
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
    return SignalRecorder(log, places)
