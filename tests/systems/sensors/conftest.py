"""A sensor on a bench: its inputs are held, its noise comes from a seed."""

from dataclasses import dataclass

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Context, DiagramBuilder
from pydrake.systems.primitives import RandomSource

from workbench.plant.faults import Fault
from workbench.systems.noise import add_noise, seed_noise
from workbench.systems.sensors.sampled_sensor import SampledSensor

IDENTITY = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


@dataclass
class Bench:
    """A sensor in a diagram of its own, with the source of its noise if it has one."""

    sensor: SampledSensor
    simulator: Simulator
    source: RandomSource | None

    @property
    def context(self) -> Context:
        return self.sensor.GetMyMutableContextFromRoot(self.simulator.get_mutable_context())

    def run(self, until: float) -> None:
        """Go on to a time; what is due at that time happens when the next run begins."""
        self.simulator.AdvanceTo(until)

    def settle(self) -> None:
        """Let what is due now happen."""
        self.simulator.AdvancePendingEvents()

    def order(self, fault: Fault) -> None:
        self.context.get_mutable_numeric_parameter(0).SetAtIndex(0, float(fault))

    def hold(self, **inputs) -> None:
        for name, value in inputs.items():
            self.sensor.GetInputPort(name).FixValue(self.context, np.asarray(value, dtype=float))

    def reading(self):
        return self.sensor.reading(self.context)

    def measurement(self) -> np.ndarray:
        return self.sensor.measurement_output.Eval(self.context).copy()

    def measurements(self, count: int) -> np.ndarray:
        """Return samples taken one after another, (count, 1 + size)."""
        rows = []
        for _ in range(count):
            self.settle()
            rows.append(self.measurement())
            self.run(self.simulator.get_context().get_time() + self.sensor.period)
        return np.array(rows)


@pytest.fixture
def bench():
    """Put a sensor on a bench, with values for its inputs other than noise."""

    def put(sensor: SampledSensor, seed: int = 0, **inputs) -> Bench:
        builder = DiagramBuilder()
        builder.AddNamedSystem("sensor", sensor)
        source = None
        if sensor.HasInputPort("noise"):
            source = add_noise(builder, sensor.GetInputPort("noise"), sensor.period)
        bench = Bench(sensor, Simulator(builder.Build()), source)
        if source is not None:
            seed_noise(source, bench.simulator.get_mutable_context(), seed)
        bench.hold(**inputs)
        return bench

    return put


@pytest.fixture
def record():
    """Return what all sensors of a description have, with any place, as keyword arguments."""

    def common(rate=200.0, p_BS=(0.0, 0.0, 0.0), R_BS=IDENTITY):
        return {
            "name": "it",
            "type": "kind",
            "frame": "it_link",
            "link": "it_link",
            "rate": rate,
            "p_BS": tuple(p_BS),
            "R_BS": tuple(map(tuple, np.asarray(R_BS).tolist())),
        }

    return common
