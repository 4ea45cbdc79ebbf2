"""The script in Meshcat's page, in the real web engine."""

import contextlib
import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("PyQt6.QtWebEngineWidgets", reason="the web engine is not installed")
SCRIPT = Path(__file__).with_name("engine_page.py")


HEARD = ("home", "along", "follow", "turned", "top", "side", "cured")
"""Where the camera stood and what it looked at."""
LIMIT = 200.0
"""More than the script gives its page for any one answer [s]."""


def test_the_page_says_how_it_does_and_the_camera_goes_where_it_is_told(tmp_path):
    # files, as the web engine's own processes may outlive the script, and would hold pipes open
    said, noise = tmp_path / "said", tmp_path / "noise"
    with said.open("w") as out, noise.open("w") as error:
        process = subprocess.Popen(
            [sys.executable, str(SCRIPT)], stdout=out, stderr=error, start_new_session=True
        )
        try:
            code = process.wait(LIMIT)
        except subprocess.TimeoutExpired:
            pytest.skip("the web engine of this machine has not answered")
        finally:
            with contextlib.suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)
            process.wait()
    assert code == 0, noise.read_text()[-2000:]
    found = json.loads(said.read_text().splitlines()[-1])
    if found["state"]["fault"]:
        pytest.skip(f"the web engine of this machine does not draw: {found['state']['fault']}")
    assert found["state"]["connected"]
    names = (*HEARD, "replayed", "still", "back", "free")
    cameras = {name: np.array(found[name]) for name in names}
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

    assert found["controls"] == "none", "nothing of Meshcat's own covers the picture"
    assert found["at"] == [7.0, 8.0, 9.0]
    assert (found["shown"], found["copied"], found["hidden"]) == ("true", "1", "false")
    assert found["opacity"] == [0.5], "the drone of a log is pale"
    assert cameras["replayed"][3:] == pytest.approx([7.0, 9.0, -8.0]), "the camera goes there"
    assert way["replayed"] == pytest.approx(way["cured"])
    assert cameras["still"] == pytest.approx(cameras["replayed"])
    assert cameras["back"][3:] == pytest.approx([1.0, 1.0, 0.0]), "and back to the flight"
    assert cameras["free"] == pytest.approx(cameras["back"]), "a free one stays"
