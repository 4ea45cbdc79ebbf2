"""What docs/estimation.md shows flies, and its table has every row of the estimators."""

import re
import shlex
from pathlib import Path

import numpy as np
import pytest

import workbench.estimators
from workbench.commands.cli import main
from workbench.estimation.estimators import find_estimator
from workbench.estimation.settings import ComplementarySettings, EkfSettings
from workbench.scenario.scenario import Scenario, load_scenario
from workbench.session.session import Session

PAGE = (Path(__file__).parents[2] / "docs" / "estimation.md").read_text(encoding="utf-8")


def test_the_scenario_is_read(tmp_path):
    path = tmp_path / "scenario.yaml"
    path.write_text(re.search(r"```yaml\n(.*?)```", PAGE, re.DOTALL)[1], encoding="utf-8")
    assert load_scenario(path).estimator == "ekf"


def test_the_table_has_every_parameter_of_the_estimators():
    named = set(re.findall(r"`((?:ekf|complementary)_\w+)`", PAGE))
    assert named == {*EkfSettings._fields, *ComplementarySettings._fields}


def test_the_python_prints_every_state(capsys):
    exec(re.search(r"```python\n(.*?)```", PAGE, re.DOTALL)[1], {})
    assert [line.split()[0] for line in capsys.readouterr().out.splitlines()] == [
        *("roll", "pitch", "yaw", "x", "y", "z"),
        *("v_x", "v_y", "v_z", "w_x", "w_y", "w_z"),
    ]


@pytest.fixture
def commands(tmp_path, monkeypatch):
    """Write the estimator of the page where the commands that it shows are run."""
    monkeypatch.chdir(tmp_path)
    part = PAGE[PAGE.index("## An estimator of your own") :]
    text, commands = (
        re.search(rf"```{kind}\n(.*?)```", part, re.DOTALL)[1] for kind in ("python", "sh")
    )
    Path("my_filter.py").write_text(text, encoding="utf-8")
    return [shlex.split(line)[1:] for line in commands.splitlines()]


def test_the_estimator_of_the_page_is_one(commands):
    own = find_estimator("my_filter.py")
    assert [row.name for row in own.parameters][0] == "k_attitude"
    assert sum("my_filter.py" in command for command in commands) > 4
    session = Session(Scenario(estimator="my_filter.py"))
    session.tick(1.0)
    assert np.abs(session.recording().estimate[:, 4:7] - session.recording().p_WB).max() < 0.1


@pytest.mark.slow
def test_the_estimator_of_the_page_flies_as_it_shows(commands):
    for command in commands:
        assert main(command) == 0, command
    session = Session(Scenario(estimator="my_filter.py"))
    session.tick(10.0)
    assert np.abs(session.recording().estimate[:, 4:7] - session.recording().p_WB).max() < 0.1


def test_the_page_names_all_that_a_file_may_import():
    names = [name for name in vars(workbench.estimators) if name[0].isalpha()]
    assert len(names) > 15
    assert [name for name in names if f"`{name}" not in PAGE] == []


@pytest.mark.slow
def test_a_log_is_estimated_as_the_page_shows(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    lines = re.search(r"## Over a log.*?```sh\n(.*?)```", PAGE, re.DOTALL)[1].splitlines()
    commands = [shlex.split(line, comments=True)[1:] for line in lines]
    assert [command[0] for command in commands] == ["fly", *["estimate"] * 3]
    for command in commands:
        assert main(command) == 0, command
    for suffix in (".csv", ".png"):
        assert Path("out/flight-estimate").with_suffix(suffix).is_file()
    capsys.readouterr()
    exec(re.search(r"```python\n(# over a log\n.*?)```", PAGE, re.DOTALL)[1], {})
    time, *_ = capsys.readouterr().out.split()
    assert 4.9 < float(time) <= 5.0
