"""The film of a log: when the drone is seen, and where."""

from pathlib import Path

import numpy as np
import pytest
from pydrake.geometry import Meshcat

from workbench.common.flight import Flight
from workbench.common.resources import find_model
from workbench.common.series import make_series
from workbench.logs import flight_film
from workbench.plant.description import read_description


class Watched(Meshcat):
    """A Meshcat that tells what is set over time, and lines."""

    def __init__(self):
        super().__init__()
        self.seen, self.lines = [], {}

    def SetProperty(self, path, name, value, time):
        self.seen.append((name, value, time))
        super().SetProperty(path, name, value, time)

    def SetLine(self, name, points, width, color):
        self.lines[name] = points
        super().SetLine(name, points, width, color)


def test_a_film_begins_with_its_log_and_hides_the_drone_in_gaps(tmp_path, monkeypatch):
    """The log begins at 100 s; nothing is known for half a second. Motion capture is drawn."""
    watched = Watched()
    monkeypatch.setattr(flight_film, "quiet_meshcat", lambda: watched)
    time = np.arange(100.0, 102.0, 0.01)
    time = time[(time < 100.995) | (time > 101.495)]
    values = {f"estimate.{name}": np.full(len(time), 0.5) for name in ("q_w", "q_x", "q_y", "q_z")}
    values |= {f"estimate.{axis}": np.zeros(len(time)) for axis in "xyz"}
    values |= {f"position_data.{axis}": time - 100.0 for axis in "xyz"}
    signals = {name: make_series(name, "1", time, each) for name, each in values.items()}
    page = tmp_path / "film.html"
    flight = Flight("made", Path("made"), "made up", signals, end=102.0)
    flight_film.film_flight(flight, read_description(find_model("dh_drone")), page)
    assert [(name, value) for name, value, _ in watched.seen] == [
        ("visible", False),
        ("visible", True),
    ]
    hidden, shown = (when for *_, when in watched.seen)
    assert (hidden, shown) == pytest.approx((1.0, 1.5), abs=1 / 32)
    flown = watched.lines["flown"]
    assert flown[:, 0] == pytest.approx([0.0] * 3, abs=0.01) and flown[0, -1] > 1.9
    assert "<html" in page.read_text(encoding="utf-8")[:1000].lower()
