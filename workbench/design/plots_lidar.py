"""The pictures of a lidar trial: a figure of cloud, errors and detections, and a film in 3-D."""

import math
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.patheffects import withStroke
from pydrake.perception import BaseField, Fields, PointCloud

from workbench.design.flight_page import quiet_meshcat
from workbench.design.lidar_trial import TrialReport, fly_trial
from workbench.design.obstacle_detection import slowest_detection
from workbench.design.obstacles import RayObstacle
from workbench.design.plots import PALETTE, label_panel, note, styled, tick_name, titled
from workbench.design.plots_flight import draw_silhouette, obstacle_times
from workbench.plant.worlds.world import GROUND_NAME
from workbench.scenario.scenario import Scenario

_REGION_MARGIN_M = 3.0
"""Margin around obstacles and path [m]."""
_MAX_CLOUD_POINTS = 60_000
"""Largest number of points drawn; more make the file larger and the picture no clearer."""
_WIDE_REGION_RATIO = 1.7
"""A region longer than this from west to east leaves room for a legend next to its title."""
_GROUND_COLOUR = "0.8"
_CLOUD_POINT_SIZE_M = 0.04
"""[m]"""
_TRIAL_CAMERA_M, _TRIAL_CAMERA_TARGET_M = np.array([-14.0, -12.0, 11.0]), np.array([12.0, 0.0, 0.0])
"""Position and target of the camera relative to the start of the flight [m]."""


@styled
def plot_trial(report: TrialReport, title: str) -> Figure:
    """Return the figure of a lidar trial."""
    low, high = _shown_region(report)
    wide = max(2.2, min(5.5, 11.0 * float((high[1] - low[1]) / (high[0] - low[0]))))
    figure = titled(title, 12.5, wide + 7.6)
    grid = figure.add_gridspec(3, 3, height_ratios=(wide, 3.4, 3.0))
    cloud = _thinned_cloud(report, low, high)
    _draw_from_above(figure.add_subplot(grid[0, :]), report, cloud, low, high)
    _draw_in_space(figure.add_subplot(grid[1, :]), report, cloud, low, high)
    draw_histogram(figure.add_subplot(grid[2, 0]), report)
    draw_error_over_distance(figure.add_subplot(grid[2, 1]), report)
    draw_delays(figure.add_subplot(grid[2, 2]), report)
    return figure


def _shown_region(report: TrialReport) -> tuple[np.ndarray, np.ndarray]:
    """Return the smallest and largest x, y, z of path and obstacles."""
    points = [report.flight.recording.p_WB]
    for obstacle in report.flight.obstacles:
        if obstacle.name != GROUND_NAME:
            points += map(obstacle.outline, obstacle_times(report.flight.recording, obstacle))
    everything = np.vstack(points)
    low, high = everything.min(axis=0) - _REGION_MARGIN_M, everything.max(axis=0) + _REGION_MARGIN_M
    low[2], high[2] = min(0.0, low[2] + _REGION_MARGIN_M), high[2] - _REGION_MARGIN_M
    return low, high


