"""The page's modules, by their own tests under node."""

import json
import os
import shutil
import subprocess
from pathlib import Path

import pytest

from tests.link.test_golden_vectors import OUTFIT
from workbench.link.drone_topics import drone_topics

HERE = Path(__file__).parent
OLDEST_NODE = 20


@pytest.fixture(scope="module")
def node():
    found = shutil.which("node")
    if found is None:
        pytest.skip(f"needs node {OLDEST_NODE} or newer: apt-get install nodejs")
    version = subprocess.run([found, "--version"], capture_output=True, text=True, check=True)
    if int(version.stdout.strip().lstrip("v").split(".")[0]) < OLDEST_NODE:
        pytest.skip(f"needs node {OLDEST_NODE} or newer, not {version.stdout.strip()}")
    return found


@pytest.mark.parametrize("module", sorted(HERE.glob("*.test.js")), ids=lambda path: path.name)
def test_module(module, node, tmp_path):
    topics = tmp_path / "topics.json"
    topics.write_text(json.dumps([topic.definition() for topic in drone_topics(OUTFIT)]))
    done = subprocess.run(
        [node, "--test", "--test-reporter=tap", str(module)],
        capture_output=True,
        text=True,
        env={**os.environ, "TOPICS": str(topics)},
        timeout=60,
    )
    assert done.returncode == 0, done.stdout[-5000:] + done.stderr[-2000:]
    assert "\n# tests 0\n" not in done.stdout
