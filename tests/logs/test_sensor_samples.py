"""What a log's sensors say, and what an estimator makes of it, beside the flight's true motion.

The reader has two oracles: MCAP's own reader with the closed form of WGS84, and the textbook's
filter run over what they give.
"""

import dataclasses
import math

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from scipy.spatial.transform import Rotation

from tests.estimation.textbook import State, TextbookFilter, moved
from tests.systems.sensors.test_geodesy import seen_from
from workbench.common.errors import WorkbenchError
from workbench.common.resources import find_model
from workbench.design.estimation_errors import estimate_errors, judge_estimate, over_truth
from workbench.estimation.ekf import InitialDeviations
from workbench.estimation.estimators import find_estimator
from workbench.estimation.run import SensorSamples, StampedSamples, run_estimator
from workbench.estimation.samples import Mounting
from workbench.estimation.settings import EkfSettings
from workbench.logs.flight_log import LoggedFlight
from workbench.logs.record import read_log
from workbench.logs.sensor_samples import LoggedSensors, logged_sensors
from workbench.plant.home import DEFAULT_HOME
from workbench.plant.loading import load_vehicle
from workbench.plant.vehicle import VehicleJoint
from workbench.scenario.configured import configured_vehicle
from workbench.scenario.scenario import Action, Scenario, ScenarioStart, VehicleConfig
from workbench.scenario.sensors_config import SensorsConfig

SILENT = 3.0
SAMPLES = 600
"""Of the IMU, that the textbook's filter is given."""
LOST, BACK = 6.5, 14.5
"""When the GPS goes and comes back [s]."""


@pytest.fixture(scope="module")
def record(tmp_path_factory):
    """A flight on the truth, with a GPS that has noise and is lost for eight seconds."""
    scenario = Scenario(
        duration=18.0,
        vehicle=VehicleConfig(args={"gps_noise": "0.5"}),
        sensors=SensorsConfig(use=["imu", "gps", "magnetometer"], seed=4),
        script=[
            Action(2.0, velocity=[1.5, 0.0, 0.2]),
            Action(4.0, velocity=[0.0, -1.5, 0.0], yaw_rate=0.3),
            Action(5.5, velocity=[-1.0, 0.0, 0.0]),
            Action(LOST, set={"gps_fault": SILENT}, velocity=[0.0, 1.0, 0.0], yaw_rate=0.0),
            Action(BACK, set={"gps_fault": 0.0}),
        ],
    )
    path = tmp_path_factory.mktemp("logs") / "lost.mcap"
    LoggedFlight(path, scenario, {}).run(lambda share: None)
    return read_log(path)


def estimated(record, name="ekf", **settings):
    """Return an estimator's history of a log beside the truth."""
    estimator, sensors = find_estimator(name), logged_sensors(record)
    numbers = estimator.settings()._replace(**settings)
    begin = sensors.begin(estimator)
    history = run_estimator(estimator, sensors.samples, numbers, sensors.mounting, begin)
    return over_truth(history, sensors.state_time, sensors.states, sensors.mounting.p_BI)


@pytest.fixture(scope="module")
def flight(record):
    return estimated(record)


def decoded(path, *topics):
    """Yield topic, time of arrival, stamp [ns] and message, as MCAP's own reader has them."""
    with path.open("rb") as stream:
        reader = make_reader(stream, decoder_factories=[DecoderFactory()])
        for _, channel, message, content in reader.iter_decoded_messages(topics=[*topics]):
            stamp = content.header.stamp
            yield channel.topic, message.log_time, stamp.sec * 10**9 + stamp.nanosec, content


def three(vector):
    return np.array([vector.x, vector.y, vector.z])


