"""Margins and poles against python-control's, of the model that `linearize` gives."""

import dataclasses
import math

import control
import numpy as np
import pytest

from workbench.analysis.judging import judge_gains
from workbench.analysis.queries import (
    DrawFrequency,
    FindRanges,
    Judge,
    OtherControllerQuery,
    PlanMeasurement,
    RequestedStep,
    Sensitivities,
)
from workbench.analysis.subject import AnalysedVehicle
from workbench.common.errors import WorkbenchError
from workbench.control.controller_file import load_controller
from workbench.design.judge.loop_judgement import hover_margins
from workbench.design.judge.loop_measurement import loop_injection
from workbench.design.linear.linearize import linearize
from workbench.design.linear.operating_point import HOLDING_POINT, HOVER_POINT
from workbench.design.linear.study import LinearStudy
from workbench.plant.variation import Variation
from workbench.scenario.scenario import Action, Rates, Scenario, VehicleConfig
from workbench.setup import make_setup

GAINS = {"kp_roll": 180.0, "kd_roll": 24.0, "kp_velocity_z": 6.0, "kp_position_xy": 1.4}
HARD = {"kp_velocity_x": 12.0, "kp_roll": 300.0}


def of_model(name):
    """Return a scenario of a shipped drone."""
    return Scenario(vehicle=VehicleConfig(model=name))


def roll_margin(judged):
    """Return the phase margin of roll, without rounding [rad]."""
    return round(next(each.phase_margin for each in judged.loops if each.name == "roll"), 9)


@pytest.mark.parametrize(
    "loop",
    [
        "roll",
        "velocity_x",
        *(
            pytest.param(loop, marks=pytest.mark.slow)
            for loop in ("velocity_z", "yaw_rate", "position_x")
        ),
    ],
)
def test_margins_are_python_controls(answer, loop):
    judged = next(each for each in answer(Judge(GAINS)).loops if each.name == loop)
    frequencies = np.geomspace(0.05, 400.0, 4000)
    model = linearize(loop=loop, gains=GAINS)
    response = model(np.exp(1j * frequencies / 128.0))
    measured = control.frd(response, frequencies, smooth=True)
    gains, phases, _, _, crossovers, _ = control.stability_margins(measured, returnall=True)
    # the yaw rate's phase reaches -180 degrees only at half the sampling rate, at z = -1
    at_half_rate = 1.0 / abs(complex(model(-1.0 + 0.0j)))
    gain_margin = min(gains[gains > 1.0], default=at_half_rate)
    assert judged.gain_margin == pytest.approx(gain_margin, rel=2e-3)
    assert judged.gain_reduction_margin == pytest.approx(
        max(gains[gains < 1.0], default=0.0), rel=2e-3
    )
    assert np.degrees(judged.phase_margin) == pytest.approx(min(abs(phases)), rel=2e-3)
    assert judged.crossover == pytest.approx(max(crossovers), rel=2e-3)
    assert judged.stable


def test_margins_are_those_of_the_model_that_is_linearised_each_time(subject, answer):
    judged = {each.name: each for each in answer(Judge(GAINS)).loops}
    for loop, margins in hover_margins(subject.study.sampled(HOLDING_POINT, GAINS)).items():
        for name in ("gain_margin", "phase_margin", "delay_margin", "disk_margin", "crossover"):
            expected = getattr(margins, name)
            assert getattr(judged[loop], name) == pytest.approx(expected, rel=1e-6), name


def test_poles_are_those_of_the_sampled_closed_loop_in_continuous_terms(answer):
    """Each is one of python-control's, and all of its that last longer than a sample are there."""
    poles = answer(Judge(GAINS)).poles
    closed = linearize(at="hold=1", gains=GAINS)
    sampled = control.poles(closed)
    truth = np.log(sampled[np.abs(sampled) > 0.05].astype(complex)) * 128.0
    for pole in poles:
        assert np.abs(truth - pole).min() < 1e-4 * abs(pole)
    slow = truth[(truth.real > -80.0) & (np.abs(truth) > 1e-3)]
    for pole in slow:
        assert np.abs(poles - pole).min() < 1e-4 * abs(pole)


