"""Who flies: the rule, how it is set and told, and that it makes no difference."""

import logging

import numpy as np
import pytest

from workbench.common.errors import WorkbenchError
from workbench.design.flier import (
    AUTO,
    COMPILED,
    DIAGRAM,
    FLY_ON_VARIABLE,
    MAX_UPDATES_COMPILING,
    MAX_UPDATES_LOADING,
    Flier,
    choose_engine,
)
from workbench.design.scripted_flight import ScriptedFlight
from workbench.design.step_response import fly_step, step_scenario
from workbench.scenario.scenario import Scenario
from workbench.session.session import Session


@pytest.mark.parametrize(
    ("wish", "why_not", "updates", "kept", "flies"),
    [
        (AUTO, "", MAX_UPDATES_LOADING, True, DIAGRAM),
        (AUTO, "", MAX_UPDATES_LOADING + 1, True, COMPILED),
        (AUTO, "", MAX_UPDATES_LOADING + 1, False, DIAGRAM),
        (AUTO, "", MAX_UPDATES_COMPILING, False, DIAGRAM),
        (AUTO, "", MAX_UPDATES_COMPILING + 1, False, COMPILED),
        (AUTO, "it stands", MAX_UPDATES_COMPILING + 1, True, DIAGRAM),
        (DIAGRAM, "", MAX_UPDATES_COMPILING + 1, True, DIAGRAM),
        (COMPILED, "", 1, False, COMPILED),
        (COMPILED, "it stands", 1, True, DIAGRAM),
    ],
)
def test_the_quicker_one_flies(wish, why_not, updates, kept, flies):
    found, why = choose_engine(wish, lambda: why_not, updates, lambda: kept)
    assert found == flies
    assert why


def test_a_short_flight_asks_nothing():
    def refuse():
        raise AssertionError

    assert choose_engine(AUTO, refuse, MAX_UPDATES_LOADING, refuse)[0] == DIAGRAM


@pytest.fixture
def flights(monkeypatch):
    """Who has flown, in order."""
    found = []
    run, fly = Session.run, ScriptedFlight.fly
    monkeypatch.setattr(Session, "run", lambda *args: found.append(DIAGRAM) or run(*args))
    monkeypatch.setattr(ScriptedFlight, "fly", lambda *args: found.append(COMPILED) or fly(*args))
    return found


def test_who_flies_can_be_set(monkeypatch, flights, caplog):
    caplog.set_level(logging.DEBUG, "workbench.flier")
    steps = []
    for who in (COMPILED, DIAGRAM):
        monkeypatch.setenv(FLY_ON_VARIABLE, who)
        steps.append(fly_step("z", 1.0, duration=1.0))
    assert flights == [COMPILED, DIAGRAM]
    assert "compiled code flies: as is asked for" in caplog.text
    assert "the diagram flies: as is asked for" in caplog.text
    ours, theirs = (step.recording for step in steps)
    np.testing.assert_allclose(ours.p_WB, theirs.p_WB, rtol=0.0, atol=1e-9)
    fly_step("z", 1.0, duration=1.0, fly_on=COMPILED)
    assert flights[-1] == COMPILED


def test_an_unknown_choice_is_refused(monkeypatch):
    monkeypatch.setenv(FLY_ON_VARIABLE, "drake")
    with pytest.raises(WorkbenchError, match="auto"):
        Flier(Scenario())


def test_a_wish_that_cannot_be_fulfilled_is_told(caplog):
    caplog.set_level(logging.INFO, "workbench.flier")
    Flier(Scenario(world="room"), fly_on=COMPILED)
    assert "the diagram flies: the world room is not compiled" in caplog.text


def test_what_compiled_code_leaves_out_flies_on_the_diagram(flights):
    scenario = step_scenario("z", -1.0, 1.5, Scenario())
    scenario.start.position = [0.0, 0.0, 0.5]
    flown, wanted = (Flier(scenario, {}, who).fly().recording for who in (COMPILED, DIAGRAM))
    assert flights == [COMPILED, DIAGRAM, DIAGRAM]
    assert np.array_equal(flown.p_WB, wanted.p_WB)


@pytest.mark.parametrize("who", [COMPILED, DIAGRAM])
def test_a_flier_flies_again_as_at_first(who):
    first, second = (step_scenario(axis, 1.0, 0.5, Scenario()) for axis in ("x", "y"))
    flier = Flier(first, {}, who)
    flown = [flier.fly().recording]
    for each in (second, first):
        flier.follow(each.script, each.duration)
        assert flier.get("max_speed") > 0.0
        flown.append(flier.fly().recording)
    assert np.array_equal(flown[0].p_WB, flown[2].p_WB)
    assert flown[1].p_WB[-1, 1] > 10.0 * abs(flown[1].p_WB[-1, 0])
