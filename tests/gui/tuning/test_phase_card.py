"""Where the phase went, from the answers that the margins come with."""

import math

import pytest
from scipy import signal

from workbench.analysis.judging import judge as answer
from workbench.analysis.questions import Judge
from workbench.analysis.subject import Subject
from workbench.gui.tuning.judgement import Judgement
from workbench.gui.tuning.limits import Limits
from workbench.gui.tuning.phase_card import PARTS, PhaseCard
from workbench.gui.tuning.table_rows import State
from workbench.scenario.scenario import Scenario

FLOWN = {"kp_pitch": 225.0, "kd_pitch": 27.0}
PROPOSED = {"kp_pitch": 225.0, "kd_pitch": 30.0}
TURNED = {"law": -70.0, "filters": -20.0, "estimator": -5.0, "delay": -2.0, "hold": -3.0}


@pytest.fixture
def card(offline, qtbot):
    judgement = Judgement(offline.analysis)
    judgement.set_seen(True)
    made = PhaseCard(offline, judgement, Limits(offline.preferences.store))
    made.judgement = judgement
    qtbot.addWidget(made)
    made.resize(560, 270)
    made.show()
    return made


def row(card, name):
    return next(each for each in card.table.rows if each.label == name)


def turned(**other):
    return tuple(
        (name, math.radians(angle)) for name, angle in {**TURNED, "rotors": -20.0, **other}.items()
    )


def test_each_loop_shows_its_parts_what_costs_most_and_what_is_left(
    card, offline, judge, make_loop
):
    assert card.said.text() == "Not known yet."
    card.judgement.follow(FLOWN, FLOWN)
    pitch = make_loop("pitch", phase_margin=math.radians(40.0), turned=turned(rotors=-40.0))
    offline.analysis.judged.emit(judge(FLOWN, pitch))
    cells = row(card, "pitch").cells
    assert [cell.text for cell in cells] == [
        "−70",
        "−20",
        "−5.0",
        "−2.0",
        "−3.0",
        "−40",
        "40.0",
    ]
    assert [cell.marked for cell in cells] == ["", "", "", "", "", "most", ""]
    assert cells[-1].over
    assert "at 10 rad/s" in cells[1].help and "the low-passes" in cells[1].help
    assert card.said.text() == "Weakest: pitch; most: rotors −40°"
    assert "most" in row(card, "pitch").spoken
    # loops whose parts are not known say so, and nothing else
    assert {cell.text for cell in row(card, "roll").cells[:-1]} == {"–"}


def test_a_cut_off_that_moves_is_followed_beside_what_flies(card, offline, judge, make_loop):
    card.judgement.follow(FLOWN, FLOWN)
    offline.analysis.judged.emit(judge(FLOWN, make_loop("pitch", turned=turned())))
    card.judgement.follow(PROPOSED, FLOWN)
    slower = make_loop("pitch", turned=turned(filters=-35.0))
    offline.analysis.judged.emit(judge(PROPOSED, slower))
    filters = row(card, "pitch").cells[1]
    assert (filters.text, filters.was, filters.marked) == ("−35", "−20", "most")
    assert row(card, "pitch").cells[0].was == ""


def test_an_unstable_loop_has_no_parts(card, offline, judge, make_loop):
    card.judgement.follow(FLOWN, FLOWN)
    broken = make_loop("roll", stable=False, growing=True)
    offline.analysis.judged.emit(judge(FLOWN, broken, said="the roll loop is unstable."))
    assert row(card, "roll").state is State.BROKEN
    assert {cell.text for cell in row(card, "roll").cells} == {"–"}
    assert card.said.text() == "The roll loop is unstable."


def test_its_degrees_are_those_of_the_filter_in_closed_form(card, offline):
    """A low-pass of the second order at the crossover that the answer itself has."""
    values = {"gyro_lowpass": 40.0, "gyro_lowpass_order": 2.0}
    (judged,) = answer(Subject(Scenario(), {}), Judge(values), None)
    card.judgement.follow(judged.gains, judged.gains)
    offline.analysis.judged.emit(judged)
    pitch = next(each for each in judged.loops if each.name == "pitch")
    cells = dict(zip(PARTS, row(card, "pitch").cells, strict=False))
    shown = {name: float(cell.text.replace("−", "-")) for name, cell in cells.items()}
    # from 10 degrees on there are no decimals
    left = math.degrees(pitch.phase_margin) - 180.0
    assert sum(shown.values()) == pytest.approx(left, abs=1.5)
    b, a = signal.butter(2, 40.0, fs=1024.0)
    _, response = signal.freqz(b, a, [pitch.crossover], fs=2.0 * math.pi * 1024.0)
    # rates pass the filter, angles do not: it costs between nothing and this
    assert math.degrees(math.atan2(response[0].imag, response[0].real)) < shown["filters"] < 0.0
