import numpy as np
import pytest
from PyQt6.QtCore import Qt

from workbench.analysis.questions import Judge, JudgePlantInput
from workbench.gui.tuning.judgement import Judgement
from workbench.gui.tuning.limits import MARGIN_LIMITS, Limits
from workbench.gui.tuning.margins_card import PLANT_INPUT, MarginsCard
from workbench.gui.tuning.number_table import Cell, NumberTable, Row, State

FLOWN = {"kp_pitch": 225.0, "kd_pitch": 27.0}
PROPOSED = {"kp_pitch": 300.0, "kd_pitch": 27.0}


@pytest.fixture
def card(offline, qtbot):
    judgement = Judgement(offline.analysis)
    judgement.set_seen(True)
    made = MarginsCard(offline, judgement, Limits(offline.preferences.store))
    made.judgement = judgement
    qtbot.addWidget(made)
    made.resize(430, 270)
    made.show()
    return made


def row(card, name):
    return next(each for each in card.table.rows if each.label == name)


def test_every_loop_is_a_row_with_its_margins_in_the_units_of_engineers(
    card, offline, judge, make_loop
):
    card.judgement.follow(FLOWN, FLOWN)
    pitch = make_loop(
        "pitch",
        gain_margin=10.0,
        gain_reduction_margin=0.1,
        phase_margin=np.pi / 3,
        delay_margin=0.025,
        disk_margin=0.7,
    )
    offline.analysis.tell(*judge(FLOWN, pitch))
    assert [cell.text for cell in row(card, "pitch").cells] == [
        "20.0",
        "20.0",
        "60.0",
        "25",
        "0.70",
    ]
    assert "factor 10" in row(card, "pitch").cells[0].help
    assert row(card, "pitch").state is State.GOOD
    assert len(card.table.rows) == 7  # the last is the plant's input


def test_a_margin_below_its_limit_is_low_in_a_word_and_named_above(card, offline, judge, make_loop):
    card.judgement.follow(FLOWN, FLOWN)
    low = make_loop("pitch", phase_margin=np.radians(30.0))
    offline.analysis.tell(*judge(FLOWN, low))
    assert row(card, "pitch").state is State.LOW
    assert [cell.over for cell in row(card, "pitch").cells] == [False, False, True, False, False]
    assert card.said.text() == "Weakest: pitch, phase margin 30.0° (≥ 45°)"
    assert row(card, "pitch").strong


def test_another_limit_judges_anew_and_is_kept(card, offline, judge, make_loop, qtbot):
    card.judgement.follow(FLOWN, FLOWN)
    low = make_loop("pitch", phase_margin=np.radians(30.0))
    offline.analysis.tell(*judge(FLOWN, low))
    qtbot.mouseClick(card.form.button, Qt.MouseButton.LeftButton)
    field = card.form.fields["phase_margin"]
    assert field.isVisible()
    field.selectAll()
    qtbot.keyClicks(field, "25")
    qtbot.keyClick(field, Qt.Key.Key_Return)
    assert row(card, "pitch").state is State.GOOD
    assert Limits(offline.preferences.store).value("phase_margin") == 25.0


def test_an_unstable_loop_is_named_in_a_sentence_and_has_no_numbers(
    card, offline, judge, make_loop
):
    card.judgement.follow(FLOWN, FLOWN)
    broken = make_loop("roll", stable=False, growing=True)
    along = make_loop("pitch", stable=False)
    said = "the roll loop is unstable."
    offline.analysis.tell(*judge(FLOWN, broken, along, said=said))
    assert card.said.text() == "The roll loop is unstable."
    assert row(card, "roll").state is State.BROKEN
    assert row(card, "pitch").state is State.NONE
    for name in ("roll", "pitch"):
        assert {cell.text for cell in row(card, name).cells} == {"–"}


def test_proposed_margins_stand_beside_those_that_fly_where_they_differ(
    card, offline, judge, make_loop
):
    card.judgement.follow(FLOWN, FLOWN)
    offline.analysis.tell(*judge(FLOWN))
    card.judgement.follow(PROPOSED, FLOWN)
    less = make_loop("pitch", phase_margin=np.radians(50.0))
    offline.analysis.tell(*judge(PROPOSED, less))
    phase = row(card, "pitch").cells[2]
    assert (phase.text, phase.was) == ("50.0", "60.0")
    assert row(card, "pitch").cells[0].was == ""
    assert all(cell.was == "" for cell in row(card, "roll").cells)


def test_a_row_without_room_for_two_numbers_shows_the_new_one(offline, qtbot):
    """Side by side none fits, below each other they would overlap: the tool tip has the other."""
    table = NumberTable("margins", ["phase °"], offline.look, paired=True, widest="pitch")
    qtbot.addWidget(table)
    shown = {}
    for lines in (1.3, 2.2):
        table.resize(100, round(2 * lines * table.fontMetrics().height()))
        for was in ("", "60.0"):
            table.set_rows((Row("pitch", (Cell("50.0", was, help="phase"),), State.GOOD),))
            shown[lines, was] = table.grab().toImage()
    assert shown[1.3, ""] == shown[1.3, "60.0"]
    assert shown[2.2, ""] != shown[2.2, "60.0"]
    assert table.help_at(50.0, table.height() - 5.0) == "phase (flown: 60.0)"


def test_a_slider_that_moves_is_followed_by_one_question_at_a_time(card, offline, judge):
    analysis = offline.analysis
    card.judgement.follow(FLOWN, FLOWN)
    analysis.tell(*judge(FLOWN))
    asked = len(analysis.asked)
    for value in range(226, 246):
        card.judgement.follow({**FLOWN, "kp_pitch": float(value)}, FLOWN)
    assert len(analysis.asked) == asked + 1
    analysis.tell(*judge({**FLOWN, "kp_pitch": 226.0}))
    assert analysis.asked[-1] == Judge({**FLOWN, "kp_pitch": 245.0})


