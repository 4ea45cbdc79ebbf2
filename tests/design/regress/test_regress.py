"""Specs that are flown: what holds, what is caught, and what a flight that is lost comes to."""

import numpy as np
import pytest

from workbench.common.errors import WorkbenchError
from workbench.common.resources import find_model, find_spec
from workbench.design.judge.margins import loop_margins
from workbench.design.linear.operating_point import parse_point
from workbench.design.linear.study import LinearStudy
from workbench.design.regress.baseline import read_curves
from workbench.design.regress.flight import Changes
from workbench.design.regress.loading import load_spec
from workbench.design.regress.running import Job, compare_to_baseline, record, regress
from workbench.design.reproduce import PAPER_FIGURES
from workbench.design.reproduce import compare_with_paper as beside_paper
from workbench.design.step_response import fly_step
from workbench.plant.gravity import GRAVITY
from workbench.plant.loading import load_vehicle
from workbench.scenario.scenario import (
    Action,
    Scenario,
    ScenarioStart,
    SensorsConfig,
    VehicleConfig,
)
from workbench.session.session import Session


@pytest.fixture
def spec(tmp_path):
    def write(text: str):
        path = tmp_path / "s.workbench.yaml"
        path.write_text(text)
        return path

    return write


def judged(name: str, case: str, **changes):
    job = Job(load_spec(find_spec(name)), case, Changes(**changes))
    return compare_to_baseline(job, job.task.run())


def value(result, metric: str) -> float:
    return next(check.value for check in result.checks if check.name == metric)


def test_metrics_are_those_of_the_flown_step(spec):
    names = [
        "rise_time", "settling_time", "overshoot", "undershoot", "peak", "peak_time",
        "steady_state_value", "steady_state_error",
    ]  # fmt: skip
    other = ["t90", "mean_acceleration", "mean_force", "peak_rotor_use", "coupling_z"]
    limits = ", ".join(f"{name}: {{min: 0}}" for name in names + other)
    text = f"cases:\n  - {{name: a, axis: x, amplitude: 2, duration: 2, limits: {{{limits}}}}}\n"
    (result,) = regress([spec(text)])
    step = fly_step("x", 2.0, duration=2.0)
    assert {name: value(result, name) for name in names} == step.metrics.numbers
    row = beside_paper(PAPER_FIGURES[1], step)
    assert value(result, "t90") == row.t90
    assert value(result, "mean_acceleration") == row.mean_acceleration
    assert value(result, "mean_force") == row.mean_force
    assert value(result, "peak_rotor_use") == step.peak_rotor_use
    assert value(result, "coupling_z") == step.coupling.z


def test_metrics_of_a_script_by_hand(spec):
    """At rest for a second, then a gain-free climb: what a hover weighs, and where it ends."""
    limits = ", ".join(
        f"{name}: {{min: -1000}}"
        for name in (
            "hover_thrust", "hover_rotor_speed", "hover_rotor_spread", "minimum", "maximum",
            "final", "mean", "steady_state_value", "peak_thrust", "peak_tilt", "peak_speed",
        )
    )  # fmt: skip
    text = (
        "cases:\n  - name: a\n    edge: 1\n    duration: 3\n    signal: p_z\n    command: 0.5\n"
        f"    script: [{{at: 1, go_to: [0, 0, 10.5]}}]\n    limits: {{{limits}}}\n"
    )
    path = spec(text)
    (result,) = regress([path])
    vehicle_weight = 1.90 * 9.81
    assert value(result, "hover_thrust") == pytest.approx(vehicle_weight, rel=1e-3)
    assert value(result, "hover_rotor_spread") == pytest.approx(0.0, abs=1e-3)
    assert value(result, "minimum") == pytest.approx(10.0, abs=2e-3)
    assert value(result, "steady_state_value") == pytest.approx(
        value(result, "final") - 10.0, abs=2e-3
    )
    curve = result.curves[0]
    assert value(result, "maximum") == curve.flown.values.max()
    assert value(result, "mean") == pytest.approx(curve.flown.values.mean())
    assert value(result, "peak_tilt") < 1e-3
    assert value(result, "peak_thrust") > vehicle_weight


