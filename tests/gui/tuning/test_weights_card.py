import pytest

from workbench.analysis.queries import RequestedStep, Sensitivities
from workbench.gui.tuning.limits import find_limit
from workbench.gui.tuning.trial import NO_TRIAL_STEP_TEXT
from workbench.gui.tuning.weights_card import WeightsCard, strongest_gains, weight_text

STEP = RequestedStep("x", 1.0, 2.0)


@pytest.fixture
def card(offline, trial, qtbot):
    made = WeightsCard(offline, trial)
    qtbot.addWidget(made)
    made.show()
    made.begin()
    made.set_seen(True)
    trial.set_step(STEP)
    return made


def test_a_slope_for_one_percent_is_told_for_ten():
    text = weight_text("kp_pitch", -0.002, find_limit("rise_time"))
    assert text == "10 % more kp_pitch: rise time −0.0200 s"
    text = weight_text("kp_pitch", 0.001, find_limit("peak_rotor_use"))
    assert text == "10 % more kp_pitch: rotor use +1.00 %"


def test_gains_that_do_nothing_to_speak_of_are_left_out():
    slopes = {"a": 0.001, "c": 0.3, "b": -1.0, "d": float("nan")}
    assert [*strongest_gains(slopes)] == ["b", "c"]
    assert strongest_gains({"a": 0.0}) == {}


def test_it_asks_once_gains_have_settled(card, offline, trial, gains, qtbot):
    for value in (300.0, 310.0, 320.0):
        gains.propose("kp_pitch", value)
    assert offline.analysis.of(Sensitivities) == []
    qtbot.waitUntil(lambda: bool(offline.analysis.of(Sensitivities)))
    assert offline.analysis.of(Sensitivities) == [Sensitivities(trial.proposed, STEP)]


def test_the_metric_on_show_is_told_in_words(card, offline, trial, qtbot):
    qtbot.waitUntil(lambda: bool(offline.analysis.of(Sensitivities)))
    weights = {
        "rise_time": {"kp_velocity_x": -0.003, "kp_pitch": 0.001},
        "overshoot": {"kp_pitch": 0.2},
    }
    offline.analysis.tell(Sensitivities(trial.proposed, STEP), weights)
    assert card.words.text() == "10 % more Velocity x Kp: rise time −0.0300 s."
    card.number.setCurrentIndex(1)
    assert card.words.text() == "10 % more Pitch Kp: overshoot +2.00 %."
    assert len(card.bars.texts) == 1


def test_old_bars_say_that_they_are_old(card, offline, trial, gains, qtbot):
    qtbot.waitUntil(lambda: bool(offline.analysis.of(Sensitivities)))
    offline.analysis.tell(Sensitivities(trial.proposed, STEP), {})
    gains.propose("kp_pitch", 333.0)
    assert card.said.text() == "For the previous gains; new ones follow …"


def test_bars_of_an_earlier_step_do_not_stay_for_an_attitude(card, offline, trial, qtbot):
    qtbot.waitUntil(lambda: bool(offline.analysis.of(Sensitivities)))
    earlier = Sensitivities(trial.proposed, STEP)
    offline.analysis.tell(earlier, {"rise_time": {"kp_pitch": 0.001}})
    assert card.bars.texts
    trial.set_step(RequestedStep("y", 1.0, 2.0))
    assert card.said.text() == "For the previous step; the new one follows …"
    trial.set_step(RequestedStep("pitch", 0.1, 1.0))
    assert card.said.text() == NO_TRIAL_STEP_TEXT
    assert card.bars.texts == () and card.words.text() == ""
    offline.analysis.tell(earlier, {"rise_time": {"kp_pitch": 0.001}})
    assert card.bars.texts == () and card.said.text() == NO_TRIAL_STEP_TEXT


def test_a_question_that_waited_unseen_is_not_asked_after_another_choice(offline, trial, qtbot):
    card = WeightsCard(offline, trial)
    qtbot.addWidget(card)
    card.begin()
    trial.set_step(STEP)
    qtbot.waitUntil(lambda: bool(card._queries._wanted))
    trial.set_step(RequestedStep("pitch", 0.1, 1.0))
    qtbot.waitUntil(lambda: card.said.text() == NO_TRIAL_STEP_TEXT)
    card.set_seen(True)
    assert offline.analysis.of(Sensitivities) == []
    assert card.said.text() == NO_TRIAL_STEP_TEXT


def test_a_refusal_leaves_no_bars_of_an_earlier_step(card, offline, trial, gains, qtbot):
    """And the question that waited is asked then."""
    qtbot.waitUntil(lambda: bool(offline.analysis.of(Sensitivities)))
    weights = {"rise_time": {"kp_pitch": 0.001}}
    offline.analysis.tell(offline.analysis.of(Sensitivities)[0], weights)
    trial.set_step(RequestedStep("x", 1.0, 25.0))
    qtbot.waitUntil(lambda: len(offline.analysis.of(Sensitivities)) == 2)
    gains.propose("kp_pitch", 333.0)
    qtbot.waitUntil(lambda: bool(card._queries._wanted))
    offline.analysis.refused.emit(offline.analysis.of(Sensitivities)[1], "the step is too long")
    assert card.bars.texts == () and card.words.text() == ""
    assert card.said.text() == "the step is too long"
    assert offline.analysis.of(Sensitivities)[-1].gains["kp_pitch"] == 333.0
