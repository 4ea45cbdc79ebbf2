"""Where the phase went, from the answers that the margins come with."""

import math
from functools import partial

import pytest

from workbench.analysis.judging import judge_gains as answer
from workbench.analysis.queries import Judge
from workbench.analysis.subject import AnalysedVehicle
from workbench.design.judge.loop_judgement import judge_loops
from workbench.design.judge.phase_budget import PHASE_BUDGET_PARTS, phase_budgets
from workbench.design.linear.operating_point import OperatingPoint
from workbench.design.linear.study import LinearStudy
from workbench.gui.tuning.judgement import StabilityFollower
from workbench.gui.tuning.limits import LimitValues
from workbench.gui.tuning.number_row import RowState
from workbench.gui.tuning.phase_view import PhaseView
from workbench.scenario.scenario import Scenario

FLOWN = {"kp_pitch": 225.0, "kd_pitch": 27.0}
PROPOSED = {"kp_pitch": 225.0, "kd_pitch": 30.0}
TURNED = {"law": -70.0, "filters": -20.0, "estimator": -5.0, "delay": -2.0, "hold": -3.0}
LABELS = {"velocity": "vel.", "position": "pos.", "_": " "}


@pytest.fixture
def card(offline, qtbot):
    judgement = StabilityFollower(offline.analysis)
    judgement.set_seen(True)
    made = PhaseView(offline, judgement, LimitValues(offline.preferences.store))
    made.judgement = judgement
    qtbot.addWidget(made)
    made.resize(560, 270)
    made.show()
    return made


@pytest.fixture
def screen(screen):
    """The tuning screen with the table in front."""
    screen.resize(1190, 600)
    screen.tabs.setCurrentWidget(screen.frequency)
    screen.frequency.show_view("Phase")
    return screen


def row(card, name):
    for long, short in LABELS.items():
        name = name.replace(long, short)
    return next(each for each in card.table.rows if each.label == name)


def number(cell):
    return float(cell.text.replace("−", "-"))


def is_asked(analysis, times):
    return len(analysis.of(Judge)) >= times


def turned(**other):
    return tuple(
        (name, math.radians(angle)) for name, angle in {**TURNED, "rotors": -20.0, **other}.items()
    )


@pytest.mark.parametrize("estimator", ["truth", "ekf"])
def test_the_table_is_that_of_the_judge_and_follows_a_cut_off(screen, offline, qtbot, estimator):
    """Each cut-off is asked about once, and the answer of the margins fills both cards."""
    analysis, scenario = offline.analysis, Scenario(estimator=estimator)
    subject, study, filters = AnalysedVehicle(scenario, {}), LinearStudy(scenario), {}
    qtbot.waitUntil(lambda: bool(analysis.of(Judge)))
    for cutoff in (80.0, 25.0):
        asked = len(analysis.of(Judge))
        screen.gains.propose("gyro_lowpass", cutoff)
        for _ in range(2):  # what was asked before, then the cut-off
            question = analysis.of(Judge)[-1]
            analysis.tell(question, next(answer(subject, question, None)))
            qtbot.waitUntil(partial(is_asked, analysis, asked + 1))
        gains = {"gyro_lowpass": cutoff}
        models = study.sampled(gains=gains), study.sampled(OperatingPoint(hold=True), gains)
        found = phase_budgets(study, *models, judge_loops(*models), gains)
        assert len(found) == len(screen.frequency.phase.table.rows) == 9
        for budget in found:
            *parts, at = row(screen.frequency.phase, budget.loop).cells
            for name, cell in zip(PHASE_BUDGET_PARTS, parts, strict=True):
                # half of the last digit, and what both linearisations differ by
                angle = math.degrees(getattr(budget, name))
                assert number(cell) == pytest.approx(angle, abs=0.055, rel=1e-3)
                assert f"° at {budget.crossover:.3g}\N{NO-BREAK SPACE}rad/s" in cell.help
            assert number(at) == pytest.approx(budget.crossover, rel=6e-3)
        margin = row(screen.margins, "pitch").cells[2]
        pitch = row(screen.frequency.phase, "pitch").cells
        total = sum(math.radians(number(cell)) for cell in pitch[:-1])
        assert 180.0 + math.degrees(total) == pytest.approx(number(margin), abs=2.0)
        filters[cutoff] = number(pitch[1])
        absent = "No estimator flies: the loops have the true motion."
        assert screen.frequency.phase.missing.text() == (absent if estimator == "truth" else "")
    assert filters[25.0] < 2.0 * filters[80.0] < 0.0
    cutoffs = [question.gains["gyro_lowpass"] for question in analysis.of(Judge)]
    assert cutoffs == [0.0, 80.0, 25.0]


