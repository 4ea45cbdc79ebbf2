"""Measure a loop in flight, and compare it with its sampled linear model."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from workbench.common.errors import WorkbenchError
from workbench.common.plain_files import write_atomically
from workbench.control.loop import Loop
from workbench.design.judge.loop_response import loop_responses
from workbench.design.judge.margins import LoopMargins, response_margins
from workbench.design.judge.measured_loop import MIN_COHERENCE, MeasuredLoop, measured_loop
from workbench.design.linear.model import LinearModel, frequency_response
from workbench.design.linear.operating_point import OperatingPoint
from workbench.design.linear.study import LinearStudy
from workbench.plant.thrust_frame import thrust_frame
from workbench.plant.vehicle import Vehicle
from workbench.scenario.multisine import multisine
from workbench.scenario.scenario import Injection, Rates, Scenario, ScenarioStart
from workbench.scenario.scenario_check import check_injection
from workbench.setup import Setup, make_setup

MEASUREMENT_HEIGHT_M = 10.0
"""Height for the measurement of a loop [m], far from the ground, as in linear models."""
MIN_MEASURED_RAD_S = 0.5
"""Usual lowest frequency of a measurement [rad/s]."""
MEASURED_BANDWIDTH_RATIO = 4.0
"""Usual highest frequency, as a multiple of the larger of bandwidth and crossover."""
MEASUREMENT_PERIODS = 8
"""Usual number of periods of a measurement; the first one is not evaluated."""
INJECTION_ROTOR_SHARE, INJECTION_TILT_RAD, INJECTION_SPEED_M_S = 0.1, math.radians(6.0), 0.7
"""Limits of an injection, rms: share of the rotors' reserve, tilt [rad] and speed [m/s]."""
INJECTION_ERROR_RAD = 0.03
"""Limit of errors of angles at loop points, rms [rad]: a loop of high gain cancels almost all of
the injection, and nonlinear effects would mask the small rest."""
ANGLE_UNITS_PER_RAD = {"1": 1.0, "rad": 1.0, "deg": math.degrees(1.0)}
"""Units of loop points that are angles, per radian."""


@dataclass(frozen=True)
class Measurement:
    """A measured loop, with its linear model.

    Attributes:
        vehicle: its name.
        loop: its name.
        cut: where it was opened: actuator or error.
        injection: the one flown.
        measured: response, coherence and spread.
        model: (F) L of the sampled linear model, at the same frequencies.
        margins: of that model.
    """

    vehicle: str
    loop: str
    cut: str
    injection: Injection
    measured: MeasuredLoop
    model: np.ndarray
    margins: LoopMargins

    @property
    def difference(self) -> np.ndarray:
        """Measured L over that of the model (F)."""
        found: np.ndarray = self.measured.response / self.model
        return found

    def worst(self) -> tuple[float, float] | None:
        """Return the largest difference up to the bandwidth in dB and rad, or None.

        Frequencies with a coherence below `MIN_COHERENCE` do not count.
        """
        counts = self.measured.coherence >= MIN_COHERENCE
        counts &= self.measured.frequency <= self.margins.bandwidth
        if not counts.any():
            return None
        difference = self.difference[counts]
        size = np.abs(20.0 * np.log10(np.abs(difference)))
        return float(size.max()), float(np.abs(np.angle(difference)).max())

    def rows(self) -> list[dict[str, float]]:
        """Return a row for each frequency, SI and rad; phases are within half a turn."""
        measured = self.measured
        columns = {
            "frequency": measured.frequency,
            "coherence": measured.coherence,
            "measured_size": np.abs(measured.response),
            "measured_phase": np.angle(measured.response),
            "deviation": measured.deviation,
            "model_size": np.abs(self.model),
            "model_phase": np.angle(self.model),
        }
        values = zip(*columns.values(), strict=True)
        return [dict(zip(columns, map(float, row), strict=True)) for row in values]

    def write_csv(self, path: Path) -> None:
        """Write the rows as a table, with units in the head."""
        rows = self.rows()
        units = {"frequency": " [rad/s]", "measured_phase": " [rad]", "model_phase": " [rad]"}
        lines = [",".join(name + units.get(name, "") for name in rows[0])]
        lines += [",".join(repr(value) for value in row.values()) for row in rows]
        write_atomically(path, "\n".join([*lines, ""]))


