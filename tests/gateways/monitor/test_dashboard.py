import dataclasses
import json
import math

import pytest

from workbench.gateways.monitor.dashboard import control_line, dashboard, one_line
from workbench.gateways.monitor.picture import Picture, as_json
from workbench.link.drone_topics import Outfit, drone_topics
from workbench.link.messages import ControlState, Hand, Stage
from workbench.link.sample import Sample

TOPICS = {
    topic.name.rsplit("/", 1)[1]: topic
    for topic in drone_topics(
        Outfit(2, 200.0, 10.0, imu=200.0, gps=10.0, lidar=10.0, rays=100, magnetometer=50.0)
    )
}
NOBODY = ControlState(Hand.NOBODY, 0, "", Stage.LIVE, 3.0, "nobody has requested")


def sample(name, *values):
    return Sample(TOPICS[name], 2_500_000_000, TOPICS[name].pack(values))


SAMPLES = {
    each.topic.rsplit("/", 1)[1]: each
    for each in (
        sample("position_data", 1.0, -2.0, 3.0, 0.0, math.pi / 6, -math.pi / 2, 0.0, 0.0, 0.0),
        sample("velocity_data", 0.5, 0.25, -0.75, 0.0, 0.0, 0.0),
        sample("drone_state", 3, "hovering", 0.5, 4.25),
        sample("rotors", (700.0, 350.0), (4.0, 1.0)),
        sample("imu", 0, (0.0, 0.0, 9.81), (0.1, 0.2, 0.3), (1.0, 0.0, 0.0, 0.0)),
        sample("gps", 0, math.radians(47.5), math.radians(8.5), 488.0, (0.0, 0.0, 0.0)),
        sample("lidar", 0, 30, 100, 2.5, (1.0, 0.0, 0.0)),
        sample("magnetometer", 0, (1.5e-6, 21.5e-6, -43.25e-6)),
        sample("wind", (5.0, 0.0, 0.0)),
        sample("command_velocity", 0, 15, 1.0, 0.0, 0.0, math.pi / 18),
        sample("events", 1, "the battery is low \x1b[2J"),
    )
}
PICTURE = Picture(
    vehicle="dh_drone",
    address="127.0.0.1:7733",
    trouble="",
    control=NOBODY,
    mine=False,
    rate=1638.4,
    age=0.0034,
    strongest=4.0,
    samples=SAMPLES,
)


@pytest.mark.parametrize(
    "said",
    [
        "dh_drone at 127.0.0.1:7733, 2.50 s",
        "mode hovering, charge 50 %, 4.25 m to the next obstacle",
        "position x 1.00 y -2.00 z 3.00 m",
        "velocity v_x 0.50 v_y 0.25 v_z -0.75 m/s",
        "attitude roll 0.00 pitch 30.00 yaw -90.00 deg",
        "flown v_x 1.00 v_y 0.00 v_z 0.00 m/s yaw 10.0 deg/s",
        "rotors 1 ######## 4.00 N 700 rad/s",
        "2 ##...... 1.00 N 350 rad/s",
        "imu 0.00 0.00 9.81 m/s^2 0.10 0.20 0.30 rad/s",
        "gps 47.500000 N 8.500000 E deg, 488.0 m high",
        "field 1.50 21.50 -43.25 uT",
        "lidar 30 of 100 rays hit something, nearest 2.50 m",
        "wind 5.00 0.00 0.00 m/s",
        "event warning: the battery is low \\x1b[2J (at 2.5 s)",
        "control nobody: nobody has requested",
        "link 1638 samples/s, age 3 ms",
    ],
)
def test_the_screen_shows(monkeypatch, said):
    monkeypatch.setattr("workbench.gateways.monitor.dashboard.BAR", 8)
    assert said in [" ".join(line.split()) for line in dashboard(PICTURE)]


def test_values_stay_in_their_places_whatever_they_are():
    turned = sample("position_data", -100.0, 22.0, 1.0, 0.1, -0.2, 0.3, 0.0, 0.0, 0.0)
    other = dataclasses.replace(PICTURE, samples=SAMPLES | {"position_data": turned})
    lengths = [[len(line) for line in dashboard(each)[3:]] for each in (PICTURE, other)]
    assert lengths[0] == lengths[1]


def test_what_a_drone_has_not_is_left_out():
    few = {"position_data": SAMPLES["position_data"]}
    lines = dashboard(dataclasses.replace(PICTURE, samples=few))
    assert not [line for line in lines if line.startswith(("imu", "gps", "rotors", "lidar"))]
    assert "\n\n\n" not in "\n".join(lines)


def test_nothing_known_yet_is_shown_too():
    empty = Picture("x", "a:1", "", None, False, 0.0, None, 0.0, {})
    assert dashboard(empty)[0] == "x at a:1, - s"
    assert "not known yet" in one_line(empty)


def test_numbers_that_are_none_do_no_harm():
    broken = {"rotors": sample("rotors", (math.nan, math.inf), (math.nan, -math.inf))}
    lines = dashboard(dataclasses.replace(PICTURE, samples=broken))
    assert sum("rad/s" in line for line in lines) == 2


@pytest.mark.parametrize(
    ("control", "mine", "said"),
    [
        (ControlState(Hand.CLIENT, 3, "Ada", Stage.LIVE, 0.04, ""), False, "Ada, last command"),
        (ControlState(Hand.CLIENT, 3, "", Stage.HOLD, 0.6, ""), False, "client 3 (hold), last"),
        (ControlState(Hand.CLIENT, 3, "Ada", Stage.LIVE, 0.0, ""), True, "you, last command"),
        (ControlState(Hand.OPERATOR, 0, "", Stage.LIVE, 0.0, "took over"), False, "operator"),
        (None, False, "not known yet"),
    ],
)
def test_who_flies_is_said(control, mine, said):
    assert said in control_line(dataclasses.replace(PICTURE, control=control, mine=mine))


def test_a_lost_connection_is_said_instead_of_a_rate():
    lost = dataclasses.replace(PICTURE, trouble="nobody listens")
    assert "link      no connection: nobody listens" in dashboard(lost)


def test_one_line_has_it_all():
    line = one_line(PICTURE)
    assert line.startswith("2.50 s; hovering, charge 50 %")
    assert "attitude roll 0.00 pitch 30.00 yaw -90.00 deg; control nobody" in line
    assert "\n" not in line


def test_json_is_strict_and_in_si():
    broken = SAMPLES | {"wind": sample("wind", (math.nan, math.inf, 1.0))}
    said = json.loads(as_json(dataclasses.replace(PICTURE, samples=broken)))
    assert said["topics"]["position_data"]["pitch"] == pytest.approx(math.pi / 6)
    assert said["topics"]["wind"]["wind"] == [None, None, 1.0]
    assert said["control"]["hand"] == "nobody"
    assert (said["time"], said["rate"], said["age"]) == (2.5, 1638.4, 0.0034)
    assert json.loads(as_json(dataclasses.replace(PICTURE, control=None)))["control"] is None
