"""Flights as signals: gaps, what can be found from them, and our own logs."""

import dataclasses
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from workbench.common.errors import WorkbenchError
from workbench.common.flight import Flight
from workbench.common.series import make_series
from workbench.gui.signals import Signals
from workbench.logs.flight_contents import contents_of_flight
from workbench.logs.flight_reader import open_log, read_flight
from workbench.logs.imported import flight_of_log
from workbench.logs.readers import log_reader
from workbench.logs.readers.rotations import quaternion_from_angles, vectors_in_world
from workbench.logs.record import read_log
from workbench.scenario.scenario import Scenario, ScenarioStart, VehicleConfig
from workbench.session.session import Session
from workbench.systems.bridge import Bridge

pytestmark = pytest.mark.usefixtures("unheld")


def test_attitudes_are_those_of_scipy():
    angles = np.random.default_rng(1).uniform(-1.5, 1.5, (50, 3))
    turns = Rotation.from_euler("ZYX", angles[:, ::-1])
    q = quaternion_from_angles(*angles.T)
    np.testing.assert_allclose(
        Rotation.from_quat(q, scalar_first=True).as_matrix(), turns.as_matrix(), atol=1e-12
    )
    vectors = np.random.default_rng(2).standard_normal((50, 3))
    np.testing.assert_allclose(vectors_in_world(q, vectors), turns.apply(vectors), atol=1e-12)


def test_gaps_are_marked_and_never_bridged_unasked():
    time = np.concatenate([np.arange(0.0, 1.0, 0.01), np.arange(1.5, 2.0, 0.01)])
    signal = make_series("a.b", "m", time, time, end=3.0)
    assert signal.rate == pytest.approx(100.0)
    assert signal.gaps == ((pytest.approx(0.99), 1.5), (pytest.approx(1.99), 3.0))
    flight = Flight("x", Path("x"), "made", {"a.b": signal}, end=3.0)
    grid = flight.resample(["a.b"], 0.1, span=(0.0, 3.0))
    known = [bool(known) for known in grid.known[:, 0]]
    assert known == [t <= 0.99 or 1.5 <= t <= 1.99 for t in np.round(grid.time, 6)]
    assert np.isnan(grid["a.b"][~grid.whole]).all()
    bridged = flight.resample(["a.b"], 0.1, bridge=0.6, span=(0.0, 3.0))
    assert bridged["a.b"][12] == pytest.approx(1.2) and not bridged.whole[25]
    for lost, gaps in ((1, 0), (2, 1)):  # a gap is 2.5 periods long, in a log and up to its end
        even = 0.01 * np.arange(100)
        torn = np.delete(even, np.arange(50, 50 + lost))
        end = even[-1] + 0.01 * (1 + lost)
        assert len(make_series("a.b", "m", torn, torn).gaps) == gaps
        assert len(make_series("a.b", "m", even, even, end=end).gaps) == gaps


def test_commands_that_are_speeds_are_commands():
    """`identify` takes them, so `log` says that it can; the full speed no log knows."""
    time = np.arange(0.0, 10.0, 0.002)
    kinds = ("linear_acceleration", "angular_velocity")
    names = [f"imu.{kind}.{axis}" for kind in kinds for axis in "xyz"]
    values = {name: np.sin(time) for name in names}
    values |= {f"rotors.speed_command.{k}": 500.0 * (time >= 4.0) for k in range(4)}
    signals = {name: make_series(name, "", time, each) for name, each in values.items()}
    contents = contents_of_flight(Flight("a", Path("a.csv"), "made up", signals, end=10.0))
    assert contents.turning == pytest.approx(6.0, abs=0.005) and np.isnan(contents.saturated)
    found = {each.what: each.can for each in contents.findable}
    assert found["rotor lag"] and found["inertia"] and not found["thrust over voltage"]


def test_our_own_log_is_a_flight_record(log):
    flight = read_flight(log)
    record = open_log(log)
    np.testing.assert_array_equal(
        flight["velocity_data.v_z"].values, record["velocity_data.v_z"].values
    )
    grid = flight.resample(["attitude.q_w", "attitude.q_z", "position_data.yaw"], 0.05)
    yaw = 2.0 * np.arctan2(grid["attitude.q_z"], grid["attitude.q_w"])
    np.testing.assert_allclose(np.cos(yaw - grid["position_data.yaw"]), 1.0, atol=1e-3)
    q = np.column_stack([flight[f"attitude.q_{part}"].values for part in "wxyz"])
    away = Rotation.from_quat(q, scalar_first=True)
    steps = (away[:-1].inv() * away[1:]).as_rotvec() / np.diff(flight["attitude.q_w"].time)[:, None]
    rates = np.column_stack([flight[f"attitude.w_{axis}"].values for axis in "xyz"])
    between = 0.5 * (rates[1:] + rates[:-1])
    assert np.ptp(rates, axis=0).min() > 0.2 and np.abs(steps - between).max() < 0.02
    contents = contents_of_flight(
        flight
    )  # it has no commands, and speeds tell that the rotors turn
    assert contents.turning == pytest.approx(flight.end, abs=0.05)
    assert np.isnan(contents.saturated)
    assert not any("never turn" in each.why for each in contents.findable)


