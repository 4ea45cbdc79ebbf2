import dataclasses

import numpy as np
import pytest
from PyQt6.QtCore import Qt

from workbench.analysis.questions import Tune
from workbench.analysis.replies import Searched, Tuned
from workbench.control.controller import load_controller
from workbench.design.tune.wish import parse_wish
from workbench.gui.tuning.autotune_card import (
    DEFAULT,
    AutoTuneCard,
    completions,
    what_is_wrong,
    with_point,
)
from workbench.gui.tuning.number_table import State

PD = load_controller()
FOUND = {"kp_velocity_x": 5.5, "kp_pitch": 180.0}
TIME = np.linspace(0.0, 2.0, 50)


@pytest.mark.parametrize("law", [load_controller(name) for name in ("pd", "pid", "geometric")])
def test_every_beginning_that_is_offered_makes_a_wish(law):
    values = {"phase_margin": "45 deg", "gain_margin": "6 dB", "peak_sensitivity": "2"}
    offered = completions(law)
    for each in offered:
        metric = each.split(".")[1].split()[0]
        assert parse_wish(each + values.get(metric, "0.5"), law=law)
    beginnings = {each.split(" ")[0] for each in offered}
    assert beginnings > {"level.overshoot", "tilt.phase_margin", "rotors.noise_amplification"}
    assert beginnings > {f"{loop.name}.disk_margin" for loop in law.loops}


@pytest.mark.parametrize("wish", [*DEFAULT, "x.rise_time<=,4", "pitch.phase_margin ≥ 45deg"])
def test_a_good_wish_is_good(wish):
    assert what_is_wrong(wish, PD) == ""


@pytest.mark.parametrize(
    ("wish", "said"),
    [
        ("faster", "'faster' is not a wish: write SUBJECT.METRIC"),
        ("x.speed <= 3", "unknown metric 'speed'"),
        ("pitch.peak_rotor_use <= 0.3", "pitch has no peak_rotor_use: that is of x, y, z, yaw"),
        ("x.rise_time <= soon", "'x.rise_time <= soon' is not a wish"),
        ("x.rise_time <= 1,000.5", "'1,000.5' has more than one point or comma"),
        ("yaw_rate.overshoot <= 5", "yaw_rate has no overshoot"),
    ],
)
def test_a_bad_wish_is_told_in_a_sentence(wish, said):
    assert what_is_wrong(wish, PD).startswith(said)


def test_a_comma_before_decimals_is_a_point_for_the_search():
    assert with_point(" x.rise_time <= 0,45 s ") == "x.rise_time <= 0.45 s"


def tuned(met=True, stopped=False) -> Tuned:
    return Tuned(
        before={"kp_velocity_x": 4.45, "kp_pitch": 225.0},
        gains=FOUND,
        met=met,
        stopped=stopped,
        wishes=(
            ("x.rise_time <= 0.4 s", "0.5 s", "0.38 s", True),
            ("x.overshoot <= 1 %", "3 %", "2 %", False),
        ),
        steps={"x": (TIME, TIME, 0.5 * TIME), "yaw": (TIME, TIME, TIME)},
        said=("The overshoot is at odds with the rise time.",),
    )


@pytest.fixture
def card(offline, trial, qtbot):
    made = AutoTuneCard(offline, trial)
    qtbot.addWidget(made)
    made.resize(420, 360)
    made.show()
    made.begin()
    return made


def press(qtbot, button):
    qtbot.mouseClick(button, Qt.MouseButton.LeftButton)


def test_a_search_begins_from_the_proposed_gains_with_the_wishes(card, offline, trial, qtbot):
    press(qtbot, card.start)
    assert offline.analysis.of(Tune) == [Tune(trial.proposed, DEFAULT)]
    assert card.is_running


def test_another_line_appears_as_one_is_typed(card, qtbot):
    before = len(card.wishes.lines)
    qtbot.keyClicks(card.wishes.lines[-1].field, "yaw.rise_time <= 0.5")
    assert len(card.wishes.lines) == before + 1
    assert card.wishes.wishes == (*DEFAULT, "yaw.rise_time <= 0.5")


