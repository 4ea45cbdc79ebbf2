import dataclasses
import math

import numpy as np
import pytest

from workbench.gui.tuning.response_history import (
    MAX_EARLIER_RESPONSES,
    ExcitationRound,
    ResponseHistory,
)
from workbench.gui.tuning.round_trace import RoundTrace
from workbench.scenario.excitation import ActiveExcitation, Excitation, Shape

STEP = Excitation("x", Shape.STEP, 1.0, 1.0, repeats=True)
GAINS = {"kp_pitch": 225.0}


def take(excitation, begun, end):
    """Answer every command after 0.25 s."""
    time = np.arange(0.0, max(0.0, end - begun), 1 / 128)
    asked = np.array([excitation.command(max(0.0, each - 0.25)) for each in time])
    return RoundTrace(time, asked, np.zeros(len(time)), np.full(len(time), 0.5))


@pytest.fixture
def history():
    return ResponseHistory(take, lambda: 0.0)


def test_there_is_nothing_before_the_first_round(history):
    assert history.present(5.0) is None
    assert history.numbers is None


def test_the_present_response_begins_at_the_edge_and_ends_now(history):
    history.begin(ActiveExcitation(STEP, 10.0, 1), GAINS)
    trace = history.present(10.5)
    assert trace.time[0] == 0.0
    assert trace.time[-1] == pytest.approx(0.5, abs=0.01)


def test_numbers_come_once_the_step_is_over_and_stay_while_the_next_is_flown(history):
    history.begin(ActiveExcitation(STEP, 10.0, 1), GAINS)
    history.present(10.9)
    assert history.numbers is None
    history.present(11.1)
    first = history.numbers
    assert first.peak_rotor_use == 0.5
    history.begin(ActiveExcitation(STEP, 12.0, 2), GAINS)
    history.present(12.3)
    assert history.numbers is first


def test_a_round_that_began_while_joints_swung_has_no_numbers():
    """Its response alone does not tell: a swing passes zero."""

    def take_from_rest(excitation, begun, end):
        trace = take(excitation, begun, end)
        return dataclasses.replace(trace, response=1.0 - np.exp(-9.0 * trace.time))

    for axis in ("x", "force_x"):
        for swings in (False, True):
            history = ResponseHistory(take_from_rest, lambda: 0.0)
            step = dataclasses.replace(STEP, axis=axis, period=2.0)
            history.begin(ActiveExcitation(step, 10.0, 1, swings=swings), GAINS)
            history.present(15.0)
            assert ("did not begin at rest" in history.numbers.withheld) is swings
            assert math.isnan(history.numbers.settling_time) is swings


def test_a_response_of_an_attitude_begins_at_that_of_the_hover():
    """Else the numbers of a drone that hovers tilted would be withheld."""

    def take_tilted(excitation, begun, end):
        trace = take(excitation, begun, end)
        response = 0.1 * (1.0 - np.exp(-9.0 * trace.time)) - 0.094
        return dataclasses.replace(trace, response=response)

    step = dataclasses.replace(STEP, axis="pitch", amplitude=0.1, period=2.0)
    numbers = []
    for hover in (0.0, -0.094):
        history = ResponseHistory(take_tilted, lambda: 0.0)
        history.begin(ActiveExcitation(step, 10.0, 1, hover=hover), GAINS)
        trace = history.present(12.1)
        numbers.append(history.numbers)
    assert "did not begin at rest" in numbers[0].withheld
    assert numbers[1].withheld == ""
    assert numbers[1].steady_state_value == pytest.approx(0.1)
    assert trace.response[0] == pytest.approx(0.0)
    assert history.round.response_name == "pitch, from that of hover"


def test_numbers_of_a_round_that_is_never_steady_are_withheld_with_the_reason(history):
    history.begin(
        ActiveExcitation(STEP, 10.0, 1, hover=0.2, unsteady="the air is turbulent"), GAINS
    )
    history.present(10.0 + STEP.round_time)
    assert history.numbers.withheld == "the air is turbulent"
    assert np.isnan(history.numbers.steady_state_error)
    assert history.round.response_name.endswith(", from that of the drift")


def test_the_same_round_told_again_changes_nothing(history):
    for _ in range(3):
        history.begin(ActiveExcitation(STEP, 10.0, 1), GAINS)
    assert history.ghosts == ()


