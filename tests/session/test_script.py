"""Oracle: times counted in physics steps by hand."""

import math

from workbench.scenario.scenario import Action
from workbench.session.script import Script

STEP = 1 / 1024


def script(*times: float, step: float = STEP) -> Script:
    return Script([Action(at=time) for time in times], step)


def times(script: Script, step: int) -> list[float]:
    return [action.at for action in script.due(step)]


def test_an_action_is_due_at_the_first_step_at_or_after_its_time(case):
    for at, step, first in [
        (0.0, STEP, 0),
        (STEP, STEP, 1),
        (1.1 * STEP, STEP, 2),  # the first step at or after its time
        (0.9 * STEP, STEP, 1),
        (1.0, STEP, 1024),
        (0.003, 0.001, 3),  # 3.0000000000000004 steps are 3
        (0.07, 0.001, 70),
        (1e-12, STEP, 0),
    ]:
        with case(at, step, first):
            plan = script(at, step=step)
            assert plan.next_step == first
            assert times(plan, first - 1) == []
            assert times(plan, first) == [at]


def test_each_action_is_handed_out_once_in_the_order_of_time():
    plan = script(0.5, 0.25, 0.75)
    assert plan.next_step == 256
    assert times(plan, 600) == [0.25, 0.5]
    assert times(plan, 600) == []
    assert plan.next_step == 768
    assert times(plan, 10_000) == [0.75]
    assert plan.next_step == math.inf


def test_actions_of_one_time_keep_their_order():
    actions = [Action(at=0.5, request="arm"), Action(at=0.5, request="take_off")]
    plan = Script(actions, STEP)
    assert [action.request for action in plan.due(512)] == ["arm", "take_off"]


def test_what_is_not_taken_is_still_due():
    """The pilot may fail in the middle; the rest is not lost."""
    plan = script(0.1, 0.2)
    assert next(plan.due(1000)).at == 0.1
    assert times(plan, 1000) == [0.2]


def test_it_begins_again_and_without_actions_it_has_nothing():
    plan = script(0.25)
    assert times(plan, 256) == [0.25]
    plan.rewind()
    assert times(plan, 256) == [0.25]
    nothing = script()
    assert nothing.next_step == math.inf
    assert times(nothing, 10**9) == []
