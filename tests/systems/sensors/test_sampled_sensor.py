"""Oracle: a sensor of the time, whose samples say when they were taken."""

import math

import numpy as np
import pytest

from workbench.plant.faults import FAULT_NOISE_FACTOR, Fault
from workbench.systems.sensors.sampled_sensor import SampledSensor

STEP = 1 / 1024
PERIOD = 5 * STEP


class Watch(SampledSensor):
    """Shows the time, and how much its noise is multiplied; remembers how often it was asked."""

    def __init__(self, **settings) -> None:
        super().__init__(size=2, memory=[10.0], **settings)

    def truth(self, context):
        return np.array([context.get_time(), 0.0])

    def sampled(self, context, scale):
        return self.truth(context) + [0.0, scale]

    def next_memory(self, context):
        return super().next_memory(context) + 1.0


@pytest.fixture
def watch(bench):
    return lambda **settings: bench(Watch(period=PERIOD, **settings))


def test_there_is_nothing_before_the_first_sample(watch):
    assert np.isnan(watch().measurement()).all()


def test_samples_are_a_period_apart_to_the_bit(watch):
    bench = watch()
    rows = bench.measurements(500)
    assert rows[:, 0].tolist() == [k * PERIOD for k in range(500)]
    assert rows[:, 1].tolist() == rows[:, 0].tolist()
    assert bench.sensor.samples_taken(bench.context) == 500


def test_a_sample_is_held_until_the_next(watch):
    bench = watch()
    for step in range(1, 40):
        bench.run(step * STEP + 0.4 * STEP)
        assert bench.measurement()[0] == step // 5 * PERIOD


@pytest.mark.parametrize("steps", [0, 1, 4, 5, 6, 12, 35])
def test_a_sample_is_delivered_after_its_latency_and_no_sooner(watch, steps):
    bench = watch(latency=steps * STEP)
    for step in range(80):
        bench.run(step * STEP)
        bench.settle()
        newest = math.floor((step - steps) / 5)
        stamp = bench.measurement()[0]
        assert stamp == newest * PERIOD if newest >= 0 else math.isnan(stamp)


def test_latency_may_be_any_time(watch):
    bench = watch(latency=0.3 * PERIOD)
    bench.run(2.29 * PERIOD)
    assert bench.measurement()[0] == PERIOD
    bench.run(2.31 * PERIOD)
    assert bench.measurement()[0] == 2 * PERIOD


def test_truth_is_now_and_without_noise(watch):
    bench = watch(latency=PERIOD)
    bench.run(1.7 * PERIOD)
    assert bench.sensor.truth_output.Eval(bench.context).tolist() == [1.7 * PERIOD, 0.0]


def test_a_frozen_sensor_goes_on_sending_its_last_values(watch):
    bench = watch()
    bench.run(2.5 * PERIOD)
    bench.order(Fault.FROZEN)
    bench.run(6.5 * PERIOD)
    assert bench.measurement().tolist() == [6 * PERIOD, 2 * PERIOD, 1.0]
    bench.order(Fault.NONE)
    bench.run(7.5 * PERIOD)
    assert bench.measurement().tolist() == [7 * PERIOD, 7 * PERIOD, 1.0]


def test_a_sensor_frozen_from_the_start_sends_its_first_sample(watch):
    bench = watch()
    bench.order(Fault.FROZEN)
    bench.run(3.5 * PERIOD)
    assert bench.measurement().tolist() == [3 * PERIOD, 0.0, 1.0]


def test_a_silent_sensor_sends_nothing(watch):
    bench = watch()
    bench.run(2.5 * PERIOD)
    bench.order(Fault.SILENT)
    bench.run(9.5 * PERIOD)
    assert bench.measurement()[0] == 2 * PERIOD
    assert bench.sensor.samples_taken(bench.context) == 3
    bench.order(Fault.NONE)
    bench.run(10.5 * PERIOD)
    assert bench.measurement()[0] == 10 * PERIOD


def test_what_was_taken_before_the_silence_is_still_delivered(watch):
    bench = watch(latency=2 * PERIOD)
    bench.run(4.5 * PERIOD)
    bench.order(Fault.SILENT)
    assert bench.measurement()[0] == 2 * PERIOD
    bench.run(8.5 * PERIOD)
    assert bench.measurement()[0] == 4 * PERIOD


def test_a_noisy_sensor_has_more_noise(watch):
    bench = watch()
    bench.order(Fault.NOISY)
    bench.run(PERIOD / 2)
    assert bench.measurement()[2] == FAULT_NOISE_FACTOR


@pytest.mark.parametrize("fault", list(Fault))
def test_memory_goes_on_with_every_fault(watch, fault):
    bench = watch()
    bench.order(fault)
    bench.run(4.5 * PERIOD)
    memory = bench.context.get_discrete_state(bench.sensor.memory_index).CopyToVector()
    assert memory.tolist() == [15.0]
