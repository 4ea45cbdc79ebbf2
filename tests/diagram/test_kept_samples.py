"""Every sample that was delivered, once: against what polling at each control update sees."""

import math

import numpy as np
import pytest

from workbench.scenario.scenario import Scenario, SensorsConfig
from workbench.session.session import Session
from workbench.systems.sensors.samples import SampleTable, ScanStack

STEP = 1 / 1024
KEPT = ("imu", "gps", "barometer", "magnetometer", "range_finder")
CONFIG = SensorsConfig(
    use=["imu", "gps", "lidar", "barometer", "magnetometer", "range_finder", "depth_camera"],
    latency={"gps": 0.15, "barometer": 0.013},
    rates={"depth_camera": 2.0, "imu": 102.4},
    keep=True,
)


@pytest.fixture(scope="module")
def polled():
    """Return a session and the readings that were new after each control period."""
    session = Session(Scenario(world="room", sensors=CONFIG))
    seen: dict[str, list] = {name: [] for name in KEPT}
    session.command(velocity=[0.5, 0.0, 0.2])
    for _ in range(64):
        for name, readings in seen.items():
            reading = session.reading(name)
            if reading is not None and (not readings or readings[-1].stamp != reading.stamp):
                readings.append(reading)
        session.tick(8 * STEP)
    return session, seen


def samples_of(session, name):
    return next(each for each in session.samples() if each.sensor == name)


@pytest.mark.parametrize("name", KEPT)
def test_no_sample_is_lost_and_none_comes_twice(polled, name):
    session, seen = polled
    kept = samples_of(session, name)
    stamps = [reading.stamp for reading in seen[name]]
    assert kept.stamps[: len(stamps)].tolist() == stamps
    assert len(kept.stamps) - len(stamps) in (0, 1)  # the one delivered in the last step
    assert np.all(np.diff(kept.stamps) > 0.0)


def test_values_are_those_of_the_readings(polled):
    session, seen = polled
    compass = samples_of(session, "magnetometer")
    assert compass.columns == ("B_x [T]", "B_y [T]", "B_z [T]")
    for row, reading in zip(compass.values, seen["magnetometer"], strict=False):
        assert row.tolist() == [*reading.magnetic_field]
    kept = samples_of(session, "imu")
    assert len(kept.columns) == kept.values.shape[1]
    for row, reading in zip(kept.values, seen["imu"], strict=False):
        assert row.tolist() == [*reading.specific_force, *reading.angular_velocity, *reading.q_WS]


def test_a_lidar_keeps_its_scans_with_its_poses(polled):
    session, _ = polled
    kept = samples_of(session, "lidar")
    assert isinstance(kept, ScanStack)
    scan = session.reading("lidar")
    assert kept.stamps[-1] == scan.stamp
    assert kept.ranges[-1].tolist() == scan.ranges.tolist()
    assert kept.p_WS[-1].tolist() == scan.p_WS.tolist()
    assert kept.ranges.shape == (len(kept.stamps), 16, 360)


def test_pictures_are_not_kept(polled):
    session, _ = polled
    assert {each.sensor for each in session.samples()} == {*polled[1], "lidar"}


def test_a_silent_sensor_leaves_a_gap():
    session = Session(Scenario(sensors=SensorsConfig(use=["imu"], keep=True)))
    session.tick(0.1)
    session.set("imu_fault", 3.0)
    session.tick(0.2)
    session.set("imu_fault", 0.0)
    session.tick(0.1)
    (kept,) = session.samples()
    assert np.diff(kept.stamps).max() == pytest.approx(0.2, abs=0.01)
    assert np.sort(np.diff(kept.stamps))[-2] == pytest.approx(1 / 200)


def test_nothing_is_kept_unless_asked():
    session = Session(Scenario(sensors=SensorsConfig(use=["imu"])))
    session.tick(0.1)
    assert session.samples() == ()


def test_keeping_does_not_change_the_flight():
    def flown(keep: bool) -> np.ndarray:
        session = Session(Scenario(sensors=SensorsConfig(use=["imu", "gps"], keep=keep)))
        session.command(velocity=[1.0, 0.0, 0.0])
        session.tick(0.5)
        return session.recording().p_WB

    assert flown(True).tolist() == flown(False).tolist()


def test_files_have_what_was_kept(polled, tmp_path):
    session, _ = polled
    assert {samples.suffix for samples in session.samples()} == {".csv", ".npz"}
    for samples in session.samples():
        path = tmp_path / f"{samples.sensor}{samples.suffix}"
        samples.write(path)
        if isinstance(samples, SampleTable):
            header, *rows = path.read_text(encoding="utf-8").splitlines()
            assert header.split(",") == ["stamp [s]", *samples.columns]
            last = [float(cell) for cell in rows[-1].split(",")]
            assert last == [samples.stamps[-1], *samples.values[-1].tolist()]
            assert len(rows) == len(samples.stamps)
        else:
            stored = np.load(path)
            assert stored["ranges"].tolist() == samples.ranges.tolist()
            assert stored["azimuths"][0] == pytest.approx(-math.pi)
