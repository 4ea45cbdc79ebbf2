"""The list of mutations fits the source, so that it can be run any time."""

import dataclasses
import importlib
from pathlib import Path

import pytest

TOOLS = Path(__file__).resolve().parent.parent / "tools"


@pytest.fixture
def tool(monkeypatch):
    monkeypatch.syspath_prepend(TOOLS)
    return importlib.import_module("mutations")


def test_each_mutation_fits_the_source(tool):
    pytest.importorskip("workbench.extras", reason="it is about all that is installed")
    tool.check_list(tool.MUTATIONS)
    assert len(tool.MUTATIONS) >= 25
    assert len({mutation.what for mutation in tool.MUTATIONS}) == len(tool.MUTATIONS)


def test_a_mutation_that_fits_no_longer_is_named(tool):
    stale = dataclasses.replace(tool.MUTATIONS[0], old="this stands nowhere")
    with pytest.raises(tool.MutationError, match="0 times") as caught:
        tool.check_list([stale])
    assert stale.what in str(caught.value)
    twice = dataclasses.replace(stale, old="return")
    with pytest.raises(tool.MutationError, match="times, not once"):
        tool.check_list([twice])
