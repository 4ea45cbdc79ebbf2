"""What is published, decoded by hand from the bytes, against the recording of the same flight."""

import dataclasses
import math
import struct

import numpy as np
import pytest
from pydrake.common.eigen_geometry import Quaternion
from pydrake.math import RollPitchYaw

from workbench.link import drone_topics as topic
from workbench.link.drone_topics import Outfit, drone_topics
from workbench.scenario.scenario import Action, Scenario, SensorsConfig, Start
from workbench.session.session import Session
from workbench.systems.bridge import Bridge
from workbench.systems.telemetry import TopicValues

PERIOD = 1 / 128
"""Every control update."""


@pytest.fixture(scope="module")
def flown():
    """Return a session that flew 2 s through wind, what it published, and the IMU then."""
    scenario = Scenario(
        world="room",
        start=Start(position=[0.5, 0.0, 2.0], roll_pitch_yaw=[0.0, 0.0, 0.5]),
        sensors=SensorsConfig(use=["imu", "gps", "lidar", "magnetometer"]),
        script=[Action(0.0, velocity=[1.0, -0.5, 0.3], yaw_rate=0.2, set={"wind_x": 1.0})],
    )
    session = Session(scenario, bridge=Bridge())
    session.tick(2.0)
    before = session.reading("imu")
    session.tick(PERIOD)
    return session, session.drain(), before


@pytest.fixture
def session(flown):
    return flown[0]


@pytest.fixture
def samples(flown):
    return flown[1]


@pytest.fixture
def imu_before(flown):
    return flown[2]


def payloads(samples, number) -> list[tuple[int, bytes]]:
    return [
        (each.published.t_ns, payload)
        for each in samples
        for found, payload in each.published.payloads
        if found == number
    ]


def table(samples, number, layout) -> np.ndarray:
    """Return time [s] and the numbers of a topic."""
    return np.array([[t * 1e-9, *struct.unpack(layout, p)] for t, p in payloads(samples, number)])


def common(session, rows):
    """Return rows of published numbers and samples of the recording at the same times."""
    recording = session.recording()
    times = {round(t * 1024): index for index, t in enumerate(recording.time)}
    pairs = [(row, times[round(row[0] * 1024)]) for row in rows if round(row[0] * 1024) in times]
    assert len(pairs) > 40
    ours, theirs = zip(*pairs, strict=True)
    return np.array(ours)[:, 1:], list(theirs), recording


def test_samples_come_with_every_control_update_without_a_gap(samples):
    times = [t for t, _ in payloads(samples, topic.POSITION)]
    assert times == [round(index * PERIOD * 1e9) for index in range(len(times))]
    assert len(times) == math.floor(2.0 / PERIOD) + 2


def test_position_and_velocity(session, samples):
    ours, at, recording = common(session, table(samples, topic.POSITION, "<9f"))
    assert ours[:, 0:3] == pytest.approx(recording.p_WB[at], abs=1e-6)
    angles = [RollPitchYaw(Quaternion(q)).vector() for q in recording.q_WB[at]]
    assert ours[:, 3:6] == pytest.approx(np.array(angles), abs=1e-6)
    assert ours[:, 6:9] == pytest.approx(recording.p_WB[at] - [0.5, 0.0, 2.0], abs=1e-6)
    ours, at, recording = common(session, table(samples, topic.VELOCITY, "<6f"))
    assert ours[:, 0:3] == pytest.approx(recording.v_WB[at], abs=1e-6)
    assert ours[:, 3:6] == pytest.approx(recording.w_WB[at], abs=1e-6)


def test_acceleration_force_and_torque(session, samples):
    ours, at, recording = common(session, table(samples, topic.ACCELERATION, "<6f"))
    assert ours[:, 0:3] == pytest.approx(recording.vdot_WB[at], rel=1e-5, abs=1e-5)
    assert ours[:, 3:6] == pytest.approx(recording.wdot_WB[at], rel=1e-5, abs=1e-5)
    ours, at, recording = common(session, table(samples, topic.FORCE_TORQUE, "<6f"))
    assert ours[:, 0:3] == pytest.approx(recording.force_W[at], abs=1e-5)
    assert ours[:, 3:6] == pytest.approx(recording.moment_B[at], abs=1e-6)


