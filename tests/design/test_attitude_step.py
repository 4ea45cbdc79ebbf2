"""Steps of attitude and rate beside python-control, and beside what the words mean."""

import dataclasses
import math

import control
import numpy as np
import pytest

from tests.oracles.test_wind import WIND, tilt_by_hand
from workbench.common.errors import WorkbenchError
from workbench.control.controller_file import load_controller
from workbench.control.installed_laws import installed_laws
from workbench.design import attitude_step
from workbench.design.attitude_step import fly_attitude_step
from workbench.design.linear.study import LinearStudy
from workbench.design.step_response import scenario_before_step
from workbench.plant.drag import drag_area
from workbench.scenario.attitude_axes import ATTITUDE_ROWS, find_attitude_axis, tilt_angles
from workbench.scenario.scenario import Action, AttitudeSetpoint, Injection, Scenario
from workbench.session.session import Session

SMALL_RAD = 0.01
"""Small enough that the flight is linear."""
FLOWN_S = 0.75
RAD_DEG = 57.29577951308232
UNIT_FACTORS = {"1": 1.0, "rad": 1.0, "rad/s": 1.0, "deg": RAD_DEG, "deg/s": RAD_DEG}
"""Units of loop points over rad and rad/s, stated here by hand."""


def linear_response(axis, scenario, samples):
    """Return the unit step response of the loop with the loops outside open, by python-control."""
    row, model = find_attitude_axis(axis), LinearStudy(scenario).sampled()
    point = row.point
    law = load_controller(scenario.controller)
    output = {"roll": "roll", "pitch": "pitch", "roll_rate": "w_x", "pitch_rate": "w_y"}[axis]
    closed = model.state_space([point], [point, output])
    A, B, C = closed.A, closed.B[:, 0], closed.C
    x, answers = np.zeros(len(A)), []
    for _ in range(samples):
        before, answer = C @ x
        answers.append(answer)
        x = A @ x + B * (1.0 - before)  # the setpoint in place of the signal before the point
    return UNIT_FACTORS[law.points[point]] * np.array(answers)


@pytest.mark.parametrize("axis", ["roll", "pitch"])
def test_a_small_step_of_attitude_is_that_of_the_linear_closed_loop(axis):
    scenario = Scenario()
    flown = fly_attitude_step(axis, SMALL_RAD, duration=FLOWN_S, scenario=scenario)
    linear = linear_response(axis, scenario, len(flown.time))
    assert np.abs(flown.response / SMALL_RAD - linear).max() < 2e-3
    theirs = control.step_info(flown.response, timepts=flown.time)
    assert flown.metrics.peak == pytest.approx(theirs["Peak"], rel=1e-9)
    assert flown.metrics.settling_time == pytest.approx(theirs["SettlingTime"], rel=1e-9)


@pytest.mark.slow
def test_steps_of_every_law_are_those_of_their_linear_closed_loops(case):
    flown_axes = 0
    for name in installed_laws():
        law = load_controller(name)
        for row in (row for row in ATTITUDE_ROWS if row.point in law.points):
            with case((name, row.name)):
                scenario = Scenario(controller=name)
                flown = fly_attitude_step(row.name, SMALL_RAD, duration=FLOWN_S, scenario=scenario)
                linear = linear_response(row.name, scenario, len(flown.time))
                # a part that runs in every n-th update is a mean in the linear model
                most = 0.02 if not law.dividers else 0.2
                assert np.abs(flown.response / SMALL_RAD - linear).max() < most
                flown_axes += 1
    assert flown_axes >= 28


def test_a_drone_follows_a_setpoint_of_roll_and_speeds_up_as_gravity_says():
    flown = fly_attitude_step("roll", 0.1, duration=1.0)
    assert flown.response[-1] == pytest.approx(0.1, rel=0.02)
    early = np.searchsorted(flown.recording.time, 1.35)  # before drag matters
    a_y = flown.recording.vdot_WB[early, 1]
    roll = flown.response[np.searchsorted(flown.time, 0.35)]
    assert a_y == pytest.approx(-9.81 * math.tan(roll), rel=0.05)  # to the right, and y is left
    assert flown.coupling.pitch < 1e-3
    for name in ("roll", "roll_rate"):  # both turn about x, so roll is what is commanded
        coupling = attitude_step._coupling(find_attitude_axis(name), flown.after)
        assert coupling == flown.coupling and coupling.roll == 0.0
    assert flown.metrics.steady_state_error < 2.0


def test_the_loops_outside_return_and_bring_the_drone_back():
    script = [
        Action(at=0.5, setpoint=AttitudeSetpoint(pitch=0.1)),
        Action(at=1.0, setpoint=AttitudeSetpoint()),
    ]
    session = Session(Scenario(duration=6.0, script=script))
    session.run()
    recording = session.recording()
    assert recording.p_WB[:, 0].max() > 0.1  # nose down is ahead
    assert abs(recording.p_WB[-1, 0]) < 0.03