def test_all_is_well_with_the_shipped_gains(answer):
    judged = answer(Judge({}))
    assert judged.stable
    assert judged.said == ""
    assert [each.name for each in judged.loops][:2] == ["velocity_x", "velocity_y"]
    assert len(judged.loops) == 9
    assert (judged.poles.real < 0.0).all()


def test_an_unstable_loop_is_named(answer):
    judged = answer(Judge({"kp_roll": 2500.0, "kd_roll": 0.5}))
    assert not judged.stable
    assert judged.said == "unstable: a mode grows through roll"
    assert judged.poles.real.max() > 1.0
    assert not any(each.stable for each in judged.loops)
    assert [each.name for each in judged.loops if each.growing] == ["roll"]


def test_only_a_held_place_may_be_unstable(answer):
    """The position's loops grow, and those of the velocity inside them do not."""
    gains = {
        f"{name}_velocity_{axis}": k for axis in "xy" for name, k in (("kp", 12.0), ("kd", 0.0))
    }
    assert answer(Judge(gains)).stable
    judged = answer(Judge(gains | {"kp_position_xy": 5.0}))
    assert not judged.stable
    assert judged.said.startswith(
        "holding the position is unstable: a mode grows through position x"
    )
    unstable = {each.name for each in judged.loops if not each.stable}
    assert unstable == {"position_x", "position_y", "position_z"}


def test_settings_count_and_a_question_counts_more(answer):
    firm = AnalysedVehicle(Scenario(), {"kp_roll": 180.0, "wind_x": 5.0})
    own, other = {}, {"kp_roll": 250.0}
    assert roll_margin(answer(Judge(own), firm)) == roll_margin(answer(Judge({"kp_roll": 180.0})))
    assert roll_margin(answer(Judge(other), firm)) == roll_margin(answer(Judge(other)))
    assert roll_margin(answer(Judge(own), firm)) != roll_margin(answer(Judge(own)))


def test_variation_and_rates_of_the_scenario_count(answer):
    late = VehicleConfig(variation=Variation(control_delay=1))
    slow = Rates(control_period=1 / 64, record_period=1 / 64)
    own = roll_margin(answer(Judge({})))
    for scenario in (Scenario(vehicle=late), Scenario(rates=slow)):
        assert roll_margin(answer(Judge({}), AnalysedVehicle(scenario, {}))) < own - 0.05


@pytest.mark.parametrize(
    ("gains", "said"),
    [
        ({"kp_roll": float("nan")}, "kp_roll is 'nan': give it a number"),
        ({"kp_roll": 1e9}, "kp_roll is 1e+09 1/s^2: keep it within 0 .. 2500 1/s^2"),
        ({"kp_rol": 1.0}, "did you mean 'kp_roll'?"),
        ({"wind_x": 1.0}, "wind_x is not a gain of the controller"),
        ({"kp_roll": "much"}, "give it a number"),
    ],
)
def test_bad_gains_are_refused(answer, gains, said):
    with pytest.raises(WorkbenchError) as refused:
        answer(Judge(gains))
    assert said in str(refused.value)


def test_a_set_of_scheduled_gains_is_judged_as_the_law_that_has_them_alone(answer):
    """Whichever set flies in hover; answers name gains as the question does."""
    payload = {"payload_mass": 0.1, "known_payload_mass": 0.1}
    subject = AnalysedVehicle(Scenario(controller="pd@speed=0,4"), payload)
    asked = {f"{name}_at_4": 0.8 * subject.own[name] for name in ("kp_roll", "kd_roll", "kp_pitch")}
    plain = {subject.flown.gain_of(name): value for name, value in asked.items()}
    alone = AnalysedVehicle(Scenario(), payload)
    found, wanted = answer(Judge(asked), subject), answer(Judge(plain), alone)
    one, other = (
        [(each.name, each.gain_margin, each.phase_margin) for each in judged.loops]
        for judged in (found, wanted)
    )
    assert one == other
    ranges = answer(FindRanges(asked), subject)
    assert ranges["kp_roll_at_4"] == answer(FindRanges(plain), alone)["kp_roll"]
    assert "kp_roll" not in ranges
    step = RequestedStep("x", 1.0, 1.0)
    assert "kp_pitch_at_4" in answer(Sensitivities(asked, step), subject)["rise_time"]


