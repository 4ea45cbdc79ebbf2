import math
from types import SimpleNamespace

import numpy as np
import pytest
from PyQt6.QtCore import Qt
from PyQt6.QtWidgets import QLabel

from workbench.analysis.queries import Judge, JudgePlantInput
from workbench.analysis.replies import Judged
from workbench.gui.tuning.bode_plots import margin_guides
from workbench.gui.tuning.judgement import StabilityFollower
from workbench.gui.tuning.limits import MARGIN_LIMITS, LimitValues
from workbench.gui.tuning.margins_card import (
    PLANT_INPUT_ROW,
    MarginsCard,
    margin_rows,
    margins_headline,
)
from workbench.gui.tuning.number_row import Cell, NumberRow, RowState
from workbench.gui.tuning.number_table import NumberTable

FLOWN = {"kp_pitch": 225.0, "kd_pitch": 27.0}
PROPOSED = {"kp_pitch": 300.0, "kd_pitch": 27.0}


@pytest.fixture
def card(offline, qtbot):
    judgement = StabilityFollower(offline.analysis)
    judgement.set_seen(True)
    made = MarginsCard(offline, judgement, LimitValues(offline.preferences.store))
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
    assert row(card, "pitch").state is RowState.GOOD
    assert len(card.table.rows) == 7  # the last is the plant's input


def test_a_margin_below_its_limit_is_low_in_a_word_and_named_above(card, offline, judge, make_loop):
    card.judgement.follow(FLOWN, FLOWN)
    low = make_loop("pitch", phase_margin=np.radians(30.0))
    offline.analysis.tell(*judge(FLOWN, low))
    assert row(card, "pitch").state is RowState.LOW
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
    assert row(card, "pitch").state is RowState.GOOD
    assert LimitValues(offline.preferences.store).value("phase_margin") == 25.0


def test_an_unstable_loop_is_named_in_a_sentence_and_has_no_numbers(
    card, offline, judge, make_loop
):
    card.judgement.follow(FLOWN, FLOWN)
    broken = make_loop("roll", stable=False, growing=True)
    along = make_loop("pitch", stable=False)
    said = "the roll loop is unstable."
    offline.analysis.tell(*judge(FLOWN, broken, along, said=said))
    assert card.said.text() == "The roll loop is unstable."
    assert row(card, "roll").state is RowState.BROKEN
    assert row(card, "pitch").state is RowState.NONE
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
    """The tool tip has both."""
    head = ["phase °", "delay ms"]
    table = NumberTable("margins", head, offline.look, paired=True, widest="pitch")
    qtbot.addWidget(table)
    cells = Cell("50.0", "60.0", help="phase"), Cell("12", help="delay")
    table.set_rows((NumberRow("pitch", cells, RowState.GOOD),))
    for width, shown in ((210, "50.0"), (500, "60.0→50.0"), (210, "50.0")):
        table.resize(width, 100)
        table.show()
        assert table.item(0, 1).text() == shown
        assert table.item(0, 1).toolTip() == "phase (flown: 60.0)"
        assert table.item(0, 2).text() == "12"


def test_no_number_word_or_heading_of_a_table_is_cut(offline, qtbot):
    """At the narrowest width of its column, 430 px, and wider; long labels have two lines."""
    head = [f"{limit.short} {limit.unit}".strip() for limit in MARGIN_LIMITS]
    words = {"label": "velocity x", "strong": True}
    for paired, worded in ((True, True), (False, False), (True, False)):
        table = NumberTable("m", head, offline.look, paired=paired, widest="roll", worded=worded)
        qtbot.addWidget(table)
        cells = tuple(
            Cell(text, "60.0", over=True) for text in ("−11.4", "∞", "145.0", "1234", "–")
        )
        table.set_rows((NumberRow(cells=cells, state=RowState.BROKEN, **words),))
        for width in (430, 560, 900):
            table.resize(width, 200)
            table.show()
            for column in range(1, table.columnCount()):
                needed = table.horizontalHeader().sectionSizeHint(column)
                needed = max(needed, table.sizeHintForColumn(column))
                assert table.columnWidth(column) >= needed, (paired, worded, width, column)
            assert table.horizontalHeader().length() <= table.viewport().width()
            assert table.rowHeight(0) >= table.fontMetrics().height()


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
    card.table.setCurrentCell(0, 0)
    chosen = []
    card.loop_chosen.connect(chosen.append)
    qtbot.keyClick(card.table, Qt.Key.Key_Down)
    assert [card.table.item(card.table.currentRow(), at).text() for at in (0, 1)] == [
        "vel. y",
        "12.0",
    ]
    qtbot.keyClick(card.table, Qt.Key.Key_Return)
    assert chosen == ["velocity_y"]
    qtbot.keyClick(card.table, Qt.Key.Key_P)  # a letter is for the charts, not a search for "pitch"
    assert card.table.currentRow() == 1


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
    assert row(card, PLANT_INPUT_ROW).state is RowState.WAITING
    for value in range(226, 246):
        card.judgement.follow({**FLOWN, "kp_pitch": float(value)}, FLOWN)
    card.judgement.follow(PROPOSED, FLOWN)
    asked.tell(*judge(PROPOSED))
    assert asked.of(JudgePlantInput) == []
    for gains, margin in ((PROPOSED, 0.55), (FLOWN, 0.71)):
        qtbot.waitUntil(lambda: bool(asked.of(JudgePlantInput)), timeout=20000)
        assert asked.asked.pop() == JudgePlantInput(gains)
        asked.tell(JudgePlantInput(gains), (0.8, margin))
    found = row(card, PLANT_INPUT_ROW)
    assert [cell.text for cell in found.cells] == ["", "", "", "", "0.55"]
    assert found.cells[-1].was == "0.71"
    assert "0.80 while the pilot steers, 0.55 while the position is held" in found.cells[-1].help
    assert found.state is RowState.LOW
    assert found.spoken == f"{PLANT_INPUT_ROW}: 0.55 low"
    assert card.said.text() == f"Weakest: {PLANT_INPUT_ROW}, disk margin 0.55 (≥ 0.6)"
    card.judgement.follow(FLOWN, FLOWN)
    assert row(card, PLANT_INPUT_ROW).state is RowState.GOOD
    card.judgement.follow({**FLOWN, "kp_pitch": 1.0}, FLOWN)
    assert row(card, PLANT_INPUT_ROW).state is RowState.WAITING
    assert row(card, PLANT_INPUT_ROW).cells[-1].text == "–"
    qtbot.waitUntil(lambda: bool(asked.of(JudgePlantInput)), timeout=20000)
    asked.refused.emit(asked.of(JudgePlantInput)[-1], "its process has died")
    assert "its process has died" in row(card, PLANT_INPUT_ROW).cells[-1].help