def test_gains_that_are_known_are_not_asked_about_again(card, offline, judge):
    card.judgement.follow(FLOWN, FLOWN)
    offline.analysis.tell(*judge(FLOWN))
    card.judgement.follow(PROPOSED, FLOWN)
    offline.analysis.tell(*judge(PROPOSED))
    asked = len(offline.analysis.asked)
    card.judgement.follow(FLOWN, FLOWN)
    assert len(offline.analysis.asked) == asked
    assert card.judgement.gains == FLOWN


def test_arrows_read_row_after_row(card, offline, judge, qtbot):
    card.judgement.follow(FLOWN, FLOWN)
    offline.analysis.tell(*judge(FLOWN))
    card.table.setFocus()
    for _ in range(2):
        qtbot.keyClick(card.table, Qt.Key.Key_Down)
    assert card.table.accessibleDescription().startswith("vel. y: 12.0")


def test_margins_of_earlier_gains_say_so_once_the_analyst_refuses(card, offline, judge, make_loop):
    card.judgement.follow(FLOWN, FLOWN)
    offline.analysis.tell(*judge(FLOWN))
    card.judgement.follow(PROPOSED, FLOWN)
    offline.analysis.refused.emit(offline.analysis.of(Judge)[-1], "its process has died")
    assert card.said.text() == "Of earlier gains: its process has died"
    card.judgement.follow(FLOWN, FLOWN)
    assert card.said.text().startswith("Weakest")


def test_margins_of_earlier_gains_say_so_when_the_analyst_is_slow(card, offline, judge, qtbot):
    card.judgement.follow(FLOWN, FLOWN)
    offline.analysis.tell(*judge(FLOWN))
    card.judgement.follow(PROPOSED, FLOWN)
    assert card.said.text().startswith("Weakest")
    qtbot.waitUntil(lambda: card.said.text().startswith("Of earlier gains"), timeout=10000)
    offline.analysis.tell(*judge(PROPOSED))
    assert card.said.text().startswith("Weakest")


def test_the_plants_input_is_asked_about_once_a_slider_rests(card, offline, judge, qtbot):
    """One row: its disk margin beside that of the gains that fly, low below the limit of disks."""
    asked = offline.analysis
    card.judgement.follow(FLOWN, FLOWN)
    asked.tell(*judge(FLOWN))
    assert row(card, PLANT_INPUT).state is State.WAITING
    for value in range(226, 246):
        card.judgement.follow({**FLOWN, "kp_pitch": float(value)}, FLOWN)
    card.judgement.follow(PROPOSED, FLOWN)
    asked.tell(*judge(PROPOSED))
    assert asked.of(JudgePlantInput) == []
    for gains, margin in ((PROPOSED, 0.55), (FLOWN, 0.71)):
        qtbot.waitUntil(lambda: bool(asked.of(JudgePlantInput)), timeout=20000)
        assert asked.asked.pop() == JudgePlantInput(gains)
        asked.tell(JudgePlantInput(gains), (0.8, margin))
    found = row(card, PLANT_INPUT)
    assert [cell.text for cell in found.cells] == ["", "", "", "", "0.55"]
    assert found.cells[-1].was == "0.71"
    assert "0.80 while the pilot steers, 0.55 while the position is held" in found.cells[-1].help
    assert found.state is State.LOW
    assert found.spoken == f"{PLANT_INPUT}: 0.55 low"
    assert card.said.text() == f"Weakest: {PLANT_INPUT}, disk margin 0.55 (≥ 0.6)"
    card.judgement.follow(FLOWN, FLOWN)
    assert row(card, PLANT_INPUT).state is State.GOOD
    card.judgement.follow({**FLOWN, "kp_pitch": 1.0}, FLOWN)
    assert row(card, PLANT_INPUT).state is State.WAITING
    assert row(card, PLANT_INPUT).cells[-1].text == "–"
    qtbot.waitUntil(lambda: bool(asked.of(JudgePlantInput)), timeout=20000)
    asked.refused.emit(asked.of(JudgePlantInput)[-1], "its process has died")
    assert "its process has died" in row(card, PLANT_INPUT).cells[-1].help


def test_what_is_broken_is_compared_with_nothing(card, offline, judge, make_loop):
    card.judgement.follow(FLOWN, FLOWN)
    offline.analysis.tell(*judge(FLOWN))
    card.judgement.follow(PROPOSED, FLOWN)
    offline.analysis.tell(*judge(PROPOSED, make_loop("pitch", stable=False)))
    assert {cell.was for cell in row(card, "pitch").cells} == {""}


def test_a_margin_that_is_no_number_keeps_no_limit():
    for limit in MARGIN_LIMITS:
        assert limit.text(float("nan")) == "–"
        assert not limit.keeps(float("nan"), 0.0)


def test_only_the_rows_that_have_changed_are_painted(card, offline, judge, make_loop, monkeypatch):
    card.judgement.follow(FLOWN, FLOWN)
    less = make_loop("pitch", phase_margin=1.0)
    offline.analysis.tell(*judge(FLOWN, less))
    card.judgement.follow(PROPOSED, FLOWN)
    painted = []
    monkeypatch.setattr(card.table, "update", lambda *parts: painted.append(parts))
    offline.analysis.tell(*judge(PROPOSED, make_loop("pitch", phase_margin=0.9)))
    assert len(painted) == 1
    (box,) = painted[0]
    assert box.height() < 2 * card.table.fontMetrics().height() + 10
