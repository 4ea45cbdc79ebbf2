"""Shown units, by hand."""

import math

import pytest

from workbench.common.quantity import DisplayUnit
from workbench.gui.units import (
    SHARE_UNIT,
    age_text,
    entered_number_text,
    simulated_text,
    unit_for,
)


@pytest.mark.parametrize(
    ("si", "preference", "value", "text"),
    [
        ("rad", ("angle_unit", "degree"), math.pi / 6, "30.0°"),
        ("rad", ("angle_unit", "radian"), 0.5, "0.500\N{NO-BREAK SPACE}rad"),
        ("rad/s", ("angle_unit", "degree"), -math.pi, "−180.0\N{NO-BREAK SPACE}°/s"),
        ("m/s", ("speed_unit", "m/s"), 2.0, "2.00\N{NO-BREAK SPACE}m/s"),
        ("m/s", ("speed_unit", "km/h"), 10.0, "36.00\N{NO-BREAK SPACE}km/h"),
        ("1", ("theme", "dark"), 0.25, "0.25"),
        ("T", ("theme", "dark"), -43.2e-6, "−43.20\N{NO-BREAK SPACE}µT"),
        ("(m/s)^2/Hz", ("speed_unit", "km/h"), 1.0, "12.96\N{NO-BREAK SPACE}(km/h)²/Hz"),
        ("rad^2/Hz", ("angle_unit", "degree"), 1.0, "3282.81\N{NO-BREAK SPACE}(°)²/Hz"),
        ("rad/s^2", ("angle_unit", "radian"), 1.0, "1.000\N{NO-BREAK SPACE}rad/s²"),
    ],
)
def test_a_number_is_shown_in_its_unit(workspace, si, preference, value, text):
    workspace.preferences.set(*preference)
    assert unit_for(si, workspace.preferences).text(value) == text


@pytest.mark.parametrize(
    ("si", "value", "text"),
    [
        ("rad/s", 0.4, "22.918"),  # round in SI, and not in the shown unit
        ("rad", 0.0175, "1.0027"),
        ("rad/s", 0.01, "0.57296"),
        ("rad/s", math.radians(22.918), "22.918"),  # as it was typed
        ("rad/s", math.radians(90.0), "90.0"),
        ("m/s", 8.0, "8.00"),
        ("m/s", 4.449, "4.449"),
        ("m/s", -0.0, "0.00"),
    ],
)
def test_a_value_that_can_be_entered_has_more_decimals_only_where_they_count(
    workspace, si, value, text
):
    assert entered_number_text(value, unit_for(si, workspace.preferences)) == text


@pytest.mark.parametrize(
    ("value", "text"), [(1.0, "100"), (0.996, "99.6"), (0.201, "20.1"), (0.8, "80"), (0.005, "0.5")]
)
def test_a_percentage_shows_what_is_held(value, text):
    assert entered_number_text(value, SHARE_UNIT) == text


def test_what_is_shown_is_read_back():
    unit = DisplayUnit("km/h", 3.6)
    assert unit.read(unit.shown(7.0)) == pytest.approx(7.0)


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_what_is_no_number_is_a_dash(value):
    assert DisplayUnit("m").text(value) == "–"


def test_a_negative_zero_has_no_sign():
    assert DisplayUnit("m").text(-0.001) == "0.00\N{NO-BREAK SPACE}m"


@pytest.mark.parametrize(
    ("age", "text"),
    [
        (-1e-9, "0\N{NO-BREAK SPACE}ms"),
        (0.0123, "12\N{NO-BREAK SPACE}ms"),
        (2.0, "2.0\N{NO-BREAK SPACE}s"),
        (12.3, "12\N{NO-BREAK SPACE}s"),
        (200.0, "3\N{NO-BREAK SPACE}min"),
        (math.inf, "–"),
    ],
)
def test_an_age_has_the_unit_of_its_size(age, text):
    assert age_text(age) == text


def test_a_time_of_a_flight_is_minutes_and_seconds():
    assert simulated_text(62.549) == "1:02.5"
    assert simulated_text(59.96) == "0:59.9"
    assert simulated_text(3723.0, paused=True) == "1:02:03.000"
