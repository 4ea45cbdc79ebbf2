"""What a lidar that meets its specification may be off and late by, by hand."""

import dataclasses
from types import SimpleNamespace

import pytest

from workbench.common.resources import find_model
from workbench.design.lidar_accuracy import range_tolerance
from workbench.design.obstacle_detection import slowest_detection
from workbench.plant.loading import load_vehicle
from workbench.plant.sensors import Lidar, Noise


def test_a_range_may_be_off_by_rounding_offset_and_six_deviations(case):
    found = load_vehicle(find_model("dh_drone"))
    lidar = next(each for each in found.sensors if isinstance(each, Lidar))
    noise = Noise(mean=-0.02, stddev=0.01, bias_mean=0.005, bias_stddev=0.002, precision=0.04)
    for resolution, rounding in ((0.0, 0.02), (0.1, 0.05)):
        own = dataclasses.replace(lidar, resolution=resolution, noise=noise)
        with case(resolution):
            expected = 0.001 + rounding + 0.015 + 6.0 * 0.012
            assert range_tolerance(own) == pytest.approx(expected)


def test_a_detection_may_wait_for_a_scan_its_latency_and_its_reader():
    flight = SimpleNamespace(period=0.1, latency=0.03, control_period=0.008)
    assert slowest_detection(flight) == pytest.approx(0.138)
