"""Five hundred spoilt descriptions: each gives a vehicle or a sentence, and the process lives."""

import json
import subprocess
import sys
from pathlib import Path

import pytest
import xacro

from tests.installed import FORMATS
from tests.plant.made_up import MJCF, SDF

HERE = Path(__file__).parent
SHARED = HERE.parents[1].parent / "shared" / "models"
BATCHES = 2
BATCH = 250


@pytest.fixture(scope="module")
def originals(tmp_path_factory) -> list[Path]:
    """Descriptions to spoil: ours, an SDF, an MJCF, and the published ones where they are."""
    folder = tmp_path_factory.mktemp("originals")
    if FORMATS:
        (folder / "frame.sdf").write_text(SDF)
        (folder / "frame.xml").write_text(MJCF)
    for name in ("hexacopter", "tilted_quad"):
        path = HERE.parent / "drones" / f"{name}.urdf.xacro"
        text = xacro.process_file(str(path)).toprettyxml()
        (folder / f"{name}.urdf").write_text(text)
    published = [*SHARED.glob("*/*.urdf"), *SHARED.glob("*/*/*.sdf")] if FORMATS else []
    return [*folder.iterdir(), *published]


@pytest.mark.slow
@pytest.mark.parametrize("batch", range(BATCHES))
def test_no_mutation_brings_the_process_down(originals, tmp_path, batch):
    words = [str(HERE / "mutate.py"), str(tmp_path), str(batch * BATCH), str(BATCH)]
    done = subprocess.run(
        [sys.executable, *words, *map(str, originals)], capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr[-2000:]
    result = json.loads(done.stdout)
    assert result["faults"] == []
    assert result["understood"] + result["refused"] == BATCH
    assert result["understood"] > BATCH // 20
    assert result["refused"] > BATCH // 20
