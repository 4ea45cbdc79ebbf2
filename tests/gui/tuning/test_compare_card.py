"""Designs beside each other: the card with answers of its real analyst, and a table by hand."""

import csv
import io
import math
from dataclasses import replace

import numpy as np
import pytest
from PyQt6.QtGui import QGuiApplication

from workbench.analysis.queries import (
    DrawFrequency,
    Judge,
    OtherControllerQuery,
    Predict,
    RequestedStep,
)
from workbench.analysis.replies import JudgedLoop, Predicted
from workbench.analysis.worker import find_answerer
from workbench.design.judge.report import judge as judge_all
from workbench.design.step_metrics import StepMetrics
from workbench.design.step_response import fly_step
from workbench.gui.charts.curve import CurveStyle
from workbench.gui.tuning.compare_card import FREQUENCY_VIEW, POLES_VIEW, STEP_VIEW, TABLE_VIEW
from workbench.gui.tuning.comparison import compared_rows, csv_text
from workbench.gui.tuning.designs import Design
from workbench.gui.tuning.limits import STEP_LIMITS, find_limit
from workbench.gui.tuning.response_history import ResponseHistory
from workbench.scenario.excitation import ActiveExcitation, Excitation, Shape
from workbench.scenario.scenario import Action, Scenario

FIRM = {"kp_velocity_x": 6.0, "kd_pitch": 20.0}
MARGIN_ROWS = 5


@pytest.fixture
def screen(screen):
    """The tuning screen with the comparison in front."""
    screen.resize(1190, 600)
    screen.tabs.setCurrentWidget(screen.compare)
    return screen


class Answerer:
    """Answers in this process what was asked since it did so last."""

    def __init__(self, analysis, subject) -> None:
        self.analysis, self.subject, self.done = analysis, subject, 0

    def answer(self) -> None:
        asked, self.done = self.analysis.asked[self.done :], len(self.analysis.asked)
        for question in asked:
            if isinstance(question, Judge | Predict | DrawFrequency | OtherControllerQuery):
                *_, reply = find_answerer(type(question))(self.subject, question, None)
                self.analysis.tell(question, reply)


@pytest.fixture
def settle(screen, offline, subject, qtbot):
    """Answers all until nothing of what is compared is missing."""
    answerer = Answerer(offline.analysis, subject)

    def settled() -> bool:
        answerer.answer()
        return not screen.compare.said.text().startswith("Computing") and bool(
            screen.compare.said.text()
        )

    def wait() -> None:
        qtbot.wait(1)  # what was changed is taken up when the present event is over
        qtbot.waitUntil(settled, timeout=60000)

    return wait


def known(name, rise, margin, **numbers):
    """Return a design by hand: a step and one loop."""
    values = {
        "rise_time": rise,
        "settling_time": 1.0,
        "overshoot": 0.0,
        "steady_state_error": 0.5,
        "peak_rotor_use": 0.8,
        **numbers,
    }
    margins = (math.inf, 0.0, math.radians(margin), 0.03, 1.0, 1.5, math.nan, 10.0)
    loop = JudgedLoop(*margins, name="roll")
    judged = type("Judgement", (), {"loops": (loop,), "stable": True, "said": ""})()
    predicted = Predicted(None, None, StepMetrics(**values), lost=False)
    return Design(name, {}, CurveStyle.SOLID, 0, predicted=predicted, judged=judged)