SENSED = (
    "world: room\nsensors: {use: [imu, gps, lidar], latency: {gps: 0.3}}\ncases:\n"
    "  - {name: a, edge: 0.5, duration: 1, start: {position: [0, 0, 1.5]},\n     "
)


def test_statistics_of_signals_by_hand(spec):
    """The same flight, flown by hand: what was delivered last at each time of its recording."""
    names = ("imu.f_z", "gps.v_up", "lidar.nearest", "lidar.returns", "charge", "p_x")
    limits = ", ".join(f"mean of {name}: {{min: -1e9}}" for name in names)
    limits += ", standard_deviation of imu.f_z: {min: 0}, rms of imu.f_z: {min: 0}"
    script = "script: [{at: 0.2, velocity: [0.5, 0, 0.3]}], "
    (result,) = regress([spec(f"{SENSED}{script}limits: {{{limits}}}}}\n")])
    sensors = SensorsConfig(use=["imu", "gps", "lidar"], latency={"gps": 0.3}, keep=True)
    start = ScenarioStart(position=[0.0, 0.0, 1.5])
    forwards = Action(at=0.2, velocity=[0.5, 0.0, 0.3])
    session = Session(Scenario(world="room", sensors=sensors, start=start, script=[forwards]))
    session.tick(1.5)
    flown = session.recording().between(0.5, 1.5)
    imu, gps, scan = (
        each for name in sensors.use for each in session.samples() if each.sensor == name
    )
    readings = []
    for now in flown.time:
        of_imu, of_gps, of_scan = (
            max(k for k, stamp in enumerate(each.stamps) if stamp + each.latency <= now + 1e-9)
            for each in (imu, gps, scan)
        )
        ranges = scan.ranges[of_scan][np.isfinite(scan.ranges[of_scan])]
        f_z = imu.values[of_imu, imu.columns.index("f_z [m/s^2]")]
        v_up = gps.values[of_gps, gps.columns.index("v_up [m/s]")]
        readings.append([f_z, v_up, ranges.min(), ranges.size])
    means = [*np.mean(readings, axis=0), flown.charge.mean(), flown.p_WB[:, 0].mean()]
    found = [value(result, f"mean of {name}") for name in names]
    assert found == pytest.approx(means, rel=1e-12)
    f_z = np.array(readings)[:, 0]
    assert value(result, "standard_deviation of imu.f_z") == pytest.approx(f_z.std())
    assert value(result, "rms of imu.f_z") == pytest.approx(np.mean(f_z**2) ** 0.5)
    assert [check.unit for check in result.checks][:5] == ["m/s^2", "m/s", "m", "1", "1"]


def test_signals_of_joints_and_setpoints_by_hand(spec):
    """They are those of the same flight, flown by hand, by the names of its table."""
    names = ("joint.gimbal_pitch_q", "joint.gimbal_roll_w", "joint_setpoint.gimbal_pitch")
    limits = ", ".join(f"mean of {name}: {{min: -1e9}}" for name in names)
    text = (
        "vehicle: {{model: gimbal}}\ncases:\n  - {{name: nod, edge: 0.1, duration: 0.2, "
        "start: {{position: [0, 0, 10]}},\n"
        "     script: [{{at: 0.1, set: {{servo_gimbal_pitch: 0.4}}}}], limits: {{{}}}}}\n"
    )
    (result,) = regress([spec(text.format(limits))])
    session = Session(
        Scenario(
            vehicle=VehicleConfig(model="gimbal"),
            start=ScenarioStart(position=[0.0, 0.0, 10.0]),
            script=[Action(at=0.1, set={"servo_gimbal_pitch": 0.4})],
        )
    )
    session.tick(0.3)
    flown = session.recording().between(0.1, 0.3)
    places = [name for name, _ in flown.vehicle.joint_signals]
    servos = [each.joint for each in flown.vehicle.servos]
    means = [
        flown.joints[:, places.index("gimbal_pitch_q")].mean(),
        flown.joints[:, places.index("gimbal_roll_w")].mean(),
        flown.joint_setpoints[:, servos.index("gimbal_pitch")].mean(),
    ]
    assert [value(result, f"mean of {name}") for name in names] == pytest.approx(means, rel=1e-12)
    assert means[0] > 0.05 and means[2] > 0.3
    assert [check.unit for check in result.checks] == ["rad", "rad/s", "rad"]
    wrong = text.format("maximum of joint.pitch_q: {max: 1}")
    with pytest.raises(
        WorkbenchError, match="nod: unknown joint of gimbal 'pitch_q': did you mean"
    ):
        regress([spec(wrong)])


