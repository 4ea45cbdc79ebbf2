"""Oracle: files as written by hand, and PyYAML reading what is saved."""

import random
import re

import pytest
import yaml

from workbench.common.errors import WorkbenchError
from workbench.control.controller_file import load_controller
from workbench.gains import gains as gain_files
from workbench.gains.gains import (
    MAX_HISTORY_SAVES,
    GainFile,
    flown_by,
    gains_at,
    load_gains,
    save_gains,
)

ISO = r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\dZ"


@pytest.fixture
def path(tmp_path):
    return tmp_path / "gains.yaml"


def states(file):
    return [dict(gains_at(file, index).gains) for index in range(len(file.history))]


@pytest.mark.parametrize(
    ("written", "name", "value"),
    [
        ("3.0 1/s", "kp_velocity_z", 3.0),
        ("3 1/s", "kp_velocity_z", 3.0),
        ("3", "kp_velocity_z", 3.0),
        ("3e0", "kp_velocity_z", 3.0),
        ("225.0 1/s^2", "kp_roll", 225.0),
        ("225.0 1/s²", "kp_roll", 225.0),
        ("  0.5   rad", "max_tilt", 0.5),
        ("5e-1", "max_tilt", 0.5),
        ("0.1", "kd_velocity_x", 0.1),
        ("0.1 1", "kd_velocity_x", 0.1),
    ],
)
def test_a_value_may_have_its_unit(path, written, name, value):
    path.write_text(f"gains:\n  {name}: {written}\n", encoding="utf-8")
    assert load_gains(path).gains == {name: value}


@pytest.mark.parametrize(
    ("written", "name", "said"),
    [
        ("3.0 m/s", "kp_velocity_z", "kp_velocity_z is '3.0 m/s': it is in 1/s"),
        ("40 deg", "max_tilt", "max_tilt is '40 deg': it is in rad"),
        ("0.1 1/s", "kd_velocity_x", "kd_velocity_x is '0.1 1/s': it has no unit"),
        ("1/s", "kp_velocity_z", "'1/s': give it a number"),
        ("99 1/s", "kp_velocity_z", "is 99 1/s: keep it within 0.5 .. 30 1/s"),
        ("nan 1/s", "kp_velocity_z", "give it a number"),
        ("soon", "kp_velocity_z", "give it a number"),
    ],
)
def test_a_wrong_unit_or_number_is_named_with_its_line(path, written, name, said):
    path.write_text(f"vehicle: x\ngains:\n  {name}: {written}\n")
    with pytest.raises(WorkbenchError) as caught:
        load_gains(path)
    assert str(caught.value).startswith(f"{path}:3: ")
    assert said in str(caught.value)


def test_saving_writes_units_in_the_tables_order(path):
    values = {"max_tilt": 0.5, "kd_velocity_x": 0.1, "kp_roll": 150.0, "kp_velocity_z": 2 / 3}
    save_gains(str(path), GainFile("quad", "by hand: tried", values))
    data = yaml.safe_load(path.read_text())
    assert list(data) == ["vehicle", "origin", "gains", "history"]
    assert (data["vehicle"], data["origin"]) == ("quad", "by hand: tried")
    assert list(data["gains"].items()) == [
        ("kp_velocity_z", "0.6666666666666666 1/s"),
        ("kd_velocity_x", 0.1),
        ("kp_roll", "150.0 1/s^2"),
        ("max_tilt", "0.5 rad"),
    ]


def test_any_value_comes_back_to_the_bit(path):
    chance = random.Random(1)
    for _ in range(5):
        values = {
            row.name: float(round(value)) if row.whole else value
            for row in load_controller().table
            for value in [chance.uniform(row.minimum, row.maximum)]
        }
        values["kp_position_xy"] = 1.23e-7
        save_gains(path, GainFile("quad", "", values))
        assert load_gains(path).gains == values


def test_what_is_returned_is_what_the_file_has(path):
    for value in (1.0, 2.0):
        saved = save_gains(path, GainFile("quad", "tried", {"kp_roll": value}))
        assert saved == load_gains(path)


def test_every_state_can_come_back(path):
    steps = [
        {"kp_roll": 100.0, "max_tilt": 0.5},
        {"kp_roll": 120.0, "max_tilt": 0.5},
        {"kp_roll": 120.0, "kd_roll": 20.0},
        {"kp_roll": 100.0, "kd_roll": 0.0, "max_tilt": 0.0625},
    ]
    for index, values in enumerate(steps):
        save_gains(path, GainFile("quad", f"step {index}", values))
    file = load_gains(path)
    assert states(file) == steps
    assert [gains_at(file, i).origin for i in range(4)] == [f"step {i}" for i in range(4)]
    assert file.history[2].changed == {"max_tilt": (0.5, None), "kd_roll": (None, 20.0)}
    assert gains_at(file, 0).vehicle == "quad"


