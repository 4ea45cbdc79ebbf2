"""Nothing that clients do makes the server fail, keep too much, or harm a client that is good."""

import importlib.util
import sys
from pathlib import Path

import pytest

SEQUENCES = 1000
PARTS = 8


@pytest.fixture(scope="module")
def sequences():
    """Return the module beside this, which is no test; benchmarks use it too."""
    path = Path(__file__).with_name("sequences.py")
    spec = importlib.util.spec_from_file_location("link_sequences", path)
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module


@pytest.mark.parametrize(
    "part", [0, *(pytest.param(part, marks=pytest.mark.slow) for part in range(1, PARTS))]
)
def test_no_sequence_of_operations_does_harm(parts, sequences, part):
    for seed in range(part, SEQUENCES, PARTS):
        assert sequences.play(parts, seed) == [], f"seed {seed}"
