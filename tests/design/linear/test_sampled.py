"""Oracles: differences through the wired diagram, and small flown steps."""

import dataclasses

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from scipy.linalg import expm

from workbench.common.errors import WorkbenchError
from workbench.design.judge.margins import loop_margins
from workbench.design.linear.operating_point import parse_point
from workbench.design.linear.study import LinearStudy
from workbench.design.linear.trim import filtered_of, guidance_of, reference_of
from workbench.design.step_response import fly_step
from workbench.diagram.core import add_sampled_core
from workbench.plant.variation import Variation
from workbench.scenario.scenario import Scenario, VehicleConfig
from workbench.session.integration import Integration

STEP_ERROR = 1e-5
"""What a step of `runge_kutta5` over a control period leaves, with rotor lags of 12.5 ms."""


def quaternion_rows(q_WB: np.ndarray) -> np.ndarray:
    """Return dq by a small rotation vector in W, by the quaternion product (1, a/2) q."""
    columns = []
    for axis in np.eye(3):
        v, (w, *u) = axis / 2, q_WB
        columns.append([-v @ u, *(w * v + np.cross(v, u))])
    return np.array(columns).T


def period_matrix(study, model) -> np.ndarray:
    """Return the state's derivatives through a period of the diagram, in W (23, 23).

    By central differences: to a part in 10^7 or so.
    """
    trim, rates = model.trim, study.scenario.rates
    builder = DiagramBuilder()
    airframe, computer = add_sampled_core(builder, study.setup)
    diagram = builder.Build()
    simulator = Simulator(diagram)
    root = simulator.get_mutable_context()
    in_computer = computer.GetMyMutableContextFromRoot(root)
    computer.GetInputPort("reference").FixValue(in_computer, reference_of(trim))
    computer.GetInputPort("guidance").FixValue(in_computer, guidance_of(trim))
    integration = Integration(simulator, airframe, rates)

    def after(x: np.ndarray) -> np.ndarray:
        """Fly a period from a state of the model, but with a quaternion in place of angles."""
        body, speeds, commands, filtered = np.split(x, np.cumsum([13, 4, 4]))
        airframe.place(root, body, speeds)
        computer.begin(in_computer, commands, filtered)
        root.SetTime(0.0)
        if diagram.HasSubsystemNamed("battery"):  # more than full: it stays full for the period
            battery = diagram.GetSubsystemByName("battery")
            battery.GetMyMutableContextFromRoot(root).SetDiscreteState([1.1])
        simulator.Initialize()  # the update at 0 stands in the first period
        integration.advance(round(rates.control_period / rates.physics_step))
        speeds = airframe.rotors.GetMyContextFromRoot(root).get_continuous_state_vector()
        parts = [airframe.body_state(root), speeds.CopyToVector()]
        parts.append(in_computer.get_discrete_state(0).value())
        return np.concatenate([*parts, in_computer.get_discrete_state(1).value()[:3]])

    filtered = filtered_of(trim, study._rate)[:3]
    values = np.concatenate([trim.state, trim.speeds, trim.commands, filtered])
    seeds = np.zeros((24, 23))
    seeds[0:4, 0:3] = quaternion_rows(trim.q_WB)
    seeds[4:, 3:] = np.eye(20)
    columns = []
    for seed in seeds.T:
        size = 1e-5 * max(1.0, np.abs(values @ seed))
        columns.append((after(values + size * seed) - after(values - size * seed)) / (2.0 * size))
    rows = np.array(columns).T
    q_after = after(values)[:4]
    angles = np.linalg.pinv(quaternion_rows(q_after)) @ rows[0:4]
    return np.vstack([angles, rows[4:]])


@pytest.mark.parametrize("text", ["hover", "vx=5,vy=-2,vz=2"])
def test_so_it_is_with_all_effects(effects_study, text):
    model = effects_study.sampled(parse_point(text))
    wanted = period_matrix(effects_study, model)
    assert np.abs(model.A - wanted).max() < STEP_ERROR * np.abs(wanted).max()


