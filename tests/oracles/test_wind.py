"""Flights in the wind and under pushes, against closed forms."""

import math
from pathlib import Path

import numpy as np
import pytest
from pydrake.common.value import Value
from pydrake.multibody.math import SpatialForce
from pydrake.multibody.plant import ExternallyAppliedSpatialForce, MultibodyPlant
from pydrake.multibody.tree import RotationalInertia, SpatialInertia
from scipy.integrate import solve_ivp

from workbench.design import steady_drift
from workbench.design.step_response import fly_step
from workbench.plant.drag import drag_area
from workbench.scenario.scenario import (
    Action,
    Push,
    Scenario,
    ScenarioStart,
    SensorsConfig,
    VehicleConfig,
)
from workbench.session.session import Session

HEXACOPTER = str(Path(__file__).parent.parent / "drones" / "hexacopter.urdf.xacro")
"""Its rotors have no drag."""
GRAVITY = 9.81
HIGH = 20.0
WIND = 6.0
PERIOD = 1 / 128


def session(settings=None, model="dh_drone", **scenario) -> Session:
    start = ScenarioStart(position=[0.0, 0.0, HIGH])
    vehicle = VehicleConfig(model=model)
    return Session(Scenario(start=start, vehicle=vehicle, **scenario), settings)


def tilt_by_hand(vehicle, area) -> float:
    """Return the tilt at which a drone stands still in a level wind W.

    Rotors pull across their axis with c w W cos(tilt), the body along the wind with D = 1.225 / 2
    A W². Along the axis thrust is m g cos(tilt) + D sin(tilt), and k w² each; across it
    m g sin(tilt) = (D + n c w W) cos(tilt).
    """
    rotor, n = vehicle.rotors[0], len(vehicle.rotors)
    weight = vehicle.mass * GRAVITY
    body = 0.5 * 1.225 * area * WIND**2
    tilt = 0.0
    for _ in range(20):
        thrust = weight * math.cos(tilt) + body * math.sin(tilt)
        speed = math.sqrt(thrust / n / rotor.motor_constant)
        drag = body + n * rotor.rotor_drag_coefficient * speed * WIND
        tilt = math.atan2(drag, weight)
    return tilt


@pytest.mark.slow
@pytest.mark.parametrize(
    ("model", "area", "least", "heading"),
    [
        ("dh_drone", None, 0.09, 2.0),
        pytest.param("dh_drone", 0.0, 0.07, 0.0, marks=pytest.mark.slow),  # rotors alone
        pytest.param(HEXACOPTER, 0.5, 0.1, 2.0, marks=pytest.mark.slow),  # body alone
    ],
)
def test_a_steady_wind_tilts_a_drone_that_keeps_its_place(model, area, least, heading):
    """It leans into the wind."""
    flown = session({} if area is None else {"drag_area": area}, model)
    area = drag_area(flown.vehicle.mass) if area is None else area
    assert flown.get("drag_area") == pytest.approx(area, rel=5e-3)
    flown.go_to([0.0, 0.0, HIGH])
    flown.set("wind_x", WIND * math.cos(heading))
    flown.set("wind_y", WIND * math.sin(heading))
    flown.tick(24.0)
    flight = flown.recording()
    assert np.linalg.norm(flight.v_WB[-1]) < 1e-3
    wanted = tilt_by_hand(flown.vehicle, flown.get("drag_area"))
    assert wanted > least
    assert flight.tilt[-1] == pytest.approx(wanted, rel=2e-3)
    into = -np.array([math.cos(heading), math.sin(heading)])
    assert flight.z_axis_W[-1, :2] @ into == pytest.approx(math.sin(wanted), rel=2e-3)


def test_without_drag_wind_and_gust_change_nothing():
    windy = session({"drag_area": 0.0}, HEXACOPTER, duration=1.0)
    windy.set("wind_x", 10.0)
    windy.gust([0.0, 10.0, 0.0])
    calm = session({"drag_area": 0.0}, HEXACOPTER, duration=1.0)
    for flown in (windy, calm):
        flown.run()
    assert np.array_equal(windy.recording().p_WB, calm.recording().p_WB)


def drift_by_hand(command) -> float:
    """Return the steady velocity of the hexacopter, whose body has 0.5 m², in wind [m/s].

    With c = 1.225 / 2 0.5 m² the wind W pushes by c (W - v)². The law pulls by m kp (command - v),
    plus c' v², the drag in still air of the area that it knows, (m / 1000)^(2/3) m². The sum is 0:
    (c + c') v² - (2 c W + m kp) v + c W² + m kp command = 0.
    """
    m, kp = 8.0, 1.31
    c, known = 0.5 * 1.225 * 0.5, 0.5 * 1.225 * (m / 1000.0) ** (2.0 / 3.0)
    linear = 2.0 * c * WIND + m * kp
    rest = c * WIND**2 + m * kp * command
    return (linear - math.sqrt(linear**2 - 4.0 * (c + known) * rest)) / (2.0 * (c + known))


