"""Rotors with inertia. Oracles: the closed form of the yaw loop, and flights of the diagram."""

import dataclasses
import math

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from scipy.linalg import expm

from workbench.control.guidance import Guidance
from workbench.design.judge.margins import loop_margins
from workbench.design.linear.study import LinearStudy
from workbench.design.rollout.engine import RolloutEngine
from workbench.diagram.core import add_sampled_core
from workbench.gains.gain_choice import flight_gains
from workbench.plant.drag import drag_rates
from workbench.plant.loading import make_vehicle
from workbench.plant.placing import body_state
from workbench.plant.rotors import Rotor
from workbench.scenario.configured import read_configured
from workbench.scenario.scenario import Scenario
from workbench.session.integration import Integration
from workbench.setup import make_setup

INERTIA = 6.5e-5
"""Of the shipped drone's propellers [kg·m²]."""


@pytest.fixture(scope="module")
def description():
    found = read_configured(Scenario().vehicle)
    rotors = tuple(dataclasses.replace(rotor, inertia=INERTIA) for rotor in found.rotors)
    return dataclasses.replace(found, rotors=rotors)


@pytest.fixture(scope="module")
def study(description):
    return LinearStudy(Scenario(), description)


def closed_form(study, feedforward: float):
    """Return the yaw-rate loop as a function of z, from rotor constants alone; and its zero.

    A rotor's speed follows by a first-order lag, its drag torque goes with squared speed, and its
    spin-up torque with the slope of speed; the air brakes the turn, which the law takes back.
    """
    vehicle, period = study.vehicle, 1 / 128
    rotor: Rotor = vehicle.rotors[0]
    lag, kp = vehicle.rotor_lag, study.gains["kp_yaw_rate"]
    speed = vehicle.hover_speeds[0]
    lead = rotor.inertia / (2.0 * rotor.motor_constant * rotor.moment_constant * speed)
    drag = drag_rates(vehicle).yaw
    # (1 + lead s) / ((1 + lag s) (s + drag)) with states: asked moment after the lag, and yaw rate
    A = np.array([[-1.0 / lag, 0.0], [1.0 - lead / lag, -drag]])
    b = np.array([[1.0 / lag], [lead / lag]])
    whole = expm(np.block([[A, b], [np.zeros((1, 3))]]) * period)
    Ad, held = whole[:2, :2], whole[:2, 2]
    kept = feedforward * lead / (feedforward * lead + period)

    def loop(z: complex) -> complex:
        asked = (1.0 - kept) / (1.0 - kept / z)
        rate = asked * np.linalg.solve(z * np.eye(2) - Ad, held)[1]
        return kp * rate / (1.0 - drag * rate)

    return loop, 1.0 / lead


def crossings(loop) -> tuple[float, float, float]:
    """Return crossover [rad/s], gain and phase margin [rad] of a loop, on a grid of 0.2 %."""
    w = np.geomspace(0.5, math.pi * 128, 4_000)
    L = np.array([complex(loop(z)) for z in np.exp(1j * w / 128)])
    size, angle = np.abs(L), np.unwrap(np.angle(L))
    angle += -2 * math.pi * round((angle[0] + math.pi / 2) / (2 * math.pi))
    over = np.flatnonzero((size[:-1] >= 1.0) & (size[1:] < 1.0))[-1]
    turned = np.flatnonzero(angle <= -math.pi + 1e-6)[0]  # at the last one L is real
    return float(w[over]), float(1.0 / size[turned]), float(math.pi + angle[over])


@pytest.mark.parametrize(("feedforward", "crossover"), [(0.0, 54.0), (1.0, 4.0)])
def test_the_yaw_loop_is_that_of_its_closed_form(study, feedforward, crossover):
    """A zero at 3.1 rad/s, which the law takes out of the loop if it reckons with it."""
    loop, zero = closed_form(study, feedforward)
    assert zero == pytest.approx(3.11, rel=0.01)
    wanted = crossings(loop)
    assert wanted[0] == pytest.approx(crossover, rel=0.03)
    model = study.sampled(gains={"spin_up_feedforward": feedforward})
    found = crossings(model.open_loop("yaw_rate_error"))
    assert found == pytest.approx(wanted, rel=0.01)


