"""Another controller takes over in flight: an edit of its file, another law, a line of a script."""

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from workbench.common.errors import WorkbenchError
from workbench.logs.contents import logged_gains_text
from workbench.scenario.scenario import Action, Rates, Scenario, SensorsConfig, VehicleConfig
from workbench.session.recording import Recording
from workbench.session.session import Session
from workbench.systems.bridge import Bridge

TEXT = (Path(__file__).parents[1] / "controllers/cascade.py").read_text(encoding="utf-8")
WIND = {"wind_x": 3.0, "turbulence": 4.0}


@pytest.fixture
def mine(tmp_path):
    """Return a law's file."""
    path = tmp_path / "mine.py"
    path.write_text(TEXT, encoding="utf-8")
    return path


def edit(path: Path, old: str, new: str) -> None:
    text = path.read_text(encoding="utf-8")
    assert old in text
    path.write_text(text.replace(old, new), encoding="utf-8")


def stepping(path: Path) -> Session:
    """Return a session in the middle of a step, in wind."""
    scenario = Scenario(
        controller=str(path),
        script=[Action(set=WIND), Action(at=0.2, velocity=[1.0, 0.0, 0.3])],
        sensors=SensorsConfig(use=["imu"], seed=4, keep=True),
    )
    session = Session(scenario, {"k_speed": 2.2}, bridge=Bridge())
    session.tick(0.503)
    return session


def assert_equal_to_the_bit(one: Session, other: Session) -> None:
    a, b = one.recording(), other.recording()
    for field in dataclasses.fields(Recording):
        if field.name != "vehicle":
            first, second = getattr(a, field.name), getattr(b, field.name)
            assert first.tobytes() == second.tobytes(), field.name
    assert one.state().tobytes() == other.state().tobytes()


def test_an_edit_that_changes_nothing_changes_no_bit_of_the_flight(mine):
    flights = [stepping(mine), stepping(mine)]
    edit(mine, "A reader's", "A writer's")
    before = flights[0].controller
    flights[0].fly_controller(str(mine))
    assert flights[0].controller is not before
    assert flights[0].time == flights[1].time
    for flight in flights:
        flight.tick(0.5)
    assert_equal_to_the_bit(*flights)
    time = flights[0].recording().time
    assert (np.diff(time) > 0.0).all() and time[-1] == 1.0
    stamps = flights[0].samples()[0].stamps
    assert (np.diff(stamps) > 0.0).all() and len(stamps) == len(flights[1].samples()[0].stamps)
    assert published(flights[0]) == published(flights[1])


def test_an_edit_keeps_what_has_the_same_name_and_a_reset_begins_with_it(mine):
    flight = stepping(mine)
    flight.set("k_tilt", 130.0)
    memory = flight.checkpoint().systems[flight._bench.computer.GetSystemPathname()].state[-1]
    new = 'gain("k_new", "1", (0.0, 1.0), 0.25, "of no use"),\n    gain("k_yaw"'
    edit(mine, 'gain("k_yaw"', new)
    edit(mine, 'gain("k_speed", "1/s", (0.0, 20.0), 2.5', 'gain("k_speed", "1/s", (0.0, 20.0), 9.0')
    flight.fly_controller(str(mine))
    found = [flight.get(name) for name in ("k_tilt", "k_new", "k_speed", "wind_x")]
    assert found == [130.0, 0.25, 2.2, 3.0]
    computer = flight._bench.computer.GetSystemPathname()
    assert flight.checkpoint().systems[computer].state[-1] == memory != (0.0,)
    flight.reset()
    assert flight.get("k_new") == 0.25 and flight.get("k_tilt") == 120.0
    assert flight.get("k_speed") == 2.2  # a setting that the flight was built with

    flight.tick(0.3)
    edit(mine, "k_speed", "k_velocity")  # the setting names what is gone
    flight.fly_controller(str(mine))
    assert flight.get("k_velocity") == 9.0


def test_another_law_has_its_own_gains_within_the_same_limits_and_its_settings_when_it_is_back(
    tmp_path,
):
    file = tmp_path / "soft.yaml"
    first = Session()
    values = {**first.parameters(), "kp_roll": 71.0}
    file.write_text(logged_gains_text(first.vehicle.name, values, "pd"), encoding="utf-8")
    scenario = Scenario(vehicle=VehicleConfig(gains=str(file)))
    flight = Session(scenario, {"max_speed": 3.0, "kp_velocity_x": 1.1})
    flight.tick(0.1)
    flight.set("max_tilt", 0.3)
    own = Session(Scenario(controller="pid")).get("kp_velocity_z")
    flight.fly_controller("lqi")
    flight.fly_controller("pid")
    assert flight.controller.name == "pid"
    assert [flight.get(n) for n in ("kp_velocity_z", "max_speed", "max_tilt")] == [own, 3.0, 0.3]
    assert flight.scenario == scenario  # that began, and is flown again by what was done
    assert flight.flown_scenario.controller == "pid" and not flight.flown_scenario.vehicle.gains
    flight.tick(0.1)
    flight.reset()
    assert flight.controller.name == flight.scenario.controller == "pid"
    assert flight.get("max_speed") == 3.0
    flight.fly_controller("pd")
    assert flight.flown_scenario.vehicle.gains == str(file)
    flight.reset()
    assert (flight.get("kp_roll"), flight.get("kp_velocity_x")) == (71.0, 1.1)


