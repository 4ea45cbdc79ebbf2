"""The card of what-if: what it asks while gains move, and what it makes of the answers."""

from dataclasses import replace
from pathlib import Path

import pytest
from PyQt6.QtCore import Qt

from workbench.extras.flightdata.cards import DRAW_COUNTS, NO_LOG_TEXT, NO_MODEL_TEXT, WhatIfCard
from workbench.extras.flightdata.flying_again_question import FlyAgain
from workbench.gui.tuning.designs import Designs
from workbench.gui.workspace import OpenedLog

LOG = Path("/logs/flight.csv")


@pytest.fixture
def made(offline, trial, qtbot):
    """The card before a log is opened."""
    offline = replace(offline, log=OpenedLog())
    card = WhatIfCard(offline, trial, Designs(offline.flight, trial))
    card.workspace = offline
    qtbot.addWidget(card)
    card.resize(420, 420)
    card.show()
    card.begin()
    card.set_seen(True)
    return card


@pytest.fixture
def card(made, offline, qtbot):
    """The card of a log, whose flight was asked for."""
    made.workspace.log.open(LOG)
    qtbot.waitUntil(lambda: bool(offline.analysis.of(FlyAgain)))
    return made


def test_without_a_log_or_a_model_it_says_what_to_open(made, offline, gains, qtbot):
    qtbot.waitUntil(lambda: made.said.text() == NO_LOG_TEXT)
    assert offline.analysis.of(FlyAgain) == []
    gains.proposed.clear()
    made.workspace.log.open(LOG)
    qtbot.waitUntil(lambda: made.said.text() == NO_MODEL_TEXT)
    assert offline.analysis.of(FlyAgain) == []


def test_the_curve_comes_first_and_the_band_while_gains_rest(card, offline, trial, fly_again):
    for number, draws in enumerate(DRAW_COUNTS):
        assert len(asked := offline.analysis.of(FlyAgain)) == number + 1
        assert asked[-1] == FlyAgain(LOG, trial.proposed, draws=draws)
        offline.analysis.tell(*fly_again(asked[-1]))
        assert ("low" in card.plot.names) is (draws > 0)
    assert len(offline.analysis.of(FlyAgain)) == len(DRAW_COUNTS)
    assert {"setpoint", "flown", "again"} < set(card.plot.names)
    assert card.numbers.text() == "off setpoint 0.000 → 0.100, apart 0.100 ± 0.020 m"
    card.signal.setCurrentIndex(4)
    assert "setpoint" not in card.plot.names
    assert card.numbers.text() == "apart 0.100 ± 0.020 m/s"


def test_moved_gains_are_asked_for_next_and_what_is_past_is_not(
    card, offline, gains, fly_again, qtbot
):
    for value in (300.0, 310.0, 320.0):  # faster than answers come
        gains.propose("kp_pitch", value)
        qtbot.wait(20)
    first, *more = offline.analysis.of(FlyAgain)
    assert not more
    offline.analysis.tell(*fly_again(first))
    assert card.said.text() == "For the previous request; the new flight follows …"
    _, last = offline.analysis.of(FlyAgain)
    assert last.gains["kp_pitch"] == 320.0 and last.draws == 0
    flown = {"kp_pitch": first.gains["kp_pitch"]}
    offline.analysis.tell(*fly_again(last, flown_gains=flown))
    assert card.said.text() == "dh_drone flies flight.csv: kp_pitch 320"
    qtbot.mouseClick(card.own, Qt.MouseButton.LeftButton)
    assert gains.proposed["kp_pitch"] == first.gains["kp_pitch"]


def test_another_controller_by_keyboard(card, offline, fly_again, qtbot):
    offline.analysis.tell(*fly_again(offline.analysis.of(FlyAgain)[-1]))
    card.law.setFocus()
    qtbot.keyClick(card.law, Qt.Key.Key_Down)
    offline.analysis.tell(*fly_again(offline.analysis.of(FlyAgain)[-1]))
    qtbot.waitUntil(lambda: offline.analysis.of(FlyAgain)[-1].controller == "pid")
    offline.analysis.tell(*fly_again(offline.analysis.of(FlyAgain)[-1]))
    assert card.said.text() == "dh_drone flies flight.csv: pid in place of pd"
    assert not card.own.isEnabled()


def test_it_says_why_a_log_is_not_flown_again(card, offline, case):
    asked = offline.analysis.of(FlyAgain)[-1]
    offline.analysis.refused.emit(asked, f"{LOG}: has no motors.command_1")
    assert card.said.text() == "Not flown again: flight.csv: has no motors.command_1"
    assert card.plot.names == () and card.numbers.text() == ""
    word = card.said.fontMetrics().horizontalAdvance("B3_figure8_fast_repetition2.csv.gz:")
    assert card.said.width() > word  # no name of a log is cut beside the card's buttons


def test_it_warns_of_another_drone_and_of_lost_ones(card, offline, fly_again, case):
    asked = offline.analysis.of(FlyAgain)[-1]
    offline.analysis.tell(*fly_again(asked))
    for said, other in (
        ("The log is of x500, the model of dh_drone.", {"logged_vehicle": "x500"}),
        ("Is it the drone that flew?", {"doubt": "is it the drone that flew?"}),
        ("With it the drone would have been lost.", {"stays": False}),
        ("3 of 25 uncertain drones would be lost: as it flew", {"lost": 3, "drawn": 25}),
    ):
        with case(said):
            asked = offline.analysis.of(FlyAgain)[-1]
            offline.analysis.tell(*fly_again(asked, **other))
            assert card.said.text() == said


def test_it_says_how_many_reach_the_ground_whatever_else_is_in_doubt(
    card, offline, fly_again, case
):
    for said, other in (
        (
            "With it the drone would have been lost. 2 of 25 would reach the ground. Doubtful.",
            {"stays": False, "lost": 3, "grounded": 2, "drawn": 25, "doubt": "doubtful"},
        ),
        (
            "3 of 25 uncertain drones would be lost: as it flew. 2 of 25 would reach the ground",
            {"lost": 3, "grounded": 2, "drawn": 25},
        ),
    ):
        with case(said):
            asked = offline.analysis.of(FlyAgain)[-1]
            offline.analysis.tell(*fly_again(asked, **other))
            assert card.said.text() == said


def test_preparations_are_told(card, offline):
    offline.analysis.preparing.emit("reading flight.csv")
    assert card.said.text() == "reading flight.csv …"
