"""The errors of predictions of many flights, in one summary."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from workbench.extras.flightdata.predict.prediction import FlightPrediction


@dataclass(frozen=True)
class MethodSummary:
    """The errors of a method at the end of the horizon, as RMS over all windows.

    Attributes:
        method: see above.
        position: [m].
        velocity: [m/s].
        attitude: [rad]; NaN if not predicted.
    """

    method: str
    position: float
    velocity: float
    attitude: float


@dataclass(frozen=True)
class Summary:
    """A summary of the predictions of flights.

    Attributes:
        flights: their number.
        windows: number of starts in all of them.
        horizon: of the errors [s].
        methods: a row for each.
        whole: median over flights of the RMSE of the closed loop over a whole flight [m].
        whole_late: the same for the delayed setpoint [m].
        lag_difference: median over level axes of the lag of the model minus that of the flight [s].
    """

    flights: int
    windows: int
    horizon: float
    methods: tuple[MethodSummary, ...]
    whole: float
    whole_late: float
    lag_difference: float


def summarized(predictions: Sequence[FlightPrediction]) -> Summary:
    """Return the summary of the predictions of at least one flight."""
    rows = []
    for errors in zip(*(each.errors for each in predictions), strict=True):
        last = [
            np.concatenate([getattr(each, field)[:, -1] for each in errors])
            for field in ("position", "velocity", "attitude")
        ]
        rows.append(MethodSummary(errors[0].method, *map(rms, last)))
    whole = [each.whole for each in predictions]
    pairs = [pair for each in whole for pair in zip(each.lags, each.real_lags, strict=True)]
    differences = [ours - real for ours, real in pairs if math.isfinite(ours - real)]
    return Summary(
        flights=len(predictions),
        windows=sum(len(each.starts) for each in predictions),
        horizon=float(predictions[0].errors[0].ahead[-1]),
        methods=tuple(rows),
        whole=float(np.median([each.rmse for each in whole])),
        whole_late=float(np.median([each.late_rmse for each in whole])),
        lag_difference=float(np.median(differences)) if differences else math.nan,
    )


def rms(values: np.ndarray) -> float:
    """Return the root mean square of the finite values; NaN if there are none."""
    known = values[np.isfinite(values)]
    return float(np.sqrt(np.mean(known**2))) if len(known) else math.nan
