"""What the search goes back for: corners that it left out, and a proof that disagrees."""

import dataclasses
from pathlib import Path

from workbench.design.tune import solver
from workbench.design.tune.case import NOMINAL, Robustness
from workbench.design.tune.evaluation import Budget
from workbench.design.tune.plan import make_plan
from workbench.design.tune.proof import Proof
from workbench.design.tune.solver import Solver
from workbench.design.tune.wish import parse_wish
from workbench.design.tune.wish_file import Wishes
from workbench.scenario.scenario import Scenario, VehicleConfig

PALM = str(Path(__file__).parents[2] / "drones" / "palm_quad.urdf.xacro")
LAG_ONLY = Robustness(mass=0.0, inertia=0.0, margin_share=1.0)


def plan(*texts):
    asked = [wish for text in texts for wish in parse_wish(text)]
    wishes = Wishes(wishes=tuple(asked), robustness=LAG_ONLY, defaults=False)
    scenario = Scenario(vehicle=VehicleConfig(model=PALM))
    return make_plan(scenario, wishes, {}, separate=False)


def agrees(scenario, gains, steps, required, flights, progress, velocity):
    return Proof((), ())


def test_a_corner_that_was_left_out_is_taken_in(monkeypatch):
    """The start has the delay margin that is wished for, but not with slower rotors."""
    fast = {"kp_yaw_rate": 8.0}
    problem = plan("yaw_rate.delay_margin>=1ms", "yaw.rise_time<=0.9").problem
    margin = float(problem.measured([{**problem.base, **fast}])[0, 0])
    asked = plan(f"yaw_rate.delay_margin>={0.995 * margin}s", "yaw.rise_time<=0.9")
    starts = (asked.problem.variables.point(fast),)
    monkeypatch.setattr(solver, "prove", agrees)
    monkeypatch.setattr(solver, "ENOUGH", 0.0)
    monkeypatch.setattr(Solver, "_first_cases", lambda self: {NOMINAL})
    found = Solver(dataclasses.replace(asked, starts=starts), Budget(200), 0).solve()
    assert found.proof is not None
    assert found.gains["kp_yaw_rate"] < 7.9
    pairs = zip(asked.problem.requirements, found.values, strict=True)
    assert all(required.met(value) for required, value in pairs)


def test_a_proof_that_disagrees_sends_the_search_back(monkeypatch):
    """The full diagram here rises a quarter slower than the rollouts say."""
    asked = plan("yaw.rise_time<=0.3", "yaw_rate.phase_margin>=50deg")
    flown = []

    def slower(scenario, gains, steps, required, flights, progress, velocity):
        rise = next(each for each in required if each.wish.name == "yaw.rise_time")
        problem = asked.problem.demanding([rise])
        value = 1.25 * float(problem.measured([{**problem.base, **gains}])[0, 0])
        flown.append(value)
        return Proof((), ((rise, value),))

    monkeypatch.setattr(solver, "prove", slower)
    monkeypatch.setattr(solver, "ENOUGH", 0.0)
    found = Solver(asked, Budget(300), 0).solve()
    assert flown[0] > 0.3
    assert flown[-1] <= 0.3
    assert found.proof is not None
