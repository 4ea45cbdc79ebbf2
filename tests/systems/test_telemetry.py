"""What is published, decoded by hand from the bytes, against the recording of the same flight."""

import dataclasses
import math
import struct

import numpy as np
import pytest
from pydrake.common.eigen_geometry import Quaternion
from pydrake.math import RollPitchYaw

from workbench.link import drone_topics as topic
from workbench.link.drone_topics import drone_topics
from workbench.link.picture import PictureLayout, Pinhole
from workbench.link.picture_signals import COLOUR_IMAGE_SIGNAL, DEPTH_IMAGE_SIGNAL
from workbench.link.signal import TopicOptions
from workbench.plant.servo import Servo
from workbench.plant.vehicle import VehicleServo
from workbench.scenario.scenario import Action, Scenario, ScenarioStart, SensorsConfig
from workbench.session.session import Session
from workbench.systems.bridge import Bridge
from workbench.systems.sensors.readings import DepthImage
from workbench.systems.telemetry import TopicValues

PERIOD = 1 / 128
"""Every control update."""


@pytest.fixture(scope="module")
def flown():
    """Return a session that flew 2 s through wind, what it published, and the IMU then."""
    scenario = Scenario(
        world="room",
        start=ScenarioStart(position=[0.5, 0.0, 2.0], roll_pitch_yaw=[0.0, 0.0, 0.5]),
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
    times = [t for t, _ in payloads(samples, topic.POSITION_SIGNAL.id)]
    assert times == [round(index * PERIOD * 1e9) for index in range(len(times))]
    assert len(times) == math.floor(2.0 / PERIOD) + 2


def test_position_and_velocity(session, samples):
    ours, at, recording = common(session, table(samples, topic.POSITION_SIGNAL.id, "<9f"))
    assert ours[:, 0:3] == pytest.approx(recording.p_WB[at], abs=1e-6)
    angles = [RollPitchYaw(Quaternion(q)).vector() for q in recording.q_WB[at]]
    assert ours[:, 3:6] == pytest.approx(np.array(angles), abs=1e-6)
    assert ours[:, 6:9] == pytest.approx(recording.p_WB[at] - [0.5, 0.0, 2.0], abs=1e-6)
    ours, at, recording = common(session, table(samples, topic.VELOCITY_SIGNAL.id, "<6f"))
    assert ours[:, 0:3] == pytest.approx(recording.v_WB[at], abs=1e-6)
    assert ours[:, 3:6] == pytest.approx(recording.w_WB[at], abs=1e-6)


def test_acceleration_force_and_torque(session, samples):
    ours, at, recording = common(session, table(samples, topic.ACCELERATION_SIGNAL.id, "<6f"))
    assert ours[:, 0:3] == pytest.approx(recording.vdot_WB[at], rel=1e-5, abs=1e-5)
    assert ours[:, 3:6] == pytest.approx(recording.wdot_WB[at], rel=1e-5, abs=1e-5)
    ours, at, recording = common(session, table(samples, topic.FORCE_TORQUE_SIGNAL.id, "<6f"))
    assert ours[:, 0:3] == pytest.approx(recording.force_W[at], abs=1e-5)
    assert ours[:, 3:6] == pytest.approx(recording.moment_B[at], abs=1e-6)


def test_rotors_and_command(session, samples):
    ours, at, recording = common(session, table(samples, topic.ROTORS_SIGNAL.id, "<8f"))
    assert ours[:, 0:4] == pytest.approx(recording.rotor_speeds[at], rel=1e-6)
    assert ours[:, 4:8] == pytest.approx(recording.thrusts[at], rel=1e-6)
    ours, at, recording = common(session, table(samples, topic.COMMAND_SIGNAL.id, "<2I4f"))
    assert set(ours[:, 0]) == {0}  # a lease is nobody else's business
    assert set(ours[:, 1]) == {15}
    assert ours[:, 2:6] == pytest.approx(recording.reference[at][:, 0:4], abs=1e-7)


def test_time_is_split_as_in_ros(samples):
    for t_ns, payload in payloads(samples, topic.CLOCK_SIGNAL.id):
        seconds, nanoseconds, wall = struct.unpack("<iIq", payload)
        assert seconds * 1_000_000_000 + nanoseconds == t_ns
        assert wall > 1.7e18


def test_state_and_switch_come_with_every_sixth_sample(samples):
    states = payloads(samples, topic.DRONE_STATE_SIGNAL.id)
    assert [t for t, _ in states] == [round(i * 6 * PERIOD * 1e9) for i in range(len(states))]
    mode, condition, charge, clearance = struct.unpack("<i16s2f", states[-1][1])
    assert (mode, condition.rstrip(b"\0")) == (6, b"cruising")
    assert 0.99 < charge < 1.0
    assert 0.0 < clearance < 10.0
    assert {p for _, p in payloads(samples, topic.ON_OFF_SIGNAL.id)} == {struct.pack("<i", 1)}
    wind = table(samples, topic.WIND_SIGNAL.id, "<3f")
    assert wind[-1, 1:] == pytest.approx([1.0, 0.0, 0.0])


def test_sensors_are_published_once_a_measurement(session, samples, imu_before):
    reading = imu_before
    imu = payloads(samples, topic.IMU_SIGNAL.id)
    stamps = [struct.unpack_from("<q", payload)[0] for _, payload in imu]
    assert stamps == sorted(set(stamps))
    assert len(imu) > 390
    # between control updates, too, so spectra can be made
    assert set(np.diff([t for t, _ in imu])) == {5_000_000}
    payload = imu[stamps.index(round(reading.stamp * 1e9))][1]
    numbers = struct.unpack("<q10f", payload)
    expected = (*reading.specific_force, *reading.angular_velocity, *reading.q_WS)
    assert numbers[1:] == pytest.approx(expected, abs=1e-6)
    gps = [
        struct.unpack("<q3d3f", payload) for _, payload in payloads(samples, topic.GPS_SIGNAL.id)
    ]
    assert len(gps) in (20, 21)
    last = session.reading("gps")
    assert gps[-1][1:4] == (last.latitude, last.longitude, last.altitude)
    fields = [struct.unpack("<q3f", p) for _, p in payloads(samples, topic.MAGNETOMETER_SIGNAL.id)]
    assert len(fields) in (100, 101)
    last = session.reading("magnetometer")
    assert fields[-1][0] == round(last.stamp * 1e9)
    assert fields[-1][1:] == pytest.approx(last.magnetic_field, rel=1e-6)


def test_a_scan_is_published_whole_and_summed_up(session, samples):
    scan = session.reading("lidar")
    clouds, sums = (
        payloads(samples, topic.LIDAR_CLOUD_SIGNAL.id),
        payloads(samples, topic.LIDAR_SIGNAL.id),
    )
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
    about = next(each for each in session.topics if each.id == topic.LIDAR_CLOUD_SIGNAL.id).about
    first, step, columns = about["azimuths"]
    low, rise, layers = about["elevations"]
    scan = session.reading("lidar")
    azimuth, elevation = np.meshgrid(
        first + step * np.arange(columns), low + rise * np.arange(layers)
    )
    rays = [np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth)]
    directions = np.stack([*rays, np.sin(elevation)], axis=2).reshape(-1, 3)
    assert directions == pytest.approx(scan.pattern.directions_S, abs=1e-9)


