"""What is recorded of a served flight flies the same, where it is hard to tell what came first."""

import importlib.util
import math
from pathlib import Path

import pytest

from workbench.scenario.scenario import Action, Rates, Scenario
from workbench.session.session import Session

CONTROL, STEP = Rates().control_period, Rates().physics_step
LAST = round(CONTROL / STEP) - 1
"""Of the steps of a control period, the one at which commands come into force."""


def _load():
    spec = importlib.util.spec_from_file_location("served", Path(__file__).with_name("served.py"))
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module.load()


rig = _load()


@pytest.mark.parametrize("ahead", [0, 1, 2], ids=["same step", "next step", "later"])
def test_a_command_at_a_step_of_the_script_is_flown_again_after_it(monkeypatch, ahead):
    """The script asks for one velocity, the client for another, at the same step."""
    at = (16 * round(CONTROL / STEP) + LAST + ahead) * STEP
    scenario = Scenario(script=[Action(at, velocity=[0.0, 1.0, 0.0])])
    served = rig.Served(monkeypatch, rig.build(scenario))
    client = rig.Client(served, "Ada")
    client.begin()
    for number in range(40):
        client.command(1.0 + 0.01 * number, 0.0, 0.0)
        served.fly(CONTROL)
    flown = served.flown()
    served.flying._network.close()
    again = Session(flown.scenario)
    again.run()
    assert again.recording().q_WB.tobytes() == flown.recording.q_WB.tobytes()
    assert again.recording().p_WB.tobytes() == flown.recording.p_WB.tobytes()


def test_a_zero_with_a_sign_is_no_news_and_changes_no_bit(monkeypatch):
    served = rig.Served(monkeypatch, rig.build())
    client = rig.Client(served, "Ada")
    client.begin()
    client.command(1.0, 0.0, 0.0)
    served.fly(CONTROL)
    done = len(served.script)
    client.command(1.0, -0.0, -0.0)
    served.fly(CONTROL)
    assert len(served.script) == done
    reference = served.session.snapshot().reference
    assert [math.copysign(1.0, each) for each in reference[:4]] == [1.0] * 4
    served.flying._network.close()
