"""The artificial horizon, as pixels."""

import math

import pytest
from PyQt6.QtCore import QPoint

from workbench.gui.home.attitude_indicator import Attitude, AttitudeIndicator

SIDE = 240


@pytest.fixture
def indicator(qtbot, workspace):
    made = AttitudeIndicator(workspace.look)
    qtbot.addWidget(made)
    made.resize(SIDE, SIDE)
    return made


def colours_at(indicator, *places):
    """Return the names of what is seen at places from the middle, to the right and down."""
    image = indicator.grab().toImage()
    names = {indicator.colour(name).name(): name for name in ("sky", "earth", "card", "field")}
    middle = QPoint(image.width() // 2, image.height() // 2)
    ratio = image.width() / SIDE
    return [
        names.get(image.pixelColor(middle + QPoint(round(x * ratio), round(y * ratio))).name())
        for x, y in places
    ]


UP, DOWN, LEFT, RIGHT = (-25, -85), (25, 85), (-85, -12), (85, -12)


def test_level_flight_has_the_sky_above(indicator):
    indicator.show_attitude(Attitude(0.0, 0.0))
    assert colours_at(indicator, UP, DOWN) == ["sky", "earth"]


def test_the_right_side_down_has_the_sky_on_the_left(indicator):
    indicator.show_attitude(Attitude(0.0, math.radians(90.0)))
    assert colours_at(indicator, LEFT, RIGHT) == ["sky", "earth"]


def test_the_left_side_down_has_the_sky_on_the_right(indicator):
    indicator.show_attitude(Attitude(0.0, math.radians(-90.0)))
    assert colours_at(indicator, LEFT, RIGHT) == ["earth", "sky"]


def test_upside_down_has_the_sky_below(indicator):
    indicator.show_attitude(Attitude(0.0, math.pi))
    assert colours_at(indicator, UP, DOWN) == ["earth", "sky"]


def test_the_nose_down_shows_more_earth(indicator):
    indicator.show_attitude(Attitude(math.radians(-20.0), 0.0))
    assert colours_at(indicator, (-80, -30), (80, 30)) == ["earth", "earth"]
    indicator.show_attitude(Attitude(math.radians(20.0), 0.0))
    assert colours_at(indicator, (-80, -30), (80, 30)) == ["sky", "sky"]


def test_a_bank_of_a_few_degrees_turns_the_horizon_against_the_clock(indicator):
    indicator.show_attitude(Attitude(0.0, math.radians(20.0)))
    assert colours_at(indicator, (85, 0), (-85, 0)) == ["earth", "sky"]


def test_before_the_first_attitude_there_is_neither(indicator):
    assert colours_at(indicator, UP, DOWN) == ["field", "field"]
    assert indicator.spoken == "no attitude yet"


def test_what_is_no_number_takes_the_horizon_away(indicator):
    indicator.show_attitude(Attitude(0.0, 0.0))
    indicator.show_attitude(None)
    assert colours_at(indicator, UP, DOWN) == ["field", "field"]


def test_it_says_in_words_how_it_is(indicator):
    indicator.show_attitude(Attitude(math.radians(-12.0), math.radians(7.0)))
    assert indicator.spoken == "nose 12 degrees down, right side 7 degrees down"


def test_nothing_is_painted_for_the_same_attitude(indicator, qtbot, monkeypatch):
    indicator.show()
    qtbot.waitExposed(indicator)
    indicator.show_attitude(Attitude(0.1, 0.1))
    updates = []
    monkeypatch.setattr(indicator, "update", lambda *_: updates.append(1))
    indicator.show_attitude(Attitude(0.1, 0.1))
    indicator.show_attitude(Attitude(0.1 + 1e-5, 0.1))
    assert not updates
    indicator.show_attitude(Attitude(0.2, 0.1))
    assert len(updates) == 1


def test_the_colours_follow_the_look(indicator, workspace):
    workspace.preferences.set("theme", "dark")
    indicator.show_attitude(Attitude(0.0, 0.0))
    assert indicator.colour("sky") == workspace.look.colour("sky")
    assert colours_at(indicator, UP, DOWN) == ["sky", "earth"]
