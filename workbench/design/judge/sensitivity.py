"""Exact sensitivities of the metrics of a step to the gains, by automatic differentiation.

The step is simulated with the continuous flight core: the law without its sample time, in still
air.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from pydrake.autodiffutils import AutoDiffXd, ExtractValue, InitializeAutoDiff
from pydrake.systems.analysis import ResetIntegratorFromFlags, Simulator, Simulator_
from pydrake.systems.framework import Diagram, System

from workbench.common.errors import WorkbenchError, unknown_name
from workbench.control.guidance import Guidance, Reference
from workbench.design.metrics import FLOWN_METRICS
from workbench.design.step_response import MIN_STEP_DURATION_S, STEP_START_HEIGHT_M
from workbench.diagram.core import make_flight_core
from workbench.diagram.forces import body_places
from workbench.plant.payload import payload_of, vehicle_with_payload
from workbench.plant.placing import body_state
from workbench.plant.thrust_frame import thrust_frame
from workbench.plant.variation import Variation
from workbench.plant.vehicle import Vehicle
from workbench.scenario.axes import AXIS_NAMES
from workbench.scenario.scenario import Scenario
from workbench.setup import Setup, make_setup

SENSITIVITY_STEP_S = 1 / 128
"""Step of the integrator, third-order Runge-Kutta, and of the samples of curves [s]."""
_AXIS_VELOCITY_INDEX = {"x": 10, "y": 11, "z": 12, "yaw": 9}
"""Index of the velocity of an axis in the state of the body."""
SENSITIVITY_METRICS = tuple(metric.name for metric in FLOWN_METRICS)
SENSITIVITY_BAND = 0.02
"""Settling band, as a share of the steady state, as in python-control."""
MIN_METRIC_VALUE = 1e-6
"""Smaller values of a metric, in its unit or percent, are rounding errors and count as 0."""


@dataclass(frozen=True)
class CubicCurve:
    """Cubic pieces between samples of a value and its slope, with derivatives by the gains.

    Every number read from it (the time of a crossing, a peak) has derivatives, too: a step of
    Newton's method from the root does not change the value, and yields the derivatives of the
    implicit function theorem.

    Attributes:
        time: (N) [s], evenly spaced.
        value: (N) of AutoDiffXd.
        slope: (N) by time, of AutoDiffXd.
    """

    time: np.ndarray
    value: np.ndarray
    slope: np.ndarray

    def scaled(self, factor: float) -> "CubicCurve":
        """Return the curve times a factor."""
        return CubicCurve(self.time, factor * self.value, factor * self.slope)

    @property
    def end(self) -> AutoDiffXd:
        """The last value."""
        return self.value[-1]

    @cached_property
    def _numbers(self) -> np.ndarray:
        """The values without derivatives (N)."""
        return np.asarray(ExtractValue(self.value)).ravel()

    def first_crossing(self, level: AutoDiffXd) -> AutoDiffXd:
        """Return when the curve first reaches a level from below; NaN if never."""
        return self._crossing(np.flatnonzero(self._numbers[1:] >= level.value())[:1], level)

    def last_crossing(self, level: AutoDiffXd) -> AutoDiffXd:
        """Return when the curve last crosses a level; NaN if never."""
        above = self._numbers > level.value()
        return self._crossing(np.flatnonzero(above[1:] != above[:-1])[-1:], level)

    def highest(self) -> tuple[AutoDiffXd, AutoDiffXd]:
        """Return the largest value and its time."""
        piece = int(np.argmax(self._numbers))
        ends = self.value[piece], AutoDiffXd(self.time[piece])
        return self._peak(piece - 1) or self._peak(piece) or ends

    def _crossing(self, pieces: np.ndarray, level: AutoDiffXd) -> AutoDiffXd:
        """Return the time at which the curve crosses a level in a piece, if any."""
        if not len(pieces):
            return AutoDiffXd(np.nan, np.full(level.derivatives().size, np.nan))
        index = int(pieces[0])
        step, data = self._piece(index)
        known = ExtractValue(data).ravel()
        share = _root(_CUBIC_MATRIX @ known - [0.0, 0.0, 0.0, level.value()])
        beyond = _cubic_weights(share) @ data - level
        return self.time[index] + step * (
            share - beyond / float(_cubic_slope_weights(share) @ known)
        )

    def _peak(self, index: int) -> tuple[AutoDiffXd, AutoDiffXd] | None:
        """Return the largest value and its time in a piece, if the curve has an extremum there."""
        if not 0 <= index < len(self.time) - 1:
            return None
        if not self.slope[index].value() > 0.0 >= self.slope[index + 1].value():
            return None
        step, data = self._piece(index)
        cubic = _CUBIC_MATRIX @ ExtractValue(data).ravel()
        share = _root(np.polyder(cubic))
        bend = float(np.polyval(np.polyder(cubic, 2), share))
        turned = share - (_cubic_slope_weights(share) @ data) / bend
        return _cubic_weights(share) @ data, self.time[index] + step * turned

    def _piece(self, index: int) -> tuple[float, np.ndarray]:
        """Return length, and values and slopes (4) at the ends, slopes by share of the piece."""
        step = float(self.time[index + 1] - self.time[index])
        ends = slice(index, index + 2)
        return step, np.append(self.value[ends], step * self.slope[ends])


_CUBIC_MATRIX = np.array(
    [[2.0, -2.0, 1.0, 1.0], [-3.0, 3.0, -2.0, -1.0], [0.0, 0.0, 1.0, 0.0], [1.0, 0.0, 0.0, 0.0]]
)
"""Matrix from the data of a piece (values at its ends, slopes at its ends) to its cubic."""


def _cubic_weights(share: float) -> np.ndarray:
    """Return the weight of each datum (4) in the curve at a share of a piece."""
    weights: np.ndarray = np.array([share**3, share**2, share, 1.0]) @ _CUBIC_MATRIX
    return weights


def _cubic_slope_weights(share: float) -> np.ndarray:
    """Return the same for the derivative by the share."""
    slope: np.ndarray = np.array([3.0 * share**2, 2.0 * share, 1.0, 0.0]) @ _CUBIC_MATRIX
    return slope


def _root(polynomial: np.ndarray) -> float:
    """Return the root in 0 .. 1, or the one nearest to it."""
    roots = np.roots(polynomial)
    roots = roots[np.abs(roots.imag) < 1e-6].real
    return float(np.clip(roots[np.argmin(np.abs(roots - 0.5))], 0.0, 1.0))


@dataclass(frozen=True)
class Sensitivity:
    """The sensitivity of one metric of a step to the gains.

    Attributes:
        metric: its name, as in `StepMetrics`.
        value: of the continuous flight; times are not rounded to samples.
        derivatives: by the name of each gain, in units of the metric per unit of the gain.
        elasticities: change of the metric in percent per percent of the gain; NaN if the metric is
            0.
    """

    metric: str
    value: float
    derivatives: dict[str, float]
    elasticities: dict[str, float]


def step_sensitivity(
    axis: str,
    amplitude: float,
    *,
    duration: float = 3.0,
    heading: float = 0.0,
    scenario: Scenario | Setup | None = None,
    settings: Mapping[str, float] | None = None,
    progress: Callable[[float], None] | None = None,
) -> tuple[Sensitivity, ...]:
    """Return the sensitivity of every metric of a step from hover to every controller parameter.

    It is that in still air, whatever wind the scenario has. Arguments are those of `fly_step`, and
    the yaw of the drone at the start, `heading` [rad].

    Raises:
        WorkbenchError: if axis, amplitude or duration are invalid, or the scenario varies the
            vehicle, moves a servo, or has a payload unknown to the law, as the flight begins in a
            known hover.
    """
    if axis not in AXIS_NAMES:
        raise unknown_name("axis", axis, AXIS_NAMES)
    if not MIN_STEP_DURATION_S <= duration < np.inf or not 0.0 < abs(amplitude) < np.inf:
        raise WorkbenchError(
            f"a step of {amplitude:g} over {duration:g} s cannot be measured: give it an amplitude "
            f"that is not 0 and {MIN_STEP_DURATION_S:g} s or more"
        )
    setup = make_setup(scenario, settings).without_dropped_loads()
    if setup.variation != Variation():
        raise WorkbenchError(
            "sensitivities are those of the vehicle as its controller knows it: leave the "
            "variation out"
        )
    vehicle, controller, values = setup.vehicle, setup.controller, setup.values
    if controller.designed:
        raise WorkbenchError(
            f"sensitivities need derivatives, and {controller.name} designs numbers of its gains: "
            "sweep them instead"
        )
    payload = payload_of(values)
    if payload.payload_mass != payload.known_payload_mass:
        raise WorkbenchError(
            "sensitivities are those of the vehicle as its controller knows it: set "
            f"known_payload_mass to payload_mass, {payload.payload_mass:g} kg"
        )
    moved = [row.name for row in controller.setpoints if values[row.name] != row.default]
    if moved:
        raise WorkbenchError(
            "sensitivities are those of a step that begins with all servos at their start: leave "
            f"{' and '.join(moved)} there"
        )
    gains = {row.name: values[row.name] for row in controller.parameters}
    core = make_flight_core(setup)
    start = _hover_state(core, vehicle_with_payload(vehicle, payload), heading)
    simulator = _prepared(core.ToAutoDiffXd(), start, axis, amplitude, list(gains.values()))
    time, state, rate = _flown_states(simulator, duration, progress)
    own, first = _body_and_rotors(core, vehicle)
    moved = own[_AXIS_VELOCITY_INDEX[axis]]
    found = carried_metrics(CubicCurve(time, state[:, moved], rate[:, moved]), amplitude)
    uses = []
    for place, rotor in enumerate(vehicle.rotors, start=first):
        limit = rotor.max_rot_velocity
        use, _ = CubicCurve(time, state[:, place] / limit, rate[:, place] / limit).highest()
        uses.append(use)
    found["peak_rotor_use"] = max(uses, key=lambda use: use.value())
    return tuple(_metric_sensitivity(name, found[name], gains) for name in SENSITIVITY_METRICS)


def _hover_state(core: Diagram, vehicle: Vehicle, heading: float) -> np.ndarray:
    """Return the core's state in hover with a yaw [rad], the joints at their start."""
    root = core.CreateDefaultContext()
    frame = thrust_frame(vehicle)
    state: np.ndarray = root.get_continuous_state_vector().CopyToVector()
    own, first = _body_and_rotors(core, vehicle)
    state[own] = body_state(
        p_WB=[0.0, 0.0, STEP_START_HEIGHT_M],
        roll_pitch_yaw=frame.roll_pitch_yaw([0.0, 0.0, heading]),
        v_WB=[0.0, 0.0, 0.0],
        w_WB=[0.0, 0.0, 0.0],
    )
    state[first : first + len(vehicle.rotors)] = frame.hover_speeds
    return state


