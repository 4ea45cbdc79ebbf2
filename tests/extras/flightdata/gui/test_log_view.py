"""Logs of other programs on the Visualization screen."""

import numpy as np
import pytest

from tests.extras.flightdata.test_readers import usd_log
from workbench.gui.visualization.log_worker import drawable_flight

pytestmark = pytest.mark.usefixtures("unheld")

LIMIT = 60_000


def test_a_log_of_another_program_is_shown_by_the_names_of_a_flight(begun, qtbot, tmp_path):
    rows = [(1000 * i, 90.0, 1.0) for i in range(3000) if not 1000 < i < 1500]
    path = tmp_path / "log07"
    path.write_bytes(usd_log(rows))
    begun.open_log(path)
    qtbot.waitUntil(lambda: begun.shows_log, timeout=LIMIT)
    flight = drawable_flight(path, lambda share: None)
    assert flight.units == {"imu.angular_velocity.1": "rad/s", "imu.specific_force.2": "m/s^2"}
    assert flight.vehicle == "log07" and flight.end == pytest.approx(2.999)
    time, turning = flight.series("imu.angular_velocity.1")
    inside = (time > 1.001) & (time < 1.499)
    assert inside.any() and np.isnan(turning[inside]).all()
    assert np.isfinite(turning[~inside]).all()


def test_a_log_leads_to_the_flight_that_would_have_been(shared_window):
    shared_window.show_screen("visualization")
    shared_window.stack.current.log_bar.card_buttons["What if"].click()
    tuning = shared_window.stack.current
    assert shared_window.stack.name == "tuning"
    assert tuning.tabs.currentWidget() is tuning.added["What if"]