def test_a_published_depth_image_places_the_ground_at_height_zero():
    """The intrinsics of the topic, the optical frame and the pixels, on a flat world."""
    scenario = Scenario(
        start=ScenarioStart(position=[0.0, 0.0, 2.0], roll_pitch_yaw=[0.0, 0.0, 0.7]),
        sensors=SensorsConfig(use=["depth_camera"], rates={"depth_camera": 30.0}),
    )
    session = Session(scenario, bridge=Bridge())
    X_WC = session.pose("world", "camera_optical")
    session.tick(0.45)
    samples = session.drain()
    depths = payloads(samples, DEPTH_IMAGE_SIGNAL.id)
    stamps = [struct.unpack_from("<q", payload)[0] for _, payload in depths]
    assert stamps == [0, 200_000_000, 400_000_000]  # every sixth of 30 a second
    about = next(each for each in session.topics if each.id == DEPTH_IMAGE_SIGNAL.id).about
    assert (about["width"], about["height"], about["frame"]) == (160, 120, "camera_optical")
    z = np.frombuffer(depths[0][1], "<u2", offset=8).reshape(120, 160) / 1e3
    v, u = np.nonzero(z)
    assert len(v) > 2000 and v.min() > 60  # below the horizon, as far as 10 m
    rays = [(u - about["cx"]) / about["fx"], (v - about["cy"]) / about["fy"], np.ones(len(u))]
    points = X_WC.rotation().matrix() @ (z[v, u] * np.array(rays)) + X_WC.translation()[:, None]
    assert np.abs(points[2]).max() < 2e-3
    colours = payloads(samples, COLOUR_IMAGE_SIGNAL.id)
    assert [t for t, _ in colours] == [t for t, _ in depths]
    colour = np.frombuffer(colours[0][1], np.uint8, offset=8).reshape(120, 160, 3)
    sky = np.round(255 * np.array([0.72, 0.84, 0.95]))
    assert np.abs(colour[10, 80] - sky).max() <= 1


def test_depth_is_in_whole_millimetres_and_zero_where_it_is_not_known(vehicle):
    """Too near, nothing within range, and beyond what 16 bits hold."""
    pinhole = Pinhole(3, 2, 1.0, 1.0, 1.0, 0.5)
    layout = PictureLayout(pinhole, "optical", has_colour=False)
    options = TopicOptions(4, 200.0, 20.0, rates={"depth_camera": 5.0}, picture=layout)
    depth = np.array([[1.2344, 1.2346, -np.inf], [np.inf, 70.0, 65.535]], np.float32)
    image = DepthImage(
        stamp=0.25,
        frame="camera",
        p_WS=np.zeros(3),
        R_WS=np.eye(3),
        pinhole=pinhole,
        depth=depth,
        colour=None,
    )
    [(number, payload)] = TopicValues(vehicle, drone_topics(options)).pictures(image)
    assert number == DEPTH_IMAGE_SIGNAL.id
    assert struct.unpack("<q6H", payload) == (250_000_000, 1234, 1235, 0, 0, 0, 65_535)


