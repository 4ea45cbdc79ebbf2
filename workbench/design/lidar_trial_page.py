"""A lidar trial in 3-D as one HTML page: the flight with its cloud over the world."""

import logging
from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np
from matplotlib.colors import to_rgb
from pydrake.geometry import Meshcat
from pydrake.perception import BaseField, Fields, PointCloud

from workbench.design.flight_page import not_about_listening
from workbench.design.lidar_trial import TrialReport, fly_trial
from workbench.design.plots_lidar import obstacle_colours
from workbench.scenario.scenario import Scenario

MOST_POINTS = 60_000
"""In a page [1]: each takes 40 bytes."""
POINT_SIZE = 0.04
"""[m]"""
_EYE, _TARGET = np.array([-14.0, -12.0, 11.0]), np.array([12.0, 0.0, 0.0])
"""Where the camera stands and looks, seen from where the flight begins [m]."""


def fly_and_film_trial(
    scenario: Scenario,
    settings: Mapping[str, float],
    page: Path,
    progress: Callable[[float], None] | None = None,
) -> TrialReport:
    """Fly a lidar trial, write its film with the cloud of all scans, and return its report.

    Args:
        scenario: what to fly.
        settings: parameter values for this flight.
        page: the HTML file to write, about 5 MB.
        progress: called with the flown share, 0 .. 1.
    """
    logging.getLogger("drake").addFilter(not_about_listening)
    meshcat = Meshcat()
    meshcat.StartRecording()
    report = fly_trial(scenario, settings, progress, meshcat)
    meshcat.PublishRecording()
    start = report.flight.recording.p_WB[0]
    meshcat.SetCameraPose(start + _EYE, start + _TARGET)
    meshcat.SetObject("lidar cloud", cloud_of(report), point_size=POINT_SIZE)
    page.write_text(meshcat.StaticHtml(), encoding="utf-8")
    return report


def cloud_of(report: TrialReport) -> PointCloud:
    """Return the cloud of all scans in W, in the colours of the obstacles."""
    points, obstacle = report.accuracy.p_WP, report.accuracy.obstacle.astype(int)
    some = slice(None, None, max(1, -(-len(points) // MOST_POINTS)))
    colours = np.array([to_rgb(colour) for colour in obstacle_colours(report)])
    fields = Fields(BaseField.kXYZs | BaseField.kRGBs)
    cloud = PointCloud(len(points[some]), fields)
    cloud.mutable_xyzs()[:] = points[some].T
    cloud.mutable_rgbs()[:] = np.round(255.0 * colours[obstacle[some]]).T
    return cloud
