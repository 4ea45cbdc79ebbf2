"""A log flown again."""

import dataclasses
import re

import numpy as np
import pytest

from workbench.common.errors import WorkbenchError
from workbench.control.controller_file import load_controller
from workbench.logs import replay as module
from workbench.logs.record import LogRecord, read_log
from workbench.logs.replay import replay, replay_scenario
from workbench.scenario.scenario import Action, Scenario
from workbench.scenario.scenario_file import load_scenario

pytestmark = pytest.mark.usefixtures("unheld")

SCENARIO = """
title: by hand
start: {mode: "off"}
duration: 1.25
script:
  - {at: 0.0, request: arm}
  - {at: 0.5004, request: take_off, height: 1.2}
  - {at: 1.0, set: {kp_velocity_z: 3.1}, gust: {velocity: [2.0, 0.5, 0.0], duration: 0.2}}
"""


@pytest.mark.slow
def test_twenty_replays_are_equal_to_the_bit(log_of):
    done = [
        Action(at=13 / 128, velocity=[1.0, 0.1, 1 / 3]),
        Action(at=25 / 128, set={"kp_velocity_x": 5.1}, yaw_rate=0.3),
    ]
    record = read_log(log_of(Scenario(duration=0.4), done))
    found = {replay(record) for _ in range(20)}
    assert len(found) == 1
    only = found.pop()
    assert only.equal and only.first is None and only.changed == ()
    assert only.states == len(record.states) > 50


def test_a_flight_with_sensors_and_a_pilot_is_equal(log, flown):
    found = replay(read_log(log))
    assert found.equal
    assert found.states == len(flown.samples)


def test_a_hand_written_scenario_with_a_script_is_equal(log_of, tmp_path):
    path = tmp_path / "by_hand.yaml"
    path.write_text(SCENARIO)
    record = read_log(log_of(load_scenario(path)))
    assert record.done == ()
    assert replay(record).equal


def test_the_script_and_what_was_done_are_both_flown(log, flown, tmp_path):
    script = replay_scenario(read_log(log), "", tmp_path).script
    assert [action.at for action in script] == [0.25, *(action.at for action in flown.done)]


def test_other_gains_are_not_equal(log):
    record = read_log(log)
    other = dataclasses.replace(record, values=record.values | {"kp_velocity_x": 4.0})
    found = replay(other)
    assert not found.equal
    assert found.first.time < 0.3  # at the latest when the script asks for a velocity along x
    assert found.first.size > 0.0
    assert found.first.part in ("orientation", "velocity", "angular velocity", "position")


@pytest.mark.parametrize(
    ("index", "part"),
    [(0, "orientation"), (4, "position"), (9, "angular velocity"), (12, "velocity")],
)
def test_one_bit_of_one_number_is_a_difference(log, index, part):
    record = read_log(log)
    states = record.states.copy()
    states[200, index] = np.nextafter(states[200, index], np.inf)
    vars(record)["states"] = states
    found = replay(record)
    assert found.first.part == part
    assert found.first.time == pytest.approx(record.state_ns[200] * 1e-9)
    assert 0.0 < found.first.size < 1e-15


def test_minus_zero_is_not_zero_to_the_bit(log):
    record = read_log(log)
    states = record.states.copy()
    flown = states[:, 5]
    states[:, 5] = np.where(flown == 0.0, -flown, flown)
    vars(record)["states"] = states
    assert replay(record).equal == (not np.any(flown == 0.0))


def test_other_versions_are_named(log):
    record = read_log(log)
    other = dataclasses.replace(record, versions={**record.versions, "numpy": "1.0"})
    found = replay(other)
    assert found.equal
    assert len(found.changed) == 1
    assert re.fullmatch(r"numpy \S+, was 1\.0", found.changed[0])


def test_a_state_that_does_not_come_again_is_no_equal_one(log, flown, monkeypatch):
    """What flies again has a state at each of its own times, and the log one beside them."""
    record = read_log(log)
    times = list(record.state_ns)
    times[-1] += 1
    monkeypatch.setattr(LogRecord, "state_ns", tuple(times))
    monkeypatch.setattr(module, "_replayed_samples", lambda *_: iter(flown.samples))
    with pytest.raises(WorkbenchError, match=f"only {len(times) - 1} of its {len(times)} states"):
        replay(record)


def test_a_log_without_states_is_refused(write):
    record = read_log(write(samples=[]))
    with pytest.raises(WorkbenchError, match="nothing to fly again"):
        replay(record)


def test_a_log_cut_short_is_flown_as_far_as_it_goes(log, tmp_path):
    path = tmp_path / "cut.mcap"
    path.write_bytes(log.read_bytes()[: log.stat().st_size * 2 // 3])
    record = read_log(path)
    assert 0.2 < record.duration < 1.4
    assert replay(record).equal


def test_a_log_has_its_controller_and_tells_when_that_has_changed(log, log_of):
    record, law = read_log(log), load_controller()
    assert record.controller == {"name": "pd", "file": str(law.file), "sha256": law.digest}
    assert record.law == law.text
    other = dataclasses.replace(record, controller=record.controller | {"sha256": "0" * 64})
    assert replay(other).changed[0].startswith(f"controller pd with SHA-256 {law.digest[:12]}")
    assert replay(dataclasses.replace(record, controller={})).changed == ()  # of earlier versions


def test_python_that_only_the_log_names_does_not_run(log):
    record = read_log(log)
    foreign = dataclasses.replace(
        record, scenario_text=record.scenario_text + "controller: theirs.py\n"
    )
    with pytest.raises(WorkbenchError, match="as --controller theirs.py"):
        replay(foreign)
    assert replay(foreign, controller="pd").equal
    with pytest.raises(WorkbenchError, match="was flown by pd, and pid is another law"):
        replay(record, controller="pid")


def test_python_that_only_an_action_of_a_log_names_does_not_run(log, tmp_path):
    record, file = read_log(log), tmp_path / "other.py"
    file.write_text("raise SystemExit('it ran')\n", encoding="utf-8")
    act = dataclasses.replace(record.done[0].action, controller=str(file))
    record.__dict__["done"] = (dataclasses.replace(record.done[0], action=act),)
    for controller in ("", "pd", str(log)):
        with pytest.raises(
            WorkbenchError, match=r"other\.py takes over, but the log does not have its text"
        ):
            replay_scenario(record, controller, tmp_path)
