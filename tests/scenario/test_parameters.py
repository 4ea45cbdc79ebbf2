"""Oracle: the table itself, and the flight that reads it."""

import math
from functools import partial

import numpy as np
import pytest

from workbench.common.errors import WorkbenchError
from workbench.control.controller_file import load_controller
from workbench.control.flight_law import UNFILTERED_COMPUTER, ComputerSettings
from workbench.control.flight_mode import FlightModeSettings
from workbench.dynamics.air.settings import AirSettings
from workbench.estimation.gyro import GyroSettings
from workbench.estimation.settings import (
    ESTIMATORS,
    TRUTH,
    ComplementarySettings,
    EkfSettings,
)
from workbench.gains.gain_choice import flight_gains
from workbench.parameters.parameter_table import split_setting
from workbench.plant.payload import Payload
from workbench.plant.sensors import CORE_SENSORS, sensor_kinds
from workbench.scenario.scenario import Action, Scenario, ScenarioStart, SensorsConfig
from workbench.session.session import Session

TABLE = load_controller().table
NAMES = [row.name for row in TABLE]
NEVER = [row.name for row in (*TABLE.of("rotors")[4:], *TABLE.of("cables"))]
"""Rows that no flight of a quadrotor without cables has."""
KINDS = [each.kind for each in CORE_SENSORS]
"""The shipped drone has a sensor of each."""
SOMETIMES = [row.name for row in TABLE if row.system in (*KINDS, "obstacles")]
"""Rows of systems that a flight without sensors in an empty world does not have."""
NOT_FLOWN = (*ESTIMATORS, "gauge", *(set(sensor_kinds()) - set(KINDS)))
FLOWN = [row for row in TABLE if row.name not in NEVER and row.system not in NOT_FLOWN]
FLOWN_NAMES = [row.name for row in FLOWN]


def full(settings=None, estimator=TRUTH) -> Session:
    """Return a flight with all sensors, in a world with obstacles: it has every row.

    But for those of the estimators that do not fly.
    """
    scenario = Scenario(
        world="room",
        estimator=estimator,
        start=ScenarioStart(position=[0.0, 0.0, 5.0]),
        script=[Action(at=0.1, velocity=[1.0, 1.0, 1.0], yaw_rate=0.2)],
        sensors=SensorsConfig(use=["all"], rates={"depth_camera": 2.0, "lidar": 2.0}),
    )
    return Session(scenario, settings)


@pytest.fixture(scope="module")
def session():
    return full()


@pytest.fixture(scope="module")
def plain_session():
    return Session()


def test_names_are_unique():
    assert len(set(NAMES)) == len(NAMES)


def test_a_row_is_complete_and_its_default_allowed(case):
    for row in TABLE:
        with case(row):
            assert -math.inf < row.minimum < row.maximum < math.inf
            assert row.minimum <= row.default <= row.maximum
            assert row.unit
            assert row.help
            assert row.check(row.default) == row.default


def test_rows_stand_in_the_order_that_their_system_reads_them():
    assert TABLE.of("controller") == load_controller().parameters
    assert tuple(row.name for row in TABLE.of("modes")) == FlightModeSettings._fields
    assert tuple(row.name for row in TABLE.of("payload")) == Payload._fields
    assert [row.name for row in TABLE.of("battery")] == ["battery_duration", "sag_compensation"]
    assert tuple(row.name for row in TABLE.of("air")) == AirSettings._fields
    assert GyroSettings(**{row.name: row.default for row in TABLE.of("gyro")}) == GyroSettings()
    assert (
        ComputerSettings(**{row.name: row.default for row in TABLE.of("computer")})
        == UNFILTERED_COMPUTER
    )
    assert EkfSettings(**{row.name: row.default for row in TABLE.of("ekf")}) == EkfSettings()
    own = {row.name: row.default for row in TABLE.of("complementary")}
    assert ComplementarySettings(**own) == ComplementarySettings()
    assert tuple(row.name for row in TABLE.of("ekf")) == EkfSettings._fields
    assert tuple(own) == ComplementarySettings._fields
    assert tuple(row.name for row in TABLE.of("gyro")) == GyroSettings._fields
    assert tuple(row.name for row in TABLE.of("computer")) == ComputerSettings._fields
    rotors = [row.name for row in TABLE.of("rotors")]
    assert rotors == [f"rotor_{number}" for number in range(1, 13)]
    systems = ("controller", "modes", "battery", "air", "payload", "cables", "obstacles", "rotors")
    systems += ("gauge", "gyro", "computer", "ekf", "complementary", *sensor_kinds())
    assert sum(len(TABLE.of(system)) for system in systems) == len(TABLE.rows)


