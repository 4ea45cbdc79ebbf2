"""Oracle: the table itself, and the flight that reads it."""

import math

import numpy as np
import pytest

from workbench.errors import WorkbenchError
from workbench.gains import vehicle_gains
from workbench.parameters import (
    PARAMETERS,
    checked,
    defaults,
    find_parameter,
    parameters_of,
    parse_setting,
)
from workbench.scenario import Action, Scenario, Start
from workbench.session import Session
from workbench.systems.cascade import Gains
from workbench.systems.flight_mode import Settings

NAMES = [row.name for row in PARAMETERS]


@pytest.fixture(scope="module")
def session():
    return Session()


def test_names_are_unique():
    assert len(set(NAMES)) == len(NAMES)


@pytest.mark.parametrize("row", PARAMETERS, ids=NAMES)
def test_a_row_is_complete_and_its_default_allowed(row):
    assert -math.inf < row.minimum < row.maximum < math.inf
    assert row.minimum <= row.default <= row.maximum
    assert row.unit
    assert row.help
    assert row.check(row.default) == row.default


def test_rows_stand_in_the_order_that_their_system_reads_them():
    assert tuple(row.name for row in parameters_of("controller")) == Gains._fields
    assert tuple(row.name for row in parameters_of("modes")) == Settings._fields
    assert [row.name for row in parameters_of("battery")] == ["battery_duration"]
    systems = ("controller", "modes", "battery")
    assert sum(len(parameters_of(system)) for system in systems) == len(PARAMETERS)


@pytest.mark.parametrize("row", PARAMETERS, ids=NAMES)
def test_a_row_is_read_and_written_alone(session, row):
    session.reset()
    before = {name: session.get(name) for name in NAMES}
    assert before == {**defaults(), **vehicle_gains(session.vehicle)}
    for value in (row.minimum, row.maximum):
        session.set(row.name, value)
        assert {name: session.get(name) for name in NAMES} == {**before, row.name: value}


@pytest.mark.parametrize("row", PARAMETERS, ids=NAMES)
@pytest.mark.parametrize("end", ["minimum", "default", "maximum"])
def test_every_allowed_value_builds_and_flies(row, end):
    """Not well, perhaps; but what is allowed must not break off or give no number."""
    scenario = Scenario(
        duration=0.5,
        start=Start(position=[0.0, 0.0, 5.0]),
        script=[Action(at=0.1, velocity=[1.0, 1.0, 1.0], yaw_rate=0.2)],
    )
    value = getattr(row, end)
    session = Session(scenario, {row.name: value})
    assert session.get(row.name) == value
    session.run()
    flight = session.recording()
    assert flight.time[-1] == 0.5
    for values in (flight.p_WB, flight.q_WB, flight.w_WB, flight.thrusts):
        assert np.isfinite(values).all()


def eventful() -> Session:
    """Return a flight that asks for everything: speed, turn, way-point, landing."""
    script = [
        Action(at=0.0, velocity=[2.0, -2.0, 1.0], yaw_rate=0.3),
        Action(at=0.4, velocity=[0.0, 0.0, 0.0]),
        Action(at=0.5, go_to=[1.0, 1.0, 3.0]),
        Action(at=0.8, request="land"),
    ]
    return Session(Scenario(start=Start(position=[0.0, 0.0, 2.0]), script=script))


def motion(session) -> np.ndarray:
    session.tick(1.0)
    flight = session.recording()
    return np.hstack([flight.v_WB, flight.w_WB])


@pytest.fixture(scope="module")
def eventful_motion():
    return motion(eventful())


@pytest.mark.parametrize("row", parameters_of("controller"), ids=Gains._fields)
def test_every_row_of_the_controller_is_of_effect(row, eventful_motion):
    """Limits at a value that cuts, gains at half."""
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
    least = find_parameter("kp_position_z").minimum
    script = [Action(at=0.0, request="take_off", height=1.0)]
    scenario = Scenario(duration=4.0, start=Start(mode="off"), script=script)
    session = Session(scenario, {"kp_position_z": least})
    session.run()
    assert session.snapshot().p_WB[2] > 0.9


def test_a_row_is_found_by_name():
    assert find_parameter("kp_roll").name == "kp_roll"


def test_an_unknown_name_is_answered_with_the_nearest():
    with pytest.raises(WorkbenchError, match="'kp_rol': did you mean 'kp_roll'"):
        find_parameter("kp_rol")


@pytest.mark.parametrize("value", [math.nan, "5", None, True])
def test_what_is_no_number_is_refused(value):
    with pytest.raises(WorkbenchError, match="x.yaml:3: kp_roll is .*give it a number"):
        find_parameter("kp_roll").check(value, "x.yaml:3: ")


@pytest.mark.parametrize("value", [-0.001, 2500.1, math.inf, -math.inf])
def test_what_is_out_of_range_is_refused_with_the_range(value):
    with pytest.raises(WorkbenchError, match=r"kp_roll is .*0 .. 2500 1/s\^2"):
        find_parameter("kp_roll").check(value)


@pytest.mark.parametrize("value", [7, 7.0, np.float64(7.0), np.float32(7.0), np.int64(7)])
def test_any_kind_of_number_becomes_a_float(value):
    found = find_parameter("kp_roll").check(value)
    assert type(found) is float
    assert found == 7.0


def test_many_are_checked_at_once():
    assert checked({"kp_roll": 5, "max_tilt": 0.5}) == {"kp_roll": 5.0, "max_tilt": 0.5}
    with pytest.raises(WorkbenchError, match="here: unknown parameter 'max_tlt'"):
        checked({"max_tlt": 0.5}, "here: ")
    with pytest.raises(WorkbenchError, match="here: max_tilt"):
        checked({"max_tilt": 5.0}, "here: ")


@pytest.mark.parametrize("text", ["kp_roll=12.5", " kp_roll = 12.5 ", "kp_roll=1.25e1"])
def test_a_setting_is_parsed(text):
    assert parse_setting(text) == ("kp_roll", 12.5)


@pytest.mark.parametrize(
    ("text", "word"),
    [
        ("kp_roll", "NAME=VALUE"),
        ("kp_roll=", "number"),
        ("kp_roll=fast", "'fast'"),
        ("kp_roll=nan", "number"),
        ("kp_roll=1=2", "'1=2'"),
        ("kp_roll=-1", "0 .. 2500"),
        ("kp_rol=1", "'kp_roll'"),
        ("=1", "unknown parameter"),
    ],
)
def test_a_setting_that_is_none_is_refused(text, word):
    with pytest.raises(WorkbenchError) as caught:
        parse_setting(text)
    assert word in str(caught.value)