def _body_and_rotors(core: Diagram, vehicle: Vehicle) -> tuple[np.ndarray, int]:
    """Return the places of the body's state in the core's (13), and the first of the rotors'."""
    plant = core.GetSubsystemByName("plant")
    return body_places(plant, plant.GetBodyByName(vehicle.base_link)), plant.num_multibody_states()


def _prepared(
    core: System, start: np.ndarray, axis: str, amplitude: float, gains: list[float]
) -> Simulator:
    """Return a Simulator in hover, just after the command."""
    root = core.CreateDefaultContext()
    root.SetContinuousState(start)
    controller = core.GetSubsystemByName("controller").GetMyMutableContextFromRoot(root)
    carried = InitializeAutoDiff(np.array(gains)).ravel()
    controller.get_mutable_numeric_parameter(0).SetFromVector(carried)
    reference = np.zeros(len(Reference._fields))
    reference[AXIS_NAMES.index(axis)] = amplitude
    # as in flight, the position is held until a pilot steers, and also while turning in place
    hold = Guidance(1.0, 1.0, 1.0, 0.0, 1.0, 1.0, 0.0, 0.0, STEP_START_HEIGHT_M)
    core.GetInputPort("reference").FixValue(root, reference)
    core.GetInputPort("guidance").FixValue(root, np.array(hold))
    simulator = Simulator_[AutoDiffXd](core, root)
    ResetIntegratorFromFlags(simulator, "runge_kutta3", SENSITIVITY_STEP_S)
    simulator.get_mutable_integrator().set_fixed_step_mode(True)
    simulator.Initialize()
    return simulator