@pytest.mark.slow
def test_it_is_what_the_textbooks_filter_makes_of_the_log(record):
    """The first seconds, by IMU and GPS alone; all fixes but the last have come in by then."""
    sensors = logged_sensors(record)
    found = estimated(_without(record, "magnetometer"))
    noise = EkfSettings()
    mounts = {each.kind: each for each in load_vehicle(find_model("dh_drone")).sensors}
    p_BI, p_BG = np.array(mounts["imu"].p_BS), np.array(mounts["gps"].p_BS)
    imu, fixes, speeds = [], [], {}
    for topic, arrived, stamp, content in decoded(
        record.path, "/dh_drone/imu", "/dh_drone/gps", "/dh_drone/gps_velocity"
    ):
        if topic.endswith("imu"):
            if len(imu) == SAMPLES:
                break
            sample = (three(content.angular_velocity), three(content.linear_acceleration))
            imu.append((arrived, stamp, *(np.array(mounts["imu"].R_BS) @ each for each in sample)))
        elif topic.endswith("gps"):
            place = (math.radians(content.latitude), math.radians(content.longitude))
            p_W = seen_from(DEFAULT_HOME, (*place, content.altitude))
            fixes.append((arrived, stamp, p_W))
        else:
            speeds[stamp] = three(content.twist.linear)
    q, p, _, v = np.split(sensors.states[0], [4, 7, 10])
    known = np.repeat(np.square(InitialDeviations()), 3)
    turn = Rotation.from_quat(q[[1, 2, 3, 0]])
    start = State(turn, p + turn.apply(p_BI), v, np.zeros(3), np.zeros(3))
    textbook = TextbookFilter(start, np.diag(known), noise[:4])
    variances = np.square([noise[4], noise[4], noise[5], *[noise[6]] * 3])
    for k, (arrived, stamp, w, f) in enumerate(imu):
        if k:
            _, before, w_0, f_0 = imu[k - 1]
            textbook.predict(0.5 * (w + w_0), 0.5 * (f + f_0), 1e-9 * (stamp - before))
            w_mean, f_mean = 0.5 * (w + w_0), 0.5 * (f + f_0)
        else:
            w_mean, f_mean = w, f
        while fixes and fixes[0][0] <= arrived and fixes[0][1] <= stamp:
            _, taken, p_W = fixes.pop(0)
            age = 1e-9 * (stamp - taken)

            def said(state, w=w_mean, f=f_mean, age=age):
                arm, then = p_BG - p_BI, moved(state, w, f, -age)
                speed = then.v + then.turn.apply(np.cross(w - then.b_g, arm))
                return np.concatenate([then.p + then.turn.apply(arm), speed], axis=-1)

            textbook.correct(said, np.append(p_W, speeds[taken]), variances, said)
        q, p, w_W, v = np.split(found.estimate[k], [4, 7, 10])
        turn = Rotation.from_quat(q[[1, 2, 3, 0]])
        arm = turn.apply(p_BI)
        own = State(turn, p + arm, v + np.cross(w_W, arm), *np.split(found.biases[k], 2))
        assert np.abs(own.minus(textbook.state)).max() < 1e-6, k
    assert len(fixes) < len(speeds) - 25


@pytest.mark.slow
def test_errors_of_a_flight_on_the_truth_are_those_of_a_good_filter(flight, record):
    """GPS of 0.5 m and exact velocities; four times what a filter of its noise leaves, rounded."""
    good = flight.time < LOST
    errors = estimate_errors(flight)
    rms = {
        name: np.sqrt(np.mean(getattr(errors, name)[good] ** 2, axis=0))
        for name in ("attitude_B", "position", "velocity")
    }
    assert np.degrees(rms["attitude_B"][:2]).max() < 0.15
    assert np.degrees(rms["attitude_B"][2]) < 0.3
    assert rms["position"].max() < 0.25
    assert rms["velocity"].max() < 0.04
    worse = estimate_errors(estimated(record, "complementary"))
    rms = np.sqrt(np.mean(worse.position[good] ** 2, axis=0))
    assert 0.05 < rms.max() < 1.0


