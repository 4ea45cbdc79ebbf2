"""What docs/identification.md shows runs as it stands."""

import re
import shlex
from pathlib import Path

import pytest

from workbench.commands.cli import main

PAGE = (Path(__file__).parents[2] / "docs" / "identification.md").read_text(encoding="utf-8")


@pytest.mark.slow
def test_the_road_runs(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    first = re.findall(r"```sh\n(.*?)```", PAGE, re.DOTALL)[0].splitlines()
    for line in first:
        assert main(shlex.split(line.split("#")[0])[1:]) == 0, line
    said = capsys.readouterr().out
    assert "rotor_lag" in said and "no rotor stands out" in said
    assert Path("out/dh_drone-identified.png").is_file()
