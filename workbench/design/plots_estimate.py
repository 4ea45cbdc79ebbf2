"""An estimate and the truth: attitude, position and velocity with 2 sigma bounds."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from scipy.spatial.transform import Rotation

from workbench.design.estimation_errors import Estimated
from workbench.design.plots import PALETTE, label_panel, styled, titled, widen

_MIN_ESTIMATE_SPAN_S = 0.1
"""Smallest span of the time axis [s]."""
_STATE_PANELS = (
    (("roll", "deg"), ("pitch", "deg"), ("yaw", "deg")),
    (("x", "m"), ("y", "m"), ("z", "m")),
    (("v_x", "m/s"), ("v_y", "m/s"), ("v_z", "m/s")),
)


@styled
def plot_estimate(recording: Estimated, title: str) -> Figure:
    """Return the figure of a flight that used an estimate, with a panel for each state.

    For angles the band is that of the deviations in B, a good approximation near level flight.
    """
    figure = titled(title, 12.5, 8.0)
    panels = figure.subplots(3, 3, sharex=True)
    estimate, deviations = recording.estimate, recording.deviations
    rows = (
        (
            _euler_angles_deg(recording.q_WB),
            _euler_angles_deg(estimate[:, 0:4]),
            np.degrees(deviations[:, 0:3]),
        ),
        (recording.p_WB, estimate[:, 4:7], deviations[:, 3:6]),
        (recording.v_WB, estimate[:, 10:13], deviations[:, 6:9]),
    )
    for axes_row, names, (truth, known, deviation) in zip(panels, _STATE_PANELS, rows, strict=True):
        for index, (name, unit) in enumerate(names):
            axes = axes_row[index]
            _draw_state(axes, recording.time, truth[:, index], known[:, index], deviation[:, index])
            label_panel(axes, name, f"[{unit}]")
    for axes in panels[-1]:
        axes.set_xlabel("time [s]")
    begin = recording.time[0]
    panels[0][0].set_xlim(begin, max(recording.time[-1], begin + _MIN_ESTIMATE_SPAN_S))
    handles, labels = panels[0][0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper right", ncols=3)
    return figure


def _draw_state(
    axes: Axes, time: np.ndarray, truth: np.ndarray, known: np.ndarray, deviation: np.ndarray
) -> None:
    """Draw one state."""
    if np.isfinite(deviation).any():
        axes.fill_between(
            time,
            known - 2.0 * deviation,
            known + 2.0 * deviation,
            color=PALETTE.window,
            label="± 2 sigma",
        )
    axes.plot(time, truth, color=PALETTE.command, lw=1.2, label="truth")
    axes.plot(time, known, color=PALETTE.ours, lw=1.0, label="estimate")
    widen(axes, truth, known, known - 2.0 * deviation, known + 2.0 * deviation, least=1e-3)


def _euler_angles_deg(q: np.ndarray) -> np.ndarray:
    """Return roll, pitch and yaw over time (N, 3), yaw without jumps [deg]."""
    yaw, pitch, roll = Rotation.from_quat(q[:, [1, 2, 3, 0]]).as_euler("ZYX").T
    return np.degrees(np.stack([np.unwrap(roll), pitch, np.unwrap(yaw)], axis=1))