def test_legs_at_rest_bear_the_weight_by_name(spec):
    """Each bears m g / 4 at rest on the ground, and nothing across it."""
    legs = [f"contact.leg{number}_link.z" for number in (1, 2, 3, 4)]
    names = [*legs, "contact.leg1_link.x", "contact.base_link.z"]
    limits = ", ".join(f"mean of {name}: {{min: -1e9}}" for name in names)
    text = (
        "vehicle: {{model: landing_gear}}\ncases:\n  - {{name: stands, edge: 1.25, duration: 0.25, "
        "signal: p_z, start: {{mode: 'off', position: [0, 0, 0.184]}},\n"
        "     script: [{{at: 0, set: {{drag_area: 0}}}}], limits: {{{}}}}}\n"
    )
    (result,) = regress([spec(text.format(limits))])
    weight = load_vehicle(find_model("landing_gear")).mass * GRAVITY
    found = [value(result, f"mean of {name}") for name in names]
    assert found == pytest.approx([*[weight / 4.0] * 4, 0.0, 0.0], rel=2e-3, abs=1e-3)
    assert {check.unit for check in result.checks} == {"N"}
    wrong = text.format("maximum of contact.leg1.z: {max: 1}")
    with pytest.raises(WorkbenchError, match="unknown contact of landing_gear 'leg1.z': did you"):
        regress([spec(wrong)])


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("mean of imu.f_u", "a: unknown signal of 'imu' 'f_u': did you mean 'f_"),
        ("mean of imo.f_z", "a: unknown sensor of this flight 'imo': did you mean 'imu'"),
        ("mean of barometer.pressure", "a: unknown sensor of this flight 'barometer'"),
    ],
)
def test_a_signal_that_no_sensor_has_is_named_with_spec_and_case(spec, text, said):
    path = spec(f"{SENSED}limits: {{{text}: {{min: 0}}}}}}\n")
    with pytest.raises(WorkbenchError) as caught:
        regress([path])
    assert str(caught.value).startswith(f"{path}: {said}")


def test_a_sensor_that_has_delivered_nothing_yet_is_named(spec):
    path = spec(SENSED.replace("0.5,", "0.1,") + "limits: {mean of gps.v_up: {min: 0}}}\n")
    said = "'gps' delivers first at 0.3 s, but is judged from 0.102 s on: give the case a later"
    with pytest.raises(WorkbenchError, match=said):
        regress([path])
    none = path.read_text().replace("use: [imu, gps, lidar]", "use: []")
    with pytest.raises(WorkbenchError, match=r"no signal 'gps\.v_up': name the sensor in the spec"):
        regress([spec(none)])


def test_a_curve_that_is_infinite_makes_no_baseline(spec):
    path = spec(
        "sensors: {use: [range_finder]}\ncases:\n  - {name: a, duration: 0.2, edge: 0.1,\n"
        "     start: {position: [0, 0, 30]}, baseline: {range_finder.distance: {absolute: 1}}}\n"
    )
    with pytest.raises(WorkbenchError, match=r"a: range_finder\.distance is inf at 0\.0.* finite"):
        record([path])


