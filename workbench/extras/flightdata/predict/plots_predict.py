"""Figures of predictions: errors over the horizon, and simulated and real flights."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from workbench.design.plots import PALETTE, label_panel, styled, titled
from workbench.extras.flightdata.predict.motion import POSITION_VELOCITY_ROWS
from workbench.extras.flightdata.predict.prediction import (
    CLOSED_LOOP_METHOD,
    PREDICTION_METHODS,
    FlightPrediction,
)
from workbench.extras.flightdata.predict.prediction_summary import rms, summarized
from workbench.extras.flightdata.predict.what_if import WhatIf

_METHOD_COLOURS = dict(zip(PREDICTION_METHODS, PALETTE.series, strict=False))
_ERROR_FIELDS = (
    ("position", "m", 1.0),
    ("velocity", "m/s", 1.0),
    ("attitude", "deg", 180.0 / np.pi),
)


@styled
def plot_predictions(predictions: Sequence[FlightPrediction], title: str) -> Figure:
    """Return the figure of errors over the horizon, a panel per quantity, and of whole flights.

    Lines are the RMS over all windows; the band is from the 10th to the 90th percentile of flights.
    """
    figure = titled(title, 12.5, 7.0)
    panels = figure.subplots(2, 2).ravel()
    for axes, (field, unit, factor) in zip(panels, _ERROR_FIELDS, strict=False):
        for errors in zip(*(each.errors for each in predictions), strict=True):
            values = [getattr(each, field) for each in errors]
            if not np.isfinite(np.concatenate(values)).any():
                continue
            method, ahead = errors[0].method, errors[0].ahead
            line = [factor * rms(column) for column in np.concatenate(values).T]
            axes.plot(ahead, line, color=_METHOD_COLOURS[method], lw=1.4, label=method)
            if method == CLOSED_LOOP_METHOD:
                flights = factor * np.array([[rms(c) for c in each.T] for each in values])
                low, high = np.quantile(flights, (0.1, 0.9), axis=0)
                axes.fill_between(ahead, low, high, color=_METHOD_COLOURS[method], alpha=0.15, lw=0)
        label_panel(axes, f"{field} error", f"[{unit}]", "ahead [s]")
        _limit_error_axis(axes, predictions, field, factor)
    _draw_whole_flights(panels[3], predictions)
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper right", ncols=len(labels))
    return figure


def _limit_error_axis(
    axes: Axes, predictions: Sequence[FlightPrediction], field: str, factor: float
) -> None:
    """Limit the axis, so that methods with large errors do not hide the others."""
    last = [factor * getattr(row, field) for row in summarized(predictions).methods]
    known = sorted(value for value in last if np.isfinite(value))
    axes.set_ylim(0.0, 1.3 * known[len(known) // 2])


def _draw_whole_flights(axes: Axes, predictions: Sequence[FlightPrediction]) -> None:
    """Draw the error of each whole flight over that of the delayed setpoint."""
    ours = np.array([each.whole.rmse for each in predictions])
    late = np.array([each.whole.late_rmse for each in predictions])
    most = 1.05 * float(max(ours.max(), late.max()))
    axes.plot([0.0, most], [0.0, most], color=PALETTE.command, lw=0.8)
    axes.plot(late, ours, "o", ms=4, color=PALETTE.ours)
    label_panel(axes, "whole flights: closed loop", "[m]", "setpoint, late [m]")
    axes.set_xlim(0.0, most)
    axes.set_ylim(0.0, most)


@styled
def plot_what_if(found: WhatIf, title: str) -> Figure:
    """Return the figure of a flight, of the predicted one with its band, and of the disturbance."""
    figure = titled(title, 12.5, 8.0)
    panels = figure.subplots(3, 3, sharex=True)
    names = (("x", "m"), ("y", "m"), ("z", "m"), ("v_x", "m/s"), ("v_y", "m/s"), ("v_z", "m/s"))
    for index, (axes, (name, unit)) in enumerate(zip(panels[:2].ravel(), names, strict=True)):
        place = POSITION_VELOCITY_ROWS[index]
        logged, other = found.logged[:, place], found.other[:, place]
        low, high = found.low[:, index], found.high[:, index]
        axes.fill_between(found.time, low, high, color=PALETTE.ours, alpha=0.2, lw=0, label="band")
        axes.plot(found.time, logged, color=PALETTE.command, lw=1.2, label="log")
        axes.plot(found.time, other, color=PALETTE.ours, lw=1.0, label="other")
        label_panel(axes, name, f"[{unit}]")
    for index, axis in enumerate("xyz"):
        axes = panels[2][index]
        axes.plot(found.time, found.disturbance[:, index], color=PALETTE.mean, lw=0.8)
        label_panel(axes, f"disturbance, force {axis}", "[N]", "time [s]")
    handles, labels = panels[0][0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper right", ncols=3)
    return figure
