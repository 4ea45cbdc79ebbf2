"""`workbench gains`."""

import pytest

from workbench.common.resources import find_model
from workbench.gains.gain_choice import flight_gains, rule_gains
from workbench.gains.gains import load_gains
from workbench.plant.loading import load_vehicle

DRONE = load_vehicle(find_model("dh_drone"))
CONTROLLER = 18
"""Rows of the controller, as counted in the table."""


@pytest.fixture
def gain_file(run, tmp_path):
    """A file of three states: kp_velocity_z 4.4, 3, 2."""
    path = tmp_path / "mine.yaml"
    assert run("gains", "save", path).code == 0
    for value in (3, 2):
        words = ("--set", f"kp_velocity_z={value}", "--origin", f"tried {value}")
        assert run("gains", "save", path, *words).code == 0
    return path


def test_show_prints_the_gains_that_a_model_flies_with(run):
    said = run("gains", "show", "--json").json
    assert said["vehicle"] == "dh_drone"
    values = {row["name"]: row["value"] for row in said["gains"]}
    everything = flight_gains(DRONE)
    assert len(values) == CONTROLLER + 2
    assert values == {name: everything[name] for name in values}
    rows = {row["name"]: row for row in said["gains"]}
    assert rows["kp_roll"]["unit"] == "1/s^2"
    assert rows["kp_roll"]["origin"].endswith("dh_drone/gains.yaml")
    assert rows["max_speed"]["origin"] == "default"


def test_show_prints_a_file(run, write):
    path = write("a.yaml", "vehicle: q\norigin: by hand\ngains: {max_tilt: 0.5 rad}\n")
    assert run("gains", "show", path).out.splitlines() == [
        "vehicle: q",
        "controller: pd",
        "origin: by hand",
        "max_tilt  0.5  rad",
    ]
    assert run("gains", "show", path, "--json").json == {
        "vehicle": "q",
        "controller": "pd",
        "origin": "by hand",
        "gains": [{"name": "max_tilt", "value": 0.5, "unit": "rad", "origin": ""}],
    }


def test_diff_compares_a_model_with_its_rule(run):
    rows = {
        row["name"]: row for row in run("gains", "diff", "dh_drone", "rule", "--json").json["rows"]
    }
    rule = rule_gains(DRONE)
    assert {name: rows[name]["b"] for name in rule} == rule
    assert rows["kp_roll"]["a"] == 225.0
    assert rows["kp_roll"]["percent"] == pytest.approx(100.0 * (rule["kp_roll"] / 225.0 - 1.0))


def test_diff_takes_what_a_file_lacks_from_the_rule(run, write):
    a, b = (write(f"{n}.yaml", f"gains: {{{n}: 1.0}}\n") for n in ("kp_roll", "kp_pitch"))
    rows = {row["name"]: row for row in run("gains", "diff", a, b, "--json").json["rows"]}
    rule = rule_gains(DRONE)
    assert set(rows) == {"kp_roll", "kp_pitch"}
    assert (rows["kp_roll"]["a"], rows["kp_roll"]["b"]) == (1.0, rule["kp_roll"])
    assert (rows["kp_pitch"]["a"], rows["kp_pitch"]["b"]) == (rule["kp_pitch"], 1.0)


def test_diff_prints_only_what_differs(run, gain_file):
    lines = run("gains", "diff", gain_file, "dh_drone").out.splitlines()
    assert [line.split() for line in lines[1:]] == [
        ["kp_velocity_z", "2", "4.4", "1/s", "+120.0", "%"],
        ["19", "others", "are", "equal"],
    ]
    assert run("gains", "diff", "default", "default").out == "no difference in 20 gains\n"


def test_what_is_saved_flies_the_same(run, gain_file):
    said = run("params", "--gains", gain_file, "--json").json["parameters"]
    values = {row["name"]: row["value"] for row in said}
    own = {row["name"]: row["value"] for row in run("params", "--json").json["parameters"]}
    assert values == {**own, "kp_velocity_z": 2.0}
    assert load_gains(gain_file).vehicle == "dh_drone"
    assert load_gains(gain_file).origin == "tried 2"


def test_save_builds_on_another_file_and_says_so(run, write, tmp_path):
    other, path = write("other.yaml", "gains: {kp_roll: 99.0}\n"), tmp_path / "new.yaml"
    said = run("gains", "save", path, "--gains", other, "--set", "kd_roll=9", "--json")
    assert said.json["gains"]["kp_roll"] == 99.0
    assert said.json["state"] == 0
    file = load_gains(path)
    assert (file.gains["kp_roll"], file.gains["kd_roll"]) == (99.0, 9.0)
    assert file.origin == f"dh_drone with {other} and kd_roll=9"


def test_history_lists_the_states(run, gain_file):
    states = run("gains", "history", gain_file, "--json").json["states"]
    assert [state["state"] for state in states] == [0, 1, 2]
    assert [state["changed"] for state in states] == [
        {},
        {"kp_velocity_z": [4.4, 3.0]},
        {"kp_velocity_z": [3.0, 2.0]},
    ]
    lines = run("gains", "history", gain_file).out.splitlines()
    assert lines[0].split()[0] == "state"
    assert lines[2].endswith("kp_velocity_z 4.4 to 3  tried 3")


def test_history_of_a_file_by_hand(run, write):
    path = write("a.yaml", "gains: {kp_roll: 1.0}\n")
    assert "no state was saved yet" in run("gains", "history", path).out
    assert run("gains", "history", path, "--json").json["states"] == []


def test_restore_brings_a_state_back(run, gain_file):
    before = load_gains(gain_file).gains["kp_velocity_z"]
    said = run("gains", "restore", gain_file, "0")
    (row,) = [line.split() for line in said.out.splitlines() if "kp_velocity_z" in line]
    assert row[1:3] == [f"{before:g}", "4.4"]  # from what the file had to what it has
    file = load_gains(gain_file)
    assert file.gains["kp_velocity_z"] == 4.4
    assert len(file.history) == 4
    assert f"wrote {gain_file}" in said.err


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ([], "show, diff, save, history or restore"),
        (["shoe"], "unknown command 'shoe'"),
        (["show", "gone.yaml"], "gone.yaml: no such file"),
        (["diff", "dh_drone"], "required: B"),
        (["diff", "dh_drone", "dh_dron"], "did you mean 'dh_drone'"),
        (["diff", "dh_drone", "gone.yaml"], "gone.yaml: no such file"),
        (["save", "gains.txt"], "ends in .yaml"),
        (["save", "gone/gains.yaml"], "cannot be written"),
        (["save", "/dev/null/gains.yaml"], "cannot be written: Not a directory"),
        (["save", "gains.yaml", "--set", "rotor_1=0.5"], "rotor_1 is not a gain"),
        (["save", "gains.yaml", "--model", "gone"], "unknown model"),
        (["history", "gone.yaml"], "gone.yaml: no such file"),
        (["restore", "gone.yaml", "0"], "gone.yaml: no such file"),
        (["restore", "gone.yaml", "last"], "last"),
    ],
)
def test_bad_input_is_a_sentence_and_leaves_nothing(refused, tmp_path, monkeypatch, words, said):
    monkeypatch.chdir(tmp_path)
    assert said in refused("gains", *words)
    assert list(tmp_path.iterdir()) == []


def test_a_state_that_is_not_there_leaves_the_file(refused, gain_file):
    before = gain_file.read_bytes()
    assert "no state 7" in refused("gains", "restore", gain_file, "7")
    assert gain_file.read_bytes() == before