@pytest.mark.slow
def test_a_step_of_velocity_in_wind_goes_from_the_drift_of_the_law():
    """It drifts with no command, and its numbers are those of the way from there."""
    scenario = Scenario(vehicle=VehicleConfig(model=HEXACOPTER))
    flown = fly_step(
        "x",
        1.0,
        scenario=scenario,
        settings={"wind_x": WIND, "drag_area": 0.5},
    )
    drift, after = drift_by_hand(0.0), drift_by_hand(1.0)
    assert (drift, after - drift) == pytest.approx((0.7936, 0.7838), abs=1e-4)
    assert flown.before == pytest.approx(drift, abs=1e-4)
    assert flown.metrics.steady_state_value == pytest.approx(after - drift, abs=1e-3)
    assert flown.metrics.steady_state_error == pytest.approx(100.0 * (1.0 - after + drift), abs=0.1)
    assert flown.metrics.withheld == ""
    hover = flown.recording.between(flown.edge - 4.0, flown.edge)
    assert np.ptp(hover.v_WB[:, 0]) < 0.01
    assert flown.response[0] == 0.0
    assert flown.time[0] == 0.0
    assert flown.coupling.y == pytest.approx(0.0, abs=1e-6)


@pytest.mark.slow
def test_a_step_of_a_drone_that_does_not_drift_steadily_has_no_numbers(monkeypatch):
    """It did not have the time to; or it is looked at again, and has moved meanwhile."""
    windy = {"wind_x": WIND}
    flown = fly_step("x", 1.0, duration=2.0, settings=windy, longest_hover=1.5)
    assert (flown.edge, flown.before) == (1.0, 0.0)
    assert "does not drift steadily" in flown.metrics.withheld
    assert math.isnan(flown.metrics.steady_state_error)
    monkeypatch.setattr(steady_drift, "steady_time", lambda *_: 2.0)
    flown = fly_step("x", 1.0, duration=3.0, settings=windy)
    assert flown.edge == 2.0
    assert "did not begin at rest" in flown.metrics.withheld
    assert math.isnan(flown.metrics.rise_time)


def test_numbers_of_a_step_in_turbulence_are_withheld_at_once():
    """Nothing is waited for: it flies the second before the edge, and the step."""
    told: list[float] = []
    windy = {"wind_x": WIND, "turbulence": 15.4}
    flown = fly_step("x", 1.0, duration=2.0, settings=windy, progress=told.append)
    assert flown.recording.time[-1] == 3.0
    assert told == sorted(told)
    assert told[-1] == 1.0
    assert "the air is turbulent" in flown.metrics.withheld
    assert math.isnan(flown.metrics.rise_time)
    assert math.isnan(flown.metrics.steady_state_error)
    assert flown.metrics.peak > 0.5


FORCE, POINT = np.array([60.0, -40.0, 20.0]), np.array([0.1, 0.05, -0.02])


def centre_velocity(flown) -> tuple[np.ndarray, np.ndarray]:
    """Return velocity of the centre of mass and angular velocity of an upright drone."""
    now = flown.snapshot()
    w_WB = np.array(now.w_WB)
    return now.v_WB + np.cross(w_WB, flown.vehicle.p_BoBcm_B), w_WB


@pytest.mark.parametrize("at", [0.0, 0.25])
def test_a_push_moves_and_turns_as_newton_says(at):
    """F t / m and I⁻¹ (r x F t): one control period of it, before the law can answer."""
    flown = session()
    flown.tick(at)
    flown.push(FORCE.tolist(), POINT.tolist(), PERIOD)
    assert flown.get("push_start") == at
    v_before, w_before = centre_velocity(flown)
    flown.tick(PERIOD)
    v_after, w_after = centre_velocity(flown)
    impulse = FORCE * PERIOD
    assert v_after - v_before == pytest.approx(impulse / flown.vehicle.mass, rel=5e-3, abs=1e-3)
    spin = np.cross(POINT - flown.vehicle.p_BoBcm_B, impulse)
    wanted = np.linalg.solve(flown.vehicle.inertia, spin)
    assert w_after - w_before == pytest.approx(wanted, rel=0.01, abs=0.01)


@pytest.mark.parametrize("duration", [0.001, 0.01, 0.0151])
def test_a_push_has_its_impulse_however_short_it_is(duration):
    """Two control periods later, with what the law has answered by then: under 2 %."""
    flown = session()
    flown.push(FORCE.tolist(), flown.vehicle.p_BoBcm_B, duration)
    flown.tick(2 * PERIOD + 1 / 1024)
    v_WBcm, _ = centre_velocity(flown)
    wanted = FORCE * duration / flown.vehicle.mass
    assert v_WBcm == pytest.approx(wanted, abs=0.02 * np.linalg.norm(wanted))


TORQUE = np.array([0.06, -0.09, 0.03])


def dead(**start) -> Session:
    """Return a drone whose rotors give nothing, far above the ground, in no air."""
    settings = {f"rotor_{number}": 0.0 for number in range(1, 5)}
    settings |= {"drag_area": 0.0, "air_density": 0.0}
    above = ScenarioStart(position=[0.0, 0.0, 500.0], **start)
    return Session(Scenario(start=above), settings)


