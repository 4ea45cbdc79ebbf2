"""Autopilots' defaults fly the vehicles that they are made for, as docs/autopilots.md says.

Published vehicles are read from ../shared/models, where they are at hand.
"""

import math
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from workbench.control.controller_file import load_controller
from workbench.design.hover_check import check_hover
from workbench.design.judge.margins import loop_margins
from workbench.design.linear.study import LinearStudy
from workbench.gains.gain_choice import rule_gains
from workbench.plant.loading import load_vehicle
from workbench.scenario.scenario import Scenario, ScenarioStart, VehicleConfig
from workbench.session.session import Session

TESTS = Path(__file__).resolve().parents[3]
SHARED = TESTS.parent / "../shared/models"
X500 = SHARED / "px4_gazebo_models/x500/model.sdf"
VEHICLES = {
    "px4": X500,
    "ardupilot": X500,
    "betaflight": TESTS / "drones/five_inch_quad.urdf.xacro",
    "crazyflie": SHARED / "gym_pybullet_drones/cf2x.urdf",
}
GAINS = {
    "px4": "MC_|MPC_(XY|Z)_",
    "ardupilot": "ATC_|PSC_|INS_",
    "betaflight": "[pid]_|d_max|angle|gyro|dterm|tpa|anti|iterm",
    "crazyflie": "pid_|posCtlPid|velCtlPid",
}
"""Names of those parameters that no rule may touch on such a vehicle."""
DRIFT, TILT, OVERSHOOT = 0.2, math.radians(2.0), 25.0
"""At most [m, rad, %]."""
YAW_OVERSHOOT = 40.0
"""The heading that is held has to be caught up with [%]."""
PAGE = (TESTS.parent / "docs/autopilots.md").read_text(encoding="utf-8")


def scenario(law, **more):
    path = VEHICLES[law]
    if not path.exists():
        pytest.skip(f"put the published {path.parent.name} into ../shared/models")
    return Scenario(controller=law, vehicle=VehicleConfig(model=str(path)), **more)


def stated(law):
    """Return the numbers of a law's row of the page's table, each as it is written."""
    (row,) = re.findall(rf"^\| `{law}`, [^|]+\|(.*)\|$", PAGE, re.MULTILINE)
    return re.findall(r"\d+\.?\d*", row)


@pytest.mark.slow
@pytest.mark.parametrize("law", VEHICLES)
def test_their_gains_are_the_firmware_s_and_hold_the_place(law):
    """Nudged and pushed."""
    flight = scenario(law, start=ScenarioStart(position=[0.0, 0.0, 10.0]))
    controller = load_controller(law)
    ruled = rule_gains(load_vehicle(VEHICLES[law]), controller)
    stock = {
        row.name: row.default for row in controller.parameters if re.match(GAINS[law], row.name)
    }
    assert len(stock) > 5
    assert {name: ruled.get(name, default) for name, default in stock.items()} == stock
    session = Session(flight)
    session.go_to([0.0, 0.0, 10.0])
    session.push([0.05 * session.vehicle.mass, 0.0, 0.0], duration=0.2)
    session.tick(2.0)
    state = session.state()
    assert np.linalg.norm(state[4:7] - [0.0, 0.0, 10.0]) < 0.05
    assert 2.0 * math.hypot(*state[1:3]) < TILT


def test_a_5_inch_quad_whose_rotors_have_no_inertia_keeps_betaflights_roll_and_pitch():
    """Only yaw has its torque from that inertia; the default `i_yaw` makes it swing without."""
    quad = load_vehicle(VEHICLES["betaflight"])
    rotors = tuple(replace(each, inertia=0.0) for each in quad.rotors)
    ruled = rule_gains(replace(quad, rotors=rotors), load_controller("betaflight"))
    turned = {"p_roll", "i_roll", "d_roll", "p_pitch", "i_pitch", "d_pitch", "angle_p_gain"}
    assert not turned & ruled.keys()
    assert ruled["p_yaw"] < 15.0 and ruled["i_yaw"] < 5.0


def check_stated(law, first, found):
    """Hold numbers against those of the page from a column on; the last digit may be rounded."""
    for number, value in zip(stated(law)[first:], found, strict=False):
        last = 10.0 ** -len(number.partition(".")[2])
        assert float(number) == pytest.approx(value, abs=0.6 * last)


@pytest.mark.parametrize("law", VEHICLES)
def test_their_margins_are_those_of_the_page(law):
    model = LinearStudy(scenario(law)).sampled()
    margins = loop_margins(model, load_controller(law).loop("roll_rate").point("actuator"))
    phase = math.degrees(margins.phase_margin)
    check_stated(law, 5, [margins.gain_margin, phase, margins.crossover])


@pytest.mark.slow
@pytest.mark.parametrize("law", ["px4", "ardupilot"])
def test_they_hover_and_step_as_the_page_says(law):
    report = check_hover(scenario(law))
    assert report.drift.max() < DRIFT and report.tilt.max() < TILT
    steps = {step.axis: step.metrics for step in report.steps}
    for axis in "xyz":
        assert steps[axis].overshoot < OVERSHOOT
    assert steps["yaw"].overshoot < YAW_OVERSHOOT
    found = [
        *(each for axis in "xz" for each in (steps[axis].rise_time, steps[axis].overshoot)),
        steps["yaw"].overshoot,
    ]
    check_stated(law, 0, found)
