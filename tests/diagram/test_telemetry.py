"""What is published of large scans, beside their rays."""

import dataclasses
import math

import numpy as np
import pytest

from workbench.common.resources import find_model
from workbench.diagram.telemetry import _scan, thinned_columns
from workbench.plant.loading import load_vehicle
from workbench.plant.sensors import Lidar
from workbench.systems.sensors.scan_pattern import make_scan_pattern


def test_the_definition_of_a_thinned_cloud_gives_every_published_ray_its_direction(case):
    found = load_vehicle(find_model("dh_drone"))
    lidar = next(each for each in found.sensors if isinstance(each, Lidar))
    lidar = dataclasses.replace(
        lidar,
        horizontal=dataclasses.replace(lidar.horizontal, samples=10, max_angle=math.pi),
        vertical=dataclasses.replace(lidar.vertical, samples=3, min_angle=-0.3, max_angle=0.4),
    )
    pattern = make_scan_pattern(lidar)
    for stride in (1, 3, 4):
        about = _scan(lidar, pattern, stride)
        first, step, columns = about["azimuths"]
        low, rise, layers = about["elevations"]
        azimuth, elevation = np.meshgrid(
            first + step * np.arange(columns), low + rise * np.arange(layers)
        )
        rays = [np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth)]
        directions = np.stack([*rays, np.sin(elevation)], axis=2).reshape(-1, 3)
        sent = pattern.directions_S[thinned_columns(pattern, stride)]
        with case(stride):
            assert directions == pytest.approx(sent, abs=1e-9)