def test_frames_are_those_of_the_session(session, samples):
    published = {t: p for t, p in payloads(samples, topic.FRAMES_SIGNAL.id)}
    definition = next(each for each in session.topics if each.id == topic.FRAMES_SIGNAL.id)
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


def test_a_flight_that_begins_anew_is_published_from_its_begin_on():
    """To the bit as the first time, though its times and stamps are those of before."""
    scenario = Scenario(sensors=SensorsConfig(use=["imu", "gps", "barometer"]))
    session = Session(scenario, bridge=Bridge())
    flights = []
    for seconds in (0.05, 0.25):
        session.drain()
        session.reset()
        session.tick(seconds)
        flights.append(
            [(each.published.t_ns, dict(each.published.payloads)) for each in session.drain()]
        )
    first, again = flights
    assert first and first[0][0] == 0
    clock = topic.CLOCK_SIGNAL.id  # has the time of the wall
    for (t_ns, before), (t_again_ns, after) in zip(first, again, strict=False):
        assert t_ns == t_again_ns and before.keys() == after.keys()
        assert {k: v for k, v in before.items() if k != clock} == {
            k: v for k, v in after.items() if k != clock
        }


@pytest.mark.parametrize("estimator", ["ekf", "complementary"])
def test_the_estimate_is_published_beside_the_truth(estimator):
    session = Session(Scenario(estimator=estimator), bridge=Bridge())
    session.tick(1.0)
    samples, flown = session.drain(), session.recording()
    estimate = [
        (t, struct.unpack("<21f", p)) for t, p in payloads(samples, topic.ESTIMATE_SIGNAL.id)
    ]
    assert len(estimate) == len(payloads(samples, topic.POSITION_SIGNAL.id))
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
    values = TopicValues(vehicle, drone_topics(TopicOptions(rotors=4, fast=200.0, slow=20.0)))
    signals = {
        "state": state,
        "acceleration": [0.0] * 6,
        "thrusts": thrusts,
        "reference": [0.0] * 8,
        "speeds": [0.0] * 4,
    }
    return dict([values.clocks(0, 0), *values.fast(signals)])


def test_joints_and_setpoints_of_their_servos_are_published_by_joint(vehicle):
    """A load that flies freely comes first, and has seven positions and six velocities."""
    load = [(f"load_q{a}", "1") for a in "wxyz"] + [(f"load_{a}", "m") for a in "xyz"]
    speeds = [(f"load_w{a}", "rad/s") for a in "xyz"] + [(f"load_v{a}", "m/s") for a in "xyz"]
    names = [*load, ("arm_q", "rad"), ("lift_x", "m"), ("bob_qx", "rad")]
    names += [*speeds, ("arm_w", "rad/s"), ("lift_v", "m/s"), ("bob_wx", "rad/s")]
    servos = (
        VehicleServo("lift", True, Servo("position")),
        VehicleServo("arm", False, Servo("velocity")),
    )
    moving = dataclasses.replace(vehicle, joint_signals=tuple(names), servos=servos)
    topics = TopicOptions(
        rotors=4,
        fast=200.0,
        slow=20.0,
        joints=list(moving.published_joints),
        setpoints=["position", "velocity"],
    )
    values = TopicValues(moving, drone_topics(topics))
    assert topics.joints == ["arm", "lift", "bob_qx"]
    signals = {"joints": [float(i) for i in range(19)], "joint_setpoints": [0.25, -3.0]}
    found = dict(values._joints(signals))
    states = struct.unpack("<6f", found[topic.JOINT_STATES_SIGNAL.id])
    assert states == (7.0, 8.0, 9.0, 16.0, 17.0, 18.0)
    wanted = struct.unpack("<6f", found[topic.JOINT_SETPOINTS_SIGNAL.id])
    nan = math.nan
    assert wanted == pytest.approx((nan, 0.25, nan, -3.0, nan, nan), nan_ok=True)


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
    assert struct.unpack("<6f", found[topic.FORCE_TORQUE_SIGNAL.id])[:3] == pytest.approx(
        force_W, abs=1e-6
    )


def test_a_number_too_large_for_its_field_is_infinite(vehicle):
    state = [1.0, 0.0, 0.0, 0.0, 1e39, -1e300, 2.0, *[0.0] * 6]
    found = made(vehicle, state, [1.0] * 4)
    assert struct.unpack("<9f", found[topic.POSITION_SIGNAL.id])[0:3] == (math.inf, -math.inf, 2.0)
