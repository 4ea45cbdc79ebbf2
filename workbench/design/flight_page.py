"""A flight in 3-D as one HTML page that plays in any browser, without a server."""

import logging
from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np
from pydrake.geometry import Meshcat

from workbench.scenario.scenario import Scenario
from workbench.session.session import Session

_CAMERA_OFFSET_SPANS = np.array([-3.0, -3.0, 1.7])
"""Position of the camera relative to the start of the flight, in spans of the vehicle."""


def fly_and_film(
    scenario: Scenario,
    settings: Mapping[str, float],
    page: Path,
    progress: Callable[[float], None] | None = None,
) -> Session:
    """Fly a scenario, write its film, and return the session at its end.

    Args:
        scenario: what to fly.
        settings: parameter values for this flight.
        page: the HTML file to write, about 2 MB and a tenth more for each ten seconds.
        progress: called with the flown share, 0 .. 1.
    """
    meshcat = quiet_meshcat()
    session = Session(scenario, settings, meshcat)
    target = np.array(session.snapshot().p_WB)
    meshcat.SetCameraPose(target + session.vehicle.span * _CAMERA_OFFSET_SPANS, target)
    meshcat.StartRecording()
    with session.programs():
        session.run(progress)
    meshcat.PublishRecording()
    page.write_text(meshcat.StaticHtml(), encoding="utf-8")
    return session


def quiet_meshcat() -> Meshcat:
    """Return a Meshcat for a page; Drake does not log the address of its server."""
    logging.getLogger("drake").addFilter(_not_about_listening)
    return Meshcat()


def _not_about_listening(record: logging.LogRecord) -> bool:
    return "Meshcat listening" not in record.getMessage()
