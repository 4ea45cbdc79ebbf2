"""docs/first-drone.md, walked from its data sheet to its test; and the smallest descriptions."""

import os
import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

from workbench.commands.cli import main
from workbench.plant.data_sheet import DataSheet, Propeller, figures
from workbench.scenario.scenario import Scenario, VehicleConfig
from workbench.session.session import Session

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "first-drone.md").read_text(encoding="utf-8")
DESCRIPTIONS = (ROOT / "docs" / "descriptions.md").read_text(encoding="utf-8")
REFUSED = "--set kp_roll=60"
"""Of the one command that says no."""


def commands() -> list[str]:
    text = "\n".join(re.findall(r"```sh\n(.*?)```", PAGE, re.DOTALL))
    return [line for line in text.splitlines() if line]


@pytest.mark.slow
def test_the_way_from_a_data_sheet_to_a_test(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    walked = commands()
    assert [shlex.split(line)[1] for line in walked] == [
        "new",
        "inspect",
        "hover",
        "tune",
        "gains",
        "pin",
        "f450.spec.yaml",
        "regress",
    ]
    for line in walked:
        program, *words = shlex.split(line)
        if program == "pytest":
            ran = subprocess.run(
                [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", *words],
                capture_output=True,
                text=True,
                env=os.environ | {"PYTHONPATH": str(ROOT)},
            )
            assert ran.returncode == 0, ran.stdout
            assert "2 passed" in ran.stdout
        else:
            # a page must not fail for a slow machine: what the tuner finds is not judged here
            few = ["--evaluations", "20", "--no-plots"] if words[0] == "tune" else []
            assert main([*words, *few]) == (1 if REFUSED in line else 0), line
    assert "kp_roll" in capsys.readouterr().out
    assert {path.name for path in tmp_path.iterdir()} >= {
        "f450.urdf.xacro",
        "f450.yaml",
        "f450.spec.yaml",
        "f450.gains.yaml",
        "f450.baseline",
    }


def test_the_shown_thrust_curve_is_read(tmp_path, capsys):
    curve = tmp_path / "curve.csv"
    curve.write_text(re.search(r"```csv\n(.*?)```", PAGE, re.DOTALL)[1], encoding="utf-8")
    words = ["--mass", "1.4kg", "--diagonal", "450mm", "--propeller", "10x4.5", "--thrust-curve"]
    assert main(["new", str(tmp_path / "mine"), *words, str(curve)]) == 0
    assert "least squares of the 3 points in curve.csv" in capsys.readouterr().out


def test_the_shares_on_the_page_are_those_of_the_estimates():
    sheet = DataSheet("drone", 1.0, 0.2, Propeller(0.2), max_thrust=5.0)
    said = " ".join(figure.source for figure in figures(sheet))
    for share in ("35 % of the mass", "10 % of the mass", "0.033 s at 5.1 in"):
        assert share in said
        assert share in PAGE.replace("10 % in the arms", "10 % of the mass")


@pytest.mark.parametrize("name", ["smallest", "shortest"])
def test_the_smallest_descriptions_fly(name, tmp_path):
    (text,) = re.findall(
        rf'```xml\n((?:(?!```).)*<robot name="{name}".*?)```', DESCRIPTIONS, re.DOTALL
    )
    path = tmp_path / f"{name}.urdf"
    path.write_text(text, encoding="utf-8")
    if name == "shortest":
        rotors = re.search(r"```yaml\n(# rotors.*?)```", DESCRIPTIONS, re.DOTALL)[1]
        (tmp_path / "shortest.rotors.yaml").write_text(rotors, encoding="utf-8")
    session = Session(Scenario(vehicle=VehicleConfig(model=str(path))))
    session.tick(2.0)
    assert session.snapshot().p_WB[2] == pytest.approx(1.5, abs=0.01)
    assert len(session.vehicle.rotors) == 4
