"""A sensor of a few numbers, whose noise comes in through a random input port."""

from abc import abstractmethod
from collections.abc import Sequence

import numpy as np
from pydrake.common import RandomDistribution
from pydrake.systems.framework import Context

from workbench.plant.sensors import Noise
from workbench.systems.sensors.noise_model import (
    DRAWS,
    first_memory,
    next_memory,
    noise_model,
    noisy,
)
from workbench.systems.sensors.sampled_sensor import SampledSensor


class NoisySensor(SampledSensor):
    """Adds noise to exact values, then says what a sensor shows of them.

    Input port:
        noise (3 n): standard normal numbers, new ones for each sample; see `noise_model`.
    Memory (2 n): biases and their drift.
    """

    def __init__(
        self,
        *,
        size: int,
        noises: Sequence[Noise],
        usual: Sequence[float],
        period: float,
        latency: float,
    ) -> None:
        """Declare what `SampledSensor` has, and the port of the noise.

        Args:
            size: of a sample.
            noises: of the first n exact values; any others have none.
            usual: deviations that a noisy sensor has a multiple of, where `noises` has none (n).
            period: between samples [s], a multiple of the physics step.
            latency: from a sample to its delivery [s].
        """
        n = len(noises)
        super().__init__(size=size, period=period, latency=latency, memory=first_memory(n).tolist())
        self.noise_model = noise_model(noises, usual, period)
        self.noise_input = self.DeclareVectorInputPort(
            "noise", DRAWS * n, RandomDistribution.kGaussian
        )

    @abstractmethod
    def exact(self, context: Context) -> np.ndarray:
        """Return the values that noise is added to, as they are now."""

    def shown(self, values: np.ndarray) -> np.ndarray:
        """Return a sample (size) from exact or noisy values."""
        return values

    def truth(self, context: Context) -> np.ndarray:
        return self.shown(self.exact(context))

    def sampled(self, context: Context, scale: float) -> np.ndarray:
        values = self.exact(context)
        n = self.noise_model.mean.size
        values[:n] = noisy(
            self.noise_model,
            values[:n],
            self._memory(context),
            self.noise_input.Eval(context),
            scale,
        )
        return self.shown(values)

    def next_memory(self, context: Context) -> np.ndarray:
        draws = self.noise_input.Eval(context)
        return next_memory(self.noise_model, self._memory(context), draws)

    def _memory(self, context: Context) -> np.ndarray:
        return context.get_discrete_state(self.memory_index).CopyToVector()