@pytest.mark.parametrize(
    "text", ["hover", "vx=5,vy=-2", "vz=3", "yaw_rate=0.3", "vx=3,yaw_rate=0.3"]
)
def test_it_is_the_derivative_through_a_period_of_the_diagram(study, text):
    model = study.sampled(parse_point(text))
    wanted = period_matrix(study, model)
    angle = model.trim.point.yaw_rate * model.period
    back = np.array(
        [[np.cos(angle), np.sin(angle), 0], [-np.sin(angle), np.cos(angle), 0], [0, 0, 1]]
    )
    for block in (0, 3, 6, 9, 20):
        wanted[block : block + 3] = back @ wanted[block : block + 3]
    assert np.abs(model.A - wanted).max() < STEP_ERROR * np.abs(wanted).max()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("axis", "amplitude", "shown"),
    [("x", 0.02, "v_x"), ("y", -0.02, "v_y"), ("z", 0.01, "v_z"), ("yaw", 0.002, "w_z")],
)
def test_small_steps_flown_and_linear_agree(study, axis, amplitude, shown):
    step = fly_step(axis, amplitude, duration=2.0)
    asked = "reference_yaw_rate" if axis == "yaw" else f"reference_v_{axis}"
    linear = linear_step(study.sampled(), asked, shown, len(step.time))
    assert np.abs(step.response - amplitude * linear).max() < 0.005 * abs(amplitude)


def linear_step(model, asked, shown, count) -> np.ndarray:
    b, c = model.B([asked])[:, 0], model.C([shown])[0]
    x, found = np.zeros(len(b)), []
    for _ in range(count):
        found.append(c @ x)
        x = model.A @ x + b
    return np.array(found)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("variation", "axis"),
    [
        (Variation(inertia=1.3), "x"),
        (Variation(rotor_lag=1.5), "x"),
        (Variation(control_delay=1), "x"),
        (Variation(control_delay=3), "y"),
        (Variation(sensing_delay=0.003), "x"),
        (Variation(command_delay=0.004), "y"),
        (Variation(command_delay=0.0115, sensing_delay=0.002), "x"),
    ],
)
def test_a_varied_vehicle_flies_as_its_linear_model(study, variation, axis):
    scenario = Scenario(vehicle=VehicleConfig(variation=variation))
    step = fly_step(axis, 0.02, duration=1.5, scenario=scenario)
    asked, shown = f"reference_v_{axis}", f"v_{axis}"
    linear = linear_step(LinearStudy(scenario).sampled(), asked, shown, len(step.time))
    assert np.abs(step.response - 0.02 * linear).max() < 0.005 * 0.02
    nominal = linear_step(study.sampled(), asked, shown, len(step.time))
    assert np.abs(linear - nominal).max() > 0.005


def test_delays_that_end_within_a_period_lie_between_those_that_end_with_it():
    """The phase margin falls with each physics step of delay, by the crossover times its length."""

    def phase(**delays) -> float:
        scenario = Scenario(vehicle=VehicleConfig(variation=Variation(**delays)))
        return loop_margins(LinearStudy(scenario).sampled(), "pitch_acceleration").phase_margin

    crossover = loop_margins(LinearStudy().sampled(), "pitch_acceleration").crossover
    for name in ("sensing_delay", "command_delay"):
        found = [phase(**{name: steps / 1024}) for steps in (0, 1, 4, 8)]
        wanted = found[0] - crossover * np.array([0, 1, 4, 8]) / 1024
        assert found == pytest.approx(wanted, rel=0.03), name
    assert phase(sensing_delay=8 / 1024) == pytest.approx(phase(control_delay=1), rel=1e-9)


