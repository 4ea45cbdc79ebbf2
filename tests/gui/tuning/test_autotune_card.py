import dataclasses

import numpy as np
import pytest
from PyQt6.QtCore import Qt

from workbench.analysis.queries import Tune
from workbench.analysis.replies import Searched, Tuned
from workbench.control.controller_file import load_controller
from workbench.design.metrics import WISHED_METRICS, find_metric, units_of_bounds
from workbench.design.tune.wish import parse_wish
from workbench.gui.tuning.autotune_card import DEFAULT_REQUIREMENTS, AutoTuneCard
from workbench.gui.tuning.number_row import RowState
from workbench.gui.tuning.requirement_rows import MAX_REQUIREMENTS, requirement_names

FOUND = {"kp_velocity_x": 5.5, "kp_pitch": 180.0}
TIME = np.linspace(0.0, 2.0, 50)


@pytest.mark.parametrize("law", [load_controller(name) for name in ("pd", "pid", "geometric")])
def test_every_number_that_is_offered_makes_a_wish_in_every_unit(law):
    values = {"deg": "45", "dB": "6", "Hz": "3", "ms": "300"}
    names = requirement_names(law)
    for name in names:
        metric = find_metric(name.split(".")[1], WISHED_METRICS)
        for unit in units_of_bounds(metric):
            number = "2" if metric.name in ("peak_sensitivity", "gain_margin") else "0.5"
            number = "200" if (metric.name, unit) == ("peak_sensitivity", "%") else number
            number = "50" if unit == "%" and "peak_s" not in name else number
            assert parse_wish(f"{name} >= {values.get(unit, number)} {unit}".strip(), law=law)
    assert set(names) > {"level.overshoot", "tilt.phase_margin", "rotors.noise_amplification"}
    assert set(names) > {f"{loop.name}.disk_margin" for loop in law.loops}


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
    assert offline.analysis.of(Tune) == [Tune(trial.proposed, DEFAULT_REQUIREMENTS)]
    assert card.is_running


def choose(box, data):
    """Choose an item, as a user does."""
    box.setCurrentIndex(box.findData(data))
    box.activated.emit(box.currentIndex())


def enter(qtbot, field, text):
    field.setFocus()
    field.selectAll()
    qtbot.keyClicks(field, text)
    qtbot.keyClick(field, Qt.Key.Key_Return)


def test_a_wish_is_a_metric_a_relation_a_number_and_a_unit(card, qtbot):
    press(qtbot, card.wishes.add)
    row = card.wishes.rows[-1]
    choose(row.name, "pitch.gain_margin")
    assert row.relation.currentData() == ">="
    enter(qtbot, row.number, "7,5")
    assert row.text == "pitch.gain_margin >= 7.5 dB"
    choose(row.name, "yaw.rise_time")
    choose(row.unit, "ms")
    enter(qtbot, row.number, "450")
    assert card.wishes.wishes == (*DEFAULT_REQUIREMENTS, "yaw.rise_time <= 450 ms")
    press(qtbot, card.wishes.rows[0].remove)
    assert card.wishes.wishes == (*DEFAULT_REQUIREMENTS[1:], "yaw.rise_time <= 450 ms")


def test_there_are_as_many_wishes_as_a_search_takes(card, qtbot):
    while card.wishes.add.isEnabled():
        press(qtbot, card.wishes.add)
    assert len(card.wishes.rows) == MAX_REQUIREMENTS
    for row in list(card.wishes.rows):
        press(qtbot, row.remove)
    assert card.wishes.wishes == () and not card.start.isEnabled()


def test_a_bad_wish_is_told_below_its_row_and_stops_the_search(card, qtbot):
    row = card.wishes.rows[2]
    enter(qtbot, row.number, "400")
    assert row.fault.text().startswith("✕ phase_margin of 400 deg is not possible")
    assert not card.start.isEnabled()
    enter(qtbot, row.number, "soon")
    assert "not a number" in row.number.fault and not card.start.isEnabled()
    enter(qtbot, row.number, "50")
    assert row.fault.isHidden() and card.start.isEnabled()


def test_a_loop_that_another_controller_lacks_is_marked_and_stays(card):
    choose(card.wishes.rows[0].name, "roll_acceleration.disk_margin")
    card.wishes.set_controller(load_controller("geometric"))
    kept = card.wishes.rows[0]
    assert kept.text.startswith("roll_acceleration.disk_margin") and not kept.is_good


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
    assert [row.state for row in card.table.rows] == [RowState.GOOD, RowState.MISSED]
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
    offline.analysis.refused.emit(question, f"'{DEFAULT_REQUIREMENTS[1]}': both cannot be met")
    assert card.wishes.rows[1].fault.text() == f"✕ '{DEFAULT_REQUIREMENTS[1]}': both cannot be met"
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
        table = card.table
        assert table.columnWidth(1) >= table.fontMetrics().horizontalAdvance("44.0312 deg")
        assert sum(map(table.columnWidth, range(4))) <= table.width() + 1
        assert table.item(0, 0).toolTip() == long[0]
