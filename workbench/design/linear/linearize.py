"""Linear models for python-control, by one function."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from workbench.common.errors import WorkbenchError, unknown_name
from workbench.control.controller import Controller
from workbench.control.loop import LOOP_CUTS
from workbench.design.linear.model import LinearModel, Matrices
from workbench.design.linear.operating_point import HOVER_POINT, OperatingPoint, parse_point
from workbench.design.linear.study import LinearStudy
from workbench.scenario.scenario import Scenario
from workbench.setup import Setup

if TYPE_CHECKING:
    import control

CLOSED_LOOP, VEHICLE_ONLY = "closed", "vehicle"
MODEL_TIMES = ("sampled", "continuous")
DEFAULT_INPUTS = ("reference_v_x", "reference_v_y", "reference_v_z", "reference_yaw_rate")
DEFAULT_OUTPUTS = ("v_x", "v_y", "v_z", "w_z")
RANK_TOLERANCE = 1e-7
"""Smallest new share of a step of the staircase to count as a direction."""


def linearize(
    scenario: Scenario | Setup | None = None,
    *,
    at: OperatingPoint | str = HOVER_POINT,
    loop: str = CLOSED_LOOP,
    cut: str = "actuator",
    time: str = "sampled",
    inputs: Sequence[str] | None = None,
    outputs: Sequence[str] | None = None,
    gains: Mapping[str, float] | None = None,
    minimal: bool = False,
) -> "control.StateSpace":
    """Return an exact linear model as a `control.StateSpace` with named signals.

    Arguments are those of `linear_matrices`.

    Raises:
        WorkbenchError: if a name is unknown, or the vehicle cannot fly like that.
    """
    return linear_matrices(
        scenario,
        at=at,
        loop=loop,
        cut=cut,
        time=time,
        inputs=inputs,
        outputs=outputs,
        gains=gains,
        minimal=minimal,
    ).state_space()


def linear_matrices(
    scenario: Scenario | Setup | None = None,
    *,
    at: OperatingPoint | str = HOVER_POINT,
    loop: str = CLOSED_LOOP,
    cut: str = "actuator",
    time: str = "sampled",
    inputs: Sequence[str] | None = None,
    outputs: Sequence[str] | None = None,
    gains: Mapping[str, float] | None = None,
    minimal: bool = False,
) -> Matrices:
    """Return an exact linear model as matrices, without python-control.

    Args:
        scenario: its vehicle, variation, gains and rates are used.
        at: operating point, or text such as `vx=5,yaw_rate=0.2`.
        loop: `closed`; `vehicle`, from rotor commands to motion; or the name of a loop, for the
            open loop L with negative feedback while all others stay closed.
        cut: where to open the loop: `actuator`, its output to the inner loop, or `error`.
        time: `sampled`, from one control update to the next, with hold and computing delay as in
            flight; or `continuous`, without them.
        inputs: names of selected inputs of the closed loop or the vehicle.
        outputs: names of selected outputs.
        gains: parameter values by name that differ from the scenario's.
        minimal: whether to remove states that are not reachable or not observable.

    Raises:
        WorkbenchError: if a name is unknown, or the vehicle cannot fly like that.
    """
    point = parse_point(at) if isinstance(at, str) else at
    if time not in MODEL_TIMES:
        raise unknown_name("kind of time", time, MODEL_TIMES)
    study = LinearStudy(scenario)
    _check_cut(study.controller, loop, cut, point)
    if loop == VEHICLE_ONLY:
        system = _vehicle_model(study.bare_vehicle(point, gains), time, study, inputs, outputs)
    else:
        found = study.sampled if time == "sampled" else study.continuous
        if loop == CLOSED_LOOP:
            system = found(point, gains).matrices(
                inputs or DEFAULT_INPUTS, outputs or DEFAULT_OUTPUTS
            )
        elif inputs or outputs:
            raise WorkbenchError(
                "an open loop has the input and output of its cut: leave the names out"
            )
        else:
            wanted = study.controller.loop(loop)
            if wanted.hold and not point.hold:
                point = OperatingPoint(hold=True)
            system = found(point, gains).loop_matrices(wanted.point(cut))
    return minimal_realisation(system) if minimal else system


def _check_cut(controller: Controller, loop: str, cut: str, point: OperatingPoint) -> None:
    """Refuse an unknown loop or cut."""
    known = (CLOSED_LOOP, VEHICLE_ONLY, *(each.name for each in controller.loops))
    if loop not in known:
        raise unknown_name("loop", loop, known)
    if cut not in LOOP_CUTS:
        raise unknown_name("place to cut a loop", cut, LOOP_CUTS)
    if loop in (CLOSED_LOOP, VEHICLE_ONLY):
        if cut != "actuator":
            raise WorkbenchError(f"'{loop}' has no loop to cut: name a loop, or leave the cut out")
    elif controller.loop(loop).hold and point not in (OperatingPoint(), OperatingPoint(hold=True)):
        raise WorkbenchError(
            f"the position is held in hover only: the loop {loop} is not closed at {point.label}"
        )


def _vehicle_model(
    model: LinearModel,
    time: str,
    study: LinearStudy,
    inputs: Sequence[str] | None,
    outputs: Sequence[str] | None,
) -> Matrices:
    """Return the model of the vehicle, if requested sampled with held commands."""
    commands = [signal.name for signal in model.inputs]
    motions = [signal.name for signal in model.outputs[:12]]
    system = model.matrices(inputs or commands, outputs or motions)
    if time == "continuous":
        return system
    import control

    period = study.scenario.rates.control_period
    held = control.sample_system(system.state_space(), period, method="zoh")
    return replace(system, A=held.A, B=held.B, C=held.C, D=held.D, dt=period)


def minimal_realisation(system: Matrices) -> Matrices:
    """Return a minimal realisation: a system of least order with the same transfer functions.

    Its states are combinations of the old ones, without names. This is the Kalman decomposition by
    orthogonal bases of the reachable, then of the observable directions (Rosenbrock's staircase).
    The one in python-control needs slycot.
    """
    A, B, C = system.A, system.B, system.C
    reach = reachable(A, _unit_columns(B))
    A, B, C = reach.T @ A @ reach, reach.T @ B, C @ reach
    seen = reachable(A.T, _unit_columns(C.T))
    A, B, C = seen.T @ A @ seen, seen.T @ B, C @ seen
    return replace(system, A=A, B=B, C=C, state_labels=())


def reachable(A: np.ndarray, B: np.ndarray) -> np.ndarray:
    """Return an orthonormal basis of the reachable subspace: the span of B, A B, A² B, ..."""
    basis = np.zeros((A.shape[0], 0))
    new = B
    while basis.shape[1] < A.shape[0]:
        whole = np.linalg.norm(new, axis=0).max()
        for _ in range(2):  # twice is enough against rounding errors
            new = new - basis @ (basis.T @ new)
        left, sizes, _ = np.linalg.svd(new, full_matrices=False)
        left = left[:, sizes > RANK_TOLERANCE * whole]
        if left.shape[1] == 0:
            break
        basis = np.hstack([basis, left])
        new = A @ left
    return basis


def _unit_columns(columns: np.ndarray) -> np.ndarray:
    """Return normalised columns; zero columns stay zero."""
    sizes = np.linalg.norm(columns, axis=0)
    return columns / np.where(sizes > 0.0, sizes, 1.0)