def test_each_loop_shows_its_parts_what_costs_most_and_where(card, offline, judge, make_loop):
    assert card.headline[0] == "Not known yet: the analyst is computing it."
    card.judgement.follow(FLOWN, FLOWN)
    pitch = make_loop("pitch", phase_margin=math.radians(40.0), turned=turned(rotors=-40.0))
    offline.analysis.tell(*judge(FLOWN, pitch))
    cells = row(card, "pitch").cells
    texts = ["−70.0", "−20.0", "−5.0", "−2.0", "−3.0", "−40.0", "10"]
    assert [cell.text for cell in cells] == texts
    assert [cell.marked for cell in cells] == ["", "", "", "", "", "most", ""]
    assert (
        "−20.0° at 10\N{NO-BREAK SPACE}rad/s" in cells[1].help and "the low-passes" in cells[1].help
    )
    assert "leave 40.0°" in cells[-1].help
    assert card.headline[0] == "Weakest: pitch; most: rotors −40.0°"
    assert "most" in row(card, "pitch").spoken
    # loops whose parts are not known say so, and nothing else
    assert {cell.text for cell in row(card, "roll").cells} == {"–"}
    assert card.missing.text().startswith("Without a crossover: velocity x, velocity y")
    assert card.missing.isVisible()


def test_what_is_proposed_stands_beside_what_flies(card, offline, judge, make_loop):
    card.judgement.follow(FLOWN, FLOWN)
    offline.analysis.tell(*judge(FLOWN, make_loop("pitch", turned=turned())))
    card.judgement.follow(PROPOSED, FLOWN)
    slower = make_loop("pitch", turned=turned(filters=-35.0), crossover=12.0)
    offline.analysis.tell(*judge(PROPOSED, slower))
    law, filters, *_, at = row(card, "pitch").cells
    assert (filters.text, filters.was, filters.marked) == ("−35.0", "−20.0", "most")
    assert (at.text, at.was, law.was) == ("12", "10", "")


def test_an_unstable_loop_has_no_parts_and_says_so(card, offline, judge, make_loop):
    card.judgement.follow(FLOWN, FLOWN)
    broken = make_loop("roll", stable=False, growing=True)
    offline.analysis.tell(*judge(FLOWN, broken, said="the roll loop is unstable."))
    assert row(card, "roll").state is RowState.BROKEN
    assert {cell.text for cell in row(card, "roll").cells} == {"–"}
    assert card.headline[0] == "The roll loop is unstable."
    assert card.missing.text() == "Phases are known only for a stable closed loop."


def test_filters_and_estimators_that_are_not_there_are_named(card, offline, judge, make_loop):
    card.judgement.follow(FLOWN, FLOWN)
    names = [each.name for each in judge(FLOWN)[1].loops]
    plain = [make_loop(name, turned=turned(filters=0.0, estimator=0.0)) for name in names]
    offline.analysis.tell(*judge(FLOWN, *plain))
    said = "No filter is on. No estimator flies: the loops have the true motion."
    assert card.missing.text() == said
    card.judgement.follow(PROPOSED, FLOWN)
    offline.analysis.tell(*judge(PROPOSED, *(make_loop(name, turned=turned()) for name in names)))
    assert card.missing.text() == "" and not card.missing.isVisible()
