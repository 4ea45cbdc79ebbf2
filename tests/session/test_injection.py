"""Injections in a session: flown again to the bit, ended, and left behind by forks."""

import numpy as np
import pytest

from workbench.common.errors import WorkbenchError
from workbench.scenario.scenario import Action, Injection, Rates, Scenario
from workbench.session.injected import ActiveInjection
from workbench.session.session import Session

ASKED = Injection("acceleration_z", 1.0, 6.0, 30.0, 3)
"""Some 3.2 s of flight."""


def scenario(*script):
    return Scenario(duration=4.0, script=list(script))


def positions(session):
    return session.recording().p_WB


def test_it_flies_again_to_the_bit_whatever_the_slices():
    live = Session(scenario())
    live.tick(0.3125)
    live.do(Action(injection=ASKED))
    for duration in (0.0131, 0.7, 1.0003, 1.9):
        live.tick(duration)
    scripted = Session(scenario(Action(at=0.3125, injection=ASKED)))
    scripted.tick(0.3125 + 0.0131 + 0.7 + 1.0003 + 1.9)
    np.testing.assert_array_equal(positions(live), positions(scripted))
    np.testing.assert_array_equal(live.injected.came, scripted.injected.came)
    assert live.injecting == 1.0
    assert np.ptp(positions(live)[:, 2]) > 0.01
    # two of three periods, of 6 rad/s at 128 Hz
    assert live.injected.came.shape == (2, 135)


def test_one_that_ends_leaves_nothing_behind():
    """It returns to rest, and the law is as it was: gates of 1, and nothing added."""
    session = Session(scenario())
    session.do(Action(injection=ASKED))
    session.tick(0.5)
    assert 0.0 < session.injecting < 0.5
    session.do(Action(injection=Injection()))
    assert session.injecting is None
    session.tick(6.0)
    assert np.abs(session.state()[10:13]).max() < 1e-3
    # a rest of it would hold the drone as far off as it is of the loops' gains
    np.testing.assert_allclose(positions(session)[-1], positions(session)[0], atol=1e-3)


@pytest.mark.slow
def test_a_fork_goes_on_without_it():
    session = Session(scenario())
    session.do(Action(injection=ASKED))
    session.tick(1.0)
    fork = Session(scenario())
    fork.begin_from(session.checkpoint())
    fork.tick(6.0)
    assert fork.injecting is None
    assert np.abs(fork.state()[10:13]).max() < 1e-3


def test_what_came_is_what_the_law_saw():
    """The signal at a velocity's error is setpoint minus velocity, by hand from the state."""
    session = Session(scenario(Action(velocity=[0.0, 0.0, 0.2])))
    session.inject(Injection("velocity_z_error", 0.05, 6.0, 30.0, 3))
    period, seen = session.scenario.rates.control_period, []
    for _ in range(3 * 135):
        seen.append(0.2 - session.state()[12])
        session.tick(period)
    came = session.injected.came.ravel()
    np.testing.assert_allclose(came, seen[135:], atol=1e-9)


def test_what_cannot_be_injected_is_refused(case):
    session = Session(scenario())
    for injection, said in (
        (Injection("acceleration_w", 1.0), "unknown loop point 'acceleration_w'"),
        (Injection("acceleration_z", -1.0), "size injected is -1"),
        (Injection("acceleration_z", 1.0, 5.0, 2.0), "reaches from 5 to 2"),
        (Injection("acceleration_z", 1.0, periods=2), "has 2 periods"),
    ):
        with case(said):
            with pytest.raises(WorkbenchError, match=said):
                session.inject(injection)
            with pytest.raises(WorkbenchError, match=said):
                Session(scenario(Action(injection=injection)))
    assert session.injecting is None


def test_a_part_that_runs_more_rarely_gets_its_values_where_it_runs(case):
    """The first is at or after the step that is asked for, the others whole periods later."""
    rates = Rates()
    for divider in (1, 2, 5):
        for first in (0, 1, 79, 80, 81):
            injection = ActiveInjection(
                Injection("acceleration_x", 0.1, 2.0, 10.0), 0, first, rates, divider
            )
            every = divider * rates.control_steps
            with case(divider, first):
                assert injection.next_step % every == 0
                assert first <= injection.next_step < first + every
