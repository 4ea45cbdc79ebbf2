"""Events and parameters as payloads, read back by hand."""

import struct

import pytest

from workbench.link.backplane import Published
from workbench.link.drone_topics import DRONE_STATE, EVENTS, PARAMETERS, Outfit, drone_topics
from workbench.live.announcer import WARNING, Announcer


@pytest.fixture
def announcer() -> Announcer:
    return Announcer(drone_topics(Outfit(rotors=4, fast=200.0, slow=20.0)))


def test_a_sentence_is_published_with_its_time_and_severity(announcer):
    published = announcer.event(1.25, "the battery is low", WARNING)
    assert published.t_ns == 1_250_000_000
    ((number, payload),) = published.payloads
    severity, said = struct.unpack("<i240s", payload)
    assert (number, severity, said.rstrip(b"\0")) == (EVENTS, 1, b"the battery is low")


def test_a_long_sentence_is_cut_between_characters(announcer):
    ((_, payload),) = announcer.event(0.0, "ä" * 200, 0).payloads
    assert payload[4:] == "ä".encode() * 120


def test_a_parameter_is_published_in_full_precision(announcer):
    ((number, payload),) = announcer.parameter(0.0, "kp_roll", 0.1).payloads
    name, value = struct.unpack("<48sd", payload)
    assert (number, name.rstrip(b"\0"), value) == (PARAMETERS, b"kp_roll", 0.1)


def test_a_change_of_mode_is_said_once(announcer):
    def in_mode(mode):
        return Published(0, 0, ((DRONE_STATE, struct.pack("<i16sff", mode, b"", 1.0, 1.0)),))

    said = [announcer.mode_said(in_mode(mode)) for mode in (0, 0, 1, 1, 7)]
    assert said == [None, None, "flight mode: armed", None, "flight mode: landing"]
    assert announcer.mode_said(Published(0, 0, ())) is None
