"""Flights in compiled code; the oracle is Drake's Simulator on the same diagram."""

import math
from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pytest

from workbench.common.errors import FlightBrokenError, WorkbenchError
from workbench.control.mode import FlightMode
from workbench.controllers import pd
from workbench.plant.variation import Variation
from workbench.scenario.scenario import (
    Action,
    FigureEight,
    Gust,
    Injection,
    Push,
    Rates,
    Scenario,
    SensorsConfig,
    Start,
    VehicleConfig,
)
from workbench.session.session import Session
from workbench.systems.bridge import Bridge

TESTS = Path(__file__).resolve().parents[1]
EFFECTS = VehicleConfig(
    str(TESTS / "oracles" / "uneven_quad.urdf"),
    rotors=str(TESTS / "oracles" / "effects.rotors.yaml"),
)
SCRIPT = [
    Action(0.3, velocity=[2.0, -1.0, 0.5], yaw_rate=0.4),
    Action(0.7003, set={"wind_x": 3.0, "turbulence": 4.0}),
    Action(1.0, push=Push([0.0, 6.0, 1.0], [0.1, 0.0, 0.0], 0.2, [0.05, 0.0, 0.0])),
    Action(1.2, gust=Gust([2.0, 0.0, 1.0], 0.7)),
    Action(1.5, set={"rotor_2": 0.7, "kp_velocity_x": 3.0, "gyro_lowpass": 60.0}),
    Action(1.9, velocity=[0.0, 0.0, 0.0], yaw_rate=0.0),
    Action(2.2, set={"payload_mass": 0.1, "payload_x": 0.05, "known_payload_mass": 0.1}),
    Action(2.8, go_to=[1.0, 1.0, 0.8]),
    Action(3.5, request="land"),
    Action(6.5, request="take_off", height=1.0),
    Action(8.0, set={"rotor_1": 0.0}),
]
"""Everything that a flight may be asked for, with a landing, a take-off and a crash."""


def assert_same(one: Session, other: Session):
    """To the bit: what was recorded, what is shown, and what decides how it goes on."""
    a, b = one.recording(), other.recording()
    for field in fields(a):
        x, y = getattr(a, field.name), getattr(b, field.name)
        if field.name != "vehicle":
            assert np.array_equal(x, y, equal_nan=True), field.name
    assert one.snapshot() == other.snapshot()
    assert one.checkpoint() == other.checkpoint()


@pytest.mark.parametrize("slices", [1, pytest.param(768, id="slices that cut control periods")])
def test_a_flight_is_that_of_the_diagram_to_the_bit(slices):
    scenario = Scenario(script=SCRIPT, duration=9.0)
    flown, compiled = Session(scenario), Session(scenario, engine="compiled")
    flown.tick(9.0)
    for _ in range(slices):
        compiled.tick(9.0 / slices)
    assert_same(flown, compiled)
    assert FlightMode.LANDING in flown.recording().mode
    assert flown.recording().p_WB[-1, 2] < 0.5  # it crashed
    both = flown, compiled
    for session in both:
        session.reset()
        session.tick(0.4)
    assert_same(*both)


@pytest.mark.parametrize(
    "scenario",
    [
        Scenario(vehicle=EFFECTS, start=Start(position=[0.0, 0.0, 3.0], velocity=[1.0, 0.0, -0.5])),
        Scenario(
            rates=Rates(1 / 512, 1 / 64, 1 / 16, 1 / 512), start=Start(roll_pitch_yaw=[2.5, 0.4, 1])
        ),
        Scenario(start=Start(mode="off"), script=[Action(0.1, request="take_off")]),
        *(
            pytest.param(Scenario(controller=law), marks=pytest.mark.slow, id=law)
            for law in ("crazyflie", "px4", "lqi")
        ),
    ],
    ids=lambda each: each if isinstance(each, str) else "",
)
def test_so_are_those_of_other_vehicles_rates_and_laws(scenario):
    """A battery that sags, inflow and ground effect; a record at each step; from the ground."""
    script = [Action(0.5, velocity=[1.0, 0.5, 0.2]), *scenario.script]
    scenario = replace(scenario, script=script, duration=2.0)
    both = Session(scenario), Session(scenario, engine="compiled")
    for session in both:
        session.run()
    assert_same(*both)


