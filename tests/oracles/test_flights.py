"""The flights that the workbench is held to, on the full diagram; figures are the demand's."""

import math
import re
from pathlib import Path

import numpy as np
import pytest

from workbench.control.mode import FlightMode
from workbench.scenario.scenario import Action, Scenario, ScenarioStart, VehicleConfig
from workbench.session.session import Session

ORACLES = Path(__file__).parent
HIGH = 10.0
FULL_SPEED = 8.0


def flown(**scenario):
    session = Session(Scenario(**scenario))
    session.run()
    return session.recording()


def at(time, **what) -> Action:
    return Action(at=time, **what)


@pytest.mark.slow
@pytest.mark.parametrize("heading", [0.0, -150.0])
def test_full_speed_level_and_back_to_hover(heading):
    ahead = [math.cos(math.radians(heading)), math.sin(math.radians(heading)), 0.0]
    flight = flown(
        duration=13.0,
        start=ScenarioStart(position=[0.0, 0.0, HIGH]),
        script=[
            at(1.0, velocity=[FULL_SPEED * part for part in ahead]),
            at(8.0, velocity=[0.0, 0.0, 0.0]),
        ],
    )
    cruise = flight.between(6.0, 8.0)
    assert cruise.v_WB @ ahead == pytest.approx(np.full(len(cruise.time), FULL_SPEED), rel=0.01)
    assert np.abs(flight.p_WB[:, 2] - HIGH).max() <= 0.3
    beside = np.cross([0.0, 0.0, 1.0], ahead)
    assert np.abs(flight.p_WB @ beside).max() <= 0.05
    assert flight.mode[-1] == FlightMode.HOVERING
    assert np.linalg.norm(flight.v_WB[-1]) < 0.01


@pytest.mark.slow
@pytest.mark.parametrize("rate", [0.4, -0.4])
def test_full_yaw_rate_is_held(rate):
    flight = flown(duration=6.0, script=[at(1.0, yaw_rate=rate)])
    turning = flight.between(3.0, 6.0).w_WB
    assert turning[:, 2] == pytest.approx(np.full(len(turning), rate), rel=0.01)
    assert np.abs(flight.p_WB - flight.p_WB[0]).max() <= 0.02


@pytest.mark.slow
def test_a_minute_of_hover_after_a_flight():
    """From a take-off and a stop out of 2 m/s, so that there is something to drift from."""
    flight = flown(
        duration=75.0,
        start=ScenarioStart(mode="off"),
        script=[
            at(0.0, request="take_off", height=2.0),
            at(6.0, velocity=[1.4, -1.4, 0.0]),
            at(8.0, velocity=[0.0, 0.0, 0.0]),
        ],
    )
    hover = flight.between(15.0, 75.0)
    assert set(hover.mode) == {float(FlightMode.HOVERING)}
    drift = np.linalg.norm(hover.p_WB - hover.p_WB[0], axis=1)
    assert drift.max() <= 0.02
    assert np.abs(hover.p_WB[-1, 2] - 2.0) < 0.1


def test_take_off_and_landing():
    height = 1.5
    flight = flown(
        duration=11.0,
        start=ScenarioStart(mode="off"),
        script=[at(0.0, request="take_off", height=height), at(5.0, request="land")],
    )
    feet = flight.p_WB[:, 2] - flight.vehicle.ground_clearance
    up = flight.between(4.0, 5.0)
    assert up.p_WB[:, 2] == pytest.approx(np.full(len(up.time), height), abs=0.05)
    assert flight.p_WB[:, 2].max() <= height + 0.05
    landed = int(np.flatnonzero((flight.time > 5.0) & (feet < 1e-3))[0])
    assert np.abs(flight.v_WB[landed - 1 : landed + 20, 2]).max() <= 0.5
    assert np.abs(feet[-1]) <= 0.005
    assert np.abs(feet[landed:]).max() <= 0.005  # neither bounce nor sinking in
    assert flight.mode[-1] == FlightMode.OFF
    assert np.abs(flight.thrusts[-1]).max() < 1e-3
    assert np.hypot(*flight.p_WB[-1, :2]) <= 0.02


