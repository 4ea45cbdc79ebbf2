"""Oracles: what exact sensors must read follows from the recording at the stamp, by hand."""

import math

import numpy as np
import pymap3d
import pytest
from scipy.spatial.transform import Rotation

from workbench.plant.home import DEFAULT_HOME
from workbench.plant.magnetic_field import earth_magnetic_field
from workbench.scenario.scenario import Action, Push, Rates, Scenario, ScenarioStart, SensorsConfig
from workbench.session.session import Session

STEP = Rates().physics_step
GRAVITY = np.array([0.0, 0.0, 9.81])
HOME = (47.397742, 8.545594, 488.0)
"""Latitude and longitude [°] and altitude [m] where a world says nothing: PX4's."""
FAST = {"imu": 128.0, "gps": 64.0, "barometer": 64.0, "range_finder": 64.0, "lidar": 16.0}
FAST |= {"magnetometer": 64.0}


def lively(seed: int) -> Scenario:
    """A second of steering, wind and a push, of which every physics step is recorded."""
    script = [
        Action(at=0.0, velocity=[1.5, -1.0, 0.4], yaw_rate=0.4, set={"wind_x": 5.0}),
        Action(at=0.3, push=Push(force=[4.0, 6.0, 0.0], point=[0.1, 0.0, 0.05], duration=0.2)),
    ]
    return Scenario(
        world="room",
        rates=Rates(record_period=STEP),
        start=ScenarioStart(position=[0.2, -0.3, 1.4], roll_pitch_yaw=[0.0, 0.0, 0.7]),
        script=script,
        sensors=SensorsConfig(use=[*FAST], rates=FAST, noise=False, seed=seed),
    )


@pytest.fixture(scope="module")
def flight():
    """Return a session, its recording, and the readings of exact sensors by stamp."""
    session = Session(lively(seed=0))
    readings = {kind: {} for kind in FAST}
    for _ in range(128):
        session.tick(8 * STEP)
        for kind, found in readings.items():
            reading = session.reading(kind)
            found[reading.stamp] = reading
    recording = session.recording()
    assert recording.tilt.max() > 0.15
    assert np.abs(recording.w_WB).max() > 0.5
    return session, recording, readings


def samples(flight, kind):
    """Yield a reading, the sample of the recording at its stamp, and where its sensor is."""
    session, recording, readings = flight
    (sensor,) = (sensor for sensor in session.vehicle.sensors if sensor.kind == kind)
    assert len(readings[kind]) == FAST[kind]
    for stamp, reading in readings[kind].items():
        k = round(stamp / STEP)
        assert recording.time[k] == stamp
        w, x, y, z = recording.q_WB[k]
        R_WB = Rotation.from_quat([x, y, z, w]).as_matrix()
        yield reading, k, recording.p_WB[k] + R_WB @ sensor.p_BS, R_WB @ np.array(sensor.R_BS)


def test_the_imu_feels_the_specific_force_of_its_stamp(flight):
    """Acceleration from differences of what was flown, not from the port that the IMU reads.

    They are those before the stamp: a push may begin then.
    """
    _, recording, _ = flight
    weights = np.array([25.0, -48.0, 36.0, -16.0, 3.0]) / 12.0
    for reading, k, _, R_WS in samples(flight, "imu"):
        # the IMU is at the base link's origin
        way = -1 if k else 1
        v_WB = recording.v_WB[[k + way * j for j in range(5)]]
        force_W = -way * (weights @ v_WB) / STEP + GRAVITY
        assert reading.specific_force == pytest.approx(R_WS.T @ force_W, abs=1e-4)
        assert reading.angular_velocity == pytest.approx(R_WS.T @ recording.w_WB[k], abs=1e-12)
        q_WS = np.array(reading.q_WS)
        assert abs(q_WS @ recording.q_WB[k]) == pytest.approx(1.0, abs=1e-12)
        assert reading.frame == "IMU_link"


