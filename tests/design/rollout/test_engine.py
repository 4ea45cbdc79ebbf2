"""Oracles: the full diagram, and one flight beside many."""

import subprocess
import sys
import threading
import time
from dataclasses import astuple

import numpy as np
import pytest

from workbench.common.errors import WorkbenchError
from workbench.control.controller_file import load_controller
from workbench.design.rollout.candidates import start_state
from workbench.design.rollout.compiled_flights import compiled_fly
from workbench.design.rollout.engine import RolloutEngine
from workbench.design.rollout.planned_flights import (
    MAX_PIECES_PER_CHUNK,
    PlannedFlights,
    make_schedule,
    run_chunks,
)
from workbench.design.rollout.rollouts import rollout_metrics
from workbench.design.step_response import STEP_EDGE_S, fly_step
from workbench.plant.variation import Variation
from workbench.scenario.scenario import Rates, ScenarioStart

GAINS = [row.name for row in load_controller().parameters]
FLIPS = {"kp_roll": 2500.0, "kd_roll": 0.0}
NO_NUMBER = {"kp_roll": float("nan")}


@pytest.fixture(scope="module")
def candidates(engine):
    """Many, with one that flips over and one that holds no number among them."""
    rng = np.random.default_rng(6)
    kps = rng.uniform(0.5, 2.0, 70) * engine.gains["kp_velocity_y"]
    return (
        [{"kp_velocity_y": kp} for kp in kps[:40]]
        + [FLIPS, NO_NUMBER]
        + [{"kp_velocity_y": kp} for kp in kps[40:]]
    )


def test_two_threads_fly_what_one_flies_to_the_bit(vehicle, candidates):
    one, two = (RolloutEngine(vehicle, threads=n).fly(candidates, "y", 8.0) for n in (1, 2))
    assert one.velocity_W.tobytes() == two.velocity_W.tobytes()
    assert one.angular_velocity_W.tobytes() == two.angular_velocity_W.tobytes()
    assert one.peak_rotor_use.tobytes() == two.peak_rotor_use.tobytes()
    assert one.diverged_at.tobytes() == two.diverged_at.tobytes()


def test_one_that_is_lost_is_marked_and_the_others_fly_on(engine, candidates):
    rollouts = engine.fly(candidates, "y", 8.0)
    assert np.flatnonzero(~np.isnan(rollouts.diverged_at)).tolist() == [40, 41]
    assert rollouts.diverged_at[41] == 0.0
    end = rollouts.diverged_at[40]
    assert 0.0 < end < 3.0
    assert np.isnan(rollouts.response[40]).tolist() == (rollouts.time >= end).tolist()
    assert np.isnan(rollouts.response[41]).all()
    for index in (0, 39, 42, 71):
        alone = engine.fly([candidates[index]], "y", 8.0)
        assert alone.velocity_W[0].tobytes() == rollouts.velocity_W[index].tobytes()
    metrics = rollout_metrics(rollouts, 8.0)
    assert np.flatnonzero(np.isnan(metrics.rise_time)).tolist() == [40, 41]


def test_it_is_lost_when_the_diagram_has_it_tumble(engine):
    flown = fly_step("y", 8.0, duration=1.0, settings=FLIPS).recording.between(STEP_EDGE_S, np.inf)
    fast = (np.linalg.norm(flown.w_WB, axis=1) > 10.0) | (np.linalg.norm(flown.v_WB, axis=1) > 20.0)
    first = np.flatnonzero(fast & (flown.z_axis_W[:, 2] < 0.0))[0]
    rollouts = engine.fly([FLIPS], "y", 8.0, duration=1.0)
    assert rollouts.diverged_at[0] == flown.time[first] - STEP_EDGE_S