@pytest.mark.slow
@pytest.mark.parametrize(
    ("rpy", "spin"),
    [
        ((math.pi, 0, 0), (3, 3, 3)),
        ((0, math.pi, 0), (-3, 3, -3)),
        ((math.pi - 0.3, 0.3, 2.0), (3, -3, 3)),
        ((math.pi, 0, 0), (-3, -3, -3)),
    ],
)
def test_thrown_upside_down_it_recovers(spin, rpy):
    flight = flown(
        duration=8.0,
        start=ScenarioStart(
            position=[0.0, 0.0, HIGH],
            roll_pitch_yaw=[float(angle) for angle in rpy],
            angular_velocity=[float(rate) for rate in spin],
        ),
    )
    assert flight.tilt[0] > 2.5
    feet = flight.p_WB[:, 2] - flight.vehicle.ground_clearance
    assert feet.min() > 1.0
    assert flight.mode[-1] == FlightMode.HOVERING
    assert flight.tilt[-1] < 0.01
    assert np.linalg.norm(flight.v_WB[-1]) < 0.05
    assert np.linalg.norm(flight.w_WB[-1]) < 0.01


@pytest.mark.slow
@pytest.mark.parametrize("velocity", [2.0, -2.0])
def test_a_step_along_x_leaves_height_and_y_alone(velocity):
    flight = flown(
        duration=6.0,
        start=ScenarioStart(position=[0.0, 0.0, HIGH]),
        script=[at(1.0, velocity=[velocity, 0.0, 0.0])],
    )
    assert flight.v_WB[-1, 0] == pytest.approx(velocity, rel=0.01)
    assert np.abs(flight.p_WB[:, 2] - HIGH).max() <= 0.05
    assert np.abs(flight.p_WB[:, 1]).max() <= 0.01


@pytest.mark.slow
def test_a_square_of_waypoints_is_reached():
    corners = [[2.0, 0.0, 3.0], [2.0, 2.0, 3.0], [0.0, 2.0, 3.0], [0.0, 0.0, 3.0]]
    each = 6.0
    script = [at(each * index, go_to=corner) for index, corner in enumerate(corners)]
    flight = flown(
        duration=4.0 * each, start=ScenarioStart(position=[0.0, 0.0, 3.0]), script=script
    )
    for index, corner in enumerate(corners):
        there = flight.between(each * index + each - 0.1, each * index + each)
        assert there.p_WB[0] == pytest.approx(corner, abs=0.02)


@pytest.mark.slow
@pytest.mark.parametrize("compensation", [0.6, 0.0])
def test_hover_commands_follow_the_battery_over_a_whole_discharge(tmp_path, compensation):
    """Hover takes the same thrust from each rotor to the end, so the charge falls evenly.

    Rotors go to voltage times command, so to hold speeds w in hover the law commands w over the
    voltage; where commands are raised for the share c of the sag, it has to command less.
    """
    duration, resistance, capacity, full = 20.0, 0.06, 300.0, 12.6
    text = (ORACLES / "effects.rotors.yaml").read_text(encoding="utf-8")
    points = [[0.0, 10.8], [0.8, 12.0], [1.0, full]]
    battery = f"battery: {{capacity: {capacity}, resistance: {resistance}, "
    battery += f"open_circuit_voltage: {points}}}"
    sidecar = tmp_path / "battery.rotors.yaml"
    sidecar.write_text(re.sub("battery: .*", battery, text), encoding="utf-8")
    config = VehicleConfig(str(ORACLES / "uneven_quad.urdf"), rotors=str(sidecar))
    settings = {
        "battery_duration": duration,
        "battery_reserve": 0.0,
        "sag_compensation": compensation,
    }
    start = ScenarioStart(position=[0.0, 0.0, 50.0])
    session = Session(Scenario(vehicle=config, start=start, duration=0.95 * duration), settings)
    session.run()
    flight = session.recording()
    for time in (2.0, 4.0, 10.0, 18.5):
        now = flight.between(time, time + 0.1)
        charge = 1.0 - now.time[0] / duration
        drop = resistance * capacity / duration
        voltage = (np.interp(charge, *zip(*points, strict=True)) - drop) / full
        wanted = session.vehicle.hover_speeds / voltage * (1.0 + compensation * (voltage - 1.0))
        assert now.charge[0] == pytest.approx(charge, abs=0.005)
        assert now.commanded_speeds[0] == pytest.approx(wanted, rel=0.01)


@pytest.mark.slow
def test_an_empty_battery_lands_in_time():
    """A battery of 30 s at a reserve of 60 %: 12 s of hover, 3.4 s down from 1.5 m, off."""
    session = Session(Scenario(duration=20.0), {"battery_duration": 30.0, "battery_reserve": 0.6})
    session.run()
    flight = session.recording()
    landing = flight.time[int(np.argmax(flight.mode == FlightMode.LANDING))]
    assert landing == pytest.approx(12.0, abs=0.3)
    assert flight.mode[-1] == FlightMode.OFF
    assert flight.charge[-1] > 0.4