def test_a_save_has_its_time(path):
    save_gains(path, GainFile("quad", "", {"kp_roll": 1.0}))
    entry = yaml.safe_load(path.read_text())["history"][0]
    assert re.fullmatch(ISO, entry["saved"])


def test_a_file_by_hand_becomes_the_first_state_and_keeps_its_heading(path):
    path.write_text(
        "# mine\n#\n\nvehicle: quad\norigin: by hand\ngains:\n  # stiff\n  kp_roll: 120 # soft\n"
    )
    save_gains(path, GainFile("quad", "tried", {"kp_roll": 130.0}))
    text = path.read_text()
    assert text.startswith("# mine\n#\n\nvehicle: quad\n")
    assert text.count("#") == 2
    file = load_gains(path)
    assert [(save.saved == "", save.origin) for save in file.history] == [
        (True, "by hand"),
        (False, "tried"),
    ]
    assert states(file) == [{"kp_roll": 120.0}, {"kp_roll": 130.0}]


def test_saving_the_same_again_adds_no_state(path):
    same = GainFile("quad", "tried", {"kp_roll": 1.0})
    first = save_gains(path, same)
    assert save_gains(path, same) == first
    other = save_gains(path, GainFile("quad", "tried again", {"kp_roll": 1.0}))
    assert [dict(save.changed) for save in other.history] == [{}, {}]


def test_a_restored_state_is_one_more_state(path):
    for value in (1.0, 2.0):
        save_gains(path, GainFile("quad", f"tried {value}", {"kp_roll": value}))
    save_gains(path, gains_at(load_gains(path), 0))
    file = load_gains(path)
    assert [state["kp_roll"] for state in states(file)] == [1.0, 2.0, 1.0]
    assert file.origin == "tried 1.0"


def test_the_oldest_states_go(path, monkeypatch):
    assert MAX_HISTORY_SAVES == 200
    monkeypatch.setattr(gain_files, "MAX_HISTORY_SAVES", 3)
    for value in range(6):
        save_gains(path, GainFile("quad", f"{value}", {"kp_roll": float(value)}))
    file = load_gains(path)
    assert [state["kp_roll"] for state in states(file)] == [3.0, 4.0, 5.0]


@pytest.mark.parametrize("index", [-1, 2, 99])
def test_a_state_that_is_not_there_is_refused(path, index):
    for value in (1.0, 2.0):
        save_gains(path, GainFile("quad", "", {"kp_roll": value}))
    with pytest.raises(WorkbenchError, match=f"no state {index}: the gain file has states 0 to 1"):
        gains_at(load_gains(path), index)


def test_a_file_without_history_has_no_state_to_restore(path):
    path.write_text("gains: {kp_roll: 1.0}\n")
    with pytest.raises(WorkbenchError, match="no history yet"):
        gains_at(load_gains(path), 0)


def test_what_cannot_be_saved_leaves_the_old_file(path):
    save_gains(path, GainFile("quad", "", {"kp_roll": 1.0}))
    before = path.read_bytes()
    with pytest.raises(WorkbenchError, match="0 .. 2500"):
        save_gains(path, GainFile("quad", "", {"kp_roll": -1.0}))
    with pytest.raises(WorkbenchError, match="has the gains of 'quad', and these are of 'hexa'"):
        save_gains(path, GainFile("hexa", "", {"kp_roll": 2.0}))
    assert path.read_bytes() == before


def test_what_is_no_gain_file_is_not_written_over(path):
    path.write_text("title: a scenario\n")
    with pytest.raises(WorkbenchError, match="unknown key 'title'"):
        save_gains(path, GainFile("quad", "", {"kp_roll": 1.0}))
    assert path.read_text() == "title: a scenario\n"


@pytest.mark.parametrize(
    ("history", "line", "said"),
    [
        ("history: soon", 3, "a list of saves"),
        ("history:\n  - yesterday", 4, "a save has saved, origin, changed"),
        ("history:\n  - {changed: [1]}", 4, "a save has saved, origin, changed"),
        ("history:\n  - saved: ''\n    change: {}", 5, "did you mean 'changed'"),
        ("history:\n  - changed:\n      kp_roll: 1", 5, "[value before, value after]"),
        ("history:\n  - changed:\n      kp_roll: [1]", 5, "[value before, value after]"),
        ("history:\n  - changed:\n      kp_roll: [a, 1]", 5, "[value before, value after]"),
    ],
)
def test_a_broken_history_is_named_with_its_line(path, history, line, said):
    path.write_text(f"gains:\n  kp_roll: 1\n{history}\n")
    with pytest.raises(WorkbenchError) as caught:
        load_gains(path)
    assert str(caught.value).startswith(f"{path}:{line}: ")
    assert said in str(caught.value)