def test_a_baseline_is_met_by_the_same_flight_and_by_no_other(spec):
    path = spec(
        "cases:\n  - {name: a, axis: z, amplitude: 1, duration: 0.5,\n"
        "     baseline: {v_z: {absolute: 1.0e-4}}}\n"
    )
    recorded = record([path])
    for file, text in recorded.files.items():
        file.parent.mkdir(exist_ok=True)
        file.write_text(text)
    curves = read_curves(path.parent / "s.baseline" / "a.csv")
    step = fly_step("z", 1.0, duration=0.5)
    assert curves["v_z"].values == pytest.approx(step.response, abs=1e-6)
    (same,) = regress([path])
    assert same.passed
    assert same.differences == ()
    (other,) = regress([path], Changes(settings={"kp_velocity_z": 5.0}))
    assert "v_z leaves its band" in other.failures[0]
    assert other.story[-1] == "since the baseline: kp_velocity_z 4.4 -> 5"
    path.write_text(path.read_text().replace("0.5,", "1.0,"))
    (longer,) = regress([path])
    assert "longer than its baseline" in longer.failures[0]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("changes", "name"),
    [
        ({"variation": {"mass": 1.05}}, "variation mass 1 -> 1.05"),
        ({"args": {"mass": "1.995"}}, "mass 1.9 -> 1.995"),
        ({"physics_step": 1 / 2048}, "rates physics_step"),
        ({"settings": {"rotor_1": 0.97}}, "rotor_1 1 -> 0.97"),
    ],
)
def test_what_differs_is_named(changes, name):
    assert name in judged("steps", "yaw left", **changes).changed


@pytest.mark.slow
def test_the_shipped_specs_catch(case):
    for spec, changes in [
        ("steps: z up", {"settings": {"kd_velocity_z": 0.05 * 0.7}}),
        ("hold: pushed", {"settings": {"kd_velocity_x": 0.1 * 0.7}}),
        ("hold: pushed", {"settings": {"kd_roll": 27.0 * 1.4}}),
        ("hold: go to a place", {"settings": {"kp_position_xy": 1.4}}),
        ("limits: too high", {"settings": {"max_height": 120.0 * 1.4}}),
        ("limits: turning too fast", {"settings": {"max_yaw_rate": 0.4 * 0.7}}),
        ("steps: yaw left", {"variation": {"mass": 1.05}}),
        ("steps: yaw left", {"args": {"mass": "1.995"}}),
        ("steps: x ahead", {"variation": {"rotor_lag": 1.5}}),
        ("steps: x ahead", {"variation": {"control_delay": 1}}),
        ("steps: x ahead", {"settings": {"rotor_1": 0.97}}),
        ("turns: turning while it rolls", {"variation": {"inertia": 1.05}}),
        ("sensor-noise: at rest", {"settings": {"imu_fault": 2.0}}),
        ("sensor-noise: at rest", {"args": {"gps_noise": "3"}}),
        ("battery: hover", {"settings": {"battery_duration": 36.0}}),
    ]:
        with case(spec, changes):
            name, part = spec.split(": ")
            assert not judged(name, part, **changes).passed


@pytest.mark.slow
@pytest.mark.parametrize("step", [1 / 512, pytest.param(1 / 2048, marks=pytest.mark.slow)])
@pytest.mark.parametrize(
    "case",
    [
        "steps: z up",
        "hold: pushed",
        "turns: thrown and left to itself",
        "turns: turning while it rolls",
        "sensor-truth: across the room",
        "sensor-noise: at rest",
    ],
)
def test_the_shipped_specs_cry_no_wolf(case, step):
    name, part = case.split(": ")
    assert judged(name, part, physics_step=step, seed=7).failures == []


def test_the_margins_of_every_loop_are_as_demanded():
    result = judged("margins", "margins")
    assert result.failures == []
    assert not judged("margins", "margins", settings={"kp_roll": 225.0 * 1.4}).passed


