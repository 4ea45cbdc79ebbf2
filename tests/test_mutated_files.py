"""Mutated copies of all files that others write: understood, or refused with one sentence.

`benchmarks/mutated_files.py` reads a hundred thousand.
"""

import importlib
import os
import random
from pathlib import Path

import pytest

from workbench.common.errors import WorkbenchError
from workbench.logs.readers.mcap_log import read_mcap

BENCHMARKS = Path(__file__).parents[1] / "benchmarks"
SEED = 38


@pytest.fixture
def load(monkeypatch):
    """Load modules of the benchmarks, which are no package."""
    monkeypatch.syspath_prepend(BENCHMARKS)
    return importlib.import_module


@pytest.mark.parametrize("count", [20, pytest.param(2000, marks=pytest.mark.slow)])
def test_mutated_files_are_understood_or_refused_with_a_sentence(load, count):
    pytest.importorskip("workbench.extras", reason="it is about all that is installed")
    tally = load("mutated_files").measure(SEED, range(count), jobs=os.cpu_count() or 1)
    assert tally.faults == []
    assert tally.understood.total() + tally.refused.total() == count
    if count == 2000:
        kinds = load("mutated_reader").KINDS
        assert set(tally.understood) == set(kinds)
        assert set(kinds) - set(tally.refused) <= LEFT_OUT


LEFT_OUT = {"mesh-binary", "mesh-text", "mesh-xml", "log-metadata"}
"""Kinds of files beside another one, which is read without them and with a remark."""


def test_what_is_neither_is_a_fault(load, tmp_path, case, monkeypatch):
    reader = load("mutated_reader")
    monkeypatch.setattr(reader, "LONGEST", 300)
    watch = reader.Watch()

    def fail(path):
        raise KeyError("x")

    def refuse(path):
        raise WorkbenchError("a" * 301)

    def spin(path):
        while True:
            pass

    def understand(path):
        return None

    for command, said in (
        (understand, 0),
        ("inspect {folder}/gone.urdf", 2),
        (fail, "KeyError"),
        (refuse, "no sentence"),
        ("regress {folder}/gone", 2),
    ):
        with case(said):
            outcome = reader.outcome_of(command, tmp_path / "a", watch)
            assert outcome == said if isinstance(said, int) else said in outcome
    with pytest.raises(reader.TooLongError), watch.limit(0.1):
        spin(tmp_path)


def test_mutated_chunks_are_whole(load, tmp_path):
    """Their frames and checksums are right, so that what is behind them is reached."""
    mutate = load("mutated_bytes").mutated_mcap
    data = (BENCHMARKS.parent / "tests/outside/given/flight.mcap").read_bytes()
    path, reached = tmp_path / "a.mcap", 0
    for seed in range(12):
        path.write_bytes(mutate(data, random.Random(seed)))
        try:
            record = read_mcap(path)
        except WorkbenchError:
            continue
        reached += "damaged" in record.remark or any(t.damage for t in record.topics.values())
    assert reached > 2
    assert mutate(data, random.Random(1)) == mutate(data, random.Random(1)) != data
