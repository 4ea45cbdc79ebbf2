"""What filters do to linear models: closed forms, and small steps flown with them."""

from types import SimpleNamespace

import numpy as np
import pytest
from scipy import signal

from workbench.common.errors import WorkbenchError
from workbench.design.linear.operating_point import parse_point
from workbench.design.linear.setpoint_filter import SetpointFilter
from workbench.design.step_response import fly_step
from workbench.plant.variation import Variation
from workbench.scenario.scenario import Rates, Scenario, VehicleConfig

GYRO = 1024.0
FILTERS = (
    ({"gyro_lowpass": 60.0}, signal.butter(2, 60.0, fs=GYRO)),
    ({"gyro_lowpass": 25.0, "gyro_lowpass_order": 1.0}, signal.butter(1, 25.0, fs=GYRO)),
    ({"gyro_notch": 70.0, "gyro_notch_width": 30.0}, signal.iirnotch(70.0, 70 / 30, fs=GYRO)),
)
NOTHING = ([1.0, 0.0], [1.0, 0.0])
ALL = {
    "gyro_lowpass": 40.0,
    "gyro_notch": 90.0,
    "gyro_rate": 512.0,
    "setpoint_lowpass": 4.0,
    "derivative_lowpass": 8.0,
}


def loop_at(model, point, frequency):
    """Return a loop opened at a loop point, at a frequency [rad/s]."""
    A, b, c = model.cut(point)
    z = np.exp(1j * frequency * model.period)
    return -c @ np.linalg.solve(z * np.eye(len(A)) - A, b)


def yaw_rate(vehicle, filter, steps, frequency):
    """Return the yaw rate that comes out of a filter over yawing commands, by scipy alone.

    Commands are held for so many steps of 1/1024 s.
    """
    b, a = filter
    yawing = [f"command_{rotor}" for rotor in (1, 2, 3, 4)]
    turns = -np.sign(vehicle.C(["w_z"]) @ vehicle.A[:, 12:16]).ravel()
    A, B, C, _, _ = signal.cont2discrete(
        (vehicle.A, (vehicle.B(yawing) @ turns)[:, None], vehicle.C(["w_z"]), np.zeros((1, 1))),
        1.0 / GYRO,
    )
    F, G, H, D = signal.tf2ss(b, a)
    n, m = len(A), len(F)
    step = np.block([[A, np.zeros((n, m))], [G @ C, F]])
    held = np.vstack([B, np.zeros((m, 1))])
    size = n + m
    period, entry = np.eye(size), np.zeros((size, 1))
    for _ in range(steps):
        period, entry = step @ period, step @ entry + held
    out = np.hstack([D @ C, H])
    z = np.exp(1j * frequency * steps / GYRO)
    return (out @ np.linalg.solve(z * np.eye(size) - period, entry))[0, 0]


def test_a_filter_takes_its_own_phase_from_a_rate_loop(case, study):
    """In the yaw loop the rate is all that is fed back: with updates as fast as samples, the loop
    is multiplied by the filter; with slower ones samples fold, which scipy knows as well."""
    point = study.controller.loop("yaw_rate").point("actuator")
    fast = study.like(Scenario(rates=Rates(control_period=1 / GYRO, record_period=1 / GYRO)))
    bare = study.bare_vehicle()
    for filters, (b, a) in FILTERS:
        for each, steps in ((fast, 1), (study, 8)):
            plain, model = each.sampled(), each.sampled(gains=filters)
            for frequency in (10.0, 35.0, 60.0):
                with case(filters, steps, frequency):
                    found = loop_at(model, point, frequency) / loop_at(plain, point, frequency)
                    wanted = signal.freqz(b, a, [frequency / GYRO])[1][0]
                    assert abs(np.angle(wanted, deg=True)) > 0.3
                    if steps > 1:
                        with_filter = yaw_rate(bare, (b, a), steps, frequency)
                        wanted = with_filter / yaw_rate(
                            bare, ([1.0, 0.0], [1.0, 0.0]), steps, frequency
                        )
                    apart = np.angle(found / wanted, deg=True)
                    assert abs(apart) < (0.02 if steps > 1 else 1e-6)
                    assert abs(found) == pytest.approx(abs(wanted), rel=1e-3)


