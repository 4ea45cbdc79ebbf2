"""Noise for samples of thousands of numbers, by seed and sample number.

So the diagram's state needs no memory of that size.
"""

import numpy as np

from workbench.plant.sensors import Noise


def sample_draws(seed: int, number: int) -> np.random.Generator:
    """Return what the random numbers of a sample come from; seed and number are not negative."""
    return _draws(seed, [0, 0, 0, number])


def drawn_bias(noise: Noise, seed: int) -> float:
    """Return the bias that a sensor of a seed has for a whole flight, in the noise's unit."""
    return noise.bias_mean + noise.bias_stddev * float(_draws(seed, [0, 0, 1, 0]).standard_normal())


def _draws(seed: int, counter: list[int]) -> np.random.Generator:
    return np.random.Generator(np.random.Philox(key=seed, counter=counter))
