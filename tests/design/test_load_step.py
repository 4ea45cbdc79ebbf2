"""Oracles: closed forms, python-control's linear response, and the compiled flight."""

import math

import control
import numpy as np
import pytest

from workbench.common.errors import WorkbenchError
from workbench.control.controller_file import load_controller
from workbench.design.linear.operating_point import HOLDING_POINT
from workbench.design.linear.study import LinearStudy
from workbench.design.load_metrics import load_metrics
from workbench.design.load_step import (
    NO_LOAD_PARAMETERS,
    fly_load_step,
    predict_load_step,
    response_to_load,
    usual_load,
)
from workbench.design.rollout.engine import RolloutEngine
from workbench.design.step_response import STEP_EDGE_S
from workbench.scenario.loads import LOAD_NAMES, PUSH_ROWS, find_load

TIME = np.linspace(0.0, 10.0, 10001)
TICK = 1e-3
PUSHES = tuple(row.name for row in PUSH_ROWS)


@pytest.mark.parametrize("size", [2.0, -0.3])
def test_a_load_that_integral_action_makes_up_for(size):
    """t exp(-a t) is largest at 1/a, 1/(a e), and back within 5 % where a t exp(1 - a t) is."""
    a = 2.0
    metrics = load_metrics(TIME, size * TIME * np.exp(-a * TIME))
    assert metrics.peak == pytest.approx(abs(size) / (a * math.e), rel=1e-6)
    assert metrics.peak_time == pytest.approx(1.0 / a, abs=TICK)
    back = metrics.settling_time
    assert a * back * math.exp(1.0 - a * back) == pytest.approx(0.05, rel=5e-3)
    assert metrics.steady_state_error == pytest.approx(0.0, abs=1e-4)
    assert not metrics.withheld


def test_a_load_that_nothing_makes_up_for():
    """A spring and a damper give way by F/k: within 5 % of that after tau ln 20, for good."""
    tau = 0.5
    metrics = load_metrics(TIME, 3.0 * (1.0 - np.exp(-TIME / tau)))
    assert metrics.peak == pytest.approx(3.0, rel=1e-6)
    assert metrics.settling_time == pytest.approx(tau * math.log(20.0), abs=2 * TICK)
    assert metrics.steady_state_error == pytest.approx(100.0, rel=1e-6)


def test_numbers_that_mean_nothing_are_withheld():
    swinging = load_metrics(TIME, np.sin(3.0 * TIME))
    assert swinging.peak == pytest.approx(1.0, rel=1e-5)
    assert math.isnan(swinging.settling_time) and math.isnan(swinging.steady_state_error)
    assert "not settled within 10 s" in swinging.withheld
    changed = load_metrics(TIME, np.exp(-TIME), changed=True)
    assert all(math.isnan(number) for number in changed.numbers.values())
    assert "not settled" in load_metrics(TIME, 0.0 * TIME).withheld
    lost = load_metrics(TIME, np.where(TIME < 5.0, TIME, np.nan))
    assert "lost" in lost.withheld and math.isnan(lost.settling_time)


def linear_response(study, load, amplitude) -> tuple[np.ndarray, np.ndarray]:
    """Return python-control's response of the closed loop while the position is held."""
    model = study.sampled(HOLDING_POINT)
    place = {name: index for index, name in enumerate(model.state_names)}
    vehicle, row, h = study.vehicle, find_load(load), model.period
    turning = np.linalg.solve(vehicle.inertia, row.torque_B)
    moving = np.array(row.force_W) / vehicle.mass - np.cross(turning, vehicle.p_BoBcm_B)
    disturbed = np.zeros((len(place), 1))  # a free body's motion within a period
    angles = ("roll", "pitch", "yaw")
    for axis, angle, turn, move in zip("xyz", angles, turning, moving, strict=True):
        for name, value in (
            (angle, 0.5 * h * h * turn),
            (f"p_{axis}", 0.5 * h * h * move),
            (f"w_{axis}", h * turn),
            (f"v_{axis}", h * move),
            (f"wdot_{axis}", turn),
            (f"vdot_{axis}", move),
        ):
            if name in place:
                disturbed[place[name]] = value
    states = dict(zip(PUSHES, ("p_x", "p_y", "p_z", "roll", "pitch", "w_z"), strict=True))
    seen = np.zeros((1, len(place)))
    seen[0, place[states[load]]] = 1.0
    system = control.ss(model.A, disturbed, seen, 0.0, h)
    time = np.arange(0.0, 5.0, h)
    found = control.forced_response(system, time, np.full(time.shape, amplitude))
    return time, found.outputs


@pytest.fixture(scope="module")
def engine():
    return RolloutEngine(LinearStudy().vehicle)


@pytest.fixture(scope="module")
def study():
    return LinearStudy()


