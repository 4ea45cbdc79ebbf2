"""Oracle: the recording and the readings of the same flight, and angles by hand."""

import dataclasses
import enum
import json
import math

import numpy as np
import pytest
from pydrake.common.eigen_geometry import Quaternion
from pydrake.math import RotationMatrix
from scipy.spatial.transform import Rotation

from workbench.commands.printing import to_json
from workbench.control.mode import ModeRequest
from workbench.plant.faults import Fault
from workbench.scenario.scenario import Action, Scenario, ScenarioStart, SensorsConfig
from workbench.session.session import Session
from workbench.session.snapshot import Snapshot

RATES = {"imu": 100.0, "gps": 5.0, "lidar": 10.0, "depth_camera": 4.0}
PLAIN = (type(None), bool, int, float, str, enum.IntEnum)


@pytest.fixture(scope="module")
def session():
    script = [
        Action(at=0.0, velocity=[1.0, -0.5, 0.3], yaw_rate=0.3, set={"wind_y": 4.0}),
        Action(at=0.5, set={"barometer_fault": 3.0}),
    ]
    start = ScenarioStart(position=[0.5, 0.4, 1.2], roll_pitch_yaw=[0.1, -0.2, 0.5])
    sensors = SensorsConfig(use=["all"], rates=RATES, latency={"gps": 0.05})
    session = Session(Scenario(world="room", start=start, script=script, sensors=sensors))
    session.tick(1.25)
    return session


@pytest.fixture(scope="module")
def now(session):
    return session.snapshot()


@pytest.fixture(scope="module")
def plain():
    """Return the first look at a flight without sensors or obstacles."""
    return Session().snapshot()


def leaves(value):
    """Yield everything in a value that is no container."""
    if dataclasses.is_dataclass(value):
        for field in dataclasses.fields(value):
            yield from leaves(getattr(value, field.name))
    elif isinstance(value, tuple):
        for item in value:
            yield from leaves(item)
    else:
        yield value


def test_a_snapshot_is_frozen_plain_and_can_be_written_as_json(now, plain):
    for snapshot in (now, plain):
        assert {type(leaf) for leaf in leaves(snapshot) if not isinstance(leaf, PLAIN)} == set()
        assert not any(isinstance(leaf, np.generic) for leaf in leaves(snapshot))
        assert hash(snapshot) == hash(dataclasses.replace(snapshot))
        with pytest.raises(dataclasses.FrozenInstanceError):
            snapshot.time = 0.0
        data = json.loads(to_json(snapshot))
        assert list(data) == [field.name for field in dataclasses.fields(Snapshot)]
    assert json.loads(to_json(now))["gps"]["latitude"] == now.gps.latitude
    assert json.loads(to_json(now))["sensors"][0]["kind"] == "lidar"


def test_a_snapshot_outlives_what_comes_after(session, now):
    kept = to_json(now)
    session.tick(0.1)
    assert to_json(now) == kept
    session.reset()
    session.tick(1.25)
    assert session.snapshot() == now


def test_motion_is_that_of_the_recordings_last_sample(session, now):
    flight = session.recording()
    assert now.time == flight.time[-1] == 1.25
    for name in ("p_WB", "v_WB", "w_WB", "vdot_WB", "thrusts", "reference"):
        assert getattr(now, name) == tuple(getattr(flight, name)[-1]), name
    assert now.wind == tuple(flight.wind_W[-1])
    assert now.wind[1] == 4.0
    assert now.q_WB == pytest.approx(flight.q_WB[-1], abs=1e-15)
    assert now.charge == flight.charge[-1]
    assert now.mode == flight.mode[-1]
    assert now.clearance.distance == flight.clearance[-1]


def test_displacement_is_from_the_start_and_orientation_in_angles(now):
    assert now.displacement == pytest.approx(np.array(now.p_WB) - [0.5, 0.4, 1.2], abs=1e-15)
    assert np.linalg.norm(now.displacement) > 0.3
    w, x, y, z = now.q_WB
    yaw, pitch, roll = Rotation.from_quat([x, y, z, w]).as_euler("ZYX")
    assert now.roll_pitch_yaw == pytest.approx((roll, pitch, yaw), abs=1e-12)


def test_displacement_is_also_from_a_place_that_nobody_named():
    session = Session(Scenario(start=ScenarioStart(mode="off")))
    assert session.snapshot().displacement == (0.0, 0.0, 0.0)


def test_readings_are_what_the_sensors_delivered(session, now):
    assert now.imu == session.reading("imu")
    assert now.gps == session.reading("gps")
    assert now.barometer == session.reading("barometer")
    assert now.magnetometer == session.reading("magnetometer")
    assert now.height == session.reading("range_finder").distance
    assert now.height == pytest.approx(now.p_WB[2] - 0.063, abs=0.1)


