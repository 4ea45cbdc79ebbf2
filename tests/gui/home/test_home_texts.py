"""What the Home screen says, and when; no widgets."""

import math

import pytest

from workbench.gui.home.attitude_card import heading_text
from workbench.gui.home.battery_card import charge_word
from workbench.gui.home.condition_card import wind_text
from workbench.gui.home.height_card import range_text
from workbench.gui.home.rotor_card import RotorState, rotor_reading
from workbench.gui.home.shown_units import shown_units
from workbench.gui.units import LENGTH_UNIT


def test_a_rotor_at_its_limit_and_a_weak_one(canned):
    rotor = canned.views[0].vehicle.rotors[0]
    assert rotor_reading(rotor, rotor.max_thrust, 1.0).state is RotorState.LIMIT
    assert rotor_reading(rotor, 1.0, 0.5).state is RotorState.WEAK
    half = rotor_reading(rotor, rotor.max_thrust / 4.0, 1.0)
    assert half.state is RotorState.FINE
    assert half.share == pytest.approx(0.25)
    assert half.speed == pytest.approx(rotor.max_rot_velocity / 2.0)  # thrust goes with its square


def test_charges_have_words():
    words = [charge_word(each, 0.15) for each in (0.9, 0.19, 0.15, 0.0, math.nan)]
    assert words == ["good", "low", "reserve: lands", "empty", "unknown"]


def test_wind_is_said_from_where_it_comes(workspace):
    units = shown_units(workspace.preferences)
    # Air that moves east comes from the west, 270 degrees.
    assert wind_text((3.0, 0.0, 0.0), units) == "wind 3.00\N{NO-BREAK SPACE}m/s from 270° (W)"
    assert wind_text((0.0, -2.0, 0.5), units) == (
        "wind 2.00\N{NO-BREAK SPACE}m/s from 000° (N), up 0.50\N{NO-BREAK SPACE}m/s"
    )


def test_headings_and_ranges_as_texts():
    assert heading_text(math.radians(90.04)) == "000.0"
    assert heading_text(math.nan) == "–"
    assert [range_text(each, LENGTH_UNIT) for each in (math.inf, -math.inf, 1.5)] == [
        "too far",
        "too near",
        "1.50",
    ]