def test_only_filters_that_are_on_have_states(study):
    plain = study.sampled()
    names = {
        name: set(study.sampled(gains={name: value}).state_names) - set(plain.state_names)
        for name, value in ALL.items()
    }
    assert not names["gyro_rate"]
    assert names["gyro_lowpass"] == {f"gyro_lowpass_{a}_{n}" for a in "xyz" for n in (1, 2)}
    assert names["gyro_notch"] == {f"gyro_notch_{a}_{n}" for a in "xyz" for n in (1, 2)}
    assert names["derivative_lowpass"] == {f"derivative_lowpass_{a}" for a in "xyz"}
    assert len(names["setpoint_lowpass"]) == 4
    first = study.sampled(gains={"gyro_lowpass": 40.0, "gyro_lowpass_order": 1.0})
    assert len(first.states) == len(plain.states) + 3


@pytest.mark.slow
@pytest.mark.parametrize(("axis", "shown"), [("x", "v_x"), ("z", "v_z"), ("yaw", "w_z")])
def test_small_steps_flown_through_filters_are_the_linear_ones(study, axis, shown):
    step = fly_step(axis, 0.01, duration=1.5, settings=ALL)
    asked = "reference_yaw_rate" if axis == "yaw" else f"reference_v_{axis}"
    model = study.sampled(gains=ALL)
    found = response(model, asked, shown, len(step.time))
    assert np.abs(step.response - 0.01 * found).max() < 0.005 * 0.01
    without = response(study.sampled(), asked, shown, len(step.time))
    assert np.abs(found - without).max() > 0.03


def response(model, asked, shown, count):
    b, c = model.B([asked])[:, 0], model.C([shown])[0]
    x, found = np.zeros(len(b)), []
    for _ in range(count):
        found.append(c @ x)
        x = model.A @ x + b
    return np.array(found)


def test_late_sensing_sees_what_the_filters_gave_then(study):
    """Half a period late, so the reading falls between two updates."""
    scenario = Scenario(vehicle=VehicleConfig(variation=Variation(sensing_delay=0.004)))
    step = fly_step("yaw", 0.01, duration=1.0, settings=ALL, scenario=scenario)
    model = study.like(scenario).sampled(gains=ALL)
    found = response(model, "reference_yaw_rate", "w_z", len(step.time))
    assert np.abs(step.response - 0.01 * found).max() < 0.005 * 0.01


def test_a_turn_is_linearised_with_a_gyro_filter(study):
    point = parse_point("vx=3,yaw_rate=0.3")
    model = study.sampled(point, {"gyro_lowpass": 500.0})
    without = study.sampled(point)
    slow, fast = (sorted(np.abs(np.linalg.eigvals(each.A)))[-12:] for each in (model, without))
    assert slow == pytest.approx(fast, abs=2e-3)


def test_what_has_no_model_says_so(study):
    with pytest.raises(WorkbenchError, match="switch off gyro_lowpass"):
        study.continuous(gains={"gyro_lowpass": 40.0})
    with pytest.raises(WorkbenchError, match="setpoint_lowpass"):
        study.sampled(parse_point("yaw_rate=0.3"), {"setpoint_lowpass": 3.0})


@pytest.mark.parametrize(("late", "share"), [(0, 0.25), (1, 1.0), (3, 1.0), (3, 0.25)])
def test_a_setpoint_comes_as_many_periods_late_and_through_its_low_pass(late, share):
    """In each period it goes a share of the way to the command of that many periods before."""
    servo = SimpleNamespace(delay_periods=lambda period: late, lowpass_share=lambda period: share)
    arm = SimpleNamespace(servo=servo, joint="arm", setpoint_unit="rad")
    setpoint_filter = SetpointFilter([arm], rotors=1, period=1 / 128)
    states = np.zeros((len(setpoint_filter.states), 1))
    commands = np.random.default_rng(2).normal(size=(10, 2, 1))
    setpoint = 0.0
    for number, command in enumerate(commands):
        asked = commands[number - late][1, 0] if number >= late else 0.0
        setpoint += share * (asked - setpoint)
        reached = setpoint_filter.setpoints(states, command)[:, 0]
        assert reached == pytest.approx([command[0, 0], setpoint])  # the rotor's is as it was
        states = setpoint_filter.after(states, command)