def test_the_ground_ends_it(engine):
    """At 8 m/s from 10 m; where the diagram's drone comes to stand."""
    rollouts = engine.fly([{}], "z", -8.0, duration=3.0)
    end = rollouts.diverged_at[0]
    fallen = -np.nansum(rollouts.response[0]) / 128.0
    assert fallen == pytest.approx(10.0 - engine.vehicle.ground_clearance, abs=0.1)
    assert 10.0 / 8.0 < end < 2.5


def test_a_drone_that_cannot_hover_is_lost_before_the_command(engine):
    rollouts = engine.fly([{"rotor_1": 0.0, "rotor_2": 0.0}], "x", 1.0, duration=2.0)
    assert rollouts.diverged_at[0] >= 0.0


def test_a_stride_keeps_some_of_the_same(engine):
    all_of_it = engine.fly([{}], "x", 2.0, duration=1.0)
    some = engine.fly([{}], "x", 2.0, duration=1.0, stride=3)
    assert some.time.tolist() == all_of_it.time[::3].tolist()
    assert some.response.tolist() == all_of_it.response[:, ::3].tolist()
    assert some.peak_rotor_use == all_of_it.peak_rotor_use


def test_an_array_of_gains_flies_as_their_names_do(engine):
    own = engine.gains
    row = np.array([[own[name] for name in GAINS]])
    row[0, GAINS.index("kp_yaw_rate")] *= 2.0
    named = engine.fly([{"kp_yaw_rate": 2.0 * own["kp_yaw_rate"]}], "yaw", 0.3, duration=1.0)
    assert engine.fly(row, "yaw", 0.3, duration=1.0).response.tolist() == named.response.tolist()


def test_a_varied_engine_is_one_made_that_way(engine, vehicle):
    variation = Variation(mass=1.2, inertia=1.3, rotor_lag=0.5, control_delay=2)
    made = RolloutEngine(vehicle, variation=variation).fly([{}], "x", 2.0, duration=1.0)
    varied = engine.varied(variation).fly([{}], "x", 2.0, duration=1.0)
    assert varied.velocity_W.tobytes() == made.velocity_W.tobytes()
    nominal = engine.fly([{}], "x", 2.0, duration=1.0)
    assert np.abs(varied.response - nominal.response).max() > 0.01
    back = engine.varied(variation).varied(Variation()).fly([{}], "x", 2.0, duration=1.0)
    assert back.velocity_W.tobytes() == nominal.velocity_W.tobytes()


def test_a_stop_keeps_what_has_flown(engine, candidates):
    shares: list[float] = []
    rollouts = engine.fly(
        candidates, "y", 8.0, progress=shares.append, stop=lambda: len(shares) == 2
    )
    assert shares[1] * len(candidates) <= len(rollouts) < len(candidates)
    assert not np.isnan(rollouts.response[:30]).any()
    assert len(rollouts.peak_rotor_use) == len(rollouts)


def test_none_fly_when_none_are_given(engine):
    rollouts = engine.fly([], "x", 1.0)
    assert rollouts.response.shape == (0, 385)
    assert len(rollout_metrics(rollouts, 1.0).peak) == 0


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        ({"axis": "roll"}, "unknown axis 'roll'"),
        ({"amplitude": 0.0}, "the amplitude is 0"),
        ({"amplitude": float("inf")}, "the amplitude is inf"),
        ({"duration": 0.01}, "a step cannot be measured in 0.01 s"),
        ({"duration": 601.0}, "in 601 s: give it 0.1 s or more, and 600 s at most"),
        ({"stride": 0}, "the stride is 0"),
    ],
)
def test_what_makes_no_step_is_said(engine, asked, said):
    step = {"axis": "x", "amplitude": 1.0, **asked}
    with pytest.raises(WorkbenchError, match=said):
        engine.fly([{}], **step)


def test_what_cannot_be_built_is_said(vehicle):
    with pytest.raises(WorkbenchError, match="control_period must be a multiple"):
        RolloutEngine(vehicle, Rates(control_period=0.01))
    with pytest.raises(WorkbenchError, match="the variation of mass is 0"):
        RolloutEngine(vehicle, variation=Variation(mass=0.0))