def test_rotors_and_command(session, samples):
    ours, at, recording = common(session, table(samples, topic.ROTORS, "<8f"))
    assert ours[:, 0:4] == pytest.approx(recording.rotor_speeds[at], rel=1e-6)
    assert ours[:, 4:8] == pytest.approx(recording.thrusts[at], rel=1e-6)
    ours, at, recording = common(session, table(samples, topic.COMMAND, "<2I4f"))
    assert set(ours[:, 0]) == {0}  # a lease is nobody else's business
    assert set(ours[:, 1]) == {15}
    assert ours[:, 2:6] == pytest.approx(recording.reference[at][:, 0:4], abs=1e-7)


def test_time_is_split_as_in_ros(samples):
    for t_ns, payload in payloads(samples, topic.TIME):
        seconds, nanoseconds, wall = struct.unpack("<iIq", payload)
        assert seconds * 1_000_000_000 + nanoseconds == t_ns
        assert wall > 1.7e18


def test_state_and_switch_come_with_every_sixth_sample(samples):
    states = payloads(samples, topic.DRONE_STATE)
    assert [t for t, _ in states] == [round(i * 6 * PERIOD * 1e9) for i in range(len(states))]
    mode, condition, charge, clearance = struct.unpack("<i16s2f", states[-1][1])
    assert (mode, condition.rstrip(b"\0")) == (6, b"cruising")
    assert 0.99 < charge < 1.0
    assert 0.0 < clearance < 10.0
    assert {p for _, p in payloads(samples, topic.ON_OFF)} == {struct.pack("<i", 1)}
    wind = table(samples, topic.WIND, "<3f")
    assert wind[-1, 1:] == pytest.approx([1.0, 0.0, 0.0])


def test_sensors_are_published_once_a_measurement(session, samples, imu_before):
    reading = imu_before
    imu = payloads(samples, topic.IMU)
    stamps = [struct.unpack_from("<q", payload)[0] for _, payload in imu]
    assert stamps == sorted(set(stamps))
    assert len(imu) > 390
    # between control updates, too, so spectra can be made
    assert set(np.diff([t for t, _ in imu])) == {5_000_000}
    payload = imu[stamps.index(round(reading.stamp * 1e9))][1]
    numbers = struct.unpack("<q10f", payload)
    expected = (*reading.specific_force, *reading.angular_velocity, *reading.q_WS)
    assert numbers[1:] == pytest.approx(expected, abs=1e-6)
    gps = [struct.unpack("<q3d3f", payload) for _, payload in payloads(samples, topic.GPS)]
    assert len(gps) in (20, 21)
    last = session.reading("gps")
    assert gps[-1][1:4] == (last.latitude, last.longitude, last.altitude)
    fields = [struct.unpack("<q3f", p) for _, p in payloads(samples, topic.MAGNETOMETER)]
    assert len(fields) in (100, 101)
    last = session.reading("magnetometer")
    assert fields[-1][0] == round(last.stamp * 1e9)
    assert fields[-1][1:] == pytest.approx(last.magnetic_field, rel=1e-6)


def test_a_scan_is_published_whole_and_summed_up(session, samples):
    scan = session.reading("lidar")
    clouds, sums = payloads(samples, topic.LIDAR_CLOUD), payloads(samples, topic.LIDAR)
    assert len(clouds) == len(sums)
    stamp, *ranges = struct.unpack(f"<q{scan.ranges.size}f", clouds[-1][1])
    assert stamp == round(scan.stamp * 1e9)
    assert ranges == pytest.approx(scan.ranges.reshape(-1), rel=1e-6)
    stamp, returns, rays, nearest, *direction = struct.unpack("<q2I4f", sums[-1][1])
    assert (returns, rays) == (scan.returns, scan.ranges.size)
    assert nearest == pytest.approx(scan.ranges.min(), rel=1e-6)
    index = int(np.argmin(scan.ranges))
    assert direction == pytest.approx(scan.pattern.directions_S[index], abs=1e-6)


def test_the_definition_of_a_cloud_gives_every_ray_its_direction(session):
    about = next(each for each in session.topics if each.id == topic.LIDAR_CLOUD).about
    first, step, columns = about["azimuths"]
    low, rise, layers = about["elevations"]
    scan = session.reading("lidar")
    azimuth, elevation = np.meshgrid(
        first + step * np.arange(columns), low + rise * np.arange(layers)
    )
    rays = [np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth)]
    directions = np.stack([*rays, np.sin(elevation)], axis=2).reshape(-1, 3)
    assert directions == pytest.approx(scan.pattern.directions_S, abs=1e-9)