def test_the_best_of_a_row_is_that_of_a_table_by_hand():
    """Smaller numbers of steps and larger margins are better; what is shown alike is a tie."""
    designs = (
        known("kept", 0.3000, 50.0, overshoot=1.0, settling_time=math.nan),
        known("A", 0.2001, 40.0, overshoot=2.0, settling_time=1.2),
        known("B", 0.2004, 60.0, overshoot=0.0, settling_time=math.nan),
    )
    rows = compared_rows(designs, "roll", lambda name: find_limit(name).default)
    best = {row.name: row.best for row in rows}
    assert best == {
        "rise_time": None,  # 0.200 s twice
        "overshoot": 2,
        "settling_time": None,  # there is no other one
        "steady_state_error": None,
        "peak_rotor_use": None,
        **{
            f"{loop}.{name}": {"phase_margin": 2}.get(name)
            for loop in ("weakest", "roll")
            for name in (
                "gain_margin",
                "gain_reduction_margin",
                "phase_margin",
                "delay_margin",
                "disk_margin",
            )
        },
    }
    overshoot = rows[1].row(0.5)
    assert [cell.marked for cell in overshoot.cells] == ["", "", "best"]
    assert [cell.over for cell in overshoot.cells] == [True, True, False]
    table = list(csv.reader(io.StringIO(csv_text(rows, designs))))
    assert table[0] == ["metric", "unit", "kept", "A", "B"]
    assert table[3] == ["settling_time", "s", "", "1.2", ""]
    assert float(table[8][4]) == pytest.approx(math.radians(60.0))
    other = replace(designs[1], name="soft, slow")
    named = csv_text(rows, (designs[0], other, designs[2]))
    assert next(csv.reader(io.StringIO(named)))[3] == "soft, slow"


def number(text):
    return float(text.replace("−", "-"))


@pytest.mark.slow  # flights of five designs, as Python
def test_the_table_has_the_numbers_of_step_and_judge(screen, settle, qtbot):
    """Kept gains, those of a slot, and another controller's, each against its own flight."""
    gains, card = screen.gains, screen.compare
    for name, value in FIRM.items():
        gains.propose(name, value)
    gains.store("A")
    gains.discard()
    pid = next(each for each in screen.designs.all() if each.controller == "pid")
    card.choose_design(pid, chosen=True)
    settle()
    card.view.setCurrentIndex(card.view.findText(TABLE_VIEW))
    card.loop.setCurrentIndex(card.loop.findData("pitch"))
    qtbot.wait(1)
    names = [each.name for each in card.chosen]
    assert names == ["kept", "flown", "proposed", "A", "pid"]
    step = screen.trial.step
    for column, scenario, settings in (
        (0, Scenario(), {}),
        (3, Scenario(), FIRM),
        (4, Scenario(controller="pid"), {}),
    ):
        flown = fly_step(step.axis, step.amplitude, scenario=scenario, settings=settings)
        rows = card.table.rows
        for row, limit in zip(rows, STEP_LIMITS, strict=False):
            name, text = limit.name, row.cells[column].text
            own = flown if name == "peak_rotor_use" else flown.metrics
            expected = limit.shown(getattr(own, name))
            if math.isnan(expected):
                assert text == "–" and flown.metrics.withheld in row.cells[column].help
            else:  # half of the last digit, and what compiled flights differ by
                assert number(text) == pytest.approx(expected, abs=0.06)
        pitch = next(
            loop.actuator
            for loop in judge_all(scenario, settings=settings).loops
            if loop.loop == "pitch"
        )
        phase, disk = (rows[-MARGIN_ROWS + place].cells[column].text for place in (2, 4))
        assert number(phase) == pytest.approx(math.degrees(pitch.phase_margin), abs=0.06)
        assert number(disk) == pytest.approx(pitch.disk_margin, abs=0.006)
    card.copy_text()
    lines = QGuiApplication.clipboard().text().splitlines()
    assert lines[0].split() == names
    assert len(lines) == 1 + len(card.table.rows)