def assert_same(one, other):
    for left, right in zip(astuple(one), astuple(other), strict=True):
        np.testing.assert_array_equal(left, right)


def test_metrics_are_those_of_the_curves(engine, candidates):
    """Flown by one thread or two."""
    rollouts = engine.fly(candidates, "y", 8.0)
    measured = engine.measure(candidates, "y", 8.0)
    assert_same(measured.metrics, rollout_metrics(rollouts, 8.0))
    assert measured.diverged_at.tobytes() == rollouts.diverged_at.tobytes()
    assert len(measured) == len(candidates)


@pytest.mark.parametrize("axis", ["x", "y", "z", "yaw"])
def test_what_is_measured_is_the_commanded_axis(engine, axis):
    assert engine.measure([{}], axis, 0.3).metrics.steady_state_value[0] == pytest.approx(
        0.3, rel=0.05
    )


def test_every_candidate_may_have_a_vehicle_of_its_own(engine):
    variations = [Variation(mass=1.2), Variation(), Variation(control_delay=2), Variation(mass=1.2)]
    together = engine.fly([{}] * 4, "x", 2.0, duration=1.0, variations=variations)
    for index, variation in enumerate(variations):
        alone = engine.varied(variation).fly([{}], "x", 2.0, duration=1.0)
        assert together.velocity_W[index].tobytes() == alone.velocity_W[0].tobytes()
    assert not np.array_equal(together.velocity_W[0], together.velocity_W[1])


def test_every_candidate_may_have_turbulence_of_its_own(engine, vehicle):
    rough = {"turbulence": 8.0}
    together = engine.fly([rough] * 3, "x", 2.0, duration=1.0, seeds=[4, 0, 4])
    other = RolloutEngine(vehicle, seed=4).fly([rough], "x", 2.0, duration=1.0)
    own = engine.fly([rough], "x", 2.0, duration=1.0)
    assert together.velocity_W[0].tobytes() == other.velocity_W[0].tobytes()
    assert together.velocity_W[1].tobytes() == own.velocity_W[0].tobytes()
    assert together.velocity_W[2].tobytes() == other.velocity_W[0].tobytes()
    assert not np.array_equal(together.velocity_W[0], together.velocity_W[1])


def test_a_flight_from_hover_is_the_step(engine):
    """Commanded at once instead of after a second in which nothing moves."""
    starts, command = start_state(engine.vehicle, ScenarioStart()), [2.0, 0.0, 0.0, 0.0]
    flights = engine.fly_from([{}, {}], starts, command, duration=1.0)
    step = engine.fly([{}], "x", 2.0, duration=1.0)
    assert flights.time.tolist() == step.time.tolist()
    assert flights.velocity_W[0] == pytest.approx(step.velocity_W[0], abs=1e-9)
    assert flights.angular_velocity_W[1] == pytest.approx(step.angular_velocity_W[0], abs=1e-9)
    assert flights.states[0, 0].tolist() == starts.tolist()
    assert np.isnan(flights.diverged_at).all()
    assert len(flights) == 2


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        ({"starts": np.zeros(12)}, "the starts are 12 numbers: give 13, or a row of 13"),
        ({"commands": np.zeros((2, 4))}, "the commands are 2 x 4 numbers: give 4, or a row of 4"),
        ({"commands": "fast"}, "the commands are no numbers"),
        ({"variations": [Variation()] * 2}, "there are 2 variations for 3 candidates"),
        ({"variations": [Variation(mass=0.0)] * 3}, "the variation of mass is 0"),
        ({"seeds": [1, 2]}, "there are 2 seeds for 3 candidates"),
        ({"duration": 0.0}, "cannot be measured in 0 s"),
    ],
)
def test_what_makes_no_flight_is_said(engine, asked, said):
    flight = {
        "starts": start_state(engine.vehicle, ScenarioStart()),
        "commands": np.zeros(4),
        **asked,
    }
    with pytest.raises(WorkbenchError, match=said):
        engine.fly_from([{}] * 3, **flight)