def test_the_lidar_is_summed_up(session, now):
    scan = session.reading("lidar")
    ranges = np.where(np.isfinite(scan.ranges), scan.ranges, 1e9)
    layer, column = np.unravel_index(ranges.argmin(), ranges.shape)
    assert (now.lidar.stamp, now.lidar.rays) == (scan.stamp, 5760)
    assert now.lidar.returns == np.isfinite(scan.ranges).sum()
    assert now.lidar.nearest == ranges[layer, column]
    azimuth, elevation = math.radians(column - 180), math.radians(-15 + 2 * layer)
    along = [math.cos(elevation) * math.cos(azimuth), math.cos(elevation) * math.sin(azimuth)]
    assert now.lidar.direction == pytest.approx([*along, math.sin(elevation)], abs=1e-9)


def test_a_lidar_that_sees_nothing_has_no_direction():
    high = ScenarioStart(position=[0.0, 0.0, 90.0])
    session = Session(Scenario(start=high, sensors=SensorsConfig(use=["lidar"])))
    session.tick(0.125)
    lidar = session.snapshot().lidar
    assert (lidar.returns, lidar.nearest, lidar.direction) == (0, math.inf, None)
    assert json.loads(to_json(session.snapshot()))["lidar"]["nearest"] is None


def test_the_clearance_points_to_the_nearest_wall(now):
    """Of the four of the room; the drone drifts to the south, in which the wind is against it."""
    east, west, north, south = (
        5.0 - now.p_WB[0],
        5.0 + now.p_WB[0],
        4.0 - now.p_WB[1],
        4.0 + now.p_WB[1],
    )
    directions = {east: (1, 0, 0), west: (-1, 0, 0), north: (0, 1, 0), south: (0, -1, 0)}
    nearest = min(directions)
    assert now.clearance.direction == pytest.approx(directions[nearest], abs=1e-9)
    assert nearest - 0.6 < now.clearance.distance < nearest - 0.2
    assert now.clearance.warning is False


def test_the_warning_is_given_below_its_distance():
    scenario = Scenario(world="room", start=ScenarioStart(position=[4.0, 0.0, 1.5]))
    for distance, warning in ((0.3, False), (1.0, True)):
        session = Session(scenario, {"warning_distance": distance})
        clearance = session.snapshot().clearance
        assert clearance.warning is warning
        assert 0.3 < clearance.distance < 1.0
        assert clearance.direction == pytest.approx((1.0, 0.0, 0.0), abs=1e-9)


def test_each_sensor_says_how_it_does(now):
    status = {each.kind: each for each in now.sensors}
    assert [each.name for each in now.sensors] == [
        *("lidar", "gps", "camera", "imu", "barometer", "range_finder", "magnetometer")
    ]
    assert {kind: status[kind].asked_rate for kind in RATES} == RATES
    for kind, rate in RATES.items():
        assert status[kind].rate == pytest.approx(rate, rel=1e-12)
        delay = 0.05 if kind == "gps" else 0.0
        assert delay - 1e-9 < status[kind].age < delay + 1.0 / rate + 1e-9
        assert status[kind].fault is Fault.NONE
    assert status["barometer"].fault is Fault.SILENT
    assert 0.75 <= status["barometer"].age < 0.78
    assert status["barometer"].rate == pytest.approx(0.4 * 50.0, rel=0.03)


def test_before_the_first_step_nothing_is_delivered():
    session = Session(Scenario(sensors=SensorsConfig(use=["imu", "gps", "lidar", "range_finder"])))
    now = session.snapshot()
    assert (now.imu, now.gps, now.lidar, now.height) == (None, None, None, None)
    assert {(each.rate, each.age) for each in now.sensors} == {(0.0, math.inf)}


def test_what_there_is_none_of_is_none(plain):
    assert plain.sensors == ()
    for name in ("imu", "gps", "barometer", "magnetometer", "lidar", "height", "clearance"):
        assert getattr(plain, name) is None, name


def test_a_quaternion_is_of_unit_length(now):
    assert math.hypot(*now.q_WB) == pytest.approx(1.0, abs=1e-15)
    R_WB = RotationMatrix(Quaternion(now.q_WB)).matrix()
    assert pytest.approx(np.eye(3), abs=1e-14) == R_WB @ R_WB.T


def test_a_free_way_down_ends_where_the_drone_stands_and_a_request_waits_until_it_is_read():
    session = Session(Scenario(start=ScenarioStart(position=[0.0, 0.0, 3.0])))
    height = 3.0 - session.vehicle.ground_clearance
    for direction, way in (((0.0, 0.0, -1.0), height), ((0.8, 0.0, -0.6), height / 0.6)):
        assert session.free_way(direction, 50.0) == (pytest.approx(way), "the ground")
    assert session.free_way((0.0, 0.0, -1.0), 1.0) == (1.0, "")
    assert session.free_way((0.6, 0.0, 0.8), 50.0) == (50.0, "")
    assert session.waiting_request is ModeRequest.NONE
    session.request("land")
    assert session.waiting_request is ModeRequest.LAND
    session.tick(3 / 16)  # the mode is updated every eighth of a second
    assert session.waiting_request is ModeRequest.NONE