def test_a_drone_whose_hooks_are_open_is_judged_as_the_one_without_a_load(answer):
    """`slung_load` is `dh_drone` with a load on a cable."""
    loaded, dropped, bare = (
        answer(Judge({}), AnalysedVehicle(of_model(model), settings))
        for model, settings in (
            ("slung_load", {}),
            ("slung_load", {"open_hooks": 1.0}),
            ("dh_drone", {}),
        )
    )
    assert any(loaded.pole_joints) and not any(dropped.pole_joints)
    assert len(dropped.poles) == len(bare.poles) < len(loaded.poles)
    for with_load, one, other in zip(loaded.loops, dropped.loops, bare.loops, strict=True):
        assert one.phase_margin == pytest.approx(other.phase_margin, rel=1e-6)
        assert one.gain_margin == pytest.approx(other.gain_margin, rel=1e-6)
        if one.name == "velocity_x":
            assert with_load.phase_margin < 0.95 * one.phase_margin


def test_a_drone_whose_servos_have_moved_is_judged_as_it_stands(answer):
    """As the command line judges it, also with another controller."""
    scenario = of_model("manipulator")
    moved = {"servo_shoulder": 0.9, "servo_elbow": -1.8}
    setup = make_setup(scenario)
    study = LinearStudy(dataclasses.replace(setup, values={**setup.values, **moved}))
    truth = hover_margins(study.sampled(HOLDING_POINT))
    subject = AnalysedVehicle(scenario, {**setup.values, **moved})
    before, now = (answer(Judge({}), each) for each in (AnalysedVehicle(scenario, {}), subject))
    for loop in now.loops:
        assert loop.phase_margin == pytest.approx(truth[loop.name].phase_margin, rel=1e-6)
    assert roll_margin(before) > 1.2 * roll_margin(now)
    assert len(answer(OtherControllerQuery("px4", Judge({})), subject).loops) > 3


@pytest.fixture(scope="module")
def found(subject):
    from workbench.analysis.gain_ranges import find_ranges

    class Unstopped:
        def check(self):
            pass

    return {
        name: list(find_ranges(subject, FindRanges(gains), Unstopped()))[-1]
        for name, gains in (("own", {}), ("hard", HARD))
    }


@pytest.mark.parametrize("which", ["own", "hard"])
def test_the_end_of_a_range_is_stable_and_a_percent_outside_is_not(answer, found, which):
    ranges, gains = found[which], {"own": {}, "hard": HARD}[which]
    ends = 0
    for name, (low, high) in ranges.items():
        row = load_controller().table.find(name)
        for value, outward in ((low, 0.99), (high, 1.01)):
            assert answer(Judge({**gains, name: value})).stable, name
            if value in (row.minimum, row.maximum):
                continue
            ends += 1
            assert not answer(Judge({**gains, name: value * outward})).stable, name
    assert ends >= 6


def test_every_gain_has_a_range_that_holds_its_value(subject, found):
    ranges = found["hard"]
    assert len(ranges) == 13
    for name, (low, high) in ranges.items():
        assert low <= {**subject.own, **HARD}[name] <= high, name


def test_the_answer_of_an_unstable_value_is_the_nearest_range_that_is_stable(answer):
    ranges = answer(FindRanges({"kp_roll": 2000.0}))
    low, high = ranges["kp_roll"]
    assert 100.0 < low + 100.0 < high < 2000.0
    assert answer(Judge({"kp_roll": 0.98 * high})).stable
    # with such a roll nothing that pitch has makes the drone stable
    assert "kp_pitch" not in ranges


