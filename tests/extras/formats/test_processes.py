"""Processes that read files of others find the formats, too."""

from pathlib import Path

import pytest

from tests.docs.test_pages import blocks
from workbench.design.executor.shipment import shipment
from workbench.ipc.limited import run_limited, run_trusted
from workbench.ipc.sandbox import missing_protections
from workbench.scenario.scenario import Scenario, VehicleConfig

MISSING = missing_protections()


@pytest.fixture
def child(monkeypatch):
    monkeypatch.setenv("PYTHONPATH", str(Path(__file__).parent))
    return "asking_child"


def test_a_process_finds_the_formats(child):
    assert run_trusted(child, {}, seconds=5.0, megabytes=2000) == [2, 2, 1]


@pytest.mark.skipif(bool(MISSING), reason=f"not tested: the kernel lacks {MISSING}")
def test_a_process_that_the_kernel_bounds_finds_the_formats(child):
    assert run_limited(child, {}, seconds=5.0, megabytes=2000, reads=[]) == [2, 2, 1]


def test_the_files_of_a_drone_and_a_world_in_sdf_are_sent(tmp_path):
    for block in blocks("formats.md"):
        if block.file:
            (tmp_path / block.file).write_text(block.text, encoding="utf-8")
    drone, world = tmp_path / "hub.sdf", tmp_path / "yard.sdf"
    files = shipment(Scenario(vehicle=VehicleConfig(model=str(drone)), world=str(world)))
    assert {str(drone), str(world), str(tmp_path / "hub.rotors.yaml")} <= set(files)