@pytest.mark.slow
@pytest.mark.parametrize("load", PUSHES)
def test_a_load_is_answered_as_predicted_and_as_the_linear_model_says(load, engine, study):
    amplitude = 0.2 * usual_load(find_load(load), study.vehicle)
    flown = fly_load_step(load, amplitude)
    time, response, use = predict_load_step(engine, {}, load, amplitude, duration=5.0)
    predicted = load_metrics(time, response)
    assert flown.loss is None and not flown.metrics.withheld
    for name, value in predicted.numbers.items():  # two integrators; a time is that of a sample
        close = 1 / 128 + 1e-9 if name.endswith("_time") else 5e-4
        assert value == pytest.approx(flown.metrics.numbers[name], rel=2e-3, abs=close), name
    assert use == pytest.approx(flown.peak_rotor_use, rel=1e-4)
    linear = load_metrics(*linear_response(study, load, amplitude))
    assert flown.metrics.peak == pytest.approx(linear.peak, rel=0.01)
    assert flown.metrics.settling_time == pytest.approx(linear.settling_time, rel=0.02)


@pytest.mark.slow
@pytest.mark.parametrize("load", LOAD_NAMES)
def test_large_loads_are_answered_as_predicted(load, engine):
    """Eight times the usual one: tilts and rotors are far from hover."""
    amplitude = -8.0 * usual_load(find_load(load), engine.vehicle)
    amplitude *= 0.25 if load.startswith("gust") else 1.0
    flown = fly_load_step(load, amplitude, acts=0.75)
    time, response, _ = predict_load_step(engine, {}, load, amplitude, duration=5.0, acts=0.75)
    predicted = load_metrics(time, response)
    # two integrators; compiled wind changes at each physics step, the diagram's with the updates
    close = 2e-3 if load.startswith("gust") else 1e-4
    assert predicted.peak == pytest.approx(flown.metrics.peak, rel=1e-4)
    assert response == pytest.approx(flown.response, abs=close * flown.metrics.peak)


def test_the_usual_load_is_a_tenth_of_the_weight_at_the_centre_of_mass(study):
    flown = fly_load_step("force_y", duration=0.5)
    assert flown.amplitude == pytest.approx(0.1 * 9.81 * study.vehicle.mass)
    after = flown.recording.between(STEP_EDGE_S, STEP_EDGE_S + 3 / 128)
    assert after.v_WB[-1, 1] == pytest.approx(0.981 * 3 / 128, rel=0.03)
    assert np.abs(after.w_WB).max() < 0.05
    assert response_to_load(find_load("force_y"), after)[0] == 0.0


def test_the_usual_torque_is_that_of_the_usual_force_at_a_tenth_of_an_arm(study):
    """An arm is a rotor's way from the centre of mass; about yaw, torque over thrust."""
    vehicle = study.vehicle
    tenth = 0.1 * 9.81 * vehicle.mass
    arms = [math.dist(rotor.p_BR, vehicle.p_BoBcm_B) for rotor in vehicle.rotors]
    assert len(set(np.round(arms, 6))) == 1, "so that a mean is one of them"
    for load, wanted in (
        ("torque_roll", tenth * 0.1 * arms[0]),
        ("torque_pitch", tenth * 0.1 * arms[0]),
        ("torque_yaw", tenth * vehicle.rotors[0].moment_constant),
        ("force_z", tenth),
        ("gust_x", 5.0),
    ):
        assert usual_load(find_load(load), vehicle) == pytest.approx(wanted), load


def test_a_flights_own_gusts_and_pushes_are_left_out(engine):
    """They are of its own time: a push since 0.9 s would be in a prediction."""
    pushed = {"push_torque_x": 5.0, "gust_y": 9.0, "push_start": 0.9, "push_duration": 3.0}
    _, calm, _ = predict_load_step(engine, {}, "force_x", 1.0, duration=1.0)
    _, found, _ = predict_load_step(engine, pushed, "force_x", 1.0, duration=1.0)
    assert np.array_equal(found, calm)
    assert all(name in load_controller().table for name in NO_LOAD_PARAMETERS)


def test_what_makes_no_load_is_refused():
    for load, amplitude, said in (
        ("force_w", 1.0, "force_"),
        ("force_x", 0.0, "amplitude is 0"),
        ("torque_roll", math.inf, "amplitude is inf"),
    ):
        with pytest.raises(WorkbenchError, match=said):
            fly_load_step(load, amplitude)
    with pytest.raises(WorkbenchError, match="cannot act for 6 s in 5 s"):
        fly_load_step("gust_x", 1.0, acts=6.0)
    with pytest.raises(WorkbenchError, match="cannot be measured in 0 s"):
        fly_load_step("force_x", 1.0, duration=0.0)