def test_innovations_are_as_large_as_they_should_be(flight):
    """NIS of 0.5 m and 1 m as the filter takes them; a wrong deviation is noticed."""
    told = {each.channel: each for each in judge_estimate(flight).innovations}
    assert {*told} == {*(f"gps_{x}" for x in ("x", "y", "z", "v_x", "v_y", "v_z")), "magnetometer"}
    for channel in ("gps_x", "gps_y", "gps_z", "magnetometer"):
        spread = math.sqrt(0.95 * 0.05 / told[channel].count)
        assert told[channel].within == pytest.approx(0.95, abs=4.0 * spread), channel
    assert told["gps_v_x"].within == 1.0  # it is exact, and the filter does not know


def test_a_filter_that_takes_the_gps_for_better_than_it_is_finds_it_out(record):
    told = judge_estimate(estimated(record, ekf_gps_position=0.1)).innovations
    assert next(each.within for each in told if each.channel == "gps_x") < 0.5


def test_without_gps_deviations_grow_and_cover_the_error(flight):
    lost = (flight.time > LOST + 1.0) & (flight.time < BACK)
    error = np.abs(estimate_errors(flight).position[lost])
    sigma = flight.deviations[lost, 3:6]
    assert np.all(np.diff(sigma, axis=0) > 0.0)
    assert np.all(sigma[-1] > sigma[0] * [4.0, 4.0, 2.0])  # a tilt does not move the height
    assert np.mean(error < 2.0 * sigma) > 0.9
    after = flight.time > BACK + 3.0
    assert np.all(flight.deviations[after, 3:6] < 0.6 * sigma[-1])
    fixes = flight.time[np.isfinite(flight.innovations[:, 0])]
    assert not np.any((fixes > LOST + 0.2) & (fixes < BACK))


def test_sensors_of_the_log_are_in_the_axes_of_the_vehicle(record):
    """At rest in hover: the specific force is upwards, the field that of the home, the place 1.5 m.

    The magnetometer's noise is 0.5e-6 T a sample.
    """
    samples = logged_sensors(record).samples
    still = samples.imu.stamp < 2.0
    assert samples.imu.values[still].mean(axis=0) == pytest.approx([0, 0, 0, 0, 0, 9.81], abs=0.02)
    field = samples.magnetometer.values[samples.magnetometer.stamp < 2.0].mean(axis=0)
    m_W = logged_sensors(record).mounting.m_W
    assert field == pytest.approx(m_W, abs=4 * 0.5e-6 / math.sqrt(100))
    place = samples.gps.values[samples.gps.stamp < 2.0].mean(axis=0)
    p_BG = np.array(logged_sensors(record).mounting.p_BG)
    assert place[:3] == pytest.approx([0, 0, 1.5] + p_BG, abs=4 * 1.0 / math.sqrt(20))


def test_a_sample_that_a_log_has_twice_counts_once(record):
    def twice(topic):
        fields = {
            path: dataclasses.replace(column, values=np.repeat(column.values, 2))
            for path, column in topic.fields.items()
        }
        stamps, t_ns = np.repeat(topic.stamps_ns, 2), np.repeat(topic.t_ns, 2)
        return dataclasses.replace(topic, fields=fields, stamps_ns=stamps, t_ns=t_ns)

    topics = {
        name: twice(topic) if name in ("imu", "magnetometer") else topic
        for name, topic in record.topics.items()
    }
    found = logged_sensors(dataclasses.replace(record, topics=topics)).samples
    expected = logged_sensors(record).samples
    for kind in ("imu", "magnetometer"):
        for once, there in zip(getattr(expected, kind), getattr(found, kind), strict=True):
            np.testing.assert_array_equal(there, once)


