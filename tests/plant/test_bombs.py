"""Files that are small to send and large to read, without their time and memory.

`benchmarks/bombs.py` measures these.
"""

import importlib
import sys
from pathlib import Path

import pytest

from workbench.commands.cli import main

sys.path.insert(0, str(Path(__file__).parents[2] / "benchmarks"))
BOMBS = importlib.import_module("bombs")
sys.path.pop(0)


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=[] if bomb.quick else [pytest.mark.slow])
        for name, bomb in BOMBS.BOMBS.items()
    ],
)
def test_a_bomb_ends_with_a_sentence(tmp_path, monkeypatch, capsys, name):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.chdir(tmp_path)
    assert main(BOMBS.lay(BOMBS.BOMBS[name], tmp_path)) in (0, 2)
    *_, said = capsys.readouterr().err.strip().splitlines()
    assert said.startswith("workbench: ")
    assert len(said) < 1000