def test_either_goes_on_from_a_checkpoint_of_the_other():
    flown, compiled = Session(), Session(engine="compiled")
    for one, other in ((flown, compiled), (compiled, flown)):
        one.reset()
        one.command([1.0, 0.0, 0.3], 0.2)
        one.tick(0.7)
        other.begin_from(one.checkpoint())
        for session in (one, other):
            session.command([0.0, 0.0, 0.0], 0.0)
            session.tick(0.9)
        assert one.checkpoint() == other.checkpoint()


def test_what_python_does_to_a_law_is_done_there_too(tmp_path):
    """A multisine at a loop point, and an interpreted law."""
    injection = Injection("pitch_error", 0.02, 20.0, 60.0, 3)
    both = Session(), Session(engine="compiled")
    for session in both:
        session.command([0.5, 0.0, 0.0])
        session.inject(injection)
        session.tick(1.0)
        session.run_law(interpreted=True)
        session.tick(0.2)
        session.run_law(interpreted=False)
        session.tick(0.3)
    assert_same(*both)
    one, other = (session.loop_signals() for session in both)
    assert np.array_equal(one, other)


def test_what_it_does_not_fly_is_said(case):
    delayed = VehicleConfig(variation=Variation(sensing_delay=0.003))
    table = [
        (Scenario(estimator="ekf"), "the estimator ekf"),
        (Scenario(sensors=SensorsConfig(use=["imu"])), "the sensors imu"),
        (Scenario(world="room"), "the obstacles of room"),
        (Scenario(figure_eight=FigureEight()), "a figure of eight"),
        (Scenario(vehicle=delayed), "delays"),
        (Scenario(rates=Rates(0.003, 0.006, 0.024, 0.006)), "a physics step of 0.003 s"),
    ]
    for scenario, said in table:
        with case(said), pytest.raises(WorkbenchError, match=f"does not support {said}"):
            Session(scenario, engine="compiled")
    with pytest.raises(WorkbenchError, match="does not support clients"):
        Session(bridge=Bridge(), engine="compiled")
    with pytest.raises(WorkbenchError, match="'fast'.*diagram"):
        Session(engine="fast")


def test_either_compiles_what_it_can_and_what_seldom_changes(case, tmp_path):
    """Machine code of a flight is made for a shipped law, and not for each edit of one's own."""
    own = tmp_path / "own.py"
    own.write_text(f"{Path(pd.__file__).read_text(encoding='utf-8')}# edited\n", "utf-8")
    table = [
        (Scenario(), True),
        (Scenario(estimator="ekf"), False),
        (Scenario(world="room"), False),
        (Scenario(controller=str(own)), False),
        (Scenario(controller="pd@speed=0,3.7"), False),
    ]
    for scenario, compiled in table:
        with case(scenario):
            session, diagram = Session(scenario, engine="either"), Session(scenario)
            assert (session._compiled is not None) is compiled
            if compiled:
                for each in (session, diagram):
                    each.command([1.0, 0.0, 0.0])
                    each.tick(0.5)
                assert_same(session, diagram)


def test_a_session_that_follows_another_script_flies_as_a_new_one():
    scripts = [[Action(at=0.2, velocity=[1.0, 0.5, 0.2])], [Action(at=0.3, yaw_rate=0.4)]]
    again = Session(Scenario(script=scripts[0], duration=1.0), engine="compiled")
    again.run()
    for script in scripts[::-1]:
        again.follow(script, again.scenario.duration)
        again.run()
        new = Session(Scenario(script=script, duration=1.0))
        new.run()
        assert_same(new, again)
    with pytest.raises(WorkbenchError, match="rotor_9"):
        again.follow([Action(at=0.1, set={"rotor_9": 0.5})], 1.0)


def test_a_flight_that_breaks_off_is_said_and_recorded_until_then():
    session = Session(engine="compiled")
    session.tick(0.5)
    numbers = session.checkpoint()
    path = next(path for path in numbers.systems if path.endswith("dynamics"))
    there = numbers.systems[path]
    speeds = (*there.state[1][:-8], *[math.nan] * 4, *there.state[1][-4:])
    broken = {**numbers.systems, path: replace(there, state=(there.state[0], speeds))}
    session.begin_from(replace(numbers, systems=broken))
    with pytest.raises(FlightBrokenError, match=r"broke off after 0.5\d* s: .*are not finite"):
        session.tick(1.0)
