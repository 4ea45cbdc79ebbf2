"""Files that are small to send and large to read, without their time and memory.

`benchmarks/bombs.py` measures these.
"""

import importlib
import sys
from pathlib import Path

import pytest

from workbench.commands.cli import main
from workbench.plant.formats import xacro

sys.path.insert(0, str(Path(__file__).parents[1] / "benchmarks"))
BOMBS = importlib.import_module("bombs")
ALL = BOMBS.all_bombs()
sys.path.pop(0)


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=[] if bomb.quick else [pytest.mark.slow])
        for name, bomb in ALL.items()
    ],
)
def test_a_bomb_ends_with_a_sentence(tmp_path, monkeypatch, capsys, name):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.setattr(xacro, "_XACRO_CPU_S", 1.0)  # a dozen of them compute until they are ended
    monkeypatch.chdir(tmp_path)
    code = main(BOMBS.lay(ALL[name], tmp_path))
    lines = capsys.readouterr().err.strip().splitlines()
    assert code in (0, 2)
    assert lines or code == 0
    for said in lines[-1:]:
        assert said.startswith("workbench: ")
        assert len(said) < 1000
