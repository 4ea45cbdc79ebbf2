"""The panels of a lidar trial's three criteria: errors, errors over distance, detection."""

import math

import numpy as np
from matplotlib.axes import Axes

from workbench.design.lidar_trial import TrialReport
from workbench.design.lidar_trial_detection import slowest_detection
from workbench.design.plots import PALETTE, label


def draw_histogram(axes: Axes, report: TrialReport) -> None:
    """Draw how often which error occurs, and what the declared noise leads to expect."""
    error = 1000.0 * report.accuracy.error
    total, exact = report.accuracy.total, report.exact.total
    axes.set_xlabel("error of a distance [mm]")
    label(axes, "errors: measured less closed form", "density [1/mm]")
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
    """Draw errors over true distance, with mean and spread of each metre."""
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
    axes.set_xlabel("true distance [m]")
    label(axes, "errors over distance", "error [mm]")
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
    axes.set_yticks(places, [each.obstacle for each in found], fontsize=7.5)
    axes.invert_yaxis()
    axes.set_xlim(0.0, 1.18 * max([limit, *(1000.0 * each.delay for each in found)]))
    axes.grid(axis="y", visible=False)
    axes.set_xlabel("time from coming into view to the first return [ms]")
    label(axes, "speed of detection", "")
    axes.legend(loc="lower right", frameon=True, framealpha=0.9, edgecolor="none")
