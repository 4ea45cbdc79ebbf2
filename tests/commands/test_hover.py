"""`workbench hover`."""

import csv
import math
from functools import partial
from pathlib import Path

import pytest

from workbench.design import hover_check
from workbench.design.hover_check import check_hover
from workbench.design.step_response import fly_step

DRONES = Path(__file__).parent.parent / "drones"
QUAD = ("--model", DRONES / "palm_quad.urdf.xacro")
PNG = b"\x89PNG"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("hover") / "out"


@pytest.fixture(scope="module")
def reports():
    """What was measured of `said`."""
    return []


@pytest.fixture(scope="module")
def said(run, folder, reports):
    def check_and_keep(*arguments, **named):
        reports.append(check_hover(*arguments, **named))
        return reports[-1]

    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(hover_check, "HOVER_DURATION_S", 2.0)
        patched.setattr(hover_check, "fly_step", partial(fly_step, duration=2.2))
        patched.setattr(hover_check, "check_hover", check_and_keep)
        return run("hover", *QUAD, "--output", folder, "--json")


@pytest.fixture
def with_gains(tmp_path):
    """Options with one gain from a file, and one that spoils a quadrotor."""
    gains = tmp_path / "mine.yaml"
    gains.write_text("gains: {kp_yaw_rate: 2.5}\n")
    return ("--gains", gains, "--set", "kd_roll=1", "--no-plots", "--output", tmp_path)


def test_it_hovers_and_answers_as_demanded(said):
    assert said.code == 0, said.err
    found = said.json
    assert found["met"] is True
    assert (found["vehicle"], found["mass"]) == ("palm_quad", 0.03)
    assert found["source"].endswith("palm_quad.urdf.xacro")
    assert found["hover"]["duration"] == 2.0
    assert 0.0 < found["hover"]["drift"] <= 0.05
    assert 0.0 < found["hover"]["tilt"] <= 0.0087
    assert [(step["axis"], step["amplitude"]) for step in found["steps"]] == [
        ("x", 1.0),
        ("y", 1.0),
        ("z", 1.0),
        ("yaw", 0.2),
    ]
    assert all(step["Overshoot"] <= 15.0 for step in found["steps"])
    assert {demand["met"] for demand in found["demands"]} == {True}


def test_gains_come_with_their_origin(said):
    gains = said.json["gains"]
    assert gains["kp_roll"]["origin"] == "rule"
    assert gains["kp_roll"]["value"] == 92.5
    assert gains["max_speed"]["origin"] == "default"


def test_plot_and_log_are_written_and_nothing_else(said, folder):
    assert {path.name for path in folder.iterdir()} == {"hover-check.csv", "hover-check.png"}
    assert set(said.json["files"]) == {str(path) for path in folder.iterdir()}
    assert (folder / "hover-check.png").read_bytes()[:4] == PNG
    rows = list(csv.reader((folder / "hover-check.csv").read_text().splitlines()))
    assert rows[0][0] == "t [s]"
    assert float(rows[-1][0]) == pytest.approx(2.0)


@pytest.mark.slow
def test_what_is_not_as_demanded_is_named_and_returns_1(run, with_gains):
    bad = run("hover", *QUAD, *with_gains)
    assert bad.code == 1
    assert "requirements not met: drift of the hover is " in bad.err
    assert "m (at most 0.05 m)" in bad.err
    assert "overshoot of the y step" in bad.err
    lines = {line.partition("  ")[0]: line for line in bad.out.splitlines()}
    assert lines["hover: drift"].endswith(" not ok")
    assert lines["z step 1 m/s: overshoot"].endswith(" ok")
    assert "0.5  deg" in lines["hover: tilt"]


def test_the_table_says_which_vehicle_and_whose_gains(run, said, reports, with_gains, monkeypatch):
    monkeypatch.setattr(hover_check, "check_hover", lambda *_, **_more: reports[0])
    first, *lines = run("hover", *QUAD, *with_gains).out.splitlines()
    assert first.startswith("palm_quad, 0.03 kg, 4 rotors: ")
    heads = [index for index, line in enumerate(lines) if line.startswith("gains from ")]
    below = {lines[index].split("/")[-1]: lines[index + 1].split() for index in heads}
    assert below.keys() == {
        "gains from the rule for any vehicle:",
        "mine.yaml:",
        "gains from --set:",
    }
    assert below["mine.yaml:"] == ["kp_yaw_rate", "2.5", "1/s"]
    assert below["gains from --set:"] == ["kd_roll", "1", "1/s"]
    assert any("largest rotor speed" in line for line in lines)
    (tilt,) = (line for line in lines if line.startswith("hover: tilt"))
    degrees = math.degrees(said.json["hover"]["tilt"])
    assert tilt.split()[2:] == [f"{degrees:.3f}", "0.5", "deg", "ok"]


@pytest.mark.parametrize(
    ("options", "word"),
    [
        (["--model", "gone.urdf"], "gone.urdf"),
        (["--set", "kp_rol=1"], "did you mean 'kp_roll'?"),
        (["--gains", "gone.yaml"], "no such file"),
        (["--arg", "mass:=50"], "too heavy"),
    ],
)
def test_bad_input_is_a_sentence_and_leaves_nothing(refused, out, options, word):
    assert word in refused("hover", "--output", out, *options)
    assert not out.parent.exists()


@pytest.mark.slow
def test_ok_is_not_said_of_a_drone_that_can_hardly_be_one(run, write, tmp_path):
    """Its moments of inertia are a thousand times too large, and yet it hovers."""
    text = (DRONES / "palm_quad.urdf.xacro").read_text(encoding="utf-8")
    slip = text.replace(
        'ixx="1.7e-5" iyy="1.6e-5" izz="2.9e-5"', 'ixx="0.017" iyy="0.016" izz="0.029"'
    )
    assert slip != text
    write("parts.xacro", (DRONES / "parts.xacro").read_text(encoding="utf-8"))
    model = write("slip.urdf.xacro", slip)
    said = run("hover", "--model", model, "--no-plots", "--output", tmp_path)
    assert "this is unusual for a drone:" in said.out
    assert "moment of inertia about x" in said.out.split("this is unusual")[1]
    assert said.code == (0 if "all ok, but" in said.out else 1)