def test_the_setpoint_of_a_log_is_the_point_that_an_order_has_given_from_its_time_on(log):
    record = read_log(log)
    orders = "script: [{at: 0.5, go_to: [1, 2, 3]}, {at: 1.0, go_to: [4, 5, 6]}]"
    topics = {name: topic for name, topic in record.topics.items() if name != "actions"}
    flight = flight_of_log(dataclasses.replace(record, scenario_text=orders, topics=topics))
    begin = record.states[0, 4]
    for signal, first, then in (("x", begin, 1.0), ("z", record.states[0, 6], 3.0)):
        found = flight[f"setpoint.{signal}"]
        assert 0.5 in found.time and 1.0 in found.time
        wanted = np.where(found.time < 0.5, first, np.where(found.time < 1.0, then, then + 3.0))
        np.testing.assert_array_equal(found.values, wanted)


def test_what_is_no_log_is_a_sentence(tmp_path, case):
    for data, said in (
        (b"", "is empty"),
        (b"hello", "is not a known kind of log"),
        (b"\x1f\x8bhello", "cannot be unpacked"),
    ):
        with case(data):
            path = tmp_path / "some"
            path.write_bytes(data)
            with pytest.raises(WorkbenchError, match=said):
                read_flight(path)
    with pytest.raises(WorkbenchError, match="no such file"):
        read_flight(tmp_path / "none")
    with pytest.raises(WorkbenchError, match="a folder"):
        read_flight(tmp_path)


@pytest.fixture
def readers(monkeypatch):
    """Return a function that replaces the entries, by their names."""

    def install(**entries):
        def load(group, name):
            if isinstance(entries[name], str):
                raise WorkbenchError(entries[name])
            return entries[name]

        monkeypatch.setattr(log_reader, "find_extensions", lambda group: entries)
        monkeypatch.setattr(log_reader, "load_extension", load)
        log_reader._loaded_readers.cache_clear()

    yield install
    log_reader._loaded_readers.cache_clear()


def made_reader(name, place, magic, **more):
    """Return a reader of files that begin with some bytes."""
    return log_reader.LogReader(
        name,
        f"{name}'s logs",
        lambda _, head: log_reader.begins_with(head, magic),
        lambda file: Flight(name, file.path, name, {}, remarks=(str(file[1:]),), end=1.0),
        place,
        (f".{name}",),
        **more,
    )


def test_readers_are_asked_by_their_places_and_our_own_logs_first(readers, log, tmp_path):
    both, mapping = b"abc", tmp_path / "any.yaml"
    readers(
        last=made_reader("one", 2, both),
        first=made_reader("two", 1, both, has_several=True),
        table=made_reader("table", 3, b"x", takes_mapping=True),
    )
    assert log_reader.log_endings() == (".mcap", ".two", ".one", ".table", ".gz")
    path = tmp_path / "some"
    path.write_bytes(both)
    assert read_flight(path).format == "two"
    assert read_flight(path, log_number=2).remarks == ("(None, 2)",)
    assert read_flight(path, mapping).remarks == (f"({mapping!r}, None)",)
    with pytest.raises(WorkbenchError, match="has one log: --log-number 2"):
        read_flight(path, mapping, log_number=2)
    greedy = made_reader("greedy", 0, b"\x89MCAP0\r\n")
    readers(greedy=greedy)
    assert read_flight(log).format == "workbench log"
    with pytest.raises(WorkbenchError, match="has one log"):
        read_flight(log, log_number=2)


def test_readers_that_cannot_be_loaded_are_named_and_the_others_read(readers, tmp_path):
    broken = "the log reader 'lost' is in gone, which cannot be loaded"
    readers(lost=broken, kept=made_reader("kept", 1, b"abc"))
    path = tmp_path / "some"
    path.write_bytes(b"abc")
    assert read_flight(path).format == "kept"
    path.write_bytes(b"xyz")
    with pytest.raises(WorkbenchError, match=rf"some readers .* are not there \(lost\): {broken}"):
        read_flight(path)
    readers(lost=broken)
    with pytest.raises(WorkbenchError, match="name a log of the workbench .*: the log reader"):
        read_flight(path)
    with pytest.raises(WorkbenchError, match="no reader of tables with a mapping is there"):
        read_flight(path, path)


def test_a_reader_without_its_package_says_which(readers, tmp_path):
    readers(one=made_reader("one", 1, b"abc", package="no_such_package"))
    path = tmp_path / "some"
    path.write_bytes(b"abc")
    said = "the format one needs the package no_such_package: `pip"
    with pytest.raises(WorkbenchError, match=said):
        read_flight(path)


def test_joints_contacts_and_cables_have_their_names_as_in_a_live_flight(log_of, tmp_path):
    """Those of the published topics; the numbers are those of the flight's own recording."""
    gear = VehicleConfig(model="manipulator")
    start = ScenarioStart(position=[0.0, 0.0, 10.0])
    flight = read_flight(log_of(Scenario(vehicle=gear, start=start, duration=0.25)))
    session = Session(Scenario(vehicle=gear, start=start), bridge=Bridge())
    live = Signals()
    live.begin(session.topics)
    named = [name for name in live.units if name.startswith(("joint_", "contact", "tension"))]
    assert {"joint_states.position.shoulder", "joint_setpoints.position.elbow"} <= set(named)
    assert {"contact_forces.force.crate.z", "tensions.tension.left_finger"} <= set(named)
    assert set(named) <= set(flight.signals)
    session.tick(0.25)
    recording = session.recording()
    held = recording.tensions[-1, list(session.vehicle.cables).index("left_finger")]
    assert held > 1.0
    assert flight["tensions.tension.left_finger"].values[-1] == pytest.approx(held, rel=0.05)
    elbow = [name for name, _ in session.vehicle.joint_signals].index("elbow_q")
    found = flight["joint_states.position.elbow"].values[-1]
    assert found == pytest.approx(recording.joints[-1, elbow], abs=2e-3)