def test_at_most_five_ghosts_are_kept_the_newest_first_with_the_gains_that_made_them(history):
    for number in range(8):
        history.begin(
            ActiveExcitation(STEP, 2.0 * number, number + 1), {"kp_pitch": 100.0 + number}
        )
    assert len(history.ghosts) == MAX_EARLIER_RESPONSES == 5
    assert [each.round.gains["kp_pitch"] for each in history.ghosts] == [106, 105, 104, 103, 102]
    assert history.ghosts[0].trace.time[-1] == pytest.approx(2.0, abs=0.01)
    assert history.ghosts[0].numbers is not None


def test_a_round_that_is_stopped_keeps_what_was_flown(history):
    history.begin(ActiveExcitation(STEP, 10.0, 1), GAINS)
    history.end(10.6)
    assert not history.is_running
    assert history.present(20.0).time[-1] == pytest.approx(0.6, abs=0.01)
    history.begin(ActiveExcitation(STEP, 30.0, 1), GAINS)
    assert history.ghosts[0].trace.time[-1] == pytest.approx(0.6, abs=0.01)
    assert history.ghosts[0].numbers is None


def test_what_was_ended_at_once_makes_no_ghost(history):
    history.begin(ActiveExcitation(STEP, 10.0, 1), GAINS)
    history.end(10.02)
    history.begin(ActiveExcitation(STEP, 30.0, 1), GAINS)
    assert history.ghosts == ()


def test_gains_of_a_round_are_those_at_its_beginning(history):
    gains = dict(GAINS)
    history.begin(ActiveExcitation(STEP, 10.0, 1), gains)
    gains["kp_pitch"] = 1.0
    assert history.round.gains["kp_pitch"] == 225.0


def test_gains_that_change_during_the_step_withhold_its_numbers(history):
    history.begin(ActiveExcitation(STEP, 10.0, 1), GAINS)
    history.begin(ActiveExcitation(STEP, 10.0, 1), {"kp_pitch": 300.0})
    history.present(11.1)
    assert "parameters changed" in history.numbers.withheld
    history.begin(ActiveExcitation(STEP, 12.0, 2), {"kp_pitch": 300.0})
    assert "parameters changed" in history.ghosts[0].numbers.withheld
    history.present(13.1)
    assert "parameters changed" not in history.numbers.withheld
    history.begin(ActiveExcitation(STEP, 12.0, 2), GAINS)  # after the step: its numbers stay
    history.begin(ActiveExcitation(STEP, 14.0, 3), GAINS)
    assert "parameters changed" not in history.ghosts[0].numbers.withheld
    for gains in ({"kp_pitch": 300.0}, GAINS):  # there and back during the step
        history.begin(ActiveExcitation(STEP, 14.0, 3), gains)
    history.present(15.1)
    assert "parameters changed" in history.withheld


def test_numbers_stay_with_their_age_until_others_are_not_withheld():
    """Gains change in the second round, and the third one is shorter than its step."""

    def after_a_while(excitation, begun, end):
        time = np.arange(0.0, max(0.0, end - begun), 1 / 128)
        return RoundTrace(time, 1.0 * (time > 0.25), 0.0 * time, 0.0 * time)

    history = ResponseHistory(after_a_while, lambda: 0.0)
    history.begin(ActiveExcitation(STEP, 10.0, 1), GAINS)
    history.present(11.5)
    good = history.numbers
    assert history.age_text(11.5, GAINS) == "" and not history.withheld
    assert history.age_text(11.5, {"kp_pitch": 300.0}) == "with other gains"
    history.begin(ActiveExcitation(STEP, 20.0, 2), GAINS)
    history.begin(ActiveExcitation(STEP, 20.0, 2), {"kp_pitch": 300.0})
    history.present(21.1)
    assert history.numbers is good and "parameters changed" in history.withheld
    assert history.age_text(23.0, GAINS) == "12\N{NO-BREAK SPACE}s ago"  # its step was over at 11 s
    history.begin(ActiveExcitation(STEP, 200.0, 3), GAINS)
    assert history.age_text(200.0, GAINS) == "3\N{NO-BREAK SPACE}min ago"
    history.end(200.3)
    history.present(200.4)
    assert history.numbers is good
    history.begin(ActiveExcitation(STEP, 210.0, 4), GAINS)
    history.present(211.1)
    assert history.numbers is not good and not history.withheld
    assert history.age_text(220.0, GAINS) == ""


def test_the_next_edge_of_a_round_is_known():
    flown = ExcitationRound(Excitation("x", Shape.STEP, 1.0, 2.0), 10.0, {})
    assert flown.next_edge(10.5) == 12.0
    assert flown.next_edge(12.0) == 14.0
    assert flown.next_edge(13.0) == 14.0