def _flown_states(
    simulator: Simulator, duration: float, progress: Callable[[float], None] | None
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return times (N) of a flight, its states and their slopes (N, m) with derivatives."""
    count = round(duration / SENSITIVITY_STEP_S)
    states, rates = [], []
    for index in range(count + 1):
        simulator.AdvanceTo(index * SENSITIVITY_STEP_S)
        context = simulator.get_context()
        states.append(context.get_continuous_state_vector().CopyToVector())
        rates.append(simulator.get_system().EvalTimeDerivatives(context).CopyToVector())
        if progress:
            progress(index / count)
    return SENSITIVITY_STEP_S * np.arange(count + 1), np.array(states), np.array(rates)


def carried_metrics(response: CubicCurve, command: float) -> dict[str, AutoDiffXd]:
    """Return python-control's step metrics of a curve, with their derivatives, by name."""
    sign = float(np.sign(command))
    curve = response.scaled(sign)
    steady = curve.end
    peak, peak_time = curve.highest()
    lowest, _ = curve.scaled(-1.0).highest()
    band = [curve.last_crossing((1.0 + side * SENSITIVITY_BAND) * steady) for side in (-1.0, 1.0)]
    settled = [time for time in band if np.isfinite(time.value())]
    return {
        "rise_time": curve.first_crossing(0.9 * steady) - curve.first_crossing(0.1 * steady),
        "settling_time": max(settled, key=lambda time: time.value()),
        "overshoot": 100.0 * ((peak - steady) / steady),
        "undershoot": 100.0 * (lowest / steady),
        "peak": peak,
        "peak_time": peak_time,
        "steady_state_value": sign * steady,
        "steady_state_error": 100.0 * abs(1.0 - steady / abs(command)),
    }


def _metric_sensitivity(metric: str, found: AutoDiffXd, gains: Mapping[str, float]) -> Sensitivity:
    """Return the sensitivity of a metric."""
    value = found.value() if abs(found.value()) >= MIN_METRIC_VALUE else 0.0
    slopes = (found.derivatives() + 0.0).tolist() or [0.0] * len(gains)  # no -0
    derivatives = dict(zip(gains, slopes, strict=True))
    return Sensitivity(
        metric=metric,
        value=value,
        derivatives=derivatives,
        elasticities={
            name: gains[name] * slope / value if value else float("nan")
            for name, slope in derivatives.items()
        },
    )