def test_frames_are_those_of_the_session(session, samples):
    published = {t: p for t, p in payloads(samples, topic.FRAMES)}
    definition = next(each for each in session.topics if each.id == topic.FRAMES)
    names = definition.about["frames"]
    poses = np.array(definition.packer.unpack(published[0])).reshape(len(names), 7)
    assert names[0] == ["world", "base_link"]
    assert poses[0] == pytest.approx([0.5, 0.0, 2.0, math.cos(0.25), 0.0, 0.0, math.sin(0.25)])
    lidar = next(i for i, (_, child) in enumerate(names) if "lidar" in child)
    parent, child = names[lidar]
    assert poses[lidar, 0:3] == pytest.approx(session.pose(parent, child).translation(), abs=1e-6)


def test_nothing_is_made_that_nobody_wants():
    bridge = Bridge()
    bridge.wanted = False
    session = Session(Scenario(), bridge=bridge)
    session.tick(0.1)
    assert session.drain() == []
    bridge.wanted = True
    session.tick(0.1)
    assert len(session.drain()) == 13


@pytest.mark.parametrize("estimator", ["ekf", "complementary"])
def test_the_estimate_is_published_beside_the_truth(estimator):
    session = Session(Scenario(estimator=estimator), bridge=Bridge())
    session.tick(1.0)
    samples, flown = session.drain(), session.recording()
    estimate = [(t, struct.unpack("<21f", p)) for t, p in payloads(samples, topic.ESTIMATE)]
    assert len(estimate) == len(payloads(samples, topic.POSITION))
    both = {round(1e9 * time): index for index, time in enumerate(flown.time)}
    seen = 0
    for t_ns, values in estimate:
        if t_ns in both:
            known, sigma = flown.estimate[both[t_ns]], flown.deviations[both[t_ns]]
            angles = RollPitchYaw(Quaternion(wxyz=known[:4] / np.linalg.norm(known[:4]))).vector()
            expected = [*known[4:7], *angles, *known[10:13], *known[7:10]]
            expected += [*sigma[3:6], *sigma[0:3], *sigma[6:9]]
            assert values == pytest.approx(expected, rel=1e-5, abs=1e-6, nan_ok=True)
            seen += 1
    assert seen > 20
    assert math.isnan(estimate[0][1][-1]) == (estimator == "complementary")


def made(vehicle, state, thrusts) -> dict[int, bytes]:
    """Return the payloads of a motion (13) with thrusts (4), by topic."""
    values = TopicValues(vehicle, drone_topics(Outfit(rotors=4, fast=200.0, slow=20.0)))
    signals = {
        "state": state,
        "acceleration": [0.0] * 6,
        "thrusts": thrusts,
        "reference": [0.0] * 8,
        "speeds": [0.0] * 4,
    }
    return dict([values.clocks(0, 0), *values.fast(signals)])


def test_the_force_of_leaning_rotors_is_turned_into_the_world(vehicle):
    """Each leans another way, so that all of its parts are there."""
    axes = [[0.6, 0.0, 0.8], [0.0, 0.6, 0.8], [0.0, -0.28, 0.96], [-0.28, 0.0, 0.96]]
    rotors = tuple(
        dataclasses.replace(rotor, axis_B=tuple(axis))
        for rotor, axis in zip(vehicle.rotors, axes, strict=True)
    )
    thrusts = [1.0, 2.0, 3.0, 4.0]
    turn = RollPitchYaw(0.3, -0.5, 2.0)
    state = [*turn.ToQuaternion().wxyz(), *[0.0] * 9]
    found = made(dataclasses.replace(vehicle, rotors=rotors), state, thrusts)
    force_W = turn.ToRotationMatrix().matrix() @ (np.array(thrusts) @ np.array(axes))
    assert struct.unpack("<6f", found[topic.FORCE_TORQUE])[:3] == pytest.approx(force_W, abs=1e-6)


def test_a_number_too_large_for_its_field_is_infinite(vehicle):
    state = [1.0, 0.0, 0.0, 0.0, 1e39, -1e300, 2.0, *[0.0] * 6]
    found = made(vehicle, state, [1.0] * 4)
    assert struct.unpack("<9f", found[topic.POSITION])[0:3] == (math.inf, -math.inf, 2.0)
