"""The step response of the linear closed loop, and the time at which its transient has decayed.

A flown response looks settled wherever its peak is flat. Laws with integral action have slow modes
of a small share, so their responses peak flat, and go on moving for many seconds. The linear model
knows these modes: a step has settled only after its transient has decayed.
"""

import math
from collections.abc import Mapping, Sequence

import numpy as np

from workbench.common.errors import WorkbenchError
from workbench.design.linear.model import LinearModel
from workbench.design.linear.operating_point import HOVER_POINT, OperatingPoint
from workbench.design.linear.retuned import RETUNABLE, Models, retuned_models
from workbench.design.linear.study import LinearStudy
from workbench.design.step_metrics import DECAYED_SHARE, MAX_AUTO_STEP_S, USUAL_STEP_S
from workbench.plant.variation import Variation
from workbench.scenario.attitude_axes import find_attitude_axis
from workbench.scenario.scenario import Scenario
from workbench.setup import Setup, make_setup

STEP_INPUTS = {
    "x": "reference_v_x",
    "y": "reference_v_y",
    "z": "reference_v_z",
    "yaw": "reference_yaw_rate",
}
"""Commands of the steps, by axis."""
STEP_OUTPUTS = {"x": "v_x", "y": "v_y", "z": "v_z", "yaw": "w_z"}
"""Responses to them."""
_LINEAR_HORIZON_S = 2.0 * MAX_AUTO_STEP_S
"""Time after which the linear response counts as steady [s]."""
MAX_DRIFT_RATE_PER_S, MIN_DECAY_RATE_PER_S = 2e-4, 1 / 60
"""Modes between these rates are slow ones that decay or grow, and no drift [1/s]."""
MAX_DRIFT_CHANGE = 0.1
"""By which a drift may change from a quarter of the response to its second half, as a share."""


def linear_step(model: LinearModel, command: str, answer: str, samples: int) -> np.ndarray:
    """Return the response (N) of a sampled model at rest to a command that steps to 1 at time 0.

    With the constant command as a state, x⁺ = M x, and y at sample i h + j is (C Mʲ) (Mⁱʰ x_0).
    Both factors come from a few products by repeated doubling.

    Args:
        model: sampled.
        command: name of an input.
        answer: name of an output.
        samples: N.
    """
    size = len(model.A)
    M = np.zeros((size + 1, size + 1))
    M[:size, :size], M[:size, size] = model.A, model.B([command])[:, 0]
    M[size, size] = 1.0
    rows = np.append(model.C([answer])[0], model.D([answer], [command])[0, 0])[None, :]
    states = np.eye(size + 1)[:, size:]
    with np.errstate(over="ignore", invalid="ignore"):
        while len(rows) ** 2 < samples:
            rows, M = np.vstack([rows, rows @ M]), M @ M
        while states.shape[1] * len(rows) < samples:
            states, M = np.hstack([states, M @ states]), M @ M
        response: np.ndarray = (states.T @ rows.T).ravel()[:samples]
    return response


def linear_attitude_step(model: LinearModel, axis: str, samples: int) -> np.ndarray:
    """Return the response (N) of a sampled model at rest to a unit step of an attitude or a rate.

    Args:
        model: sampled.
        axis: of the setpoint, see `AttitudeAxis`; the loops outside are open.
        samples: N.

    Raises:
        WorkbenchError: if the controller has no such setpoint.
    """
    row, law = find_attitude_axis(axis), model.controller
    assert law
    row.check(law)
    response = linear_step(model.opened([row.point]), row.point, row.output, samples)
    return row.slope_at_point(law) * response


def decay_time(model: LinearModel, axis: str) -> float:
    """Return the time [s] after which the linear step response stays near its steady state.

    Near means within `DECAYED_SHARE`. The response is the sum of the modes' shares, so each mode
    has decayed by then, but for a drift: a vehicle whose centre of mass is beside its rotors turns
    away slowly under a law without integral action, and its responses never stand still.

    Args:
        model: sampled, while the pilot steers.
        axis: x, y, z or yaw.

    Returns:
        The time; infinite if it is longer than `MAX_AUTO_STEP_S`, or if a mode of the response
        grows; 0 if the axis does not respond.
    """
    samples = round(_LINEAR_HORIZON_S / model.period) + 1
    response = linear_step(model, STEP_INPUTS[axis], STEP_OUTPUTS[axis], samples)
    if not np.isfinite(response).all():
        return math.inf
    near = DECAYED_SHARE * abs(response[-1])
    time = _time_near(response, response[-1], near, model.period)
    if time <= MAX_AUTO_STEP_S:
        return time
    return _time_near_drift(model, response, near)


