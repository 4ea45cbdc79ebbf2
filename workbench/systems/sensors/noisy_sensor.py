"""A sensor of a few numbers, with noise from a random input port."""

import math
from abc import abstractmethod
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from pydrake.common import RandomDistribution
from pydrake.systems.framework import Context

from workbench.plant.sensors import Noise
from workbench.systems.sensors.sampled_sensor import SampledSensor

DRAWS = 3
"""Normal numbers that a channel takes for a sample."""


class NoiseModel(NamedTuple):
    """What the functions below need, an array (n) each.

    Attributes:
        mean: offset.
        stddev: of a sample's white noise.
        faulty: that of which a noisy sensor has a multiple.
        bias_mean: of the bias drawn once.
        bias_stddev: of the bias drawn once.
        kept: share of the drift that is left after a period.
        driven: deviation of what a period adds to it.
        precision: to which samples are rounded, 0 for none.
    """

    mean: np.ndarray
    stddev: np.ndarray
    faulty: np.ndarray
    bias_mean: np.ndarray
    bias_stddev: np.ndarray
    kept: np.ndarray
    driven: np.ndarray
    precision: np.ndarray


def noise_model(noises: Sequence[Noise], usual: Sequence[float], period: float) -> NoiseModel:
    """Return the noise of channels that are sampled every `period` [s]; `Noise` has the formulas.

    A sample takes three normal numbers for each of its n channels: n for white noise, n for the
    driven drift, n for the bias that is drawn once.

    Args:
        noises: of the channels.
        usual: deviations of a common sensor of the kind, from which a fault makes noise where the
            description has none.
        period: between samples [s].
    """
    drifts = [_drift(noise, period) for noise in noises]
    return NoiseModel(
        mean=np.array([noise.mean for noise in noises]),
        stddev=np.array([noise.stddev for noise in noises]),
        faulty=np.array([n.stddev or common for n, common in zip(noises, usual, strict=True)]),
        bias_mean=np.array([noise.bias_mean for noise in noises]),
        bias_stddev=np.array([noise.bias_stddev for noise in noises]),
        kept=np.array([kept for kept, _ in drifts]),
        driven=np.array([driven for _, driven in drifts]),
        precision=np.array([noise.precision for noise in noises]),
    )


def first_memory(n: int) -> np.ndarray:
    """Return what is remembered of n channels before their first sample: no biases, no drift."""
    return np.concatenate([np.full(n, math.nan), np.zeros(n)])


def next_memory(model: NoiseModel, memory: np.ndarray, draws: np.ndarray) -> np.ndarray:
    """Return the biases and the drift after a sample (2 n).

    Args:
        model: of the noise.
        memory: biases, NaN before they are drawn, and drift at the sample (2 n).
        draws: standard normal numbers (3 n).
    """
    n = model.mean.size
    drift = model.kept * memory[n:] + model.driven * draws[n : 2 * n]
    return np.concatenate((_biases(model, memory, draws), drift))


def noisy(
    model: NoiseModel, exact: np.ndarray, memory: np.ndarray, draws: np.ndarray, scale: float
) -> np.ndarray:
    """Return what is measured (n).

    Args:
        model: of the noise.
        exact: what is to be measured (n).
        memory: see `next_memory`.
        draws: see `next_memory`.
        scale: 1, or so many times its usual deviation has the white noise of a faulty sensor.
    """
    n = model.mean.size
    deviation = model.stddev if scale == 1.0 else scale * model.faulty
    bias = _biases(model, memory, draws) + memory[n:]
    values = exact + (model.mean + bias + deviation * draws[:n])
    if not model.precision.any():
        return values
    step = np.where(model.precision > 0.0, model.precision, 1.0)
    return np.where(model.precision > 0.0, step * np.round(values / step), values)


def _biases(model: NoiseModel, memory: np.ndarray, draws: np.ndarray) -> np.ndarray:
    """Return the biases remembered (n), or at the first sample those drawn."""
    n = model.mean.size
    drawn = model.bias_mean + model.bias_stddev * draws[2 * n :]
    return np.where(np.isnan(memory[:n]), drawn, memory[:n])


def _drift(noise: Noise, period: float) -> tuple[float, float]:
    """Return the share of the drift that remains after a period, and the deviation that is added.

    The drift is a first-order Gauss-Markov process with time constant T and driving density s:
    after dt it is exp(-dt / T) times itself plus a normal number of variance
    s² T / 2 (1 - exp(-2 dt / T)). Source: Maybeck, Stochastic Models, Estimation, and Control,
    volume 1, section 4.9; gz-sensors and RotorS use the same.
    """
    time, density = noise.dynamic_bias_correlation_time, noise.dynamic_bias_stddev
    if time == 0.0:
        return 1.0, 0.0
    variance = -0.5 * density**2 * time * math.expm1(-2.0 * period / time)
    return math.exp(-period / time), math.sqrt(variance)


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
        settings: Sequence[float] = (),
    ) -> None:
        """Declare what `SampledSensor` has, and the port of the noise.

        Args:
            size: of a sample.
            noises: of the first n exact values; any others have none.
            usual: deviations that a noisy sensor has a multiple of, where `noises` has none (n).
            period: between samples [s], a multiple of the physics step.
            latency: from a sample to its delivery [s].
            settings: see `SampledSensor`.
        """
        n = len(noises)
        super().__init__(
            size=size,
            period=period,
            latency=latency,
            memory=first_memory(n).tolist(),
            settings=settings,
        )
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
