"""The script in Meshcat's page, in the real web engine."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("PyQt6.QtWebEngineWidgets", reason="the web engine is not installed")
SCRIPT = Path(__file__).with_name("engine_page.py")


def test_the_page_says_how_it_does_and_the_camera_goes_where_it_is_told():
    done = subprocess.run([sys.executable, str(SCRIPT)], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr[-2000:]
    found = json.loads(done.stdout.splitlines()[-1])
    assert (found["state"]["fault"], found["state"]["connected"]) == ("", True)
    cameras = {name: np.array(each) for name, each in found.items() if name != "state"}
    way = {name: each[:3] - each[3:] for name, each in cameras.items()}  # x east, y up, z south

    assert cameras["home"][3:] == pytest.approx([0.0, 1.0, 0.0])
    assert cameras["along"][3:] == pytest.approx([30.0, 5.0, -20.0])
    assert way["along"] == pytest.approx(way["home"]), "the camera comes along"
    far = np.linalg.norm(way["home"])
    assert way["follow"] / far == pytest.approx([-0.94, 0.34, 0.0], abs=0.01)
    assert way["turned"] / far == pytest.approx([0.0, 0.34, 0.94], abs=0.01), "north is ahead"
    assert way["top"] / np.linalg.norm(way["top"]) == pytest.approx([0.0, 1.0, 0.0], abs=0.01)
    assert way["side"] / np.linalg.norm(way["side"]) == pytest.approx([0.0, 0.1, 1.0], abs=0.01)
    assert cameras["cured"] == pytest.approx(cameras["along"]), "a reset needs nothing of before"
