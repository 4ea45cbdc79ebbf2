"""What holds for every kind of sensor; a new one adds a row."""

import dataclasses
import pickle
import re
from pathlib import Path

import numpy as np
import pytest

from workbench.link.drone_topics import drone_signals
from workbench.link.signal import ANY_DRONE, STAMP_FIELD
from workbench.parameters.parameter_table import flight_table
from workbench.plant.sensors import CORE_SENSORS, added_sensors, sensor_kinds
from workbench.scenario.scenario import Scenario, SensorsConfig, VehicleConfig
from workbench.session.session import Session
from workbench.systems.sensors.samples import SampleTable

ROOT = Path(__file__).parents[3]
ROWS = {
    "imu": ("imu", "<imu><angular_velocity><x>{}</x></angular_velocity></imu>", 0.002),
    "gps": (
        "navsat",
        "<navsat><position_sensing><vertical>{}</vertical></position_sensing></navsat>",
        0.5,
    ),
    "lidar": (
        "gpu_lidar",
        "<lidar><scan><horizontal><samples>8</samples><min_angle>-1</min_angle>"
        "<max_angle>1</max_angle></horizontal></scan>"
        "<range><min>0.1</min><max>90</max></range>{}</lidar>",
        0.05,
    ),
    "range_finder": (
        "gpu_lidar",
        "<lidar><scan><horizontal><samples>1</samples></horizontal></scan>"
        "<range><min>0.1</min><max>90</max></range>{}</lidar>",
        0.02,
    ),
    "barometer": ("air_pressure", "<air_pressure><pressure>{}</pressure></air_pressure>", 2.0),
    "depth_camera": (
        "depth_camera",
        "<camera><horizontal_fov>1</horizontal_fov><image><width>16</width><height>12</height>"
        "</image><clip><near>0.1</near><far>90</far></clip>{}</camera>",
        0.02,
    ),
    "magnetometer": ("magnetometer", "<magnetometer><x>{}</x></magnetometer>", 1e-6),
}
"""Type, element and noise of a sensor of each kind; it looks along body x at a wall."""
RATE_HZ = 25.0
NOISE = '<noise type="gaussian"><stddev>{}</stddev></noise>'
DESCRIPTION = """
<robot name="laden" xmlns:xacro="http://www.ros.org/wiki/xacro">
  <xacro:include filename="$(find dh_drone)/drone.urdf.xacro"/>
{sensors}
</robot>
"""
SENSOR = """
  <gazebo reference="base_link">
    <sensor name="my_{kind}" type="{type}">
      <pose>0.1 0.02 0.03 0.1 -0.2 0.3</pose>
      <update_rate>25</update_rate>
      {content}
    </sensor>
  </gazebo>
"""


@pytest.fixture(scope="module")
def model(tmp_path_factory) -> Path:
    """Return the shipped drone with one more sensor of each kind."""
    sensors = "".join(
        SENSOR.format(kind=kind, type=type_, content=content.format(NOISE.format(stddev)))
        for kind, (type_, content, stddev) in ROWS.items()
    )
    path = tmp_path_factory.mktemp("laden") / "laden.urdf.xacro"
    path.write_text(DESCRIPTION.format(sensors=sensors), encoding="utf-8")
    return path


def laden(model, noise: bool) -> Session:
    """Return a flight on which all of these sensors, and only these, measure."""
    sensors = SensorsConfig(use=[f"my_{kind}" for kind in ROWS], keep=True, noise=noise)
    packages = {"dh_drone": str(ROOT / "models" / "dh_drone")}
    vehicle = VehicleConfig(model=str(model), packages=packages)
    return Session(Scenario(vehicle=vehicle, world="room", sensors=sensors))


@pytest.fixture(scope="module")
def session(model) -> Session:
    return laden(model, noise=True)


def numbers(reading) -> np.ndarray:
    """Return all numbers of a reading but its stamp."""
    values = [getattr(reading, each.name) for each in dataclasses.fields(reading)]
    arrays = [each for each in values if isinstance(each, np.ndarray | float | tuple)][1:]
    return np.concatenate([np.ravel(np.asarray(each, dtype=float)) for each in arrays])


def test_every_kind_has_its_row():
    assert set(ROWS) == set(sensor_kinds())


@pytest.mark.parametrize("kind", ROWS)
def test_a_kind_is_read_measures_at_its_rate_and_repeats_by_its_seed(session, kind):
    session.reset()
    declared = next(each for each in session.vehicle.sensors if each.name == f"my_{kind}")
    assert (declared.kind, type(declared)) in [
        (each.kind, each) for each in (*CORE_SENSORS, *added_sensors())
    ]
    assert declared.p_BS == pytest.approx((0.1, 0.02, 0.03), abs=0.2)
    session.tick(1.0)
    status = next(each for each in session.snapshot().sensors if each.name == f"my_{kind}")
    assert (status.kind, status.asked_rate) == (kind, RATE_HZ)
    assert status.rate == pytest.approx(RATE_HZ) and status.age <= 1.0 / RATE_HZ + 1e-9
    reading = session.reading(f"my_{kind}")
    assert reading.stamp == pytest.approx(1.0 - status.age) and reading.frame
    assert np.isfinite(numbers(reading)).any()
    first = pickle.dumps(reading)
    session.reset()
    session.tick(1.0)
    assert pickle.dumps(session.reading(f"my_{kind}")) == first


def test_the_noise_of_a_few_numbers_is_the_stated_one(model, session, case):
    """No sensor changes the flight, so what differs from exact samples is the noise."""
    session.reset()
    exact = laden(model, noise=False)
    for flight in (session, exact):
        flight.tick(2.0)
    for noisy, true in zip(session.samples(), exact.samples(), strict=True):
        if isinstance(noisy, SampleTable):
            with case(noisy.sensor):
                assert len(noisy.stamps) == 50
                spread = (noisy.values - true.values).std(axis=0).max()
                assert spread == pytest.approx(ROWS[noisy.sensor[3:]][2], rel=0.4)


@pytest.mark.parametrize("kind", ROWS)
def test_a_kind_has_live_parameters_and_falls_silent(session, kind):
    session.reset()
    table = flight_table()
    assert table.of(kind)[0].name == f"{kind}_fault"
    for row in table.of(kind)[1:]:
        session.set(row.name, row.default)
    session.tick(0.5)
    before = session.reading(f"my_{kind}")
    session.set(f"{kind}_fault", 3.0)
    session.tick(0.5)
    assert session.reading(f"my_{kind}").stamp == before.stamp
    session.set(f"{kind}_fault", 0.0)
    session.tick(0.5)
    assert session.reading(f"my_{kind}").stamp > before.stamp


@pytest.mark.parametrize("kind", ROWS)
def test_a_kind_is_on_the_page_and_its_signal_has_its_numbers(session, kind):
    page = (ROOT / "docs" / "sensors.md").read_text(encoding="utf-8")
    assert re.search(rf"^\| `{kind}` \|", page, re.MULTILINE)
    session.reset()
    session.tick(0.1)
    [kept] = [each for each in session.samples() if each.sensor == f"my_{kind}"] or [None]
    for row in drone_signals():
        if row.rate == kind and isinstance(kept, SampleTable):
            stamp, *fields = row.fields_for(ANY_DRONE)
            assert stamp == STAMP_FIELD
            assert sum(each.count for each in fields) == len(kept.columns)
