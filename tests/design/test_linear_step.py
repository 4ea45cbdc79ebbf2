"""Oracles: python-control, closed forms of sums of modes, and flights of thirty seconds."""

import dataclasses
import math

import control
import numpy as np
import pytest

from workbench.analysis.predicting import predict
from workbench.analysis.queries import Predict, RequestedStep
from workbench.analysis.subject import AnalysedVehicle
from workbench.commands.cli import main
from workbench.control.installed_laws import installed_laws
from workbench.design import linear_step as linear_step_module
from workbench.design.linear.model import LinearModel, ModelSignal
from workbench.design.linear.study import LinearStudy
from workbench.design.linear_step import DecayTimes, decay_time, linear_step
from workbench.design.pin import pin_step
from workbench.design.regress.flight import fly_case
from workbench.design.regress.loading import load_spec
from workbench.design.step_metrics import (
    DECAYED_SHARE,
    MAX_AUTO_STEP_S,
    USUAL_STEP_S,
    step_duration,
    step_metrics,
)
from workbench.design.step_response import fly_step
from workbench.design.sweep.sweep import sweep
from workbench.scenario.scenario import Scenario
from workbench.setup import make_setup

PERIOD = 1 / 128


def modal(shares: dict[float, float], steady: float = 1.0) -> LinearModel:
    """Return a model whose step response is steady (1 - Σ share exp(-rate t)), by rate [1/s]."""
    poles = np.exp(-PERIOD * np.array(list(shares)))
    residues = steady * np.array(list(shares.values())) * (1.0 - poles)
    states = tuple(ModelSignal(f"mode_{index}", "1") for index in range(len(poles)))
    rest = steady * (1.0 - sum(shares.values()))
    return LinearModel(
        A=np.diag(poles),
        input_matrix=np.ones((len(poles), 1)),
        output_matrix=residues[None, :],
        feedthrough=np.array([[rest]]),
        period=PERIOD,
        states=states,
        inputs=(ModelSignal("reference_v_x", "m/s"),),
        outputs=(ModelSignal("v_x", "m/s"),),
        trim=None,
    )


@pytest.mark.parametrize("samples", [1, 2, 7, 640, 1000])
def test_a_linear_step_is_that_of_python_control(samples):
    model = LinearStudy().sampled()
    time = model.period * np.arange(max(samples, 2))
    system = model.state_space(["reference_v_x"], ["v_x"])
    theirs = control.step_response(system, time).outputs[:samples]
    ours = linear_step(model, "reference_v_x", "v_x", samples)
    np.testing.assert_allclose(ours, theirs, atol=1e-12)


@pytest.mark.parametrize("steady", [1.0, -0.8])
@pytest.mark.parametrize(
    ("shares", "rate", "share"),
    [({4.0: 1.0}, 4.0, 1.0), ({4.0: 0.9, 0.25: 0.1}, 0.25, 0.1), ({4.0: 1.1, 0.3: -0.1}, 0.3, 0.1)],
)
def test_a_transient_has_decayed_when_its_slowest_mode_has(shares, rate, share, steady):
    """A share s of rate r falls below d after ln(s / d) / r."""
    wanted = math.log(share / DECAYED_SHARE) / rate
    assert decay_time(modal(shares, steady), "x") == pytest.approx(wanted, abs=2 * PERIOD)


@pytest.mark.parametrize(
    ("shares", "wanted"),
    [
        ({5.0: 1.0, 0.01: 0.1}, math.inf),  # slower than a step is flown
        ({5.0: 1.1, -0.1: -0.1}, math.inf),  # grows
        ({5.0: 0.99, 0.01: 0.01}, math.inf),  # slow, and almost a line after 24 s
        ({5.0: 0.95, 5e-4: 0.05}, math.inf),  # a line, and 5 % of the response are to come
        ({5.0: 1.1, -1e-4: -0.1}, math.log(1.1 / DECAYED_SHARE) / 5.0),  # drifts by 5e-5 in 5 s
        ({5.0: 0.99, 1 / 38: 0.01}, math.inf),  # is small after 122 s
        ({5.0: 11.0, -1e-4: -10.0}, math.inf),  # drifts by 5e-3 of 11 in 5 s
        (
            {5.0: 1.0, 0.001: 0.5 * DECAYED_SHARE},
            math.log(1.0 / DECAYED_SHARE) / 5.0,
        ),  # too small to matter
    ],
)
def test_modes_that_do_not_decay_in_time(shares, wanted):
    assert decay_time(modal(shares), "x") == pytest.approx(wanted, rel=0.1)


