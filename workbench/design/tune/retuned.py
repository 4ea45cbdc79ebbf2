"""Linear models for many sets of gains from two that were linearised: exact, and fast.

Steady hover does not depend on the gains, but for what the pilot asks. And there every signal of
the law that is passed on at a loop point is linear in the gains of its own loop:

    velocity error      = kp_position position_error - velocity
    acceleration        = kp_velocity velocity_error - kd_velocity estimate + drag
    angular acceleration = kp error + kd rate_error

So other gains are an addition to that signal, which comes in as an injection at its point would:
with M the model's matrix from states and inputs to the next states and outputs, and K the row of
what is added, M becomes M + M[:, injection] K. From the outer loop to the inner one, as a signal
further in depends on those before it.
"""

import dataclasses
from collections.abc import Callable, Mapping
from typing import NamedTuple

import numpy as np

from workbench.control.controller import load_controller
from workbench.design.linear.model import LinearModel
from workbench.design.linear.operating_point import OperatingPoint
from workbench.design.linear.study import LinearStudy

OTHER_KD = 0.1
"""By so much the second model's kd_velocity differ."""
LEAST_KD = 1.0
"""Of roll and pitch in both models, as a rate error is what kd makes of it."""


Models = Callable[[Mapping[str, float]], LinearModel]
"""Gives the sampled model of one vehicle at one point with some gains of the loops."""


class _Term(NamedTuple):
    """A gain, the point where it acts, and the signal that it is multiplied by."""

    gain: str
    point: str
    signal: str


_POSITION = tuple(
    _Term(gain, f"velocity_{axis}_error", f"position_{axis}_error")
    for axis, gain in (("x", "kp_position_xy"), ("y", "kp_position_xy"), ("z", "kp_position_z"))
)
_VELOCITY = tuple(
    term
    for axis in "xyz"
    for term in (
        _Term(f"kp_velocity_{axis}", f"acceleration_{axis}", f"velocity_{axis}_error"),
        _Term(f"kd_velocity_{axis}", f"acceleration_{axis}", f"estimate_{axis}"),
    )
)
_ATTITUDE = tuple(
    term
    for axis in ("roll", "pitch")
    for term in (
        _Term(f"kp_{axis}", f"{axis}_acceleration", f"{axis}_error"),
        _Term(f"kd_{axis}", f"{axis}_acceleration", f"{axis}_rate_error"),
    )
)
_YAW = _Term("kp_yaw_rate", "yaw_acceleration", "yaw_rate_error")
TERMS = (*_POSITION, *_VELOCITY, *_ATTITUDE, _YAW)
"""From the outermost loop inwards."""


class RetunedModels:
    """Gives the sampled models of one vehicle in hover for any gains.

    Args:
        study: of the vehicle.
        point: hover, with or without the hold.
        gains: all parameter values; models are for these but for the gains of the loops.

    Raises:
        WorkbenchError: if it cannot hover.
    """

    def __init__(
        self, study: LinearStudy, point: OperatingPoint, gains: Mapping[str, float]
    ) -> None:
        self._gains = {**gains, **{name: LEAST_KD for name in ("kd_roll", "kd_pitch")}}
        self._gains |= {f"kd_velocity_{axis}": 0.0 for axis in "xyz"}
        self._model = study.sampled(point, self._gains)
        other = {f"kd_velocity_{axis}": OTHER_KD for axis in "xyz"}
        second = study.sampled(point, {**self._gains, **other})
        states = len(self._model.A)
        self._columns = {s.name: states + i for i, s in enumerate(self._model.inputs)}
        self._rows = {s.name: states + i for i, s in enumerate(self._model.outputs)}
        self._matrix = self._with_estimates(_whole(self._model), _whole(second))

    def model(self, gains: Mapping[str, float]) -> LinearModel:
        """Return the sampled model with other gains of the loops."""
        M = self._matrix.copy()
        for term in TERMS:
            change = gains[term.gain] - self._gains[term.gain]
            if change:
                added = change * self._passed(M, term.signal)
                M += np.outer(M[:, self._columns[term.point]], added)
                M[self._rows[term.point]] += added
        model, m = self._model, len(self._model.A)
        last = m + len(model.outputs)
        return dataclasses.replace(
            model,
            A=M[:m, :m],
            input_matrix=M[:m, m:],
            output_matrix=M[m:last, :m],
            feedthrough=M[m:last, m:],
        )

    def _with_estimates(self, first: np.ndarray, second: np.ndarray) -> np.ndarray:
        """Return a model's matrix with rows for the signals that kd multiplies."""
        rows = [first]
        for axis in "xyz":
            row = self._rows[f"acceleration_{axis}"]
            rows.append((second[row] - first[row])[None] / OTHER_KD)
            self._rows[f"estimate_{axis}"] = len(first) + len(rows) - 2
        for axis in ("roll", "pitch"):
            whole, error = self._rows[f"{axis}_acceleration"], f"{axis}_error"
            rate = first[whole] - self._gains[f"kp_{axis}"] * self._passed(first, error)
            rows.append(rate[None] / self._gains[f"kd_{axis}"])
            self._rows[f"{axis}_rate_error"] = len(first) + len(rows) - 2
        return np.vstack(rows)

    def _passed(self, M: np.ndarray, signal: str) -> np.ndarray:
        """Return the row of a signal; if it is a loop point's, with what is injected there."""
        row: np.ndarray = M[self._rows[signal]].copy()
        if signal in self._columns:
            row[self._columns[signal]] += 1.0
        return row


def retuned_models(study: LinearStudy, point: OperatingPoint, gains: Mapping[str, float]) -> Models:
    """Return what gives models for many sets of gains; arguments are those of `RetunedModels`.

    A controller whose gains are not known to enter linearly is linearised anew for each set, in
    some milliseconds a model.

    Raises:
        WorkbenchError: if it cannot fly so.
    """
    if study.controller.update is load_controller().update:
        return RetunedModels(study, point, gains).model
    base = dict(gains)
    study.trim(point, base)
    return lambda others: study.sampled(point, {**base, **others})


def _whole(model: LinearModel) -> np.ndarray:
    """Return the matrix from states and inputs to next states and outputs."""
    return np.block([[model.A, model.input_matrix], [model.output_matrix, model.feedthrough]])