def test_a_phase_margin_of_an_older_spec_is_in_rad(spec, caplog):
    caplog.set_level("INFO", "workbench")
    text = "margins:\n  roll: {phase_margin: [0.6, 1.2], disk_margin: {min: 0.5}}\n"
    old = load_spec(spec(text))
    assert "s.workbench.yaml:2: phase_margin is read in rad, as in specs before 1.0" in caplog.text
    now = load_spec(spec("margins: {roll: {phase_margin_deg: {min: 34.4}}}\n"))
    limit = old.content.margins["roll"]["phase_margin_deg"]
    assert (limit.min, limit.max) == pytest.approx((34.377, 68.755), abs=1e-3)
    assert now.content.margins["roll"]["phase_margin_deg"].min == 34.4


def test_margins_are_those_at_the_named_point(spec):
    """A flight ahead keeps no place, so it has no model with a place held."""
    text = "at: vx=5\nmargins: {roll: {phase_margin_deg: {min: 6}}}\n"
    (result,) = regress([spec(text)])
    expected = loop_margins(LinearStudy().sampled(parse_point("vx=5")), "roll_acceleration")
    assert value(result, "roll phase_margin_deg") == expected.phase_margin_deg
    (hover,) = regress([spec(text.replace("vx=5", "hover"))])
    assert value(hover, "roll phase_margin_deg") != expected.phase_margin_deg


def test_a_loop_that_holds_a_place_is_judged_in_hover(spec):
    text = "margins:\n  position_x: {bandwidth: {min: 0.1}}\n  roll: {bandwidth: {min: 1}}\n"
    (result,) = regress([spec(text)])
    assert result.failures == []


def test_a_point_that_cannot_be_flown_is_named_with_its_line(spec):
    path = spec("title: fast\nat: vx=500\nmargins: {roll: {phase_margin: {min: 0.1}}}\n")
    with pytest.raises(WorkbenchError) as caught:
        regress([path])
    assert str(caught.value).startswith(f"{path}:2: there is no flight as 'vx=500'")


def test_a_flight_that_is_lost_is_a_failing_result(spec):
    text = (
        "cases:\n  - {name: a, axis: x, amplitude: 8, duration: 3, set: {kp_roll: 2500},\n"
        "     limits: {peak: {max: 9}}}\n"
    )
    (result,) = regress([spec(text)], Changes(variation={"control_delay": 16, "inertia": 0.1}))
    assert not result.passed


def test_a_drone_on_its_back_is_lost_and_makes_no_baseline(spec):
    """With gains that the air frame cannot follow it turns over long before 100 m/s."""
    path = spec(
        "cases:\n  - {name: a, axis: x, amplitude: 2, duration: 1, set: {kp_pitch: 2400},\n"
        "     limits: {peak: {max: 99}}, baseline: {v_x: {absolute: 99}}}\n"
    )
    results, files = record([path])
    (failure,) = results[0].failures
    assert failure.startswith("the flight is lost at t = 1.")
    assert ": upside down and turning at " in failure
    assert results[0].checks == ()
    assert files == {}


def test_a_broken_flight_says_when(spec, monkeypatch):
    from workbench.common.errors import FlightBrokenError
    from workbench.session.session import Session

    def broken(self, progress=None):
        raise FlightBrokenError("the flight broke off after 0.500 s: out of numbers")

    monkeypatch.setattr(Session, "run", broken)
    text = "cases:\n  - {name: a, axis: x, amplitude: 1, limits: {peak: {max: 9}}}\n"
    (result,) = regress([spec(text)])
    assert result.failures == ["the flight broke off after 0.500 s: out of numbers"]
    assert record([spec(text)]).files == {}


def test_what_cannot_be_built_is_bad_input(spec):
    text = "cases:\n  - {name: a, axis: x, amplitude: 1, limits: {peak: {max: 9}}}\n"
    with pytest.raises(WorkbenchError, match="mass"):
        regress([spec(text)], Changes(args={"mass": "heavy"}))
    with pytest.raises(WorkbenchError, match="rotor_7"):
        regress([spec(text)], Changes(settings={"rotor_7": 0.5}))