def test_the_gps_is_where_pymap3d_has_the_antenna(flight):
    _, recording, _ = flight
    for reading, k, p_WS, _ in samples(flight, "gps"):
        latitude, longitude, altitude = pymap3d.enu2geodetic(*p_WS, *HOME)
        east, north, up = pymap3d.geodetic2enu(
            math.degrees(reading.latitude), math.degrees(reading.longitude), reading.altitude, *HOME
        )
        assert (east, north, up) == pytest.approx(tuple(p_WS), abs=1e-4)
        assert math.degrees(reading.latitude) == pytest.approx(latitude, abs=1e-9)
        assert math.degrees(reading.longitude) == pytest.approx(longitude, abs=1e-9)
        assert reading.altitude == pytest.approx(altitude, abs=1e-4)
        lever = p_WS - recording.p_WB[k]
        velocity = recording.v_WB[k] + np.cross(recording.w_WB[k], lever)
        assert reading.velocity == pytest.approx(velocity, abs=1e-12)


def test_the_range_finder_reads_height_over_the_cosine_of_its_tilt(flight):
    for reading, _, p_WS, R_WS in samples(flight, "range_finder"):
        down = -R_WS[2, 0]
        assert down > 0.5
        assert reading.distance == pytest.approx(p_WS[2] / down, abs=1e-12)


def test_the_barometer_has_the_pressure_of_its_height(flight):
    """ICAO's formula, with geopotential height, for the home's 488 m."""
    for reading, _, p_WS, _ in samples(flight, "barometer"):
        assert reading.altitude == pytest.approx(p_WS[2], abs=1e-6)
        height = 488.0 + p_WS[2]
        geopotential = 6356766.0 * height / (6356766.0 + height)
        pressure = 101325.0 * (1.0 - 0.0065 * geopotential / 288.15) ** 5.255879
        assert reading.pressure == pytest.approx(pressure, rel=1e-7)


def test_the_magnetometer_has_the_field_of_the_home_along_its_axes(flight):
    field = earth_magnetic_field(DEFAULT_HOME)
    for reading, _, _, R_WS in samples(flight, "magnetometer"):
        assert reading.magnetic_field == pytest.approx(R_WS.T @ field, rel=0, abs=1e-18)


def test_the_lidar_ranges_are_those_of_walls_and_ground(flight):
    """The room is 10 m by 8 m inside, its walls are 3 m high; what passes over them is sky."""
    sky = walls = ground = 0
    for scan, _, p_WS, R_WS in samples(flight, "lidar"):
        assert scan.p_WS == pytest.approx(p_WS, abs=1e-12)
        assert pytest.approx(R_WS, abs=1e-12) == scan.R_WS
        azimuth, elevation = np.meshgrid(
            np.radians(np.arange(-180, 180)), np.radians(np.linspace(-15, 15, 16))
        )
        along_S = np.stack(
            [
                np.cos(elevation) * np.cos(azimuth),
                np.cos(elevation) * np.sin(azimuth),
                np.sin(elevation),
            ],
            axis=-1,
        )
        x, y, z = np.moveaxis(along_S @ R_WS.T, -1, 0)
        to_x = (np.copysign(5.0, x) - p_WS[0]) / x
        to_y = (np.copysign(4.0, y) - p_WS[1]) / y
        to_wall = np.minimum(to_x, to_y)
        to_ground = np.where(z < 0.0, -p_WS[2] / np.minimum(z, -1e-12), np.inf)
        over = (p_WS[2] + z * to_wall > 3.0) & (to_wall < to_ground)
        wanted = np.where(over, np.inf, np.minimum(to_wall, to_ground))
        np.testing.assert_allclose(scan.ranges, wanted, rtol=0.0, atol=1e-9)
        sky += over.sum()
        ground += (to_ground < to_wall).sum()
        walls += ((to_wall < to_ground) & ~over).sum()
    assert min(sky, walls, ground) > 1000


def test_exact_sensors_are_exact_at_every_seed(flight):
    session = Session(lively(seed=99))
    session.tick(1.0)
    for kind in ("imu", "gps", "barometer", "magnetometer", "range_finder"):
        last = max(flight[2][kind])
        assert session.reading(kind) == flight[2][kind][last]
