"""Forks against the flight itself, which goes on in a session of its own."""

import numpy as np
import pytest

from workbench.analysis.questions import Fork, Step
from workbench.analysis.subject import Subject
from workbench.common.errors import WorkbenchError
from workbench.design.branches import Branch
from workbench.design.response_metrics import step_metrics
from workbench.scenario.scenario import Action, Scenario
from workbench.session.session import Session

SCENARIO = Scenario(world="room", script=[Action(at=0.2, velocity=[1.0, 0.0, 0.0])], duration=100.0)
OWN, FIRM = Branch("own", {}), Branch("firm", {"kp_velocity_x": 8.0})


@pytest.fixture(scope="module")
def flight():
    """A flight at 0.5 s, and the checkpoint it is at."""
    session = Session(SCENARIO)
    session.tick(0.5)
    return session, session.checkpoint()


@pytest.fixture(scope="module")
def about():
    return Subject(SCENARIO, {})


def test_a_branch_of_its_own_gains_is_what_the_flight_does_to_the_bit(flight, about, answer):
    session, checkpoint = flight
    own, firm = answer(Fork(checkpoint, (OWN, FIRM), 1.0), about).branches
    session.tick(1.0)
    flown = session.recording()
    assert (own.name, firm.name) == ("own", "firm")
    where = np.searchsorted(flown.time, own.time)
    assert len(own.time) > 100
    assert (flown.time[where] == own.time).all()
    assert (flown.v_WB[where] == own.velocity).all()
    assert (flown.p_WB[where] == own.position).all()
    assert not np.allclose(firm.velocity, own.velocity, atol=0.01)
    assert own.lost == firm.lost == ""


def test_a_step_comes_on_top_of_what_is_asked_for(flight, about, answer):
    _, checkpoint = flight
    (own,) = answer(Fork(checkpoint, (OWN,), 3.0, Step("y", 0.5, 3.0)), about).branches
    assert own.velocity[-1] == pytest.approx([1.0, 0.5, 0.0], abs=0.05)


def test_each_controller_has_the_numbers_of_its_step(subject, answer):
    session = Session(subject.scenario)
    session.tick(0.5)
    branches, step = (OWN, Branch("lqi", {}, "lqi")), Step("y", 0.5, 5.0)
    found = answer(Fork(session.checkpoint(), branches, 5.0, step), subject)
    for branch, numbers in zip(found.branches, found.numbers, strict=True):
        wanted = step_metrics(branch.time - 0.5, branch.velocity[:, 1], 0.5)
        assert numbers.rise_time == wanted.rise_time > 0.1
        assert numbers.peak_rotor_use == branch.rotor_use.max()
    own, lqi = found.numbers
    assert own.rise_time != lqi.rise_time
    assert answer(Fork(session.checkpoint(), branches, 0.5), subject).numbers == (None, None)


def test_bad_gains_and_a_stop_are_sentences(flight, about, answer, caller):
    _, checkpoint = flight
    bad = Branch("bad", {"kp_roll": float("nan")})
    with pytest.raises(WorkbenchError, match="kp_roll is 'nan': give it a number"):
        answer(Fork(checkpoint, (OWN, bad), 1.0), about)
    caller.stopped = 1
    with pytest.raises(WorkbenchError, match="stopped"):
        answer(Fork(checkpoint, (OWN,), 1.0), about)
