"""White noise for random input ports, the same for the same seed."""

import zlib

import numpy as np
from pydrake.common import RandomDistribution, RandomGenerator
from pydrake.systems.framework import Context, DiagramBuilder, InputPort
from pydrake.systems.primitives import RandomSource


def add_noise(builder: DiagramBuilder, port: InputPort, period: float) -> RandomSource:
    """Feed a Gaussian random input port with new standard normal numbers every `period` [s]."""
    source = RandomSource(RandomDistribution.kGaussian, port.size(), period)
    builder.AddNamedSystem(f"{port.get_system().get_name()}_noise", source)
    builder.Connect(source.get_output_port(), port)
    return source


def noise_seed(seed: int, name: str) -> int:
    """Return the seed of one source of noise: another for every flight's seed and every name."""
    words = np.random.SeedSequence([seed, zlib.crc32(name.encode())]).generate_state(1)
    return int(words[0])


def seed_noise(source: RandomSource, root_context: Context, seed: int) -> None:
    """Let a source begin anew with the seed of a flight."""
    context = source.GetMyMutableContextFromRoot(root_context)
    source.SetRandomContext(context, RandomGenerator(noise_seed(seed, source.get_name())))