def _thinned_cloud(
    report: TrialReport, low: np.ndarray, high: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return points (n, 3) of the cloud within the region, and their obstacles (n).

    The ground has most of the points, and gets a quarter of those drawn.
    """
    points, obstacle = report.accuracy.p_WP, report.accuracy.obstacle
    inside = np.all((points >= low - [0.0, 0.0, 1.0]) & (points <= high), axis=1)
    ground = np.array([each.name == GROUND_NAME for each in report.flight.obstacles], dtype=bool)
    chosen = []
    for kind, most in ((True, _MAX_CLOUD_POINTS // 4), (False, 3 * _MAX_CLOUD_POINTS // 4)):
        some = np.flatnonzero(inside & (ground[obstacle] == kind))
        chosen.append(some[:: max(1, math.ceil(len(some) / most))])
    kept = np.concatenate(chosen)
    return points[kept], obstacle[kept]


def _draw_from_above(
    axes: Axes,
    report: TrialReport,
    cloud: tuple[np.ndarray, np.ndarray],
    low: np.ndarray,
    high: np.ndarray,
) -> None:
    """Draw cloud, outlines with names, and path, to scale."""
    points, obstacle = cloud
    axes.scatter(
        points[:, 0],
        points[:, 1],
        s=0.6,
        c=obstacle_colours(report)[obstacle],
        linewidths=0.0,
        rasterized=True,
    )
    for each in report.flight.obstacles:
        if each.name != GROUND_NAME:
            _draw_outline(axes, report, each)
    x, y, _ = report.flight.recording.p_WB.T
    axes.plot(x, y, color=PALETTE.command, lw=1.4, label="flown path")
    axes.plot(x[0], y[0], "o", color=PALETTE.command, ms=6, label="start")
    axes.plot(x[-1], y[-1], "s", color=PALETTE.command, ms=5, label="end")
    axes.set_xlim(low[0], high[0])
    axes.set_ylim(low[1], high[1])
    axes.set_aspect("equal", adjustable="box")
    label_panel(axes, _cloud_title(report), "y, north [m]", "x, east [m]")
    if (high[0] - low[0]) / (high[1] - low[1]) > _WIDE_REGION_RATIO:
        axes.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=3, borderaxespad=0.2)
    else:
        axes.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0))


def _cloud_title(report: TrialReport) -> str:
    """Return the title of the cloud."""
    returns, scans = report.accuracy.total.returns, len(report.flight.scans)
    return f"cloud of {scans} scans from above: {returns:,} returns in the colour of their obstacle"


def _draw_outline(axes: Axes, report: TrialReport, obstacle: RayObstacle) -> None:
    """Draw the outline and name of an obstacle, at several times if it moves."""
    times = obstacle_times(report.flight.recording, obstacle)
    for time in times:
        draw_silhouette(axes, obstacle.outline(time)[:, :2], obstacle)
    outline = obstacle.outline(times[0])
    x = float(outline[:, 0].mean())
    path = report.flight.recording.p_WB
    beside = float(path[np.argmin(np.abs(path[:, 0] - x)), 1])
    above = float(outline[:, 1].mean()) >= beside
    name = f"{obstacle.name} (moves)" if obstacle.moves else obstacle.name
    _write_name(axes, name, outline[:, :2], above=above)


def _write_name(axes: Axes, name: str, points: np.ndarray, *, above: bool) -> None:
    """Write a name above or below points in the picture (n, 2)."""
    y = points[:, 1].max() if above else points[:, 1].min()
    place, offset = (float(points[:, 0].mean()), float(y)), (0.0, 3.0 if above else -3.0)
    look: dict[str, Any] = {"ha": "center", "va": "bottom" if above else "top", "zorder": 4}
    look["path_effects"] = [withStroke(linewidth=2.0, foreground="white")]
    note(axes, name, place, offset, size=8.0, **look)


def _draw_in_space(
    axes: Axes,
    report: TrialReport,
    cloud: tuple[np.ndarray, np.ndarray],
    low: np.ndarray,
    high: np.ndarray,
) -> None:
    """Draw cloud and path from a camera beside the path, near points over far ones."""
    project = _camera_overlooking(report.flight.recording.p_WB[0], low, high)
    points, obstacle = cloud
    for begin, end in _ground_lines(low, high):
        line = project(np.linspace(begin, end, 50))
        axes.plot(line[:, 0], line[:, 1], color="0.88", lw=0.6, zorder=1)
    seen = project(points)
    order = np.argsort(-seen[:, 2])
    axes.scatter(
        seen[order, 0],
        seen[order, 1],
        s=np.clip(60.0 / seen[order, 2], 0.3, 4.0),
        c=obstacle_colours(report)[obstacle[order]],
        linewidths=0.0,
        rasterized=True,
        zorder=2,
    )
    path = project(report.flight.recording.p_WB)
    axes.plot(path[:, 0], path[:, 1], color=PALETTE.command, lw=1.4, zorder=3)
    for each in report.flight.obstacles:
        if each.name != GROUND_NAME:
            first = obstacle_times(report.flight.recording, each)[0]
            outline = project(each.outline(first))[:, :2]
            draw_silhouette(axes, outline, each)
            _write_name(axes, each.name, outline, above=True)
    axes.set_aspect("equal", adjustable="datalim")
    axes.axis("off")
    axes.set_title("the same cloud in 3-D, over a ground ruled every 10 m")


def _camera_overlooking(
    start: np.ndarray, low: np.ndarray, high: np.ndarray
) -> Callable[[np.ndarray], np.ndarray]:
    """Return the projection of a camera beside the long side of a region, towards the start.

    It returns positions in the picture and depths of points (n, 3).
    """
    middle, size = 0.5 * (low + high), high - low
    along = int(np.argmax(size[:2]))
    length, far = float(size[along]), float(size[:2].min())
    away = np.zeros(3)
    away[along] = 0.2 * length * (-1.0 if start[along] < middle[along] else 1.0)
    away[1 - along] = (-1.0 if along == 0 else 1.0) * (0.75 * length + 0.5 * far)
    away[2] = 0.45 * length
    forward = -away / np.linalg.norm(away)
    aside = np.cross(forward, [0.0, 0.0, 1.0])
    aside /= np.linalg.norm(aside)
    axes_W = np.stack([aside, np.cross(aside, forward), forward])

    def project(points_W: np.ndarray) -> np.ndarray:
        right, up, ahead = ((points_W - middle - away) @ axes_W.T).T
        ahead = np.maximum(ahead, 1.0)
        return np.stack([right / ahead, up / ahead, ahead], axis=1)

    return project


def _ground_lines(low: np.ndarray, high: np.ndarray) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Yield both ends of the lines of a grid on the ground, every 10 m."""
    for x in np.arange(10.0 * np.ceil(low[0] / 10.0), high[0], 10.0):
        yield np.array([x, low[1], 0.0]), np.array([x, high[1], 0.0])
    for y in np.arange(10.0 * np.ceil(low[1] / 10.0), high[1], 10.0):
        yield np.array([low[0], y, 0.0]), np.array([high[0], y, 0.0])


def obstacle_colours(report: TrialReport) -> np.ndarray:
    """Return a colour for each obstacle of the flight."""
    series = [colour for colour in PALETTE.series if colour != "#555555"]
    names = [each.name for each in report.flight.obstacles]
    return np.array(
        [
            _GROUND_COLOUR if name == GROUND_NAME else series[index % len(series)]
            for index, name in enumerate(names)
        ]
    )


def draw_histogram(axes: Axes, report: TrialReport) -> None:
    """Draw the histogram of errors, and the distribution expected from the declared noise."""
    error = 1000.0 * report.accuracy.error
    total, exact = report.accuracy.total, report.exact.total
    label_panel(
        axes, "errors: measured less closed form", "density [1/mm]", "error of a distance [mm]"
    )
    if not len(error):
        axes.text(0.5, 0.5, "no returns", transform=axes.transAxes, ha="center")
        return
    axes.hist(error, bins=81, density=True, color=PALETTE.ours, alpha=0.55, label="measured")
    sigma = 1000.0 * report.flight.lidar.noise.stddev
    if sigma > 0.0:
        mean = 1000.0 * (report.flight.lidar.noise.mean + report.flight.lidar.noise.bias_mean)
        x = np.linspace(mean - 4.5 * sigma, mean + 4.5 * sigma, 200)
        bell = np.exp(-0.5 * ((x - mean) / sigma) ** 2) / (sigma * math.sqrt(2.0 * math.pi))
        axes.plot(x, bell, "--", color=PALETTE.mean, label=f"declared noise, {sigma:g} mm")
        axes.set_xlim(x[0], x[-1])
    axes.text(
        0.02,
        0.97,
        f"bias {1000.0 * total.bias:z.3f} mm\nRMSE {1000.0 * total.rmse:.2f} mm\n"
        f"largest {1000.0 * total.maximum:.1f} mm\n"
        f"without noise at most {1000.0 * exact.maximum:.1g} mm",
        transform=axes.transAxes,
        va="top",
        fontsize=8,
    )
    axes.set_ylim(0.0, 1.45 * axes.get_ylim()[1])
    axes.legend(loc="upper right")


def draw_error_over_distance(axes: Axes, report: TrialReport) -> None:
    """Draw errors over true distance, with mean and spread for each metre."""
    length, error = report.accuracy.length, 1000.0 * report.accuracy.error
    some = slice(None, None, max(1, len(error) // 15_000))
    axes.scatter(length[some], error[some], s=1.0, color="0.75", linewidths=0.0, rasterized=True)
    edges = np.arange(0.0, report.flight.lidar.max_range + 1.0)
    places = np.digitize(length, edges) - 1
    full = [index for index in range(len(edges) - 1) if np.sum(places == index) >= 30]
    middle = np.array([edges[index] + 0.5 for index in full])
    mean = np.array([error[places == index].mean() for index in full])
    spread = np.array([error[places == index].std() for index in full])
    axes.plot(middle, mean, color=PALETTE.ours, label="mean of a metre")
    for sign, name in ((1.0, "± deviation"), (-1.0, None)):
        axes.plot(middle, mean + sign * spread, color=PALETTE.ours, lw=1.0, ls=":", label=name)
    sigma = 1000.0 * report.flight.lidar.noise.stddev
    for sign, name in ((1.0, "± declared"), (-1.0, None)):
        axes.axhline(sign * sigma, color=PALETTE.mean, lw=2.4, alpha=0.45, label=name)
    axes.set_xlim(0.0, edges[-1])
    label_panel(axes, "errors over distance", "error [mm]", "true distance [m]")
    most = max(4.6 * sigma, float(np.abs(error[some]).max(initial=0.1)))
    axes.set_ylim(-1.05 * most, 1.45 * most)
    axes.legend(loc="upper right", ncols=3, columnspacing=1.0, handlelength=1.2, fontsize=7.5)


def draw_delays(axes: Axes, report: TrialReport) -> None:
    """Draw how long each obstacle was in view before its first return was delivered."""
    found = [each for each in report.detections if math.isfinite(each.delay)]
    places = np.arange(len(found))
    axes.barh(places, [1000.0 * each.delay for each in found], color=PALETTE.ours, height=0.65)
    limit = 1000.0 * slowest_detection(report.flight)
    axes.axvline(limit, color=PALETTE.limit, lw=1.2, label=f"limit {limit:.0f} ms")
    axes.set_yticks(places, [tick_name(each.obstacle) for each in found], fontsize=7.5)
    axes.invert_yaxis()
    axes.set_xlim(0.0, 1.18 * max([limit, *(1000.0 * each.delay for each in found)]))
    axes.grid(axis="y", visible=False)
    label_panel(
        axes, "speed of detection", "", "time from coming into view to the first return [ms]"
    )
    axes.legend(loc="lower right", frameon=True, framealpha=0.9, edgecolor="none")


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
    meshcat = quiet_meshcat()
    meshcat.StartRecording()
    report = fly_trial(scenario, settings, progress, meshcat)
    meshcat.PublishRecording()
    start = report.flight.recording.p_WB[0]
    meshcat.SetCameraPose(start + _TRIAL_CAMERA_M, start + _TRIAL_CAMERA_TARGET_M)
    meshcat.SetObject("lidar cloud", cloud_of(report), point_size=_CLOUD_POINT_SIZE_M)
    page.write_text(meshcat.StaticHtml(), encoding="utf-8")
    return report


def cloud_of(report: TrialReport) -> PointCloud:
    """Return the cloud of all scans in W, in the colours of the obstacles."""
    points, obstacle = report.accuracy.p_WP, report.accuracy.obstacle
    some = slice(None, None, max(1, -(-len(points) // _MAX_CLOUD_POINTS)))
    colours = np.array([to_rgb(colour) for colour in obstacle_colours(report)])
    fields = Fields(BaseField.kXYZs | BaseField.kRGBs)
    cloud = PointCloud(len(points[some]), fields)
    cloud.mutable_xyzs()[:] = points[some].T
    cloud.mutable_rgbs()[:] = np.round(255.0 * colours[obstacle[some]]).T
    return cloud
