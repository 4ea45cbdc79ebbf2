"""A flight that goes on from a checkpoint equals the flight that it was taken from, to the bit."""

import dataclasses
import pickle

import pytest

from workbench.common.errors import WorkbenchError
from workbench.control.mode import FlightMode
from workbench.plant.variation import Variation
from workbench.scenario.scenario import (
    Action,
    FigureEight,
    Gust,
    Push,
    Rates,
    Scenario,
    ScenarioStart,
    SensorsConfig,
    VehicleConfig,
)
from workbench.session.checkpoint import Checkpoint
from workbench.session.recording import Recording
from workbench.session.session import Session
from workbench.systems.bridge import Bridge

PERIOD = Rates().control_period
AFTER = 2.0
"""Flown from the checkpoint on [s]."""

STEERED = [Action(at=0.2, velocity=[1.0, -0.5, 0.3], yaw_rate=0.3), Action(at=2.0, yaw_rate=-0.2)]
GUSTY = Action(set={"turbulence": 5.0, "wind_x": 2.0, "wind_y": -1.0})
GUST = Action(at=0.9, gust=Gust([3.0, 1.0, 0.0], 1.0))
PUSH = Action(at=1.1, push=Push([0.0, 2.0, 0.0], [0.1, 0.0, 0.0], 0.5))
TAKE_OFF = Action(at=0.1, request="take_off", height=1.0)
LAND = Action(at=0.5, request="land")
LATE = VehicleConfig(variation=Variation(mass=1.1, rotor_lag=1.3, control_delay=3))
WEAK = Action(at=0.5, set={"rotor_2": 0.8, "kp_roll": 70.0})
ROUGH_RATES = Rates(physics_step=0.001, control_period=0.007, mode_period=0.12, record_period=0.01)
WALL = Action(velocity=[0.0, 2.0, 0.0], set={"obstacle_brake": 1.5})

CASES = {
    "at its very start": (Scenario(script=STEERED), 0.0),
    "on the control grid": (Scenario(script=STEERED), 1.0),
    "on the mode's and the battery's grid, at a step of the script": (
        Scenario(script=STEERED),
        2.0,
    ),
    "a period before an update of the flight mode": (Scenario(script=STEERED), 1.0 - PERIOD),
    "with time owed": (Scenario(script=STEERED), 1.2345),
    "in a gust, with turbulence and a push": (
        Scenario(script=[GUSTY, GUST, PUSH, *STEERED], sensors=SensorsConfig(seed=7)),
        1.3 + 0.4 * PERIOD,
    ),
    "while the rotors spool up": (
        Scenario(start=ScenarioStart(mode="off"), script=[TAKE_OFF]),
        0.4,
    ),
    "in take-off": (Scenario(start=ScenarioStart(mode="off"), script=[TAKE_OFF]), 1.5),
    "during a landing": (Scenario(script=[*STEERED, LAND]), 1.501),
    "as it touches down": (Scenario(start=ScenarioStart(position=[0, 0, 0.4]), script=[LAND]), 2.0),
    "with a late controller": (Scenario(vehicle=LATE, script=STEERED), 1.003),
    "with a weak rotor": (Scenario(script=[WEAK, *STEERED]), 1.7),
    "during a figure of eight": (Scenario(figure_eight=FigureEight()), 3.3),
    "on its way to a place": (Scenario(script=[Action(at=0.3, go_to=[1.0, 1.0, 2.0])]), 0.8),
    "near walls": (Scenario(world="room", script=[WALL]), 0.7),
    "near walls, as they are measured": (Scenario(world="room", script=[WALL]), 0.6875 - PERIOD),
    "near what moves": (Scenario(world="moving_obstacle", script=[WALL]), 0.7),
    "with periods that are not exact": (Scenario(rates=ROUGH_RATES, script=STEERED), 0.847),
}


def watched(scenario: Scenario) -> Session:
    """Return a session with a bridge and sensors: integration steps end where these sample."""
    sensors = dataclasses.replace(scenario.sensors, use=["imu", "gps"])
    return Session(dataclasses.replace(scenario, sensors=sensors), bridge=Bridge())


def flown_to(scenario: Scenario, time: float) -> Session:
    """Return such a session, flown in uneven ticks."""
    session = watched(scenario)
    for share in (0.31, 0.36, 0.33):
        session.tick(share * time)
    return session


def sent(checkpoint: Checkpoint) -> Checkpoint:
    """Return it as another process receives it."""
    return pickle.loads(pickle.dumps(checkpoint))


ON_THE_GROUND = ("while the rotors spool up", "as it touches down")
"""Cases in which CENIC flies, which keeps the size of its last step outside the Context."""


def assert_equal_from(time: float, flight: Recording, fork: Recording) -> None:
    for field in dataclasses.fields(Recording):
        if field.name != "vehicle":
            flown = getattr(flight, field.name)[flight.time >= time]
            assert len(flown) > 100, field.name
            assert flown.tobytes() == getattr(fork, field.name).tobytes(), field.name


