"""Seeded noise: white noise for random input ports, and noise of large samples.

The noise of samples of thousands of numbers is computed from the seed and the sample's number, so
the diagram's state does not contain a generator.
"""

import zlib

import numpy as np
from pydrake.common import RandomDistribution, RandomGenerator
from pydrake.systems.framework import BasicVector, Context, DiagramBuilder, InputPort
from pydrake.systems.primitives import RandomSource

from workbench.dynamics.air.normals import NORMALS_PER_SAMPLE, normal_rows
from workbench.plant.sensors import Noise
from workbench.systems.discrete_system import DiscreteSystem


def add_noise(builder: DiagramBuilder, port: InputPort, period: float) -> RandomSource:
    """Feed a Gaussian random input port with new standard normal numbers every `period` [s]."""
    source = RandomSource(RandomDistribution.kGaussian, port.size(), period)
    builder.AddNamedSystem(noise_source_name(port.get_system().get_name()), source)
    builder.Connect(source.get_output_port(), port)
    return source


class CountedNoise(DiscreteSystem):
    """Standard normal numbers computed from a seed and the time.

    It has no state, so a checkpoint of numbers is complete. Use it for sensors that affect the
    flight; the generator of a `RandomSource` is not part of checkpoints.

    Output port:
        draws (size): new ones after each period.
    Numeric parameter 0: the seed.
    """

    def __init__(self, size: int, period: float) -> None:
        super().__init__()
        self._period = period
        self.DeclareNumericParameter(BasicVector([0.0]))
        needs = {self.time_ticket(), self.pn_ticket()}
        self.DeclareVectorOutputPort("draws", size, self._calc, needs)

    def _calc(self, context: Context, output: BasicVector) -> None:
        number = round(context.get_time() / self._period)
        seed = context.get_numeric_parameter(0)[0]
        draws = output.get_mutable_value()
        blocks = -(
            -len(draws) // NORMALS_PER_SAMPLE
        )  # as `normals.counted_draws` does it in compiled flights
        rows = normal_rows(seed, number * blocks + np.arange(blocks))
        draws[:] = rows.reshape(-1)[: len(draws)]


def add_counted_noise(builder: DiagramBuilder, port: InputPort, period: float) -> CountedNoise:
    """Feed a random input port with numbers of `CountedNoise`, new ones every `period` [s]."""
    source = CountedNoise(port.size(), period)
    builder.AddNamedSystem(noise_source_name(port.get_system().get_name()), source)
    builder.Connect(source.get_output_port(), port)
    return source


def noise_source_name(system: str) -> str:
    """Return the name of the source of a system's noise, by which it gets its own seed."""
    return f"{system}_noise"


def sensor_system_name(sensor: str) -> str:
    """Return the name of a sensor's system; `::` would be a path in a diagram."""
    return f"{sensor.replace('::', '/')}_sensor"


def noise_seed(seed: int, name: str) -> int:
    """Return the seed of a source of noise, from the seed of the flight and the source's name."""
    words = np.random.SeedSequence([seed, zlib.crc32(name.encode())]).generate_state(1)
    return int(words[0])


def seed_noise(source: RandomSource | CountedNoise, root_context: Context, seed: int) -> None:
    """Restart a source with the seed of a flight."""
    context = source.GetMyMutableContextFromRoot(root_context)
    own = noise_seed(seed, source.get_name())
    if isinstance(source, CountedNoise):
        context.get_mutable_numeric_parameter(0).SetAtIndex(0, float(own))
    else:
        source.SetRandomContext(context, RandomGenerator(own))


def sample_draws(seed: int, number: int) -> np.random.Generator:
    """Return the generator of a sample's random numbers; seed and number are not negative."""
    return _draws(seed, [0, 0, 0, number])


def drawn_sensor_bias(noise: Noise, seed: int) -> float:
    """Return the constant bias of a sensor in a flight, in the noise's unit."""
    return noise.bias_mean + noise.bias_stddev * float(_draws(seed, [0, 0, 1, 0]).standard_normal())


def _draws(seed: int, counter: list[int]) -> np.random.Generator:
    return np.random.Generator(np.random.Philox(key=seed, counter=counter))
