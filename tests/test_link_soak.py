"""Two minutes of connects, disconnects, stalls and floods beside a flight: nothing grows.

`benchmarks/link_soak.py` does the same for half an hour, with the real-time factor.
"""

import importlib

import pytest

pytestmark = pytest.mark.slow

MINUTES = 1.0
WARM = 6.0
"""What a process may still take after the first tenth: caches, pieces that malloc keeps [MB]."""


@pytest.fixture(scope="module")
def soaked():
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend("benchmarks")
        return importlib.import_module("link_soak").measure(MINUTES)


def test_harm_was_done_and_refused(soaked):
    assert soaked.harm >= 0.9 * 60.0 * MINUTES
    assert soaked.refused > 100


@pytest.mark.parametrize("process", ["server", "flight"])
def test_neither_process_grows(soaked, process):
    (row,) = (each for each in soaked.rows if each.process == process)
    assert row.threads_end <= row.threads_start
    assert row.descriptors_end <= row.descriptors_start + 1
    assert row.memory_end - row.memory_start < WARM


def test_who_behaves_is_served_all_the_time(soaked):
    assert soaked.good_ended == ""