def test_a_bad_wish_is_told_below_its_line_and_stops_the_search(card, qtbot):
    field = card.wishes.lines[0].field
    field.setFocus()
    field.selectAll()
    qtbot.keyClicks(field, "x.speed <= 3")
    card.wishes.lines[1].field.setFocus()
    field.editingFinished.emit()
    assert card.wishes.lines[0].fault.text().startswith("✕ unknown metric 'speed'")
    assert not card.start.isEnabled()
    field.selectAll()
    qtbot.keyClicks(field, "x.rise_time <= 0.3")
    assert card.wishes.lines[0].fault.isHidden()
    assert card.start.isEnabled()


def test_progress_shows_the_best_so_far(card, offline, qtbot):
    press(qtbot, card.start)
    offline.analysis.searched.emit(Searched("searching", 0.4, FOUND, "least to spare: overshoot"))
    assert card.progress.value() == 40
    assert "kp_velocity_x 5.5" in card.best.text()
    assert "overshoot" in card.best.text()


def test_stop_keeps_the_best(card, offline, qtbot):
    press(qtbot, card.start)
    press(qtbot, card.stop)
    assert offline.analysis.stopped == 1
    offline.analysis.tell(offline.analysis.of(Tune)[-1], tuned(met=False, stopped=True))
    assert card.said.text() == "Stopped: the best so far."


def test_before_and_after_stand_side_by_side(card, offline, qtbot):
    press(qtbot, card.start)
    offline.analysis.tell(offline.analysis.of(Tune)[-1], tuned(met=False))
    assert [row.state for row in card.table.rows] == [State.GOOD, State.MISSED]
    assert [cell.text for cell in card.table.rows[0].cells] == ["0.5 s", "0.38 s"]
    assert card.plot.names == ("before", "after")
    assert card.axis.count() == 2
    assert "at odds" in card.remarks.text()


def test_accepted_gains_fly_as_one_step_of_undo(card, offline, gains, qtbot):
    before = dict(gains.proposed)
    press(qtbot, card.start)
    offline.analysis.tell(offline.analysis.of(Tune)[-1], tuned())
    press(qtbot, card.accept)
    assert {name: gains.proposed[name] for name in FOUND} == FOUND
    gains.undo()
    assert dict(gains.proposed) == before


def test_discarded_gains_change_nothing(card, offline, gains, qtbot):
    before = dict(gains.proposed)
    press(qtbot, card.start)
    offline.analysis.tell(offline.analysis.of(Tune)[-1], tuned())
    press(qtbot, card.discard)
    assert dict(gains.proposed) == before
    assert card.start.isEnabled()


def test_a_refused_wish_is_blamed_where_it_stands(card, offline, qtbot):
    press(qtbot, card.start)
    question = offline.analysis.of(Tune)[-1]
    offline.analysis.refused.emit(question, f"'{DEFAULT[1]}': both cannot be met")
    assert card.wishes.lines[1].fault.text() == f"✕ '{DEFAULT[1]}': both cannot be met"
    assert not card.is_running


def test_an_answer_that_comes_after_another_flight_began_is_not_shown(card, offline, qtbot):
    press(qtbot, card.start)
    card.begin()
    offline.analysis.tell(offline.analysis.of(Tune)[-1], tuned())
    assert card.pages.currentIndex() == 0


def test_the_numbers_before_and_after_have_their_own_columns(card, offline, trial, qtbot):
    """A long wish gives way; what is cut of it stands in its tool tip."""
    long = ("tilt.phase_margin >= 45 deg, of all", "38.9123 deg", "44.0312 deg", False)
    press(qtbot, card.start)
    offline.analysis.tell(
        offline.analysis.of(Tune)[-1], dataclasses.replace(tuned(), wishes=(long,))
    )
    for width in (330, 420, 900):
        card.resize(width, 420)
        label, cell, word = card.table._columns()
        widest = card.table.fontMetrics().horizontalAdvance("44.0312 deg")
        assert cell >= widest
        assert label + 2 * cell + word <= card.table.width() + 1
        assert card.table.help_at(label / 2, 1.5 * card.table._row_height()) == long[0]
