"""`workbench replay`."""

import pytest
from mcap.reader import make_reader

from workbench.gains.gain_choice import flight_gains
from workbench.logs.flight_log import FlightLog
from workbench.logs.record import read_log
from workbench.scenario.scenario import Action, Scenario
from workbench.session.session import Session
from workbench.systems.bridge import Bridge


@pytest.fixture(scope="module")
def flown(tmp_path_factory):
    """Return a function that writes the log of a short flight, with values that it says it had."""
    scenario = Scenario(duration=0.3, script=[Action(0.1, velocity=[1.0, 0.0, 0.0])])
    session = Session(scenario, bridge=Bridge())
    values = flight_gains(session.vehicle)
    session.run()
    samples = session.drain()
    folder = tmp_path_factory.mktemp("logs")

    def write(name: str, **changed: float):
        log = FlightLog(
            folder / name, session.topics, scenario, {}, values | changed, session.vehicle.name
        )
        for sampled in samples:
            log.write(sampled)
        log.close()
        return folder / name

    return write


def test_the_same_flight_is_equal(run, flown):
    path = flown("same.mcap")
    said = run("replay", path)
    assert said.code == 0, said.err
    count = len(read_log(path).states)
    assert said.out == f"equal: all {count} states over 0.297 s are the same to the bit\n"


def test_other_gains_are_not_equal(run, flown):
    path = flown("other.mcap", kp_velocity_x=2.0)
    said = run("replay", path)
    assert said.code == 1
    assert said.out.startswith("not equal: the first difference is at 0.")
    found = run("replay", path, "--json").json
    assert found["equal"] is False
    assert 0.0 < found["first"]["time"] < 0.2
    assert found["first"]["size"] > 0.0


def test_json_of_an_equal_flight(run, flown):
    path = flown("json.mcap")
    said = run("replay", path, "--json")
    assert said.code == 0
    assert said.json == {
        "log": str(path),
        "equal": True,
        "remark": "",
        "states": len(read_log(path).states),
        "duration": pytest.approx(0.297, abs=1e-3),
        "first": None,
        "changed": [],
    }


def test_a_cut_log_is_told_and_flown(run, flown):
    path = flown("cut.mcap")
    with path.open("rb") as file:
        *_, last = make_reader(file).get_summary().chunk_indexes
    path.write_bytes(path.read_bytes()[: last.chunk_start_offset + last.chunk_length])
    said = run("replay", path)
    assert "was not closed and ends at 0.297 s" in said.err
    assert said.code == 0


def test_what_is_no_log_is_refused(refused, write):
    assert "is not an MCAP file" in refused("replay", write("a.mcap", "t,v"))
    assert "nowhere.mcap: no such file" in refused("replay", "nowhere.mcap")