def _time_near_drift(model: LinearModel, response: np.ndarray, near: float) -> float:
    """Return the time [s] after which a response (N) stays near a line of its own, or infinity.

    The line is that of a drift if it is straight for the last three quarters of the response, if no
    mode is as slow as integral action may be, and if the drift stays small until that time and in
    the usual step.
    """
    with np.errstate(divide="ignore"):
        rates = np.abs(np.log(np.abs(np.linalg.eigvals(model.A)))) / model.period
    if np.any((rates > MAX_DRIFT_RATE_PER_S) & (rates < MIN_DECAY_RATE_PER_S)):
        return math.inf
    count = len(response) - 1
    quarter, half, end = (response[share * count // 4] for share in (1, 2, 4))
    drift = (end - half) / (count - count // 2)  # a sample
    before = (half - quarter) / (count // 2 - count // 4)
    if abs(before - drift) > MAX_DRIFT_CHANGE * abs(drift):
        return math.inf
    line = end - drift * np.arange(count, -1, -1)
    time = _time_near(response, line, near, model.period)
    drifted = abs(drift) / model.period * max(time, USUAL_STEP_S)
    return time if time <= MAX_AUTO_STEP_S and drifted <= near else math.inf


def _time_near(response: np.ndarray, line: np.ndarray | float, near: float, period: float) -> float:
    """Return the time [s] after which the samples of a response (N) stay near a line."""
    # no array of the differences: to get memory for 30,000 numbers takes longer than to compare
    away = (response > line + near) | (response < line - near)
    return float(len(away) - int(away[::-1].argmax())) * period if away.any() else 0.0


class DecayTimes:
    """The decay times of the step responses of one scenario, for any gains.

    Args:
        scenario: its vehicle, controller, estimator and rates; or its setup.
        velocity: of the steady flight before the step, in W (3) [m/s].
    """

    def __init__(
        self, scenario: Scenario | Setup, velocity: Sequence[float] = HOVER_POINT.velocity
    ) -> None:
        v_x, v_y, v_z = velocity
        self._setup = make_setup(scenario)
        self._point = OperatingPoint(velocity=(v_x, v_y, v_z))
        self._study: LinearStudy | None = None
        self._models: Models | None = None

    def of(
        self,
        axis: str,
        settings: Mapping[str, float] | None = None,
        variation: Variation | None = None,
    ) -> float:
        """Return the decay time of a step [s], see `decay_time`.

        It is 0 if there is no linear model, as for a law that runs in another program: then the
        flown response alone tells whether it has settled.

        Args:
            axis: x, y, z or yaw.
            settings: parameter values that differ from those of the scenario, by name.
            variation: of the vehicle; None for that of the scenario.
        """
        try:
            return decay_time(self.model(settings, variation), axis)
        except WorkbenchError:
            return 0.0

    def model(
        self, settings: Mapping[str, float] | None = None, variation: Variation | None = None
    ) -> LinearModel:
        """Return the sampled model while the pilot steers; for the arguments see `of`.

        Raises:
            WorkbenchError: if there is none.
        """
        return self._model(self._study_of(variation), settings or {})

    def _study_of(self, variation: Variation | None) -> LinearStudy:
        variation = variation or self._setup.variation
        if self._study is None or variation != self._study.setup.variation:
            self._study, self._models = LinearStudy(self._setup.varied(variation)), None
        return self._study

    def _model(self, study: LinearStudy, settings: Mapping[str, float]) -> LinearModel:
        """Return the model of settings; other gains alone cost a tenth, see `RetunedModels`."""
        other = {name for name, value in settings.items() if value != study.gains.get(name)}
        if other <= RETUNABLE:
            if self._models is None:
                self._models = retuned_models(study, self._point, study.gains)
            return self._models({**study.gains, **settings})
        return study.sampled(self._point, settings)