def test_what_is_broken_is_compared_with_nothing(card, offline, judge, make_loop):
    card.judgement.follow(FLOWN, FLOWN)
    offline.analysis.tell(*judge(FLOWN))
    card.judgement.follow(PROPOSED, FLOWN)
    offline.analysis.tell(*judge(PROPOSED, make_loop("pitch", stable=False)))
    assert {cell.was for cell in row(card, "pitch").cells} == {""}


def test_a_margin_that_is_no_number_keeps_no_limit():
    for limit in MARGIN_LIMITS:
        assert limit.number_text(float("nan")) == "–"
        assert not limit.keeps(float("nan"), 0.0)


def test_only_the_rows_that_have_changed_are_painted(card, offline, judge, make_loop, monkeypatch):
    card.judgement.follow(FLOWN, FLOWN)
    less = make_loop("pitch", phase_margin=1.0)
    offline.analysis.tell(*judge(FLOWN, less))
    card.judgement.follow(PROPOSED, FLOWN)
    written = []
    monkeypatch.setattr(card.table, "setItem", lambda row, *rest: written.append(row))
    offline.analysis.tell(*judge(PROPOSED, make_loop("pitch", phase_margin=0.9)))
    assert {card.table.rows[row].label for row in written} == {"pitch"}


def test_a_margin_looks_the_same_in_a_sentence_a_table_and_a_plot(make_loop):
    """A phase margin of 52.345 deg, at 12.3456 rad/s."""
    judged = make_loop("roll", phase_margin=math.radians(52.345), crossover=12.3456)
    all_loops = Judged((judged,), np.array([-1.0 + 0.0j]), True, "")
    limits = {"phase_margin": 60.0}
    (row,) = margin_rows(all_loops, None, lambda name: limits.get(name, 0.0))
    said = margins_headline(all_loops, None, lambda name: limits.get(name, 0.0))
    frequency = np.geomspace(1.0, 100.0, 50)
    drawn = SimpleNamespace(
        margins=judged, frequency=frequency, open_loop=judged.crossover / (1j * frequency)
    )
    (_, size), (_, turn) = margin_guides(drawn)
    assert said == "Weakest: roll, phase margin 52.3° (≥ 60°)"
    assert "52.3" in [cell.text for cell in row.cells]
    assert turn == "phase 52.3°"
    assert size.split(", ")[0] == "12.3\N{NO-BREAK SPACE}rad/s"
    assert "at 12.3\N{NO-BREAK SPACE}rad/s" in row.cells[2].help


def test_a_long_refusal_has_two_lines_and_the_whole_of_it_in_the_tool_tip(card, offline, qtbot):
    short = card.said.height()
    refusal = "unknown parameter 'kp_pitch': known are " + ", ".join(f"gain_{n}" for n in range(99))
    card.said.say(refusal)
    assert card.said.sizeHint().height() == short
    assert card.said.text() == card.said.toolTip() == card.said.accessibleName() == refusal
    drawn = QLabel.text(card.said)
    assert refusal.startswith(drawn[:-1]) and drawn.endswith("…")
    card.resize(1600, 270)  # there more of it fits
    assert len(QLabel.text(card.said)) > len(drawn)
    card.said.say("Weakest: roll")
    assert QLabel.text(card.said) == "Weakest: roll" and not card.said.toolTip()