@pytest.mark.parametrize("axis", range(3))
def test_a_torque_about_a_principal_axis_turns_a_free_body_evenly(axis):
    """The angle is M t² / 2 I, and what falls falls straight: a torque is no force.

    Rotors that run down give torque, and gyroscopic moments: so what counts is the difference to
    the same fall without, of a body of that inertia whose product terms are some 0.1 %.
    """
    torque, time = 1e-3, 0.25
    flights = []
    for size in (0.0, torque):
        flown = dead()
        flown.push([0.0] * 3, [0.0] * 3, 10.0, [size * (axis == each) for each in range(3)])
        flown.tick(time)
        flights.append(flown)
    calm, turned = (np.array(flown.snapshot().w_WB) for flown in flights)
    inertia = flights[0].vehicle.inertia[axis, axis]
    assert (turned - calm)[axis] == pytest.approx(torque * time / inertia, rel=5e-3)
    p_calm, p_turned = (np.array(flown.snapshot().p_WB) for flown in flights)
    assert p_turned == pytest.approx(p_calm, abs=1e-3)


def test_a_tumbling_body_under_a_torque_flies_as_drakes_own_plant():
    """Torque fixed in the body, by Drake's external spatial forces and its own integrator."""
    flown = dead(angular_velocity=[2.0, -1.0, 3.0])
    vehicle = flown.vehicle
    flown.tick(3.0)  # rotors have run down
    flown.push([0.0] * 3, [0.0] * 3, 1.0, TORQUE.tolist())
    flown.tick(flown.get("push_start") - flown.time)
    begin = flown.state()
    flown.tick(1.0)
    found = flown.state()

    plant = MultibodyPlant(0.0)
    parts = [vehicle.inertia[i, j] for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))]
    spatial = SpatialInertia.MakeFromCentralInertia(
        vehicle.mass, np.array(vehicle.p_BoBcm_B), RotationalInertia(*parts)
    )
    body = plant.AddRigidBody("body", spatial)
    plant.mutable_gravity_field().set_gravity_vector([0.0, 0.0, -GRAVITY])
    plant.Finalize()
    context = plant.CreateDefaultContext()

    def slope(_, state):
        plant.SetPositionsAndVelocities(context, state)
        applied = ExternallyAppliedSpatialForce()
        applied.body_index = body.index()
        torque_W = plant.EvalBodyPoseInWorld(context, body).rotation() @ TORQUE
        applied.F_Bq_W = SpatialForce(torque_W, np.zeros(3))
        port = plant.get_applied_spatial_force_input_port()
        port.FixValue(context, Value[list[ExternallyAppliedSpatialForce]]([applied]))
        return plant.EvalTimeDerivatives(context).CopyToVector()

    wanted = solve_ivp(slope, (0.0, 1.0), begin, rtol=1e-9, atol=1e-10).y[:, -1]
    assert np.linalg.norm(wanted[7:10] - begin[7:10]) > 2.0
    assert found == pytest.approx(wanted, rel=1e-4, abs=1e-4)


def test_a_push_by_script_is_one_by_hand():
    by_hand = session(duration=1.0)
    by_hand.tick(0.5)
    by_hand.push([5.0, 0.0, 0.0], [0.0, 0.1, 0.0], 0.2, [0.0, 0.0, 0.01])
    by_hand.tick(0.5)
    push = Push([5.0, 0.0, 0.0], [0.0, 0.1, 0.0], 0.2, [0.0, 0.0, 0.01])
    scripted = session(duration=1.0, script=[Action(at=0.5, push=push)])
    scripted.run()
    assert np.array_equal(by_hand.recording().p_WB, scripted.recording().p_WB)
    assert np.abs(scripted.recording().p_WB[-1, 0]) > 0.1


@pytest.mark.slow
def test_a_push_long_ago_is_over():
    flown = session(duration=2.0)
    flown.push([5.0, 0.0, 0.0])
    flown.tick(1.0)
    assert flown.get("push_start") == 0.0
    flown.tick(9.0)
    assert np.linalg.norm(flown.recording().v_WB[-1]) < 1e-3


def turbulent(seed, turbulence=15.4):
    settings = {"wind_x": 5.0, "turbulence": turbulence}
    flown = session(settings, duration=3.0, sensors=SensorsConfig(seed=seed))
    flown.run()
    return flown


@pytest.mark.slow
def test_equal_seeds_give_equal_flights_to_the_bit():
    first = turbulent(1)
    again = first.recording().p_WB
    first.reset()
    first.run()
    assert np.array_equal(first.recording().p_WB, again)
    assert np.array_equal(turbulent(1).recording().p_WB, again)
    assert np.abs(turbulent(2).recording().p_WB - again).max() > 1e-3


def test_in_calm_air_the_seed_does_not_matter():
    one, other = (turbulent(seed, 0.0).recording() for seed in (1, 2))
    assert np.array_equal(one.p_WB, other.p_WB)