@pytest.mark.parametrize("feedforward", [0.0, 1.0])
def test_margins_say_so(study, feedforward):
    loop, _ = closed_form(study, feedforward)
    _, gain, phase = crossings(loop)
    margins = loop_margins(
        study.sampled(gains={"spin_up_feedforward": feedforward}), "yaw_rate_error"
    )
    assert margins.gain_margin == pytest.approx(gain, rel=0.01)
    assert margins.phase_margin == pytest.approx(phase, rel=0.01)


def flown(description, gains, yaw_rate: float, duration: float) -> np.ndarray:
    """Return angular velocities at the control updates of a yaw step on the diagram."""
    setup = make_setup(description=description)
    vehicle, rates = setup.vehicle, setup.rates
    builder = DiagramBuilder()
    airframe, computer = add_sampled_core(builder, dataclasses.replace(setup, values=gains))
    simulator = Simulator(builder.Build())
    root = simulator.get_mutable_context()
    still = [0.0] * 3
    state = body_state(p_WB=[0.0, 0.0, 50.0], roll_pitch_yaw=still, v_WB=still, w_WB=still)
    airframe.place(root, state, vehicle.hover_speeds)
    integration = Integration(simulator, airframe, rates)
    in_computer = computer.GetMyMutableContextFromRoot(root)
    computer.begin(in_computer, vehicle.hover_speeds, np.zeros(3))
    hold = Guidance(1.0, 1.0, 1.0, 0.0, 1.0, 1.0, 0.0, 0.0, 50.0)
    computer.GetInputPort("guidance").FixValue(in_computer, np.array(hold, dtype=float))
    asked = [0.5, 0.0, 0.0, yaw_rate, 0.0, 0.0, 0.0, 0.0]
    computer.GetInputPort("reference").FixValue(in_computer, np.array(asked))
    rows = []
    for index in range(round(duration * 128) + 1):
        integration.advance(round(index / 128 / rates.physics_step))
        rows.append(airframe.body_state(root)[7:10])
    return np.array(rows)


@pytest.mark.parametrize("feedforward", [0.0, 0.5, 1.0])
def test_compiled_flights_are_those_of_the_diagram(description, feedforward):
    vehicle = make_vehicle(description)
    gains = {**flight_gains(vehicle), "spin_up_feedforward": feedforward}
    diagram = flown(description, gains, 0.3, 1.0)
    engine = RolloutEngine(vehicle, own=gains, threads=1)
    start = np.array([1.0, *[0.0] * 5, 50.0, *[0.0] * 6])
    flights = engine.fly_from([{}], start, np.array([0.5, 0.0, 0.0, 0.3]), duration=1.0)
    assert flights.angular_velocity_W[0] == pytest.approx(diagram, abs=2e-4)  # two integrators


def test_with_all_of_it_reckoned_with_a_yaw_step_is_that_of_rotors_without_inertia(description):
    plain = read_configured(Scenario().vehicle)
    bare = dataclasses.replace(
        plain, rotors=tuple(dataclasses.replace(r, inertia=0.0) for r in plain.rotors)
    )
    gains = {**flight_gains(make_vehicle(description)), "spin_up_feedforward": 1.0}
    with_inertia, without = (flown(one, gains, 0.2, 1.0) for one in (description, bare))
    assert with_inertia[:, 2] == pytest.approx(without[:, 2], abs=0.004)
    unaware = flown(description, {**gains, "spin_up_feedforward": 0.0}, 0.2, 1.0)
    assert np.abs(unaware[:, 2] - without[:, 2]).max() > 0.05