def loop_injection(
    model: LinearModel,
    loop: Loop,
    vehicle: Vehicle,
    cut: str = "actuator",
    *,
    size: float | None = None,
    lowest: float = MIN_MEASURED_RAD_S,
    highest: float | None = None,
    periods: int = MEASUREMENT_PERIODS,
) -> Injection:
    """Return an injection that measures a loop of a hovering drone.

    Without a size it is as large as the linear model allows: in rms, rotors use
    `INJECTION_ROTOR_SHARE` of their reserve, the drone tilts by `INJECTION_TILT_RAD` and moves at
    `INJECTION_SPEED_M_S`.

    Args:
        model: of the loop in that flight, see `Injection.action`.
        loop: one of its controller's.
        vehicle: the one flown.
        cut: where to open it, actuator or error.
        size: rms, in the unit of the loop point.
        lowest: frequency [rad/s].
        highest: frequency [rad/s]; by default somewhat above the crossover of the loop.
        periods: see `Injection`.

    Raises:
        WorkbenchError: if the loop is unstable and so cannot be flown, or an argument is out of
            range.
    """
    controller = model.controller
    assert controller is not None
    point = loop.point(cut)
    spacing = controller.point_dividers[point] * model.period
    margins = response_margins(loop_responses(model, [point]))[0]
    if not margins.stable:
        raise WorkbenchError(f"the loop {loop.name} is unstable, so it cannot be measured")
    if highest is None and lowest > 0.0:
        fastest = np.nanmax([margins.crossover, margins.bandwidth, 4.0 * lowest])
        highest = min(MEASURED_BANDWIDTH_RATIO * float(fastest), 0.9 * math.pi / spacing)
    highest = lowest if highest is None else highest  # which is rejected
    found = Injection(point, 1.0 if size is None else size, lowest, highest, periods)
    check_injection(found, controller, Rates(control_period=model.period))
    return (
        found if size is not None else replace(found, size=_injection_size(model, found, vehicle))
    )


def fly_measurement(
    name: str,
    *,
    cut: str = "actuator",
    scenario: Scenario | Setup | None = None,
    settings: Mapping[str, float] | None = None,
    size: float | None = None,
    lowest: float = MIN_MEASURED_RAD_S,
    highest: float | None = None,
    periods: int = MEASUREMENT_PERIODS,
    progress: Callable[[float], None] | None = None,
) -> "Measurement":
    """Measure a loop of a hovering drone in flight.

    Args:
        name: of the loop.
        cut: where to open it, actuator or error.
        scenario: its vehicle, sensors, rates and world are used; start and script are its own.
        settings: parameter values for this flight, such as wind and turbulence.
        size: see `loop_injection`.
        progress: called with the flown share, 0 .. 1.
        lowest: see `loop_injection`.
        highest: see `loop_injection`.
        periods: see `loop_injection`.

    Raises:
        WorkbenchError: if it cannot be flown, or the drone is lost.
    """
    from workbench.design.lost import find_loss
    from workbench.session.session import Session

    setup = make_setup(scenario, settings)
    start = ScenarioStart(position=[0.0, 0.0, MEASUREMENT_HEIGHT_M])
    setup = setup.with_scenario(replace(setup.scenario, start=start, figure_eight=None, script=[]))
    loop = setup.controller.loop(name)
    model = LinearStudy(setup).sampled(OperatingPoint(hold=loop.hold))
    injection = loop_injection(
        model,
        loop,
        setup.vehicle,
        cut,
        size=size,
        lowest=lowest,
        highest=highest,
        periods=periods,
    )
    session = Session(setup)
    session.do(injection.action(hold=loop.hold))
    while (share := session.injecting) is not None and share < 1.0:
        session.tick(0.5)
        if progress:
            progress(share)
    if loss := find_loss(session.recording()):
        raise WorkbenchError(f"{loss.sentence}: give the measurement a smaller size")
    assert session.injected is not None
    found = measured_loop(session.injected)
    loops = loop_responses(model, [injection.point])
    return Measurement(
        vehicle=setup.vehicle.name,
        loop=name,
        cut=cut,
        injection=injection,
        measured=found,
        model=loops.at(found.frequency)[0],
        margins=response_margins(loops)[0],
    )


def _injection_size(model: LinearModel, injection: Injection, vehicle: Vehicle) -> float:
    """Return the rms size for which the linear model of the drone remains valid."""
    frame = thrust_frame(vehicle)
    most = np.array([rotor.max_thrust for rotor in frame.rotors])
    hover = frame.hover_thrusts
    room = np.minimum(most - hover, hover - frame.idle_thrusts)
    law = model.controller
    divider = law.point_dividers[injection.point] if law else 1
    wave = multisine(injection.lowest, injection.highest, divider * model.period)
    names = [*(f"thrust_{index + 1}" for index in range(len(most))), "roll", "pitch"]
    names += ["v_x", "v_y", "v_z"]
    errors = {
        name: INJECTION_ERROR_RAD * ANGLE_UNITS_PER_RAD[unit]
        for name, unit in (law.points if law else {}).items()
        if unit in ANGLE_UNITS_PER_RAD and name.endswith("_error")
    }
    names += errors
    found = frequency_response(model, wave.frequency, names, [injection.point])
    response = np.abs(found[:, :, 0])
    lag = np.abs(1.0 + 1j * wave.frequency * vehicle.rotor_lag)
    response[:, : len(most)] *= lag[:, None]  # the commands, before the lag of the rotors
    sines = np.abs(np.fft.rfft(wave.values)[wave.lines]) / len(wave.values)
    rms = np.sqrt(2.0 * (response**2 * sines[:, None] ** 2).sum(axis=0))
    allowed = [
        *(INJECTION_ROTOR_SHARE * np.where(room > 0.0, room, np.inf)),
        INJECTION_TILT_RAD,
        INJECTION_TILT_RAD,
        *[INJECTION_SPEED_M_S] * 3,
    ]
    allowed += errors.values()
    return float((np.array(allowed) / np.maximum(rms, 1e-12)).min())