@pytest.mark.parametrize("name", [*GAINS, "rotor_1", "wind_x", "push_x", "drag_area"])
def test_a_candidate_with_a_value_that_is_no_number_is_lost_from_the_beginning(engine, name):
    """A limit that is NaN would be no limit, as comparisons with it are false."""
    measured = engine.measure([{}, {name: float("nan")}], "x", 1.0, duration=0.5)
    assert np.isnan(measured.diverged_at[0])
    assert measured.diverged_at[1] == 0.0
    assert np.isnan(measured.metrics.rise_time[1])


def test_many_candidates_with_a_seed_each_take_little_memory(engine):
    count = 30_000
    batch = engine.plan(
        [{}] * count,
        np.zeros(4),
        start_state(engine.vehicle, ScenarioStart()),
        make_schedule(engine.rates, 0.0, 0.5, 1),
        None,
        list(range(count)),
    )
    assert len(np.unique(batch.flights["air_seed"])) == count


def test_whole_numbers_may_be_floats(engine):
    step = engine.fly([{}], "x", 1.0, duration=0.5, stride=2.0)
    assert len(step.time) == 33
    with pytest.raises(WorkbenchError, match="the stride is inf"):
        engine.fly([{}], "x", 1.0, stride=float("inf"))
    with pytest.raises(WorkbenchError, match="the control_delay is 1.5"):
        engine.varied(Variation(control_delay=1.5))


def test_a_loss_is_counted_from_when_the_command_was_given(vehicle):
    """Also where no control update comes at that time: the command is given 1 s after the start."""
    rates = Rates(physics_step=0.001, control_period=0.006, mode_period=0.12)
    rollouts = RolloutEngine(vehicle, rates).fly([FLIPS], "y", 8.0, duration=1.0)
    end = rollouts.diverged_at[0]
    first = np.flatnonzero(np.isnan(rollouts.response[0]))[0]
    assert end == pytest.approx(rollouts.time[first], abs=1e-9)


def test_a_stop_ends_measuring_and_flights_too(engine, candidates):
    for flown in (
        engine.measure(candidates, "y", 8.0, stop=lambda: True),
        engine.fly_from(
            candidates, start_state(engine.vehicle, ScenarioStart()), np.zeros(4), stop=lambda: True
        ),
    ):
        assert 0 < len(flown) < len(candidates)


def test_flights_of_all_kinds_are_compiled_once(engine):
    many = [{}] * 20
    engine.fly([{}], "x", 1.0, duration=0.1)
    engine.fly(many, "x", 1.0, duration=0.1, variations=[Variation(mass=1.1)] * 20)
    engine.measure(many, "z", 1.0, duration=0.1)
    start = start_state(engine.vehicle, ScenarioStart())
    engine.fly_from(many, np.tile(start, (20, 1)), np.zeros((20, 4)), duration=0.1)
    assert len(compiled_fly(load_controller(), None).signatures) == 1


@pytest.mark.parametrize("threads", [1, 2])
@pytest.mark.parametrize("count", [0, 1, 2, 3, 5 * MAX_PIECES_PER_CHUNK + 1])
def test_every_piece_is_done_once(count, threads):
    done: list[int] = []
    assert run_chunks(lambda first, last: done.extend(range(first, last)), count, threads) == count
    assert sorted(done) == list(range(count))


@pytest.mark.parametrize("threads", [1, 2])
def test_progress_rises_to_all_of_it(threads):
    shares: list[float] = []
    run_chunks(lambda first, last: None, 100, threads, shares.append)
    assert shares == sorted(shares)
    assert shares[-1] == 1.0
    assert len(shares) > 5


