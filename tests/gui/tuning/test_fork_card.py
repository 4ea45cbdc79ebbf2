from dataclasses import replace

import numpy as np
import pytest
from PyQt6.QtCore import Qt

from workbench.analysis.queries import Fork, RequestedStep
from workbench.control.installed_laws import installed_laws
from workbench.design.branches import Branch, FlownBranch
from workbench.design.step_metrics import StepMetrics
from workbench.gui.tuning.ahead_prediction import AHEAD_BRANCH_NAME, AheadPrediction
from workbench.gui.tuning.designs import Designs
from workbench.gui.tuning.fork_card import ForkCard
from workbench.gui.tuning.trial import NO_TRIAL_STEP_TEXT
from workbench.scenario.scenario import Action

STEP = RequestedStep("x", 1.0, 2.0)
TIME = 30.0 + np.linspace(0.0, 5.0, 50)


def branch(name: str, speed: float, lost: str = "") -> FlownBranch:
    return FlownBranch(
        name=name,
        time=TIME,
        velocity=np.full((50, 3), speed),
        yaw_rate=np.zeros(50),
        position=np.cumsum(np.full((50, 3), speed), axis=0),
        tilt=np.full(50, 0.1),
        rotor_use=np.full(50, 0.6),
        lost=lost,
    )


@pytest.fixture
def designs(offline, trial):
    return Designs(offline.flight, trial)


@pytest.fixture
def card(offline, trial, designs, qtbot):
    trial.set_step(STEP)
    made = ForkCard(offline, trial, designs)
    qtbot.addWidget(made)
    made.resize(420, 330)
    made.show()
    made.begin()
    return made


@pytest.fixture
def ghost(offline, trial):
    trial.set_step(STEP)
    made = AheadPrediction(offline.flight, offline.analysis, trial, lambda: True)
    made.set_seen(True)
    made.heard = []
    made.seen_ahead.connect(lambda time, values: made.heard.append((time, values)))
    made.foreseen_ways = []
    made.foreseen.connect(lambda ends, places: made.foreseen_ways.append((ends, places)))
    return made


def answer_fork(offline, *branches, numbers=(None, None)):
    """Answer the last question with flown branches."""
    question = offline.analysis.of(Fork)[-1]
    offline.analysis.tell(question, tuple(zip(branches, numbers, strict=False)))


def press(qtbot, button):
    qtbot.mouseClick(button, Qt.MouseButton.LeftButton)


def test_both_sets_go_on_from_the_present_instant(card, offline, gains, trial, qtbot):
    gains.propose("kp_pitch", 300.0)
    press(qtbot, card.button)
    fork = offline.analysis.of(Fork)[-1]
    assert fork.checkpoint == "answer to GET_CHECKPOINT"
    assert [each.name for each in fork.branches] == ["now", "proposed"]
    assert fork.branches[0].gains == trial.flown
    assert fork.branches[1].gains["kp_pitch"] == 300.0
    assert fork.step == RequestedStep("x", 1.0, 5.0)
    assert not card.button.isEnabled()


def test_without_a_step_it_just_flies_on(card, offline, qtbot):
    card.with_step.setChecked(False)
    press(qtbot, card.button)
    assert offline.analysis.of(Fork)[-1].step is None


def test_branches_are_laid_over_each_other(card, offline, qtbot):
    press(qtbot, card.button)
    answer_fork(offline, branch("now", 1.0), branch("proposed", 1.1))
    assert card.plot.names == ("now", "proposed")
    card.quantity.setCurrentIndex(2)
    assert card.plot.names == ("now", "proposed")
    assert card.button.isEnabled()


def test_one_can_be_kept(card, offline, gains, qtbot):
    gains.propose("kp_pitch", 300.0)
    press(qtbot, card.button)
    gains.propose("kp_pitch", 111.0)
    answer_fork(offline, branch("now", 1.0), branch("proposed", 1.1))
    press(qtbot, card.keep_other)
    assert gains.proposed["kp_pitch"] == 300.0


def test_a_slot_can_be_the_other_branch(card, offline, gains, qtbot):
    gains.propose("kp_pitch", 150.0)
    gains.store("B")
    gains.propose("kp_pitch", 300.0)
    card.other.setCurrentIndex(card.other.findData("B"))
    press(qtbot, card.button)
    fork = offline.analysis.of(Fork)[-1]
    assert fork.branches[1].name == "slot B"
    assert fork.branches[1].gains["kp_pitch"] == 150.0


def test_a_lost_branch_says_why(card, offline, qtbot):
    press(qtbot, card.button)
    lost = branch("proposed", 9.0, lost="it tumbled")
    answer_fork(offline, branch("now", 1.0), lost)
    assert card.said.text() == "proposed: it tumbled"


def choose(qtbot, box, words):
    """Choose in a list by mouse; one that was opened by mouse takes no click for a while."""
    box.showPopup()
    view = box.view()
    qtbot.waitUntil(view.isVisible, timeout=20000)
    row = view.model().index(box.findText(words), 0)
    view.scrollTo(row)  # in the app's own style a list shows ten
    place = view.visualRect(row)
    qtbot.mouseClick(view.viewport(), Qt.MouseButton.LeftButton, pos=place.center())
    qtbot.waitUntil(lambda: box.currentText() == words, timeout=20000)