def test_noise_on_a_measurement_acts_as_the_measured_thing_does(study):
    """Through the law alone: a step later the rotors' commands differ as if it had moved."""
    model = study.sampled()
    commands = [model.state_names.index(f"command_{i}") for i in (1, 2, 3, 4)]
    for place, name in enumerate(model.state_names[:12]):
        noise = model.B([f"noise_{name}"])[commands, 0]
        assert noise == pytest.approx(model.A[commands, place], abs=1e-9)


def test_a_cut_loop_answers_its_injection_with_the_loop(study):
    """1 + L = det(zI - A) / det(zI - A_cut), and no signal goes round a cut loop at once."""
    model = study.sampled()
    for point in ("acceleration_x", "pitch_error", "yaw_acceleration"):
        A, b, c = model.cut(point)
        assert model.D([point], [point]) == pytest.approx(0.0, abs=1e-12)
        L = model.open_loop(point)
        for w in (1.0, 8.0, 50.0):
            z = np.exp(1j * w * model.period)
            whole = z * np.eye(len(A))
            ratio = np.linalg.det(whole - model.A) / np.linalg.det(whole - A)
            assert 1 + complex(L(z)) == pytest.approx(ratio, rel=1e-6)


def test_a_turn_with_a_late_controller_is_refused():
    scenario = Scenario(vehicle=VehicleConfig(variation=Variation(control_delay=1)))
    with pytest.raises(WorkbenchError, match="leave one out"):
        LinearStudy(scenario).sampled(parse_point("yaw_rate=0.2"))


def test_a_place_is_held_by_its_own_loop(study):
    held = study.sampled(parse_point("hold=1"))
    x = np.abs(np.linalg.eigvals(held.A))
    assert (x > 1.0 - 1e-9).sum() == 1  # yaw alone drifts
    step = dataclasses.replace(held).state_space(["reference_p_z"], ["p_z"])
    assert float(np.real(step.dcgain())) == pytest.approx(1.0, rel=1e-6)


def test_holding_with_its_loops_opened_is_steering(study):
    """Signals, inputs and outputs included; but what moves the held place has nothing to move."""
    holding = study.sampled(parse_point("hold=1"))
    steering = study.sampled()
    opened = holding.opened(["position_x_error", "position_y_error", "position_z_error"])
    assert np.abs(opened.A - steering.A).max() < 1e-12
    shown = [s.name for s in opened.outputs if not s.name.startswith("position")]
    asked = [s.name for s in opened.inputs if not s.name.startswith("reference_p")]
    for name in ("B", "C"):
        found, wanted = (
            getattr(m, name)(asked if name == "B" else shown) for m in (opened, steering)
        )
        assert found == pytest.approx(wanted, abs=1e-9)
    assert opened.D(shown, asked) == pytest.approx(steering.D(shown, asked), abs=1e-9)


def test_the_imu_reads_the_mean_rate_of_a_period():
    """Of a spin-up of rotors, whose rate is the integral of the continuous vehicle's."""
    study = LinearStudy(Scenario(estimator="ekf"))
    model, vehicle = study.sampled(), study.bare_vehicle()
    names, of_vehicle = ([each.name for each in m.states] for m in (model, vehicle))
    speeds = [f"speed_{number}" for number in (1, 2, 3, 4)]
    offset = np.array([3.0, -1.0, 2.0, 5.0])
    T, n = model.period, len(of_vehicle)
    # the upper right block of exp is the integral of exp(A t) over the period
    whole = expm(T * np.block([[vehicle.A, np.eye(n)], [np.zeros((n, 2 * n))]]))[:n, n:] / T
    for axis in "xyz":
        row = names.index(f"imu_w_{axis}")
        read = model.A[row, [names.index(each) for each in speeds]] @ offset
        mean = (
            whole[of_vehicle.index(f"w_{axis}"), [of_vehicle.index(each) for each in speeds]]
            @ offset
        )
        assert read == pytest.approx(mean, rel=0.01)