def test_a_line_of_the_script_takes_over_at_its_time_and_a_reset_begins_with_the_first_law():
    script = [
        Action(at=0.1, velocity=[1.0, 0.0, 0.0]),
        Action(at=0.3, controller="lqi", set={"q_tilt": 3.0}),
        Action(at=0.4, velocity=[0.0, 0.0, 0.0]),
    ]
    flights = []
    for _ in range(2):
        flight = Session(Scenario(script=script))
        flight.tick(0.25)
        assert flight.controller.name == "pd"
        flight.tick(0.25)
        assert flight.controller.name == "lqi" and flight.get("q_tilt") == 3.0
        flights.append(flight)
    again = flights[1]
    again.reset()
    assert again.controller.name == "pd" and again.time == 0.0
    again.tick(0.5)
    assert_equal_to_the_bit(*flights)
    again.fly_controller("lqi")  # as it flies already; the next reset begins with it
    again.reset()
    assert again.controller.name == "lqi" and again.scenario.script == script


REFUSED = (
    ("def update(", "def update(:", r"mine\.py:\d+: is not valid Python"),
    (
        "def update(",
        "x = undefined_name\n\n\ndef update(",
        r"mine\.py:\d+: NameError.*undefined_name",
    ),
    (
        "    e_x, e_y, e_z = position_error(measured, setpoint)",
        "    e_x, e_y, e_z = position_error(measured, setpoint)\n    1 / (measured.p_WB[2] < 0.5)",
        r"mine\.py:\d+: update fails: ZeroDivisionError: ",
    ),
    (
        "    e_x, e_y, e_z = position_error(measured, setpoint)",
        "    e_x, e_y, e_z = position_error(measured, setpoint)\n"
        "    e_x = e_x + (1e999 - 1e999 if measured.p_WB[2] > 0.5 else 0.0)",
        r"mine\.py:\d+: update makes e_x nan: let it be a finite number$",
    ),
)


def test_a_law_that_cannot_fly_is_refused_and_the_flight_goes_on_to_the_bit(mine, case):
    flights = [stepping_with_a_later_set(mine) for _ in range(2)]
    for old, new, said in REFUSED:
        mine.write_text(TEXT, encoding="utf-8")
        edit(mine, old, new)
        with case(said), pytest.raises(WorkbenchError, match=said):
            flights[0].fly_controller(str(mine))
    with pytest.raises(WorkbenchError, match="controller 'lqq'"):
        flights[0].fly_controller("lqq")
    for flight in flights:
        flight.tick(0.7)
    assert_equal_to_the_bit(*flights)
    assert published(flights[0]) == published(flights[1])  # what was tried published nothing
    assert flights[0].get("k_tilt") == 99.0


def stepping_with_a_later_set(path: Path) -> Session:
    script = [Action(at=0.5, set={"k_tilt": 99.0})]
    flight = Session(Scenario(controller=str(path), script=script), bridge=Bridge())
    flight.command([1.0, 0.0, 0.0])
    flight.tick(64 * 0.0048828125)  # when topics are published, too
    return flight


def published(flight: Session) -> list[int]:
    """Return the times of what was published since the last call."""
    return [sampled.published.t_ns for sampled in flight.drain()]


def test_a_takeover_between_two_samples_publishes_none_again(mine):
    """The law runs more often than the state is published: the takeover has a time of its own."""
    scenario = Scenario(
        controller=str(mine),
        sensors=SensorsConfig(use=["gps"], seed=4),
        rates=Rates(physics_step=1 / 1024, control_period=1 / 512),
    )
    published = []
    for version in ("A reader's", "A writer's"):
        flight = Session(scenario, bridge=Bridge())
        flight.tick(549 / 1024)
        edit(mine, "A reader's", version)
        flight.fly_controller(str(mine))
        flight.tick(0.125)
        gps = next(topic.id for topic in flight.topics if topic.name.endswith("/gps"))
        payloads = (each.published.payloads for each in flight.drain())
        published.append([payload for batch in payloads for name, payload in batch if name == gps])
    assert len(published[0]) > 1 and published[0] == published[1]


def test_a_sensor_that_failed_stays_failed_under_another_controller():
    flight = Session(Scenario(sensors=SensorsConfig(use=["gps", "barometer"])))
    flight.tick(0.125)
    flight.do(Action(set={"gps_fault": 1.0}))  # frozen
    flight.tick(0.125)
    frozen = flight.snapshot().gps
    flight.do(Action(velocity=[2.0, 0.0, 0.0]))
    flight.fly_controller("lqi")
    assert flight.get("gps_fault") == 1.0
    flight.tick(0.25)
    gps = flight.snapshot().gps
    assert (gps.latitude, gps.longitude) == (frozen.latitude, frozen.longitude)
    flight.reset()
    assert flight.get("gps_fault") == 0.0