def test_two_controllers_are_forked_from_one_instant_and_one_can_be_kept(
    card, designs, offline, flying, trial, tmp_path, qtbot
):
    """The one that flies is `now`; a file that has flown can be chosen for good."""
    texts = [card.other.itemText(index) for index in range(card.other.count())]
    assert texts == ["now", "proposed", *(name for name in installed_laws() if name != "pd")]
    mine = str(tmp_path / "mine.py")
    offline.flight.show(replace(flying, scenario=replace(flying.scenario, controller=mine)))
    designs.begin()
    card.begin()
    offline.flight.show(flying)
    designs.begin()
    card.begin()
    choose(qtbot, card.other, "lqi")
    press(qtbot, card.button)
    fork = offline.analysis.of(Fork)[-1]
    assert fork.branches == (Branch("now", trial.flown), Branch("lqi", {}, "lqi"))
    offline.analysis.preparing.emit("compiling the control law lqi: 40 %")
    assert card.said.text() == "Flying both … compiling the control law lqi: 40 %"
    numbers = StepMetrics(0.31, 0.6, 12.0, steady_state_error=0.5, peak_rotor_use=0.8)
    both = branch("now", 1.0), branch("lqi", 1.1)
    answer_fork(offline, *both, numbers=(numbers, replace(numbers, rise_time=0.42)))
    assert card.plot.names == ("now", "lqi")
    assert [row.label for row in card.table.rows] == ["now", "lqi"]
    assert [row.cells[0].text for row in card.table.rows] == ["0.310", "0.420"]
    assert card.said.text() == "now flies pd; lqi takes over with its own gains"
    press(qtbot, card.keep_other)
    assert offline.flight.orders[-1] == Action(controller="lqi")
    choose(qtbot, card.one, "mine")
    press(qtbot, card.button)
    fork = offline.analysis.of(Fork)[-1]
    assert fork.branches == (Branch("mine", {}, mine), Branch("lqi", {}, "lqi"))
    offline.analysis.refused.emit(fork, "mine.py line 3: no law")
    assert card.said.text() == "mine.py line 3: no law"


def test_a_branch_is_not_flown_against_itself(card, qtbot):
    choose(qtbot, card.one, "proposed")
    assert not card.button.isEnabled()
    choose(qtbot, card.one, "indi")
    assert card.button.isEnabled()


def test_a_refusal_lets_it_be_tried_again(card, offline, qtbot):
    press(qtbot, card.button)
    offline.analysis.refused.emit(offline.analysis.of(Fork)[-1], "too long")
    assert card.said.text() == "too long"
    assert card.button.isEnabled()


def test_a_slider_that_is_dragged_sees_the_next_five_seconds(ghost, offline, gains):
    gains.propose("kp_pitch", 300.0)
    fork = offline.analysis.of(Fork)[-1]
    assert (fork.branches[0].name, fork.duration, fork.step) == (AHEAD_BRANCH_NAME, 5.0, None)
    answer_fork(offline, branch(AHEAD_BRANCH_NAME, 1.2))
    time, values = ghost.heard[-1]
    assert time is TIME
    assert values[0] == 1.2
    ends, places = ghost.foreseen_ways[-1]
    assert ends == TIME[-1]
    assert places[1] == pytest.approx([2.4, 2.4, 2.4])


def test_the_future_is_asked_for_once_at_a_time_with_the_newest_gains_next(ghost, offline, gains):
    for value in (300.0, 310.0, 320.0):
        gains.propose("kp_pitch", value)
    assert len(offline.analysis.of(Fork)) == 1
    answer_fork(offline, branch(AHEAD_BRANCH_NAME, 1.2))
    asked = offline.analysis.of(Fork)
    assert len(asked) == 2
    assert asked[-1].branches[0].gains["kp_pitch"] == 320.0


def test_the_future_goes_once_the_proposal_is_taken_back(ghost, offline, gains):
    gains.propose("kp_pitch", 300.0)
    answer_fork(offline, branch(AHEAD_BRANCH_NAME, 1.2))
    gains.discard()
    assert len(ghost.heard[-1][0]) == 0
    assert len(ghost.foreseen_ways[-1][1]) == 0


def test_nobody_looks_into_the_future_unseen(ghost, offline, gains):
    ghost.set_seen(False)
    gains.propose("kp_pitch", 300.0)
    assert offline.analysis.of(Fork) == []


def test_the_branch_that_was_flown_is_kept_whatever_is_chosen_next(card, offline, gains, qtbot):
    gains.propose("kp_pitch", 150.0)
    gains.store("B")
    gains.propose("kp_pitch", 300.0)
    press(qtbot, card.button)
    answer_fork(offline, branch("now", 1.0), branch("proposed", 1.1))
    card.other.setCurrentIndex(card.other.findData("B"))
    card.refresh()
    assert card.keep_other.text() == "Keep proposed"
    press(qtbot, card.button)
    offline.analysis.refused.emit(offline.analysis.of(Fork)[-1], "too long")
    press(qtbot, card.keep_other)
    assert gains.proposed["kp_pitch"] == 300.0


def test_a_step_that_a_fork_cannot_fly_is_not_offered(card, trial):
    assert card.with_step.isEnabled()
    trial.set_step(RequestedStep("pitch", 0.1, 1.0))
    assert not card.with_step.isEnabled()
    assert card.with_step.toolTip() == NO_TRIAL_STEP_TEXT