def test_every_view_has_every_design_in_its_own_stroke(screen, settle, qtbot):
    gains, card = screen.gains, screen.compare
    for name, value in FIRM.items():
        gains.propose(name, value)
    gains.store("B")
    settle()
    names = {"kept", "flown", "proposed", "B"}
    strokes = {each.name: (each.style, each.colour) for each in card.chosen}
    assert len(set(strokes.values())) == len(names)
    card.view.setCurrentIndex(card.view.findText(STEP_VIEW))
    qtbot.waitUntil(lambda: set(card.plot.names) == {*names, "command"}, timeout=20000)
    assert not card.loop.isVisible()  # a step is not of that loop
    card.view.setCurrentIndex(card.view.findText(FREQUENCY_VIEW))
    settle()
    qtbot.waitUntil(lambda: set(card.magnitude.names) == names, timeout=20000)
    assert card.loop.isVisible()
    for plot in (card.plot, card.magnitude, card.phase):
        drawn = {each.label: (each.style, each.colour) for each in plot.curves}
        assert {name: drawn[name] for name in names} == strokes
    card.view.setCurrentIndex(card.view.findText(POLES_VIEW))
    qtbot.waitUntil(lambda: {pole.whose for pole in card.plane.poles} == names, timeout=20000)
    assert {pole.whose: pole.colour for pole in card.plane.poles} == {
        name: colour for name, (_, colour) in strokes.items()
    }
    kept = next(each for each in card.legend.entries if each.label.startswith("kept"))
    card.legend.toggled.emit(card.legend.entries.index(kept))
    qtbot.waitUntil(lambda: "kept" not in {pole.whose for pole in card.plane.poles}, timeout=20000)
    texts = card.legend.toolTip().splitlines()
    assert "    kp_velocity_x 6 instead of 4.45" in texts
    assert "    has not flown" in texts


def test_the_legend_has_numbers_and_last_values_before_the_pointer_is_over_the_chart(
    screen, settle, qtbot
):
    """Of a step its end, as the curves have it; the last value of a loop would tell nothing."""
    card = screen.compare
    screen.gains.propose("kd_pitch", 20.0)
    screen.trial.set_step(RequestedStep("pitch", 0.1, 1.0))
    settle()

    def shown(plot):
        """Number and value of each design, once the card has them as the plot does."""
        qtbot.waitUntil(lambda: card.chosen and all(each.number for each in card.legend.entries))
        numbers = {each.label: each.number for each in plot.curves}
        for each in card.legend.entries:
            assert each.number == numbers[each.label.partition(" ")[0]]
        return [each.value for each in card.legend.entries]

    values = shown(card.plot)
    ends = {each.label: np.degrees(each.samples(0.0)[1][-1]) for each in card.plot.curves}
    for entry, value in zip(card.legend.entries, values, strict=True):
        number, unit = value.split("\N{NO-BREAK SPACE}")
        assert unit == "°"
        assert float(number) == pytest.approx(ends[entry.label.partition(" ")[0]], abs=0.01)
    card.plot.canvas.hovered.emit(0.0)
    assert all(
        float(each.value.split("\N{NO-BREAK SPACE}")[0]) < 1.0 for each in card.legend.entries
    )
    card.view.setCurrentIndex(card.view.findText(FREQUENCY_VIEW))
    settle()
    qtbot.waitUntil(lambda: len(card.magnitude.names) == 3)
    assert shown(card.magnitude) == ["", "", ""]
    card.magnitude.canvas.hovered.emit(10.0)
    assert all(each.value.endswith("dB") for each in card.legend.entries)


def test_an_attitude_step_is_compared_beside_the_loop_of_the_moved_gain(screen, settle, qtbot):
    """The attitude loop of pd has no steady error, so that each design ends at the setpoint."""
    card = screen.compare
    screen.gains.propose("kd_pitch", 20.0)
    screen.trial.set_step(RequestedStep("pitch", 0.1, 1.0))
    settle()
    names = {"kept", "flown", "proposed"}
    qtbot.waitUntil(lambda: set(card.plot.names) == {*names, "command"})
    for curve in card.plot.curves:
        if curve.label in names:
            time, pitch = curve.samples(0.0)
            assert time[-1] == pytest.approx(1.0, abs=0.02)
            assert pitch[-1] == pytest.approx(0.1, rel=0.02)
    assert card.loop.currentData() == "pitch"
    screen.trial.set_step(RequestedStep("force_x", 1.0, 1.0))
    qtbot.waitUntil(lambda: card.plot.names == ())


def test_nothing_is_asked_while_nobody_looks_and_the_slider_is_not_displaced(
    screen, offline, settle, qtbot
):
    card, analysis = screen.compare, offline.analysis
    settle()
    asked = len(analysis.of(Judge))
    screen.tabs.setCurrentWidget(screen.poles)
    screen.gains.propose("kp_pitch", 250.0)
    screen.gains.store("C")
    screen.gains.propose("kp_pitch", 260.0)
    qtbot.waitUntil(lambda: len(analysis.of(Judge)) > asked)
    assert len(analysis.of(Judge)) == asked + 1  # the slider's alone
    screen.tabs.setCurrentWidget(card)
    settle()
    wanted = [question.gains["kp_pitch"] for question in analysis.of(Judge)[asked:]]
    assert sorted(wanted) == [250.0, 260.0]