@pytest.mark.parametrize("threads", [1, 2])
def test_a_stop_leaves_what_has_not_begun(threads):
    done: set[int] = set()
    asked = 0
    many = 1000 * MAX_PIECES_PER_CHUNK

    def work(first: int, last: int) -> None:
        time.sleep(0.001)  # all of them would take long enough to notice a stop
        done.update(range(first, last))

    def stop() -> bool:
        nonlocal asked
        asked += 1
        return asked == 3

    count = run_chunks(work, many, threads, None, stop)
    assert done == set(range(count))
    assert 3 * MAX_PIECES_PER_CHUNK <= count < many


def test_two_threads_work_side_by_side():
    """Each waits for the other: alone neither would come to an end."""
    both = threading.Barrier(2, timeout=300.0)
    assert run_chunks(lambda first, last: both.wait() and None, 2, 2) == 2


def test_a_failure_comes_to_the_caller():
    def work(first: int, last: int) -> None:
        raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        run_chunks(work, 40, 2)


def test_flights_from_the_cache_load_no_compiler(engine):
    """numba's compiler loads all of scipy's linear algebra: half of what loading would take."""
    engine.measure([{}], "x", 1.0)  # kept by now
    code = """
import sys
from workbench.design.rollout.engine import RolloutEngine
from workbench.plant.loading import load_vehicle
from workbench.common.resources import find_model

RolloutEngine(load_vehicle(find_model("dh_drone"))).measure([{}], "x", 1.0)
print(*sorted({"numba.np.arraymath", "scipy.linalg"} & set(sys.modules)), "nothing")
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["nothing"]


WINDS = [{}, {"wind_x": 6.0}, {"wind_x": 6.0, "turbulence": 15.4}, {"wind_y": 6.0}]
"""Of candidates of a step along x."""


def test_in_wind_a_step_goes_from_the_drift_as_on_the_diagram(engine):
    windy = fly_step("x", 1.0, duration=3.0, settings=WINDS[1])
    assert windy.before > 0.2
    flown = engine.fly(WINDS, "x", 1.0)
    assert flown.before.tolist() == [0.0, pytest.approx(windy.before, abs=1e-9), 0.0, 0.0]
    assert flown.response[1] == pytest.approx(windy.response, abs=1e-9)
    assert flown.peak_rotor_use[1] == pytest.approx(windy.peak_rotor_use, abs=1e-9)
    assert list(flown.unsteady) == [2]
    measured = engine.measure(WINDS, "x", 1.0).metrics
    curves = rollout_metrics(flown, 1.0)
    for name, number in windy.metrics.numbers.items():
        each = getattr(measured, name)
        assert each[1] == pytest.approx(number, abs=1e-6)
        np.testing.assert_array_equal(each, getattr(curves, name))
    assert np.isfinite(measured.steady_state_error).tolist() == [True, True, False, True]
    assert measured.steady_state_error[1] < 2.0


def test_in_still_air_every_candidate_flies_once(engine, monkeypatch):
    """Also one that moves at the edge, as a heavy drone does."""
    flown = []
    fly = PlannedFlights.fly
    monkeypatch.setattr(
        PlannedFlights, "fly", lambda self, *how: flown.append(self.size) or fly(self, *how)
    )
    heavy = [Variation(), Variation(mass=1.3)]
    found = engine.measure([{}, {}], "z", 1.0, variations=heavy).metrics
    assert flown == [2]
    assert np.isnan(found.rise_time).tolist() == [False, True]


def test_a_stop_before_the_drift_is_found_keeps_what_needs_none(engine):
    """Candidates after the first that would have flown on are not reported as unsteady."""
    shares = []
    how = {"progress": shares.append, "stop": lambda: shares[-1:] == [1.0]}
    flown = engine.fly(WINDS, "x", 1.0, **how)
    assert (len(flown), dict(flown.unsteady)) == (1, {})
    shares.clear()
    measured = engine.measure(WINDS, "x", 1.0, **how)
    assert len(measured.diverged_at) == len(measured.metrics.rise_time) == 1
