"""Searches: what is found holds in a flight of its own."""

import threading

import pytest

from workbench.analysis.questions import Tune
from workbench.analysis.subject import Subject
from workbench.common.errors import WorkbenchError
from workbench.design.step_response import fly_step
from workbench.plant.variation import Variation
from workbench.scenario.scenario import Scenario, VehicleConfig


@pytest.fixture(scope="module")
def found(subject):
    """A search and all that it told."""
    from workbench.analysis.tuning import tune

    told = []

    class Listening:
        def on_stop(self, act):
            pass

        def tell(self, searched):
            told.append(searched)

    return next(tune(subject, Tune({}, ("x.rise_time <= 0.3",)), Listening())), told


@pytest.mark.slow
def test_gains_that_are_found_fly_as_wished(found):
    tuned, _ = found
    assert tuned.met
    flown = fly_step("x", 1.0, duration=2.0, settings=tuned.gains)
    assert flown.metrics.rise_time <= 0.3
    assert flown.metrics.overshoot <= 5.0
    assert tuned.before.keys() == tuned.gains.keys()
    assert tuned.before["kp_velocity_x"] != tuned.gains["kp_velocity_x"]


@pytest.mark.slow
def test_each_wish_is_shown_before_and_after(found):
    tuned, _ = found
    wished = next(each for each in tuned.wishes if each.wish == "x.rise_time <= 0.3 s")
    assert wished.met
    assert wished.before.endswith(" s")
    assert float(wished.before.split()[0]) > 0.3 >= float(wished.after.split()[0])


@pytest.mark.slow
def test_the_steps_are_there_to_be_looked_at(found):
    tuned, _ = found
    step = next(each for each in tuned.steps if each.axis == "x")
    assert len(step.time) == len(step.before) == len(step.after) > 100
    assert step.after[-1] == pytest.approx(1.0, abs=0.05)
    assert not (step.before == step.after).all()


@pytest.mark.slow
def test_it_tells_how_it_goes(found):
    _, told = found
    assert [each.share for each in told] == sorted(each.share for each in told)
    assert 0.0 < told[-1].share <= 1.0
    assert told[-1].gains["kp_velocity_x"] > 0.0
    first = next(each for each in told if each.said)
    assert first.said.startswith("y.rise_time 0.3")
    assert first.said.endswith("% short")


@pytest.mark.slow
def test_it_says_what_it_does_and_is_never_full_before_the_end(found):
    _, told = found
    phases = [each.phase for each in told]
    stages = ["reading", "flying the rule's gains", "linear model of vehicle 1 of 8", "searching"]
    stages += ["proving on the full diagram: x step 1 of", "flying the steps for the report"]
    places = [next(i for i, phase in enumerate(phases) if phase.startswith(s)) for s in stages]
    assert places == sorted(places)
    assert max(each.share for each in told) < 1.0
    proof = [each.share for each in told if each.phase.startswith("proving")]
    assert len(set(proof)) > 10  # it moves while a flight is flown


@pytest.mark.slow
def test_a_stop_keeps_the_best_so_far_and_says_so(subject):
    from workbench.analysis.tuning import tune

    class Impatient:
        def on_stop(self, act):
            self.act = act

        def tell(self, _):
            threading.Thread(target=self.act).start()

    wishes = ("x.rise_time <= 0.1", "pitch.phase_margin >= 70deg")
    tuned = next(tune(subject, Tune({}, wishes), Impatient()))
    assert tuned.stopped
    assert not tuned.met
    assert any("stopped early" in said for said in tuned.said)


def test_bad_wishes_and_a_varied_vehicle_are_refused(answer):
    with pytest.raises(WorkbenchError, match="is no wish"):
        answer(Tune({}, ("fly well",)))
    heavy = Scenario(vehicle=VehicleConfig(variation=Variation(mass=1.2)))
    with pytest.raises(WorkbenchError, match="varies the vehicle on its own"):
        answer(Tune({}, ()), Subject(heavy, {}))