def test_turned_sensors_are_turned_back(record, monkeypatch):
    """What a sensor whose axes are turned by R_BS shows is, in B, R_BS times that."""
    plain = logged_sensors(record).samples
    turns = {
        "imu": Rotation.from_euler("ZYX", [0.3, -0.5, 1.1]).as_matrix(),
        "magnetometer": Rotation.from_euler("ZYX", [-1.2, 0.4, 0.2]).as_matrix(),
    }

    def turned(config):
        vehicle = configured_vehicle(config)
        sensors = tuple(
            dataclasses.replace(each, R_BS=tuple(map(tuple, turns[each.kind])))
            if each.kind in turns
            else each
            for each in vehicle.sensors
        )
        return dataclasses.replace(vehicle, sensors=sensors)

    monkeypatch.setattr("workbench.logs.sensor_samples.configured_vehicle", turned)
    found = logged_sensors(record).samples
    for k in (0, 500):
        for part in (slice(0, 3), slice(3, 6)):
            wanted = turns["imu"] @ plain.imu.values[k, part]
            assert found.imu.values[k, part] == pytest.approx(wanted)
        wanted = turns["magnetometer"] @ plain.magnetometer.values[k]
        assert found.magnetometer.values[k] == pytest.approx(wanted)


def test_samples_of_an_imu_that_a_joint_moves_are_refused(record, monkeypatch):
    """Turned by a joint, they are not those of the body."""

    def jointed(config):
        vehicle = configured_vehicle(config)
        (imu,) = vehicle.body_imus
        joint = VehicleJoint("tilt", "revolute", "frame", imu.link, 1, (imu.link,), 0.1)
        return dataclasses.replace(vehicle, joints=(joint,))

    monkeypatch.setattr("workbench.logs.sensor_samples.configured_vehicle", jointed)
    with pytest.raises(WorkbenchError, match="its IMU 'imu' is on a link that joints move"):
        logged_sensors(record)


def _without(record, *topics):
    kept = {name: topic for name, topic in record.topics.items() if name not in topics}
    return dataclasses.replace(record, topics=kept)


@pytest.mark.slow
def test_what_a_frozen_gps_repeats_in_the_air_is_left_out_of_an_estimate(tmp_path, case):
    """A GPS that froze gave as much as one that fell silent; one that stands gave all it sent."""
    frozen, silent = 1.0, SILENT
    given = {}
    for fault in (frozen, silent, 0.0):
        scenario = Scenario(
            duration=2.5,
            sensors=SensorsConfig(use=["imu", "gps"]),
            script=[Action(1.0, set={"gps_fault": fault}), Action(2.0, set={"gps_fault": 0.0})],
        )
        path = tmp_path / f"{fault}.mcap"
        LoggedFlight(path, scenario, {}).run(lambda share: None)
        given[fault] = logged_sensors(read_log(path)).samples.gps
    assert given[frozen].stamp.tolist() == given[silent].stamp.tolist()
    assert np.array_equal(given[frozen].values, given[silent].values)
    assert len(given[0.0].stamp) == 25  # the one at the very end is not delivered any more
    assert len(given[frozen].stamp) == 25 - 10
    for noise in (True, False):
        with case(noise):
            scenario = Scenario(
                duration=2.0,
                start=ScenarioStart(mode="off"),
                sensors=SensorsConfig(use=["imu", "gps"], noise=noise),
            )
            path = tmp_path / f"stands {noise}.mcap"
            LoggedFlight(path, scenario, {}).run(lambda share: None)
            assert len(logged_sensors(read_log(path)).samples.gps.stamp) == 20


def test_an_estimate_begins_at_the_last_state_that_is_not_after_its_first_sample():
    states = np.zeros((4, 13))
    states[:, 0], states[:, 4] = 1.0, [0.0, 1.0, 2.0, 3.0]
    ekf = find_estimator("ekf")
    for first, expected in ((0.0, 0.0), (0.1, 1.0), (0.15, 1.0), (0.3, 3.0), (9.0, 3.0)):
        stamps = np.array([first, first + 0.01])
        sensors = LoggedSensors(
            samples=SensorSamples(imu=StampedSamples(stamps, stamps, np.zeros((2, 6)))),
            mounting=Mounting(),
            known=InitialDeviations(),
            state_time=np.array([0.0, 0.1, 0.2, 0.3]),
            states=states,
        )
        assert sensors.begin(ekf)[4] == expected