def choose(menu_button, words):
    """Choose in a menu that is made as it opens."""
    menu = menu_button.menu()
    menu.aboutToShow.emit()
    action = next(each for each in menu.actions() if each.text() == words)
    assert action.isEnabled()
    action.trigger()


def test_a_design_is_flown_or_kept(screen, offline, settle):
    gains, card = screen.gains, screen.compare
    kept = dict(gains.kept)
    for name, value in FIRM.items():
        gains.propose(name, value)
    gains.store("A")
    gains.discard()
    settle()
    offline.analysis.forget()
    choose(card.use, "Keep A")
    assert gains.kept == kept  # not before it flies, and not before it is judged
    settle()
    assert offline.flight.orders[-1].set
    assert {name: gains.kept[name] for name in FIRM} == FIRM
    gains.propose("kp_pitch", 250.0)
    settle()
    choose(card.use, "Keep proposed")
    settle()
    assert gains.kept["kp_pitch"] == 250.0
    choose(card.use, "Fly A")
    settle()
    assert gains.flown["kp_pitch"] == kept["kp_pitch"] and gains.kept["kp_pitch"] == 250.0
    lqi = next(each for each in screen.designs.all() if each.controller == "lqi")
    card.fly(lqi)
    assert offline.flight.orders[-1] == Action(controller="lqi")


def test_what_makes_a_loop_unstable_is_not_kept(screen, settle):
    gains, card = screen.gains, screen.compare
    kept = dict(gains.kept)
    gains.propose("kp_pitch", 2500.0)
    gains.store("C")
    gains.discard()
    settle()
    choose(card.use, "Keep C")
    settle()
    assert gains.warning and gains.kept == kept and gains.flown["kp_pitch"] == kept["kp_pitch"]


def test_a_refused_answer_says_whose_and_why(screen, offline, settle, qtbot):
    card = screen.compare
    settle()
    lqi = next(each for each in screen.designs.all() if each.controller == "lqi")
    card.choose_design(lqi, chosen=True)
    qtbot.waitUntil(lambda: bool(offline.analysis.of(OtherControllerQuery)), timeout=20000)
    offline.analysis.preparing.emit("compiling the control law lqi: 40 %")
    assert card.said.text().endswith("compiling the control law lqi: 40 %")
    offline.analysis.refused.emit(
        offline.analysis.of(OtherControllerQuery)[0], "the law has no LOOPS"
    )
    qtbot.waitUntil(lambda: card.said.text() == "lqi: the law has no LOOPS", timeout=20000)


def test_ghosts_have_names_gains_and_the_time_they_flew(screen, canned):
    """Named by the set that has their gains, else by what differs from the kept ones."""
    excitation = Excitation("x", Shape.STEP, 1.0, 0.5, repeats=True)
    gains, kept = screen.gains, dict(screen.trial.flown)
    history: ResponseHistory = screen.response.history
    screen.workspace.signals.begin(canned.views[0].topics)
    for view, published in zip(canned.views, canned.published, strict=True):
        screen.workspace.signals.add(published)
        screen.show_view(view)
    for begun, other in (
        (0.2, {}),
        (0.8, {"kp_pitch": 180.0}),
        (1.4, {"kd_pitch": 20.0}),
        (2.0, {}),
    ):
        history.begin(ActiveExcitation(excitation, begun, 1), {**kept, **other})
    gains.propose("kp_pitch", 180.0)
    gains.store("A")
    gains.discard()
    screen.show_view(canned.views[-1])
    names = {"tried at 0:01.4 (kd_pitch 20)", "A at 0:00.8", "kept at 0:00.2"}
    legend = screen.response.plot
    assert names <= set(legend.names)
    lines = legend.legend.toolTip().splitlines()
    assert lines[lines.index("A at 0:00.8") + 1] == "    kp_pitch 180 instead of 225"