@pytest.mark.parametrize("rate", [0.0, 1 / 36])
def test_an_oscillation_is_no_drift(rate, monkeypatch):
    """Its mean is a line; 3 % with a time constant of 36 s is small after 36 ln(30) = 122 s."""
    time = PERIOD * np.arange(round(2.0 * MAX_AUTO_STEP_S / PERIOD) + 1)
    response = 1.0 + 0.03 * np.exp(-rate * time) * np.cos(np.pi * time)
    monkeypatch.setattr(linear_step_module, "linear_step", lambda *_: response)
    assert decay_time(modal({5.0: 1.0}), "x") == math.inf


def test_a_step_is_flown_until_it_has_decayed_within_limits():
    assert step_duration(0.0) == step_duration(USUAL_STEP_S) == USUAL_STEP_S
    assert step_duration(12.01) == 12.5
    assert step_duration(MAX_AUTO_STEP_S) == MAX_AUTO_STEP_S
    assert step_duration(math.inf) == USUAL_STEP_S


def test_a_flat_peak_has_not_settled():
    """y = 1 - 1.4 exp(-2 t) + 0.4 exp(-0.4 t) stays within 2 % of its peak for a while."""
    time = np.arange(0.0, 30.0, PERIOD)
    response = 1.0 - 1.4 * np.exp(-2.0 * time) + 0.4 * np.exp(-0.4 * time)
    peak = int(response.argmax())
    decay = math.log(0.4 / DECAYED_SHARE) / 0.4
    short = slice(0, round(1.2 * peak))
    assert step_metrics(time[short], response[short], 1.0).withheld == ""  # the response alone
    withheld = step_metrics(time[short], response[short], 1.0, decay=decay)
    assert math.isnan(withheld.overshoot)
    assert f"fly it for {step_duration(decay):g} s" in withheld.withheld
    whole = step_metrics(time, response, 1.0, decay=decay)
    assert whole.overshoot == pytest.approx(100.0 * (response[peak] - 1.0), abs=0.01)
    assert whole.withheld == ""


def test_settings_of_gains_and_of_others_give_the_models_of_a_study():
    """The model of other gains alone is a quick one, see `RetunedModels`."""
    times, study = DecayTimes(Scenario()), LinearStudy()
    for settings in ({}, {"kp_velocity_x": 1.5}, {"kp_velocity_x": 1.5, "gyro_lowpass": 60.0}):
        wanted = decay_time(study.sampled(gains=settings), "x")
        assert times.of("x", settings) == pytest.approx(wanted, abs=PERIOD)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("law", "settings", "least"),
    [("pd", {"kp_velocity_x": 0.6}, 0.0), ("pid", {"ki_velocity_xy": 2.0}, 10.0)],
)
def test_all_who_measure_a_step_have_the_same_numbers(law, settings, least, tmp_path, case):
    """A law with a slow mode, and one with integral action, whose flat peak looks settled."""
    scenario = Scenario(controller=law)
    flown = fly_step("x", 1.0, scenario=scenario, settings=settings)
    wanted = flown.metrics.numbers
    assert flown.decay > USUAL_STEP_S
    assert wanted["overshoot"] >= least
    swept = sweep(
        ["kp_yaw_rate=5..8:2"] if law == "pd" else ["kp_tilt=5..8:2"],
        axis="x",
        amplitude=1.0,
        scenario=scenario,
        settings=settings,
    )
    answers = predict(
        AnalysedVehicle(scenario, {}), Predict(settings, RequestedStep("x", 1.0, 2.0)), None
    )
    predicted = next(filter(None, answers))
    spec = tmp_path / "a.workbench.yaml"
    pin_step(spec, scenario, settings, "x", 1.0, margins=False)
    (pinned,) = load_spec(spec).content.cases
    judged = fly_case(pinned, make_setup(scenario, settings))
    ways = {
        "sweep": dict(zip(wanted, swept.present_values, strict=False)),
        "app": vars(predicted.numbers),
        "regress": {name: getattr(judged.step, name) for name in wanted},
    }
    for way, found in ways.items():
        for name in wanted.keys() & found.keys():
            if way == "regress" and math.isnan(wanted[name]):
                continue  # it marks numbers and does not withhold them, as limits notice changes
            with case(way, name):
                # a sweep and the app fly compiled, by another integrator
                close = 1e-6 if way == "regress" else 1e-3
                assert found[name] == pytest.approx(wanted[name], rel=close, abs=close, nan_ok=True)
    assert judged.doubt == ""
    hidden = judged.recording.between(0.0, 3.0)
    assert "fly it for" in dataclasses.replace(judged, recording=hidden).doubt


