"""Events and parameters as payloads, read back by hand."""

import struct

import pytest

from workbench.control.mode import Reason
from workbench.link.backplane import Published
from workbench.link.drone_topics import (
    DRONE_STATE_SIGNAL,
    EVENTS_SIGNAL,
    PARAMETERS_SIGNAL,
    drone_topics,
)
from workbench.link.signal import TopicOptions
from workbench.live.announcer import WARNING_SEVERITY, Announcer


@pytest.fixture
def announcer() -> Announcer:
    return Announcer(drone_topics(TopicOptions(rotors=4, fast=200.0, slow=20.0)), lambda: 0.2)


def test_a_sentence_is_published_with_its_time_and_severity(announcer):
    published = announcer.event(1.25, "the battery is low", WARNING_SEVERITY)
    assert published.t_ns == 1_250_000_000
    ((number, payload),) = published.payloads
    severity, said = struct.unpack("<i240s", payload)
    assert (number, severity, said.rstrip(b"\0")) == (EVENTS_SIGNAL.id, 1, b"the battery is low")


def test_a_long_sentence_is_cut_between_characters(announcer):
    ((_, payload),) = announcer.event(0.0, "ä" * 200, 0).payloads
    assert payload[4:] == "ä".encode() * 120


def test_a_parameter_is_published_in_full_precision(announcer):
    ((number, payload),) = announcer.parameter(0.0, "kp_roll", 0.1).payloads
    name, value = struct.unpack("<48sd", payload)
    assert (number, name.rstrip(b"\0"), value) == (PARAMETERS_SIGNAL.id, b"kp_roll", 0.1)


def said_of(announcer, *states):
    """Return the sentences, and those that warn, for modes and charges one after the other."""
    found = []
    for mode, charge in states:
        payload = struct.pack("<i16sff", mode, b"", charge, 1.0)
        found += announcer.changes(Published(0, 0, ((DRONE_STATE_SIGNAL.id, payload),)))
    return [said for said, _ in found], [
        said for said, severity in found if severity == WARNING_SEVERITY
    ]


def test_a_change_of_mode_is_said_once(announcer):
    said, warned = said_of(announcer, (0, 1.0), (0, 1.0), (1, 1.0), (1, 1.0), (7, 1.0))
    assert said == ["flight mode: armed", "flight mode: landing"]
    assert warned == []
    assert list(announcer.changes(Published(0, 0, ()))) == []


def test_a_battery_warns_when_it_is_low_when_it_lands_the_drone_and_when_it_is_empty(announcer):
    flown = (3, 0.9), (3, 0.31), (3, 0.299), (3, 0.25), (3, 0.2), (7, 0.19), (7, 0.1), (0, 0.0)
    _, warned = said_of(announcer, *flown)
    assert warned == [
        "battery low: 30\N{NO-BREAK SPACE}%; the drone lands at 20\N{NO-BREAK SPACE}%. Land (F8)",
        "battery empty: the drone lands with the last 20\N{NO-BREAK SPACE}%. "
        "Let it land, then reset",
        "battery empty: the rotors are off. Reset to fly again",
    ]
    announcer.begin()
    _, warned = said_of(announcer, (3, 0.9), (7, 0.9), (0, 0.9))
    assert warned == [], "landings that a pilot asks for warn of nothing"


def test_a_flight_that_begins_anew_is_told_as_the_first_one(announcer):
    flights = []
    for _ in range(2):
        assert announcer.lasting == ()
        flights.append(said_of(announcer, (1, 0.29), (3, 0.28))[0])
        flights[-1] += announcer.reasons(Reason.DEAD_RECKONING)
        assert len(announcer.lasting) == 2
        announcer.begin()
    first, second = flights
    assert first == second and len(first) == 3


def test_a_low_battery_lasts_until_it_is_charged_again(announcer):
    for charge, lasts in ((0.9, False), (0.29, True), (0.28, True), (0.5, False), (0.25, True)):
        said_of(announcer, (3, charge))
        assert any("battery low" in each for each in announcer.lasting) is lasts, charge


def test_what_failed_is_said_once_and_that_it_works_again_too(announcer):
    flown = (Reason.NONE, Reason.DEAD_RECKONING, Reason.DEAD_RECKONING, Reason.NONE)
    flown += (Reason.BATTERY_LOW, Reason.NONE, Reason.POSITION_LOST)
    said = [each for reason in flown for each in announcer.reasons(reason)]
    assert said == [
        ("no GPS, dead reckoning. Land, or repair the GPS", WARNING_SEVERITY),
        ("the estimate has all of its sensors again", 0),
        ("position lost. It lands where it is: repair the GPS, then reset", WARNING_SEVERITY),
    ]