def test_a_history_of_what_is_no_longer_a_parameter_can_be_read_but_not_restored(path):
    path.write_text(
        "gains: {kp_roll: 1.0}\nhistory:\n"
        "  - {origin: old, changed: {}}\n"
        "  - {origin: new, changed: {kp_gone: [1.0, null], kp_roll: [2.0, 1.0]}}\n"
    )
    file = load_gains(path)
    assert gains_at(file, 1).gains == {"kp_roll": 1.0}
    with pytest.raises(WorkbenchError, match="unknown parameter 'kp_gone'"):
        gains_at(file, 0)


def test_all_defaults_can_be_saved(path):
    save_gains(path, GainFile("", "", load_controller().table.defaults()))
    assert load_gains(path).gains == load_controller().table.defaults()


SCHEDULED = """\
vehicle: x
controller: pd@speed=0,4
gains:
  kp_roll: 200.0, 150.0 1/s^2
  kp_pitch: 180.0 1/s^2
  kp_velocity_x: [4.0, 3.0]
  kp_yaw_rate_at_4: 5.0
  max_tilt: 0.5 rad
"""


def test_a_file_may_hold_sets_of_gains(path):
    path.write_text(SCHEDULED, encoding="utf-8")
    found = load_gains(path)
    assert found.controller == "pd@speed=0,4"
    assert found.gains == {
        "kp_roll_at_0": 200.0,
        "kp_roll_at_4": 150.0,
        "kp_pitch_at_0": 180.0,
        "kp_pitch_at_4": 180.0,
        "kp_velocity_x_at_0": 4.0,
        "kp_velocity_x_at_4": 3.0,
        "kp_yaw_rate_at_4": 5.0,
        "max_tilt": 0.5,
    }
    gains = {**found.gains, "kp_roll_at_4": 1.0 / 0.007}
    saved = save_gains(path, GainFile("x", "tuned", gains, controller=found.controller))
    assert saved.gains["kp_roll_at_4"] == load_gains(path).gains["kp_roll_at_4"] == 1.0 / 0.007
    text = path.read_text(encoding="utf-8")
    assert yaml.safe_load(text)["gains"]["kp_pitch"] == "180.0, 180.0 1/s^2"
    assert "kp_yaw_rate_at_4" in text
    assert states(load_gains(path))[0]["kp_roll_at_4"] == 150.0


def test_sets_that_are_wrong_are_named_with_their_line(path, case):
    for old, new, said in (
        ("200.0, 150.0", "200.0, 150.0, 100.0", "gains.yaml:4: there are 3 values: give one, or 2"),
        ("200.0, 150.0 1/s^2", "200.0, soon", "gains.yaml:4: kp_roll_at_4 is .*soon"),
        ("0.5 rad", "0.5, 0.6 rad", "gains.yaml:8: max_tilt is .*give it a number"),
        ("pd@speed=0,4", "pd@speed=4,0", "@speed=4,0 is not a schedule"),
        ("_at_4", "_at_5", "gains.yaml:7: unknown parameter 'kp_yaw_rate_at_5'"),
    ):
        path.write_text(SCHEDULED.replace(old, new), encoding="utf-8")
        with case(new), pytest.raises(WorkbenchError, match=said):
            load_gains(path)


def test_who_flies_follows_the_schedule_of_a_file(path):
    """And gains without a schedule are those of all sets."""
    path.write_text(SCHEDULED, encoding="utf-8")
    assert flown_by("pd", str(path)) == "pd@speed=0,4"
    assert flown_by("pd@speed=0,4", str(path)) == "pd@speed=0,4"
    assert flown_by("lqi", str(path)) == "lqi"
    with pytest.raises(WorkbenchError, match="of the controller pd@speed=0,4, and pd flies"):
        load_gains(path, load_controller("pd"))
    path.write_text("gains:\n  kp_roll: 200.0\n", encoding="utf-8")
    assert flown_by("pd", str(path)) == "pd"
    found = load_gains(path, load_controller("pd@height=0,4"))
    assert found.gains == {"kp_roll_at_0": 200.0, "kp_roll_at_4": 200.0}
