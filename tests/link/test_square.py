"""A client that was written from docs/protocol.md alone flies a square."""

import math
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from workbench.link.server.config import ServerConfig
from workbench.live.flight import LiveFlight
from workbench.scenario.scenario import Scenario, ScenarioStart

pytestmark = pytest.mark.slow

SQUARE = Path(__file__).resolve().parents[2] / "examples" / "link" / "square.py"
ENOUGH = 300.0
"""No test waits so long unless it fails [s]."""
SPEED = 2.0
"""Of the flight, to be done sooner."""


@pytest.fixture(scope="module")
def flown():
    """Return what the client printed, and the flight's recording."""
    with LiveFlight(Scenario(start=ScenarioStart(mode="off"))) as flight:
        flight.wait()
        flight.set_speed(SPEED).result(ENOUGH)
        address = flight.serve(ServerConfig(port=0)).result(ENOUGH)
        done = subprocess.run(
            [sys.executable, str(SQUARE), address], capture_output=True, text=True, timeout=ENOUGH
        )
        return done, flight.flown().result(ENOUGH).recording


def test_it_says_a_line_a_corner(flown):
    done, _ = flown
    assert done.returncode == 0, done.stderr
    assert done.stdout.count("corner") >= 4


@pytest.mark.parametrize("corner", [(0.0, 0.0), (2.0, 0.0), (2.0, 2.0), (0.0, 2.0)])
def test_it_was_at_every_corner(flown, corner):
    _, recording = flown
    in_the_air = recording.p_WB[:, 2] > 1.0
    level = recording.p_WB[in_the_air, :2] - recording.p_WB[0, :2]
    assert np.hypot(*(level - corner).T).min() < 0.2


def test_it_landed_where_it_began(flown):
    _, recording = flown
    assert recording.mode[-1] == 0
    assert math.dist(recording.p_WB[-1, :2], recording.p_WB[0, :2]) < 0.4
