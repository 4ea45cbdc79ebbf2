"""Oracle: times counted in control periods by hand."""

import math

import pytest

from workbench.common.errors import FlightBrokenError, WorkbenchError
from workbench.scenario.scenario import Action, Rates, Scenario, ScenarioStart
from workbench.session.script import Script, repeat_scenario
from workbench.session.session import Session

PERIOD = 1 / 128
"""Of control; eight steps of the physics."""


def script(*times: float, step: float = PERIOD / 8) -> Script:
    rates = Rates(physics_step=step, control_period=8 * step)
    return Script([Action(at=time) for time in times], rates)


def times(script: Script, step: int) -> list[float]:
    return [action.at for action in script.due(step)]


def test_an_action_is_due_at_the_first_control_update_at_or_after_its_time(case):
    for at, step, first in [
        (0.0, PERIOD / 8, 0),
        (PERIOD, PERIOD / 8, 8),
        (1.1 * PERIOD, PERIOD / 8, 16),  # the first update at or after its time
        (0.9 * PERIOD, PERIOD / 8, 8),
        (1.0, PERIOD / 8, 1024),
        (0.024, 0.001, 24),  # 3.0000000000000004 periods are 3
        (0.56, 0.001, 560),
        (1e-12, PERIOD / 8, 0),
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


def test_a_script_that_was_ended_returns_no_more_until_it_starts_again():
    plan = script(0.25, 0.5)
    assert times(plan, 300) == [0.25]
    assert plan.next_action.at == 0.5
    plan.end()
    assert plan.next_step == math.inf and plan.next_action is None
    assert times(plan, 10_000) == []
    other = script(0.25, 0.5)  # of a flight that continues from here
    for each in (plan, other):
        each.rewind(plan.done, ended=plan.ended)
        assert times(each, 10_000) == []
        assert [action.at for action in each.actions_done] == [0.25]
    plan.rewind()
    assert times(plan, 10_000) == [0.25, 0.5]


def test_actions_of_one_time_keep_their_order():
    actions = [Action(at=0.5, request="arm"), Action(at=0.5, request="take_off")]
    plan = Script(actions, Rates())
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


def test_a_hold_a_landing_and_a_stop_end_the_script_of_a_session(case):
    session = Session(Scenario(script=[Action(at=0.5, request="take_off")]))
    for action, ends in (
        (Action(request="hold"), True),
        (Action(request="land"), True),
        (Action(request="stop"), True),
        (Action(request="take_off"), False),
        (Action(velocity=[0.0, 0.0, 0.0]), False),
        (Action(request="hold", end_script=False), False),
        (Action(end_script=True), True),
    ):
        with case(action):
            session.reset()
            session.do(action)
            assert (session.next_action is None) == ends


def test_a_flight_is_repeated_without_what_its_pilot_ended(case):
    """Of an update the pilot's actions come first, so what the script has there is ended, too."""
    rates = Rates(physics_step=PERIOD / 8, control_period=PERIOD)
    planned = [
        Action(at=0.0, set={"wind_x": 1.0}),
        Action(at=0.99, yaw_rate=0.1),
        Action(at=1.0, yaw_rate=0.2),
        Action(at=1.01, yaw_rate=0.3),
    ]
    scenario = Scenario(script=planned, rates=rates, duration=2.0)
    for ended, left in ((2.0, [0.1, 0.2, 0.3]), (1.0, [0.1]), (0.0, [])):
        stop = Action(at=ended, request="hold", end_script=True)
        repeated = repeat_scenario(scenario, {"mass": 1.0}, [stop], 2.0).script
        with case(ended):
            turns = [action.yaw_rate for action in repeated if action.yaw_rate is not None]
            assert turns == left
            # what flew from the beginning on is set, although the script was ended at 0
            sets = [action.set for action in repeated if action.set]
            assert sets == [{"mass": 1.0}, {"wind_x": 1.0}]
            assert [action.at for action in repeated if action.request] == [ended]


def test_a_refusal_in_flight_says_which_action_of_the_script_it_is_and_what_to_change():
    script = [
        Action(at=0.25, go_to=[1.0, 0.0, -3.0]),  # the second in time, and first in the file
        Action(at=0.125, velocity=[0.1, 0.0, 0.0]),
    ]
    session = Session(Scenario(title="Below ground", script=script))
    session.tick(0.2)
    with pytest.raises(WorkbenchError) as refusal:
        session.tick(0.2)
    said = str(refusal.value)
    assert "script.0 of the scenario 'Below ground', at 0.25 s" in said
    assert "cannot go to a height of -3 m" in said
    assert said.endswith("change that action or remove it, as a reset flies the same script")


def test_a_broken_flight_is_not_blamed_on_the_script():
    plan = script(0.25)
    assert times(plan, 300) == [0.25]
    with pytest.raises(FlightBrokenError, match=r"^the program ended$"), plan.refusals(""):
        raise FlightBrokenError("the program ended")


def test_an_order_that_a_drone_which_is_off_does_not_follow_is_noted_once(case, caplog):
    low = Action(0.25, request="take_off", height=1.0)
    for orders, said in (
        (
            [Action(0.25, go_to=[1.0, 0.0, 1.0]), Action(0.5, velocity=[0.5, 0.0, 0.0])],
            "script.0 of the scenario, at 0.25 s: the drone is off and does not follow go_to "
            "before a take_off",
        ),
        (
            [Action(0.25, velocity=[0.5, 0.0, 0.0], yaw_rate=0.1)],
            "script.0 of the scenario, at 0.25 s: the drone is off and does not follow velocity "
            "and yaw_rate before a take_off",
        ),
        (
            [Action(0.25, request="land")],
            "script.0 of the scenario, at 0.25 s: the drone is off and does not follow land",
        ),
        ([low, Action(0.25, velocity=[0.5, 0.0, 0.0])], ""),  # the mode reads both later
        ([low, Action(0.5, velocity=[0.5, 0.0, 0.0])], ""),  # armed, and about to take off
        ([Action(0.25, velocity=[0.0, 0.0, 0.0]), Action(0.25, set={"kp_roll": 60.0})], ""),
    ):
        with case(said, len(orders)):
            caplog.clear()
            session = Session(Scenario(start=ScenarioStart(mode="off"), script=orders))
            caplog.clear()  # remarks on the vehicle
            session.tick(0.6)
            assert [each.getMessage() for each in caplog.records] == [said] * bool(said)
    hovering = Session(Scenario(script=[Action(0.25, velocity=[0.5, 0.0, 0.0])]))
    caplog.clear()
    hovering.tick(0.3)
    assert not caplog.records
