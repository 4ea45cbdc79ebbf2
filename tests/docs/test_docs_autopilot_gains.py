"""docs/autopilot-gains.md, walked in an empty folder."""

import re
import shlex
from pathlib import Path

import pytest

from workbench.commands.cli import main
from workbench.gains.autopilots.table import load_table

PAGE = (Path(__file__).parents[2] / "docs" / "autopilot-gains.md").read_text(encoding="utf-8")


def commands() -> list[list[str]]:
    text = "\n".join(re.findall(r"```sh\n(.*?)```", PAGE, re.DOTALL))
    return [shlex.split(line)[1:] for line in text.splitlines() if line]


@pytest.mark.slow
def test_the_road_from_a_data_sheet_to_the_vehicle(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for words in commands():
        # a page must not fail for a slow machine: what the tuner finds is not judged here
        few = ["--evaluations", "12", "--no-plots"] if words[0] == "tune" else []
        done = main([*words, *few])
        assert done in ((0, 1) if words[0] == "tune" else (0,)), words
    assert {path.name for path in tmp_path.iterdir()} >= {
        "f450.urdf.xacro",
        "px4.gains.yaml",
        "f450.params",
        "back.yaml",
        "ardupilot.yaml",
    }
    assert not (tmp_path / "f450.param").exists()


def test_the_road_without_the_search(tmp_path, monkeypatch):
    """The quick part of the road above: the model's own gains in place of tuned ones."""
    monkeypatch.chdir(tmp_path)
    for words in commands():
        if words[0] == "tune":
            kept = words[words.index("--save") + 1]
            words = ["gains", "save", kept, *words[1:5]]
        assert main(words) == 0, words
    text = (tmp_path / "f450.params").read_text()
    assert re.search(r"^1\t1\tMC_ROLLRATE_P\t0\.\d+\t9$", text, re.MULTILINE)


def test_the_python_example_runs(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (code,) = re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL)
    exec(compile(code, "autopilot-gains.md", "exec"), {"__name__": "__main__"})
    assert capsys.readouterr().out == (
        "ardupilot {'ATC_ANG_RLL_P': 4.5} ATC_ANG_RLL_P,6  # by hand\n"
    )


def test_the_factors_on_the_page_are_those_of_the_table():
    rows = [each for name in ("ardupilot", "px4") for each in load_table(name).settings]
    factors = {(each.name, each.law): each.scale for each in rows}
    assert factors["PSC_ACCZ_P", "PSC_D_ACC_P"] == 0.1
    assert factors["PSC_ACCZ_IMAX", "PSC_D_ACC_IMAX"] == 0.001
    assert factors["PSC_VELZ_IMAX", "PSC_D_VEL_IMAX"] == 0.01
    assert factors["PSC_ACCZ_FF", "PSC_D_ACC_FF"] == 1.0
    assert factors["MPC_Z_VEL_P", "MPC_Z_VEL_P_ACC"] == 20.0
    for each in ("PSC_VELXY_", "PSC_POSZ_P", "ATC_SLEW_YAW", "ANGLE_MAX", "WPNAV_SPEED"):
        assert f"`{each}" in PAGE
