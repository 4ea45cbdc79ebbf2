"""Missions of ground stations: transfer, places, and a flight; pymavlink is the station."""

import math

import pytest

pytest.importorskip("pymavlink", reason="install the extra `mavlink` to try it")

from pymavlink.dialects.v20 import common as mavlink

from workbench.extras.gateways.mavlink_mission import Mission, MissionError, integer_item, step_of

HOME = (math.radians(47.4), math.radians(8.5), 488.0)
A, E2 = 6378137.0, 6.69437999014e-3
"""Of WGS84: equatorial radius [m], and the eccentricity squared."""


def item(seq, command, frame, x, y, z, *numbers):
    message = mavlink.MAVLink_mission_item_int_message(
        1, 1, seq, frame, command, 0, 1, *(*numbers, 0.0, 0.0, 0.0, 0.0)[:4], x, y, z, 0
    )
    return sent(message)


def sent(message):
    """Return a message as if it had come from a station."""
    message._header = mavlink.MAVLink_header(message.get_msgId(), srcSystem=255, srcComponent=190)
    return message


def count(number, kind=0):
    return sent(mavlink.MAVLink_mission_count_message(1, 1, number, kind))


WAYPOINT, TAKEOFF, LAND = 16, 22, 21
RELATIVE, GLOBAL, NED, ENU = 6, 5, 1, 4


def test_places_are_metres_east_and_north_of_home():
    """0.001 deg along the meridian and the parallel; radii of curvature in closed form."""
    sine = math.sin(HOME[0])
    meridian = A * (1.0 - E2) / (1.0 - E2 * sine**2) ** 1.5 + HOME[2]
    parallel = (A / math.sqrt(1.0 - E2 * sine**2) + HOME[2]) * math.cos(HOME[0])
    step = step_of(item(0, WAYPOINT, RELATIVE, 474_010_000, 85_010_000, 12.5, 3.0, 1.5), HOME)
    x, y, z = step.place
    assert (x, y) == pytest.approx(
        (math.radians(1e-3) * parallel, math.radians(1e-3) * meridian), abs=2e-3
    )
    assert (z, step.wait, step.radius) == (12.5, 3.0, 1.5)
    above_sea = step_of(item(0, WAYPOINT, GLOBAL, 474_010_000, 85_010_000, 500.5), HOME)
    assert above_sea.place.z == pytest.approx(12.5)
    assert step_of(item(0, WAYPOINT, NED, 30_000, 40_000, -5.0), ()).place == (4.0, 3.0, 5.0)
    assert step_of(item(0, WAYPOINT, ENU, 30_000, 40_000, 5.0), ()).place == (3.0, 4.0, 5.0)
    assert step_of(item(0, TAKEOFF, RELATIVE, 0, 0, 5.0), ()).place == (None, None, 5.0)
    assert step_of(item(0, 178, 2, 0, 0, 0.0, 1.0, 2.5), HOME).speed == 2.5


def test_an_item_of_an_older_station_is_the_same():
    old = mavlink.MAVLink_mission_item_message(
        1, 1, 0, 3, WAYPOINT, 0, 1, 0.0, 0.0, 0.0, 0.0, 47.401, 8.501, 12.5
    )
    found = integer_item(old)
    assert (found.x, found.y) == pytest.approx((474_010_000, 85_010_000), abs=40)  # 32 bits


@pytest.mark.parametrize(
    ("wrong", "result"),
    [
        (item(0, 183, RELATIVE, 1, 1, 5.0), mavlink.MAV_MISSION_UNSUPPORTED),  # a servo
        (item(0, WAYPOINT, 10, 1, 1, 5.0), mavlink.MAV_MISSION_UNSUPPORTED_FRAME),  # terrain
        (item(0, WAYPOINT, RELATIVE, 1, 1, math.nan), mavlink.MAV_MISSION_INVALID_PARAM7),
    ],
)
def test_what_cannot_be_flown_ends_the_transfer(wrong, result):
    mission = Mission(HOME)
    mission.answer(count(2))
    with pytest.raises(MissionError, match="item 0") as refused:
        mission.answer(wrong)
    assert refused.value.result == result
    assert not mission.request_next() and not mission.steps


def test_without_gps_only_local_places_are_known():
    with pytest.raises(MissionError, match="no GPS"):
        step_of(item(0, WAYPOINT, RELATIVE, 474_010_000, 85_010_000, 5.0), ())


def test_a_mission_is_sent_item_by_item_and_read_back():
    mission = Mission(HOME)
    items = [item(0, TAKEOFF, RELATIVE, 0, 0, 5.0), item(1, LAND, NED, 10_000, 0, 0.0)]
    [first] = mission.answer(count(2))
    assert (first.get_type(), first.seq, first.target_system) == ("MISSION_REQUEST_INT", 0, 255)
    assert mission.request_next()[0].seq == 0  # again, as it may be lost
    [second] = mission.answer(items[0])
    assert second.seq == 1
    assert mission.answer(items[0]) == []  # repeated
    assert not mission.steps  # nothing is flown before all is there
    [ack] = mission.answer(items[1])
    assert (ack.get_type(), ack.type) == ("MISSION_ACK", mavlink.MAV_MISSION_ACCEPTED)
    assert [step.command for step in mission.steps] == [TAKEOFF, LAND]
    asked = sent(mavlink.MAVLink_mission_request_list_message(1, 1, 0))
    assert mission.answer(asked)[0].count == 2
    asked = sent(mavlink.MAVLink_mission_request_int_message(1, 1, 1, 0))
    assert mission.answer(asked)[0].x == 10_000
    [ack] = mission.answer(count(1, mavlink.MAV_MISSION_TYPE_FENCE))
    assert ack.type == mavlink.MAV_MISSION_UNSUPPORTED and len(mission.steps) == 2
    [ack] = mission.answer(count(501))
    assert ack.type == mavlink.MAV_MISSION_NO_SPACE
    mission.answer(sent(mavlink.MAVLink_mission_clear_all_message(1, 1, 0)))
    assert not mission.steps