def test_a_row_is_read_and_written_alone(case, session):
    for row in FLOWN:
        with case(row):
            session.reset()
            before = {name: session.get(name) for name in FLOWN_NAMES}
            values = {**TABLE.defaults(), **flight_gains(session.vehicle)}
            assert before == {name: values[name] for name in FLOWN_NAMES}
            for value in (row.minimum, row.maximum):
                session.set(row.name, value)
                assert {name: session.get(name) for name in FLOWN_NAMES} == {
                    **before,
                    row.name: value,
                }


@pytest.mark.parametrize("end", ["minimum", "maximum"])
def test_every_row_is_built_with_the_value_that_is_asked(end):
    values = {row.name: getattr(row, end) for row in FLOWN}
    # a law that knows of a payload this far off could not hover; of its mass alone it could
    values |= {"payload_x": 0.0, "payload_y": 0.0}
    session = full(values)
    assert {name: session.get(name) for name in FLOWN_NAMES} == values
    for name in FLOWN_NAMES:
        session.set(name, TABLE.find(name).default)
    session.reset()
    assert {name: session.get(name) for name in FLOWN_NAMES} == values


@pytest.mark.parametrize("estimator", ["ekf", "complementary"])
def test_rows_of_an_estimator_are_those_of_flights_on_it(case, estimator, plain_session):
    rows = TABLE.of(estimator)
    built = {row.name: row.maximum for row in rows}
    session = full(built, estimator)
    assert {row.name: session.get(row.name) for row in rows} == built
    for row in rows:
        with case(row):
            session.reset()
            session.set(row.name, row.minimum)
            assert {each.name: session.get(each.name) for each in rows} == {
                **built,
                row.name: row.minimum,
            }
            session.tick(0.125)  # the GPS has spoken once
            assert np.isfinite(session.state()).all()
            with pytest.raises(WorkbenchError, match=f"--estimator {estimator}"):
                plain_session.get(row.name)


@pytest.mark.slow
def test_every_allowed_value_flies(case, session):
    """Not well, perhaps; but what is allowed must not break off or give no number."""
    for end in ["minimum", "maximum"]:
        for row in FLOWN:
            with case(end, row):
                session.reset()
                session.set(row.name, getattr(row, end))
                session.tick(0.25)
                flight = session.recording()
                assert flight.time[-1] == 0.25
                for values in (flight.p_WB, flight.q_WB, flight.w_WB, flight.thrusts):
                    assert np.isfinite(values).all()


def test_what_nothing_in_the_flight_has_is_answered_with_a_remedy(case, plain_session):
    for name in [*SOMETIMES, *NEVER]:
        with case(name):
            remedies = {"warning_distance": "--world room"}
            remedies |= {row.name: f"--sensors {kind}" for kind in KINDS for row in TABLE.of(kind)}
            remedies |= dict.fromkeys(NEVER, "dh_drone has 4 rotors")
            remedies |= {row.name: "dh_drone has no cables" for row in TABLE.of("cables")}
            value = TABLE.find(name).maximum
            for act in (partial(plain_session.set, name, value), partial(plain_session.get, name)):
                with pytest.raises(WorkbenchError) as caught:
                    act()
                said = str(caught.value)
                assert said.startswith(f"{name} cannot be set: ")
                assert remedies[name] in said
                assert "\n" not in said


@pytest.mark.parametrize(("name", "value"), [("imu_fault", 1.0), ("rotor_5", 0.5)])
def test_a_fault_ordered_of_what_is_not_there_is_refused_before_the_flight(name, value):
    with pytest.raises(WorkbenchError, match=f"{name} cannot be set"):
        Session(Scenario(), {name: value})


def test_rows_that_nothing_has_may_keep_their_defaults():
    """So that a gain file with every row of the table can be flown with any drone."""
    defaults = {name: TABLE.find(name).default for name in (*SOMETIMES, *NEVER)}
    assert Session(Scenario(), defaults).parameters().keys().isdisjoint(defaults)


