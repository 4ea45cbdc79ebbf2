"""What the Home screen says, and when; no widgets."""

import math

import pytest

from workbench.gui.home.attitude_card import heading_text
from workbench.gui.home.cards import (
    RotorState,
    charge_word,
    rotor_reading,
    simulated_text,
    wind_text,
)
from workbench.gui.home.home_screen import Turns, range_text
from workbench.gui.home.shown_units import shown_units


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
    assert wind_text((3.0, 0.0, 0.0), units) == "wind 3.0\N{NO-BREAK SPACE}m/s from 270° (W)"
    assert wind_text((0.0, -2.0, 0.5), units) == (
        "wind 2.0\N{NO-BREAK SPACE}m/s from 000° (N), up 0.5\N{NO-BREAK SPACE}m/s"
    )


def test_times_headings_and_ranges_as_texts():
    assert simulated_text(62.549, 1) == "1:02.5"
    assert simulated_text(59.96, 1) == "1:00.0"
    assert simulated_text(3723.0, 3) == "1:02:03.000"
    assert heading_text(math.radians(90.04)) == "000.0"
    assert heading_text(math.nan) == "–"
    assert [range_text(each) for each in (math.inf, -math.inf, 1.5)] == [
        "too far",
        "too near",
        "1.50",
    ]


def test_numbers_take_turns_and_each_comes_ten_times_a_second():
    turns = Turns("abcde")
    assert turns.due(0.0) == list("abcde")
    counts = dict.fromkeys("abcde", 0)
    most = 0
    for frame in range(1, 601):
        taken = turns.due(frame / 60)
        most = max(most, len(taken))
        for name in taken:
            counts[name] += 1
    assert all(95 <= count <= 100 for count in counts.values())
    assert most <= 3


def test_after_a_while_without_frames_all_numbers_are_due():
    turns = Turns("abcde")
    turns.due(0.0)
    assert len(turns.due(0.19)) == 3  # one late frame does not do the work of all
    assert sorted(turns.due(1.0)) == list("abcde")
