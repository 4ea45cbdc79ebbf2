"""`workbench tune`."""

import re
import signal
from pathlib import Path

import pytest

from workbench.commands.cli import main
from workbench.design.metrics import WISHED_METRICS
from workbench.design.tune import tuner
from workbench.design.tune.tuning_plan import make_plan
from workbench.design.tune.wish import SUBJECT_GROUPS
from workbench.gains.gains import load_gains

PALM = Path(__file__).parent.parent / "drones" / "palm_quad.urdf.xacro"
PNG = b"\x89PNG"
FILE = """\
wishes:
  - yaw.rise_time <= 0.3 s
  - yaw.overshoot <= 3 %
robustness: {mass: 0, inertia: 0}
defaults: false
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("tune") / "out"


@pytest.fixture(scope="module")
def said(run, folder, tmp_path_factory):
    path = tmp_path_factory.mktemp("wishes") / "wishes.yaml"
    path.write_text(FILE, encoding="utf-8")
    wishes = ("--wishes", path, "--wish", "yaw_rate.phase_margin>=50deg")
    options = ("--wish", "yaw.overshoot<=4%", "--set", "kp_yaw_rate=1", "--output", folder)
    return run("tune", "--model", PALM, *wishes, *options, "--json")


@pytest.fixture(scope="module")
def unmet(run, folder):
    wishes = ("--wish", "yaw.rise_time<=0.02", "--wish", "yaw_rate.phase_margin>=60deg")
    options = ("--no-defaults", "--no-plots", "--evaluations", "40", "--output", folder / "unmet")
    return run("tune", "--model", PALM, *wishes, *options)


def test_it_finds_gains_and_proves_them(said):
    assert said.code == 0, said.err
    found = said.json
    assert found["met"] is True
    assert found["stopped"] is False
    assert found["gains"]["kp_yaw_rate"]["before"] == 1.0
    flown = {row["wish"]: row["flown"] for row in found["proof"] if row["case"]["rotor_lag"] == 1.0}
    assert flown["yaw.rise_time"] <= 0.3
    assert {row["wish"] for row in found["wishes"]} == {
        "yaw.rise_time",
        "yaw.overshoot",
        "yaw_rate.phase_margin_deg",
    }
    assert {row["origin"].rpartition("/")[2] for row in found["wishes"]} == {
        "wishes.yaml:2",
        "--wish",
    }
    nominal = {row["wish"]: row for row in found["wishes"] if row["case"]["rotor_lag"] == 1.0}
    assert nominal["yaw.overshoot"]["bound"] == 4.0  # the file has 3
    assert {row["case"]["rotor_lag"] for row in found["wishes"]} == {0.5, 1.0, 1.5}
    margin = next(
        row for row in found["wishes"] if "margin" in row["wish"] and row["origin"] == "--wish"
    )
    assert (margin["unit"], margin["bound"]) == ("deg", pytest.approx(50.0))
    assert 50.0 <= margin["after"] < 180.0
    assert all(row["met"] for row in found["wishes"] + found["proof"])


def test_gain_file_report_and_picture_are_written(said, folder):
    names = {"tuned.yaml", "tuning.html", "tuning.png"}
    assert {Path(path).name for path in said.json["files"]} == names
    assert (folder / "tuning.png").read_bytes()[:4] == PNG
    assert "yaw.rise_time" in (folder / "tuning.html").read_text(encoding="utf-8")
    file = load_gains(folder / "tuned.yaml")
    assert file.vehicle == "palm_quad"
    assert file.gains["kp_yaw_rate"] == said.json["gains"]["kp_yaw_rate"]["after"]


def test_what_cannot_be_met_writes_no_gain_file_and_returns_1(unmet, folder):
    assert unmet.code == 1
    assert "yaw.rise_time <= 0.02 s cannot be met" in unmet.err
    assert "the nearest has" in unmet.err
    assert {path.name for path in (folder / "unmet").iterdir()} == {"tuning.html"}


def test_the_table_has_wishes_and_gains(unmet):
    lines = {line.split("  ")[0]: line for line in unmet.out.splitlines() if line}
    assert lines["yaw.rise_time"].endswith("not ok")
    assert lines["kp_yaw_rate"].endswith("1/s")
    assert "<= 0.02 s" in lines["yaw.rise_time"]


def test_bad_input_is_a_sentence_and_leaves_nothing(case, refused, out):
    for options, word in [
        (["--wish", "x.rise_tim<=1"], "did you mean 'rise_time'"),
        (["--wish", "pich.phase_margin>=45deg"], "did you mean 'pitch'"),
        (["--wish", "pitch.phase_margin>=45"], "say deg"),
        (["--wish", "x.rise_time<=0.1", "--wish", "x.rise_time>=0.2"], "contradicts"),
        (["--wishes", "gone.yaml"], "no such file"),
        (["--budget", "0"], "'0' is not a number above 0"),
        (["--evaluations", "1.5"], "'1.5' is not a number above 0"),
        (["--no-defaults"], "there are no wishes"),
        (["--model", "gone.urdf"], "gone.urdf"),
        (["--set", "kp_rol=1"], "did you mean 'kp_roll'"),
    ]:
        with case(options, word):
            assert word in refused("tune", "--output", out, *options)
            assert not out.parent.exists()


def test_ctrl_c_before_the_search_ends_the_command_at_once(run, out, monkeypatch):
    def interrupted(*given, **more):
        signal.raise_signal(signal.SIGINT)
        return make_plan(*given, **more)

    monkeypatch.setattr(tuner, "make_plan", interrupted)
    yaw = ("--wish", "yaw.rise_time<=0.3", "--no-defaults")
    said = run("tune", "--model", PALM, *yaw, "--output", out)
    assert said.code == 130
    assert said.err.splitlines()[-1] == "workbench: interrupted; nothing was written"
    assert "the best so far" not in said.err
    assert not out.parent.exists()


def test_a_gain_file_of_another_vehicle_is_refused_before_the_search(refused, out, write):
    path = write("other.yaml", "vehicle: other\ngains: {kp_roll: 100}\n")
    said = refused("tune", "--model", PALM, "--save", path, "--output", out)
    assert "has the gains of 'other'" in said
    assert not out.parent.exists()


def test_a_file_that_cannot_be_written_is_refused_before_the_search(
    refused, out, write, monkeypatch
):
    def search(*_, **__):
        raise AssertionError("it searched")

    monkeypatch.setattr("workbench.design.tune.tuner.Tuner.run", search)
    beside = write("no_folder", "")
    said = refused("tune", "--model", PALM, "--save", beside / "tuned.yaml", "--output", out)
    assert "tuned.yaml: cannot be written" in said
    assert "name another place" in said
    said = refused("tune", "--model", PALM, "--save", beside.parent, "--output", out)
    assert "is a folder" in said
    assert not out.parent.exists()


def test_a_variation_of_the_callers_is_refused(refused):
    assert "leave the variation out" in refused("tune", "--vary", "mass=1.1")


def test_the_help_names_every_wish(capsys):
    with pytest.raises(SystemExit):
        main(["tune", "--help"])
    help_text = capsys.readouterr().out.partition("  --wish WISH")[2].partition("  --wishes")[0]
    words = set(re.findall(r"\w+", help_text))
    assert {*(metric.name for metric in WISHED_METRICS), *SUBJECT_GROUPS, "rotors"} <= words