def eventful() -> Session:
    """Return a flight that asks for everything: speed, turn, waypoint, landing."""
    script = [
        Action(at=0.0, velocity=[2.0, -2.0, 1.0], yaw_rate=0.3),
        Action(at=0.4, velocity=[0.0, 0.0, 0.0]),
        Action(at=0.5, go_to=[1.0, 1.0, 3.0]),
        Action(at=0.8, request="land"),
    ]
    return Session(Scenario(start=ScenarioStart(position=[0.0, 0.0, 2.0]), script=script))


def motion(session) -> np.ndarray:
    session.tick(1.0)
    flight = session.recording()
    return np.hstack([flight.v_WB, flight.w_WB])


@pytest.fixture(scope="module")
def eventful_motion():
    return motion(eventful())


@pytest.mark.slow
def test_every_row_of_the_controller_is_of_effect(case, eventful_motion):
    """Limits at a value that cuts, gains at half."""
    for row in TABLE.of("controller"):
        with case(row):
            limits = {
                "max_speed": 1.0,
                "max_climb_rate": 0.5,
                "max_height": 2.0,
                "max_tilt": 0.1,
                "max_yaw_rate": 0.1,
            }
            session = eventful()
            session.set(row.name, limits.get(row.name, 0.5 * session.get(row.name)))
            assert np.abs(motion(session) - eventful_motion).max() > 1e-3


def test_the_drone_takes_off_even_with_the_least_pull_to_a_height():
    least = TABLE.find("kp_position_z").minimum
    script = [Action(at=0.0, request="take_off", height=1.0)]
    scenario = Scenario(duration=4.0, start=ScenarioStart(mode="off"), script=script)
    session = Session(scenario, {"kp_position_z": least})
    session.run()
    assert session.snapshot().p_WB[2] > 0.9


def test_a_row_is_found_by_name():
    assert TABLE.find("kp_roll").name == "kp_roll"


def test_of_an_endless_name_the_beginning_is_repeated():
    with pytest.raises(WorkbenchError, match=f"'{60 * 'a'}… \\(100,000 characters\\)': known are"):
        TABLE.find(100_000 * "a")


def test_an_unknown_name_is_answered_with_the_nearest():
    with pytest.raises(WorkbenchError, match="'kp_rol': did you mean 'kp_roll'"):
        TABLE.find("kp_rol")


@pytest.mark.parametrize("value", [math.nan, "5", None, True])
def test_what_is_no_number_is_refused(value):
    with pytest.raises(WorkbenchError, match="x.yaml:3: kp_roll is .*give it a number"):
        TABLE.find("kp_roll").check(value, "x.yaml:3: ")


@pytest.mark.parametrize("value", [-0.001, 2500.1, math.inf, -math.inf])
def test_what_is_out_of_range_is_refused_with_the_range(value):
    with pytest.raises(WorkbenchError, match=r"kp_roll is .*0 .. 2500 1/s\^2"):
        TABLE.find("kp_roll").check(value)


@pytest.mark.parametrize("value", [7, 7.0, np.float64(7.0), np.float32(7.0), np.int64(7)])
def test_any_kind_of_number_becomes_a_float(value):
    found = TABLE.find("kp_roll").check(value)
    assert type(found) is float
    assert found == 7.0


def test_many_are_checked_at_once():
    assert TABLE.checked({"kp_roll": 5, "max_tilt": 0.5}) == {"kp_roll": 5.0, "max_tilt": 0.5}
    with pytest.raises(WorkbenchError, match="here: unknown parameter 'max_tlt'"):
        TABLE.checked({"max_tlt": 0.5}, "here: ")
    with pytest.raises(WorkbenchError, match="here: max_tilt"):
        TABLE.checked({"max_tilt": 5.0}, "here: ")


@pytest.mark.parametrize("text", ["kp_roll=12.5", " kp_roll = 12.5 ", "kp_roll=1.25e1"])
def test_a_setting_is_parsed(text):
    assert split_setting(text) == ("kp_roll", 12.5)


def test_a_setting_that_is_none_is_refused(case):
    for text, word in [
        ("kp_roll", "NAME=VALUE"),
        ("kp_roll=", "number"),
        ("kp_roll=fast", "'fast'"),
        ("kp_roll=nan", "number"),
        ("kp_roll=1=2", "'1=2'"),
        ("kp_roll=-1", "0 .. 2500"),
        ("kp_rol=1", "'kp_roll'"),
        ("=1", "NAME=VALUE"),
    ]:
        with case(text, word):
            with pytest.raises(WorkbenchError) as caught:
                TABLE.checked(dict([split_setting(text)]))
            assert word in str(caught.value)
