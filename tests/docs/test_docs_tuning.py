"""What the page on tuning shows runs as it stands."""

import re
import shlex
from pathlib import Path

import pytest

from workbench.commands.cli import main
from workbench.control.controller import load_controller
from workbench.design.metrics import WISHED
from workbench.design.tune.wish import GROUPS, load_wishes, subjects_of

PAGE = (Path(__file__).parents[2] / "docs" / "tuning.md").read_text(encoding="utf-8")


def shown(language: str) -> str:
    found = re.search(rf"```{language}\n(.*?)```", PAGE, re.DOTALL)
    assert found
    return found[1]


@pytest.mark.slow
def test_the_command_finds_gains(tmp_path, capsys):
    """With few candidates: what is better than needed is not waited for."""
    words = shlex.split(shown("sh"))[1:]
    few = ["--evaluations", "12", "--no-plots", "--output", str(tmp_path / "out")]
    assert main([*words, *few]) == 0
    assert (tmp_path / "out" / "tuned.yaml").is_file()
    assert "flown on the full diagram" in capsys.readouterr().out


def test_the_file_of_wishes_is_read(tmp_path):
    path = tmp_path / "wishes.yaml"
    path.write_text(shown("yaml"), encoding="utf-8")
    wishes = load_wishes(path)
    assert len(wishes.wishes) == 3
    assert dict(wishes.steps)["yaw"] == 0.3


@pytest.mark.slow
def test_the_python_example_runs(capsys):
    exec(compile(shown("python"), "tuning.md", "exec"), {"__name__": "__main__"})
    assert capsys.readouterr().out.startswith("True {'kp_yaw_rate': ")


def test_all_that_can_be_wished_for_is_listed():
    law = load_controller()
    names = [metric.name for metric in WISHED] + list(GROUPS)
    names += dict.fromkeys(each for metric in WISHED for each in subjects_of(metric, law))
    missing = [name for name in names if f"`{name}`" not in PAGE]
    alike = [f"{what}_{axis}" for what in ("velocity", "position") for axis in "yz"]
    points = ("position_{}_error", "velocity_{}_error", "acceleration_{}")
    assert missing == alike + [point.format(axis) for point in points for axis in "yz"]
