"""The base class of sensors: a sample of the truth at each period, delivered after a latency."""

import math
from collections.abc import Sequence

import numpy as np
from pydrake.systems.framework import BasicVector, Context, DiscreteValues

from workbench.plant.faults import FAULT_NOISE_FACTOR, Fault
from workbench.systems.discrete_system import DiscreteSystem
from workbench.systems.sensors.samples import RecordedSamples

LATENCY_TOLERANCE_S = 1e-9
"""Tolerance of delivery times, because sums of periods are not exact in binary [s]."""


class SampledSensor(DiscreteSystem):
    """Takes a sample at the end of each period, delivers it after the latency, then holds it.

    A subclass defines the ideal measurement, `truth`, and a sample with noise, `sampled`. The
    samples are discrete state, newest first, so the delivered one follows from state and time
    alone.

    Output ports:
        truth (size): the ideal measurement now.
        measurement (1 + size): stamp [s] and values of the last delivered sample, NaN before the
            first.
    Numeric parameter 0: `faults.Fault`, then the other live parameters of the sensor's kind.
    """

    def __init__(
        self,
        *,
        size: int,
        period: float,
        latency: float = 0.0,
        memory: Sequence[float] = (),
        settings: Sequence[float] = (),
    ) -> None:
        """Declare ports, state and sampling.

        Args:
            size: of a sample.
            period: between samples [s], a multiple of the physics step.
            latency: from a sample to its delivery [s].
            memory: its initial memory, for example of biases.
            settings: initial values of live parameters after the fault.
        """
        super().__init__()
        self.size = size
        self.period = period
        self.latency = latency
        self._depth = 1 + math.ceil(latency / period - LATENCY_TOLERANCE_S)
        self.DeclareNumericParameter(BasicVector([float(Fault.NONE), *settings]))
        self._samples = self.DeclareDiscreteState(np.full(self._depth * (1 + size), math.nan))
        self._count = self.DeclareDiscreteState([0.0])
        self.memory_index = self.DeclareDiscreteState(np.array(memory, dtype=float))
        self.truth_output = self.DeclareVectorOutputPort(
            "truth", size, self._calc_truth, {self.all_input_ports_ticket(), self.pn_ticket()}
        )
        self.measurement_output = self.DeclareVectorOutputPort(
            "measurement",
            1 + size,
            self._calc_measurement,
            {self.xd_ticket(), self.time_ticket()},
        )
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._update)

    def settings(self, context: Context) -> list[float]:
        """Return the live parameters after the fault."""
        found: list[float] = context.get_numeric_parameter(0).value()[1:].tolist()
        return found

    def truth(self, context: Context) -> np.ndarray:
        """Return the ideal measurement now (size)."""
        raise NotImplementedError

    def sampled(self, context: Context, scale: float) -> np.ndarray:
        """Return a sample (size) with noise whose deviation is multiplied by `scale`."""
        raise NotImplementedError

    def next_memory(self, context: Context) -> np.ndarray:
        """Return the memory after a sample; it also advances while a sensor is silent or frozen."""
        return context.get_discrete_state(self.memory_index).CopyToVector()

    def delivered(self, context: Context) -> np.ndarray:
        """Return stamp [s] and values of the last delivered sample (1 + size), NaN without one."""
        samples: np.ndarray = context.get_discrete_state(self._samples).value()
        width, now = 1 + self.size, context.get_time() + LATENCY_TOLERANCE_S
        for begin in range(0, samples.size, width):
            if samples[begin] + self.latency <= now:  # the stamp of none is NaN
                return samples[begin : begin + width].copy()
        return np.full(width, math.nan)

    def samples_taken(self, context: Context) -> int:
        """Return the number of samples taken since the start."""
        return int(context.get_discrete_state(self._count)[0])

    def recorded(self, name: str, stamps: np.ndarray, values: np.ndarray) -> RecordedSamples:
        """Return delivered samples as a record: stamps (N) [s] and values (N, size)."""
        raise NotImplementedError

    def _update(self, context: Context, discrete_state: DiscreteValues) -> None:
        fault = Fault(int(context.get_numeric_parameter(0)[0]))
        discrete_state.set_value(self.memory_index, self.next_memory(context))
        if fault is Fault.SILENT:
            return
        samples, width = context.get_discrete_state(self._samples).value(), 1 + self.size
        values = samples[1:width]
        if fault is not Fault.FROZEN or math.isnan(samples[0]):
            scale = FAULT_NOISE_FACTOR if fault is Fault.NOISY else 1.0
            values = self.sampled(context, scale)
        newest, kept = [context.get_time()], samples[:-width]
        discrete_state.set_value(self._samples, np.concatenate((newest, values, kept)))
        discrete_state.set_value(self._count, [self.samples_taken(context) + 1.0])

    def _calc_truth(self, context: Context, output: BasicVector) -> None:
        output.SetFromVector(self.truth(context))

    def _calc_measurement(self, context: Context, output: BasicVector) -> None:
        output.SetFromVector(self.delivered(context))
