"""Linear models for many sets of gains, computed exactly from two linearisations.

Steady hover does not depend on the gains, except for the pilot's reference. In hover every signal
of the law at a loop point is linear in the gains of its own loop:

    velocity error      = kp_position position_error - velocity
    acceleration        = kp_velocity velocity_error - kd_velocity estimate + drag
    angular acceleration = kp error + kd rate_error

So a change of gains adds to that signal, like an injection at its point. With the model's matrix M
from states and inputs to the next states and outputs, and the row K of the addition, M becomes M +
M[:, injection] K. The order is from the outer loop to the inner one, as inner signals depend on
outer ones.
"""

import dataclasses
from collections.abc import Callable, Mapping
from typing import NamedTuple

import numpy as np

from workbench.control.controller_file import load_controller
from workbench.design.linear.model import LinearModel
from workbench.design.linear.operating_point import OperatingPoint
from workbench.design.linear.study import LinearStudy

KD_DIFFERENCE = 0.1
"""Difference of kd_velocity in the second model."""
MIN_TILT_KD = 1.0
"""Smallest kd of roll and pitch in both models, as the rate error is derived from its product with
kd."""


Models = Callable[[Mapping[str, float]], LinearModel]
"""Function that returns the sampled model of one vehicle at one point for gains of the loops."""


class _Term(NamedTuple):
    """A gain, the point where it acts, and the signal that it is multiplied by."""

    gain: str
    point: str
    signal: str


_POSITION_TERMS = tuple(
    _Term(gain, f"velocity_{axis}_error", f"position_{axis}_error")
    for axis, gain in (("x", "kp_position_xy"), ("y", "kp_position_xy"), ("z", "kp_position_z"))
)
_VELOCITY_TERMS = tuple(
    term
    for axis in "xyz"
    for term in (
        _Term(f"kp_velocity_{axis}", f"acceleration_{axis}", f"velocity_{axis}_error"),
        _Term(f"kd_velocity_{axis}", f"acceleration_{axis}", f"estimate_{axis}"),
    )
)
_ATTITUDE_TERMS = tuple(
    term
    for axis in ("roll", "pitch")
    for term in (
        _Term(f"kp_{axis}", f"{axis}_acceleration", f"{axis}_error"),
        _Term(f"kd_{axis}", f"{axis}_acceleration", f"{axis}_rate_error"),
    )
)
_YAW_TERM = _Term("kp_yaw_rate", "yaw_acceleration", "yaw_rate_error")
TERMS = (*_POSITION_TERMS, *_VELOCITY_TERMS, *_ATTITUDE_TERMS, _YAW_TERM)
"""Terms from the outermost loop inwards."""
RETUNABLE = frozenset(term.gain for term in TERMS)
"""Names of the gains that these models cover."""


class RetunedModels:
    """Computes the sampled models of one vehicle in hover for any gains.

    Args:
        study: of the vehicle.
        point: hover, with or without the hold.
        gains: all parameter values, of which only the gains of the loops may change.

    Raises:
        WorkbenchError: if it cannot hover.
    """

    def __init__(
        self, study: LinearStudy, point: OperatingPoint, gains: Mapping[str, float]
    ) -> None:
        self._gains = {**gains, **{name: MIN_TILT_KD for name in ("kd_roll", "kd_pitch")}}
        self._gains |= {f"kd_velocity_{axis}": 0.0 for axis in "xyz"}
        self._model = study.sampled(point, self._gains)
        other = {f"kd_velocity_{axis}": KD_DIFFERENCE for axis in "xyz"}
        second = study.sampled(point, {**self._gains, **other})
        states = len(self._model.A)
        self._columns = {s.name: states + i for i, s in enumerate(self._model.inputs)}
        self._rows = {s.name: states + i for i, s in enumerate(self._model.outputs)}
        self._matrix = self._with_estimates(_full_matrix(self._model), _full_matrix(second))

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
        """Return the matrix of a model with rows for the signals multiplied by kd."""
        rows = [first]
        for axis in "xyz":
            row = self._rows[f"acceleration_{axis}"]
            rows.append((second[row] - first[row])[None] / KD_DIFFERENCE)
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
    """Return a function of gains to models; arguments are those of `RetunedModels`.

    A controller with gains that may not act linearly is linearised for each set, in some
    milliseconds per model.

    Raises:
        WorkbenchError: if it cannot fly like that.
    """
    if study.controller.update is load_controller().update:
        return RetunedModels(study, point, gains).model
    base = dict(gains)
    study.trim(point, base)
    return lambda others: study.sampled(point, {**base, **others})


def _full_matrix(model: LinearModel) -> np.ndarray:
    """Return the matrix from states and inputs to next states and outputs."""
    return np.block([[model.A, model.input_matrix], [model.output_matrix, model.feedthrough]])
