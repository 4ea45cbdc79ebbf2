"""What docs/estimation.md shows flies, and its table has every row of the estimators."""

import re
from pathlib import Path

from workbench.estimation.settings import ComplementarySettings, EkfSettings
from workbench.scenario.scenario import load_scenario

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
