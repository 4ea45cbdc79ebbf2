"""Shown units, by hand."""

import math

import pytest

from workbench.gui.units import Unit, unit_for


@pytest.mark.parametrize(
    ("si", "preference", "value", "text"),
    [
        ("rad", ("angle_unit", "degree"), math.pi / 6, "30.00°"),
        ("rad", ("angle_unit", "radian"), 0.5, "0.50\N{NO-BREAK SPACE}rad"),
        ("rad/s", ("angle_unit", "degree"), -math.pi, "−180.00\N{NO-BREAK SPACE}°/s"),
        ("m/s", ("speed_unit", "m/s"), 2.0, "2.00\N{NO-BREAK SPACE}m/s"),
        ("m/s", ("speed_unit", "km/h"), 10.0, "36.00\N{NO-BREAK SPACE}km/h"),
        ("1", ("theme", "dark"), 0.25, "0.25"),
        ("T", ("theme", "dark"), -43.2e-6, "−43.20\N{NO-BREAK SPACE}µT"),
        ("rad/s^2", ("angle_unit", "radian"), 1.0, "1.00\N{NO-BREAK SPACE}rad/s²"),
    ],
)
def test_a_number_is_shown_in_its_unit(workspace, si, preference, value, text):
    workspace.preferences.set(*preference)
    assert unit_for(si, workspace.preferences).text(value) == text


def test_what_is_shown_is_read_back():
    unit = Unit("km/h", 3.6)
    assert unit.read(unit.shown(7.0)) == pytest.approx(7.0)


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_what_is_no_number_is_a_dash(value):
    assert Unit("m").text(value) == "–"


def test_a_negative_zero_has_no_sign():
    assert Unit("m").text(-0.001) == "0.00\N{NO-BREAK SPACE}m"