@pytest.mark.slow
@pytest.mark.parametrize(
    ("scenario", "time"),
    [pytest.param(*case, id=name) for name, case in CASES.items() if name not in ON_THE_GROUND],
)
def test_a_flight_goes_on_from_an_instant_to_the_bit(scenario, time):
    flight, fork = flown_to(scenario, time), watched(scenario)
    checkpoint = flight.checkpoint()
    fork.begin_from(sent(checkpoint))
    assert fork.checkpoint() == checkpoint
    assert fork.time == flight.time
    for session in (flight, fork):
        session.tick(AFTER)
    assert_equal_from(checkpoint.time, flight.recording(), fork.recording())
    assert fork.checkpoint() == flight.checkpoint()
    assert fork.checkpoint() != checkpoint


@pytest.mark.slow
@pytest.mark.parametrize("name", ON_THE_GROUND)
def test_on_the_ground_it_goes_on_to_a_tenth_of_a_millimetre(name):
    scenario, time = CASES[name]
    flight, fork = flown_to(scenario, time), watched(scenario)
    fork.begin_from(sent(flight.checkpoint()))
    for session in (flight, fork):
        session.tick(AFTER)
    assert fork.state() == pytest.approx(flight.state(), abs=1e-4)


@pytest.mark.slow
def test_what_a_case_is_named_after_is_so():
    """The checkpoints above lie where they are said to."""
    modes = {
        "while the rotors spool up": FlightMode.ARMED,
        "in take-off": FlightMode.TAKING_OFF,
        "during a landing": FlightMode.LANDING,
        "as it touches down": FlightMode.LANDING,
    }
    for name, mode in modes.items():
        assert flown_to(*CASES[name]).snapshot().mode is mode, name
    gusty = flown_to(*CASES["in a gust, with turbulence and a push"])
    assert gusty.snapshot().wind[0] > 3.0
    assert flown_to(*CASES["near walls"]).snapshot().clearance.distance < 3.0


def test_a_session_goes_on_from_instants_again_and_again_and_from_its_start():
    scenario = Scenario(script=STEERED)
    flight, fork = flown_to(scenario, 1.0), watched(scenario)
    checkpoint = flight.checkpoint()
    flight.tick(0.3)
    later = flight.checkpoint()
    fork.begin_from(checkpoint)
    fork.tick(1.1)
    fork.set("kp_roll", 10.0)
    fork.begin_from(checkpoint)
    fork.tick(0.3)
    assert fork.checkpoint() == later
    fork.reset()
    fork.tick(1.0)
    assert fork.checkpoint() == checkpoint


def test_what_the_pilot_asks_for_is_in_the_instant():
    session = Session()
    session.command([0.5, 0.0, -0.25], 0.125)
    checkpoint = session.checkpoint()
    assert checkpoint.velocity == (0.5, 0.0, -0.25)
    assert checkpoint.yaw_rate == 0.125


def test_a_script_that_was_ended_stays_so_and_counts_what_it_ordered():
    session = flown_to(Scenario(script=STEERED), 0.5)
    session.do(Action(request="hold", end_script=True))
    checkpoint = sent(session.checkpoint())
    assert checkpoint.acted == 1
    other = Session(Scenario(script=STEERED))
    other.begin_from(checkpoint)
    other.tick(AFTER)
    assert list(other.script) == [STEERED[0]]
    other.begin_from(dataclasses.replace(checkpoint, script_ended=False))
    assert other.next_action == STEERED[1]


def test_parameters_are_those_of_the_instant():
    flight, fork = Session(), Session()
    fork.set("kd_roll", 3.0)
    for name, value in (("kp_roll", 77.0), ("rotor_3", 0.5), ("wind_y", 4.0), ("max_speed", 3.0)):
        flight.set(name, value)
    fork.begin_from(flight.checkpoint())
    for name in ("kp_roll", "rotor_3", "wind_y", "max_speed", "kd_roll"):
        assert fork.get(name) == flight.get(name), name


def test_nothing_before_the_instant_is_recorded():
    flight, fork = flown_to(Scenario(), 0.5), Session()
    fork.tick(2.0)
    fork.begin_from(flight.checkpoint())
    assert list(fork.recording().time) == [0.5]


def test_a_session_with_a_bridge_and_sensors_may_go_on_too():
    """Where other sensors sample, integration steps end elsewhere: to a nanometre."""
    scenario = Scenario(script=STEERED, sensors=SensorsConfig(use=["imu"]))
    flight, fork = flown_to(scenario, 1.0), Session(scenario, bridge=Bridge())
    fork.tick(0.5)
    fork.begin_from(flight.checkpoint())
    for session in (flight, fork):
        session.tick(1.0)
    assert fork.state() == pytest.approx(flight.state(), rel=1e-8, abs=1e-8)
    assert all(sampled.published.t_ns >= 1_000_000_000 for sampled in fork.drain())
    assert fork.reading("imu").stamp == flight.reading("imu").stamp


@pytest.mark.parametrize(
    "other", [Scenario(world="room"), Scenario(vehicle=LATE)], ids=["world", "delay"]
)
def test_an_instant_of_another_flight_is_refused(other):
    session = Session(other)
    with pytest.raises(WorkbenchError, match="belongs to another flight"):
        session.begin_from(Session().checkpoint())
    session.tick(0.1)
    assert session.time == 0.1 - 0.1 % PERIOD