SHEETS = {
    "f450": "--mass 1.4kg --diagonal 450mm --propeller 10x4.5 --motor-kv 920KV --battery 3S",
    "heavy": "--mass 6kg --diagonal 960mm --propeller 18x6 --motor-kv 320KV --battery 6S",
}
"""Data sheets of two more vehicles, one with slow rotors."""
LAWS = ("pd", "pid", "lqi", "px4", "mellinger")
LAWS = tuple(name for name in LAWS if name in installed_laws())
STEPS = (("x", 2.0), ("z", 1.0), ("yaw", 0.2))
LONG = 10.0
"""Of a flight in which all but what creeps has come to rest [s]."""
SOON = ("pd", "pid", "lqi", "mellinger")
"""Laws at 128 Hz."""
EDGE_SLACK = 0.002
"""A response may stay this near to the edge of the settling band, as a share."""


@pytest.mark.slow
@pytest.mark.parametrize(
    ("law", "vehicle"),
    [(law, "dh_drone") for law in LAWS] + [("pd", "f450"), ("pid", "heavy")],
)
def test_numbers_are_those_of_a_long_flight(vehicle, law, case, tmp_path):
    """python-control's of ten seconds, or of a quarter more than the decay."""
    scenario = Scenario(controller=law)
    if vehicle in SHEETS:
        path = tmp_path / f"{vehicle}.urdf.xacro"
        main(["new", str(path), *SHEETS[vehicle].split()])
        scenario.vehicle.model = str(path)
    # of laws that run 500 or 1000 times a second and creep for half a minute, one axis
    for axis, amplitude in STEPS if law in SOON else STEPS[:1]:
        step = fly_step(axis, amplitude, scenario=scenario)
        found = step.metrics
        if found.withheld:
            assert (law, axis) == ("mellinger", "yaw")  # the one that creeps for minutes
            continue
        long = fly_step(axis, amplitude, scenario=scenario, duration=max(LONG, 1.25 * step.decay))
        time, response = long.time, long.response
        info = control.step_info(response, T=time)
        error = 100.0 * abs(response[-1] - amplitude) / amplitude
        sample = 1.01 * (time[1] - time[0])
        with case((axis, found)):
            assert found.overshoot == pytest.approx(info["Overshoot"], abs=1.0)
            assert found.steady_state_error == pytest.approx(error, abs=1.0)
            assert found.rise_time == pytest.approx(info["RiseTime"], rel=0.01, abs=sample)
            if not math.isnan(found.peak_time):
                assert found.peak_time == pytest.approx(info["PeakTime"], rel=0.01, abs=sample)
            away = abs(found.settling_time - info["SettlingTime"])
            if away > max(sample, 0.02 * info["SettlingTime"]):
                begin, end = sorted((found.settling_time, info["SettlingTime"]))
                between = response[(time >= begin) & (time <= end)] / response[-1]
                assert np.abs(np.abs(between - 1.0) - 0.02).max() < EDGE_SLACK
