"""Positions of an estimator's sensors, from sensors that are turned."""

import dataclasses
from types import SimpleNamespace

import numpy as np
import pytest
from pydrake.math import RigidTransform, RollPitchYaw, RotationMatrix

from workbench.common.resources import find_model
from workbench.diagram.mounting import gps_repeats, magnetometer_turn, mounting_of
from workbench.diagram.sensing import _on_body
from workbench.plant.home import Home
from workbench.plant.loading import load_vehicle
from workbench.plant.sensors import Noise

R_BS = RotationMatrix(RollPitchYaw(0.3, 1.2, -0.8)).matrix()


@pytest.fixture
def choices():
    """Return those of a drone whose sensors are each at a place of its own, all turned alike."""
    sensors = load_vehicle(find_model("dh_drone")).sensors
    rows = tuple(tuple(row) for row in R_BS.tolist())
    return [
        SimpleNamespace(sensor=dataclasses.replace(each, p_BS=(0.1 * k, -0.2, 0.3), R_BS=rows))
        for k, each in enumerate(sensors)
    ]


def test_each_place_is_that_of_its_sensor_and_a_range_is_along_its_x(choices):
    imu = next(each.sensor for each in choices if each.sensor.kind == "imu")
    places = {each.sensor.kind: each.sensor.p_BS for each in choices}
    found = mounting_of(imu, choices, Home(0.8, 0.15, 400.0))
    assert tuple(found.p_BI) == places["imu"]
    assert tuple(found.p_BG) == places["gps"]
    assert tuple(found.p_BP) == places["barometer"]
    assert tuple(found.p_BR) == places["range_finder"]
    assert found.n_BR == pytest.approx(R_BS @ [1.0, 0.0, 0.0])
    assert magnetometer_turn(choices) == pytest.approx(R_BS)


def test_only_a_gps_that_rounds_all_that_it_measures_repeats_itself(choices, case):
    (gps,) = (each.sensor for each in choices if each.sensor.kind == "gps")
    axes, measured = ("horizontal", "vertical"), ("position", "velocity")
    names = [f"{axis}_{what}" for axis in axes for what in measured]
    coarse = dict.fromkeys(names, Noise(stddev=0.1, precision=1.0))

    def repeats(**noises):
        return gps_repeats([SimpleNamespace(sensor=dataclasses.replace(gps, **coarse | noises))])

    assert repeats()
    for name in names:
        with case(name):
            assert not repeats(**{name: Noise(stddev=0.1, precision=0.05)})
    assert not gps_repeats([])


def test_a_sensor_on_a_link_keeps_its_pose_in_the_body(choices):
    """On the link L that carries it: X_BL X_LS = X_BS, with all joints at zero."""
    sensor = choices[1].sensor
    X_BL = RigidTransform(RollPitchYaw(-0.4, 0.2, 1.5), [0.3, 0.1, -0.2])
    there = _on_body(sensor, X_BL)
    R_LS = np.array(there.R_BS)
    assert X_BL.rotation().matrix() @ R_LS == pytest.approx(R_BS, abs=1e-12)
    assert X_BL @ np.array(there.p_BS) == pytest.approx(sensor.p_BS, abs=1e-12)