def test_in_wind_a_setpoint_steps_from_that_of_the_hover():
    """The drone leans into the wind by a tilt that is known by hand, and steps as without wind."""
    level = fly_attitude_step("pitch", 0.1)
    windy = fly_attitude_step("pitch", 0.1, settings={"wind_x": WIND})
    vehicle = windy.recording.vehicle
    tilt = tilt_by_hand(vehicle, drag_area(vehicle.mass))
    assert tilt > 0.09
    hover = windy.recording.between(windy.edge - 0.5, windy.edge)
    _, pitch = tilt_angles(hover.q_WB)
    assert pitch[-1] == pytest.approx(-tilt, abs=1e-3)  # at rest: within 1 % of the step
    assert np.ptp(pitch) < 2e-3
    assert windy.response == pytest.approx(level.response, abs=1e-3)
    assert windy.metrics.withheld == ""
    assert windy.metrics.rise_time == pytest.approx(level.metrics.rise_time, abs=0.01)
    assert windy.metrics.steady_state_error < 2.0


def test_a_level_drone_steps_a_second_after_its_start_as_its_script_says_to_the_bit():
    own = Scenario(script=[Action(at=0.5, velocity=[1.0, 0.0, 0.0])])  # which is left out
    flown = fly_attitude_step("roll", 0.1, duration=0.5, scenario=own)
    row = find_attitude_axis("roll")
    flight = scenario_before_step(0.5, Scenario())
    flight.script = [dataclasses.replace(row.action(0.1), at=1.0)]
    session = Session(flight)
    session.run()
    assert flown.edge == 1.0
    assert flown.recording.q_WB.tobytes() == session.recording().q_WB.tobytes()


def test_a_level_drone_that_trembles_on_an_estimate_steps_a_second_after_its_start():
    """Its tilt and rates are above the shares of a small step, 0.6 and 0.3 mrad."""
    flown = fly_attitude_step("roll", 0.03, scenario=Scenario(estimator="ekf"))
    assert (flown.edge, flown.metrics.withheld) == (1.0, "")


def test_a_drone_that_does_not_come_to_rest_has_no_numbers_of_its_step(monkeypatch):
    monkeypatch.setattr(attitude_step, "MAX_HOVER_S", 1.0)
    flown = fly_attitude_step("pitch", 0.1, duration=0.5, settings={"wind_x": 20.0})
    assert flown.edge == 2.0
    assert "did not begin at rest" in flown.metrics.withheld
    assert math.isnan(flown.metrics.rise_time)


def test_a_drone_that_is_lost_before_its_step_has_no_numbers_and_flies_no_further():
    """It tumbles after 2 s; the wait would end after 60 s. The wait is a part of the progress."""
    shares = []
    flown = fly_attitude_step(
        "pitch",
        duration=0.25,
        settings={"kd_pitch": 0.0, "kp_pitch": 400.0, "wind_y": 20.0},
        progress=shares.append,
    )
    assert flown.loss.time <= flown.edge < flown.loss.time + 0.5
    assert flown.diverged_at == 0.0
    assert "lost before" in flown.metrics.withheld
    assert all(math.isnan(number) for number in flown.metrics.numbers.values())
    assert len(shares) == 4.0 * (flown.edge - 1.0) + 1.0
    assert shares == sorted(shares) and 0.0 < shares[0] < 0.05 and shares[-1] == 1.0


def test_what_cannot_be_flown_says_why():
    for axis, words, fragments in (
        ("roll_rate", {}, ("pd has no loop", "roll rate", "roll, pitch")),
        ("roll", {"amplitude": 0.9}, ("max_tilt is 0.7", "smaller amplitude")),
        (
            "pitch",
            {"amplitude": -0.65, "settings": {"wind_x": WIND}},
            ("by 0.76 rad", "is 0.7 rad"),
        ),
        ("roll", {"amplitude": 0.0}, ("not 0",)),
        ("roll", {"amplitude": math.nan}, ("finite number",)),
        ("rol", {}, ("did you mean 'roll'?",)),
    ):
        with pytest.raises(WorkbenchError) as refused:
            fly_attitude_step(axis, **words)
        assert all(fragment in str(refused.value) for fragment in fragments), refused.value
    with pytest.raises(WorkbenchError, match="would tilt the drone by 1.00 rad") as refused:
        fly_attitude_step("roll_rate", 0.5, duration=2.0, scenario=Scenario(controller="pid"))
    assert "shorter time" in str(refused.value)


def test_a_setpoint_and_a_measured_loop_exclude_each_other():
    session = Session()
    session.attitude(roll=0.05)
    with pytest.raises(WorkbenchError, match="end it, as by `setpoint: {}`"):
        session.inject(Injection("roll_error", 0.01))
    session.attitude()
    session.inject(Injection("roll_error", 0.01))
    with pytest.raises(WorkbenchError, match="a loop is being measured"):
        session.attitude(roll=0.05)
    with pytest.raises(WorkbenchError, match="pitch_rate is .nan"):
        session.attitude(pitch_rate=math.nan)


def test_a_step_without_a_duration_may_be_flown(case):
    """A rate ends where it has tilted the drone as far as it may, an attitude does not turn it."""
    for row in ATTITUDE_ROWS:
        for size in (0.2, -0.5, 1.0, 2.0):
            with case((row.name, size)):
                duration = attitude_step.usual_duration(row, size, 0.5)
                if row.is_rate:
                    assert duration == pytest.approx(min(0.75, 0.5 / abs(size)))
                    row.check_tilt(size, duration, 0.5)
                else:
                    assert duration == 1.5
