"""What docs/batch.md shows runs as it stands, and what it says of it is so."""

import re
from pathlib import Path

import numpy as np
import pytest

PAGE = (Path(__file__).parents[2] / "docs" / "batch.md").read_text(encoding="utf-8")
BATCH, LEARN, FAST = re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL)


def run(code: str) -> dict:
    names: dict = {}
    exec(code, names)
    return names


def test_the_batch_of_the_page_flies(capsys):
    names = run(BATCH)
    begun = int(names["fast"].sum())
    assert 0 < begun < 256
    said = capsys.readouterr().out
    assert "<Batch of 256 dh_drone with pd, 0 lost>" in said
    assert f"{begun} started again, {1 / 128} to {193 / 128} s" in said


def test_the_environments_of_the_page_fly(capsys):
    names = run(LEARN)
    assert "(64, 18)" in capsys.readouterr().out
    envs = names["envs"].unwrapped
    assert str(envs.single_observation_space.shape[0]) in PAGE
    assert envs._most == 320 and envs._periods == 4
    assert np.isfinite(names["seen"]).all()


def test_the_fast_flight_of_the_page_flies(capsys):
    session = run(FAST)["session"]
    assert "<Recording of dh_drone: 8321 samples>" in capsys.readouterr().out
    assert session.time == pytest.approx(65.0)