def test_it_rests_often_enough_for_margins_to_come_between(subject, work):
    """Between two rests lie two eigenvalue problems, not a whole gain."""
    from workbench.analysis.gain_ranges import find_ranges

    rests = list(find_ranges(subject, FindRanges({}), work))
    assert len(rests) > 200


def test_a_stop_ends_it(answer, caller):
    caller.stopped = 1
    with pytest.raises(WorkbenchError, match="stopped"):
        answer(FindRanges({}))


def test_a_filter_is_judged_as_a_gain_is_and_its_phase_is_told():
    subject = AnalysedVehicle(Scenario(estimator="ekf"), {})
    found = {}
    for cutoff in (0.0, 30.0):
        (reply,) = judge_gains(subject, Judge({"gyro_lowpass": cutoff}), None)
        found[cutoff] = {loop.name: loop for loop in reply.loops}
    plain, filtered = found[0.0]["pitch"], found[30.0]["pitch"]
    assert plain.phase_margin - filtered.phase_margin > 0.1
    # the rate is filtered, and the angle as far as the estimator integrates it
    s, w_c = 1j * filtered.crossover, 2.0 * math.pi * 30.0
    H = 1.0 / (1.0 + math.sqrt(2.0) * s / w_c + (s / w_c) ** 2)
    kp, kd = (subject.own[name] for name in ("kp_pitch", "kd_pitch"))
    rate_alone = np.angle((kp + kd * s * H) / (kp + kd * s))
    assert np.angle(H) < dict(filtered.turned)["filters"] < rate_alone
    total = sum(angle for _, angle in filtered.turned)
    assert total + math.pi == pytest.approx(filtered.phase_margin, abs=1e-6)
    assert abs(dict(plain.turned)["filters"]) < 1e-9


@pytest.mark.parametrize("name", ["pitch", "velocity_x", "position_z"])
def test_frequency_curves_are_of_the_gains_and_carry_the_margins_of_the_table(answer, name):
    """L against python-control's of `linearize`; every number of the loop as `Judge` has it."""
    drawn = answer(DrawFrequency(GAINS, name))
    response = linearize(loop=name, gains=GAINS)(np.exp(1j * drawn.frequency / 128.0))
    np.testing.assert_allclose(drawn.open_loop, response, rtol=1e-6)
    judged = next(each for each in answer(Judge(GAINS)).loops if each.name == name)
    for margin in ("gain_margin", "phase_margin", "delay_margin", "disk_margin", "crossover"):
        assert getattr(drawn.margins, margin) == pytest.approx(getattr(judged, margin), rel=1e-9)


def test_a_loop_that_there_is_not_is_refused(answer):
    with pytest.raises(WorkbenchError, match="loop"):
        answer(DrawFrequency(GAINS, "roll_rate"))


@pytest.mark.parametrize(
    ("loop", "point"), [("velocity_x", HOVER_POINT), ("position_x", HOLDING_POINT)]
)
def test_a_measurement_is_planned_by_the_model_of_its_flight(subject, answer, loop, point):
    """A loop that holds a place is measured while the place is held, others while steered."""
    gains = {"kp_velocity_x": 2.0, "kp_position_xy": 1.4}
    planned, held = answer(PlanMeasurement(gains, loop, "actuator"))
    study, row = subject.study, subject.controller.loop(loop)
    model = study.sampled(point, subject.linear_gains(gains))
    assert planned == loop_injection(model, row, study.vehicle, "actuator")
    assert held is (point is HOLDING_POINT)
    own = loop_injection(study.sampled(point), row, study.vehicle, "actuator")
    assert planned.highest != pytest.approx(own.highest, rel=1e-3)  # with the gains asked for


def test_a_law_is_judged_after_orders_of_the_script_to_the_one_that_flew_before():
    script = [Action(at=1.0, set={"kp_pitch": 300.0}), Action(at=2.0, controller="lqi")]
    about = AnalysedVehicle(Scenario(controller="lqi", script=script), {})
    assert about.setup.controller.name == about.flown_setup.controller.name == "lqi"
    assert about.vehicle_settings == {}
