"""Predict a logged flight with other gains or another law, with uncertainty.

The part of the log that the model does not explain is kept as a disturbance over time, see
`driven`, and acts again. Each vehicle in a sample of uncertain ones has its own disturbance for the
log; the band covers their flights with the other law. So it is wide where the result depends on
unknowns, and has no width where it does not: with the original law each of them flies the log.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from workbench.common.errors import WorkbenchError
from workbench.control.controller import Controller
from workbench.design.rollout.lanes import LANES
from workbench.extras.flightdata.predict.driven import FULL_COMMAND_SHARE, PUSH_SIZE
from workbench.extras.flightdata.predict.flown import (
    DEFAULT_LAW_PERIOD_S,
    PUSH_TRIALS,
    FlightCourses,
    FlightStarts,
    compiled_driven,
    make_compiled_model,
)
from workbench.extras.flightdata.predict.known import ESTIMATE_ERROR_SIZE, Observer
from workbench.extras.flightdata.predict.motion import (
    POSITION_VELOCITY_ROWS,
    WRONG_DRONE_REMEDY,
    LoggedMotion,
    resampled,
    rotation_matrices,
)
from workbench.extras.flightdata.predict.past import (
    Past,
    rotor_limits,
    thrust_doubt,
    voltage_doubt,
)
from workbench.extras.flightdata.predict.uncertainty import Uncertainty, drawn_vehicle
from workbench.plant.drag import drag_area
from workbench.plant.vehicle import Vehicle

BAND_SHARE = 0.95
"""Share of the flights of sampled vehicles within the band."""
MIN_BAND_HALF_WIDTH_M = 1e-3
"""Smallest half width of the band of a position [m], from rounding in the log."""
MAX_EXPLAINED_GAP_S = 0.5
"""Longest gap in a log across which it is flown [s]; across a longer one, the interpolated path
would need forces that never acted."""
MAX_BELOW_GROUND_M = 0.05
"""Depth below the ground of the log from which on a vehicle has reached it [m]."""
DOUBTED_SATURATION_SHARE = 0.05
"""Share of the time at which a rotor is at its limit from which on a height is in doubt."""
SAMPLED_VEHICLES = 40
"""Number of vehicles sampled for the band."""


@dataclass(frozen=True)
class Law:
    """A law and its gains.

    Attributes:
        controller: the law.
        gains: of all its parameters, by name.
    """

    controller: Controller
    gains: dict[str, float]

    @property
    def period(self) -> float:
        """Period of updates [s]."""
        return self.controller.period or DEFAULT_LAW_PERIOD_S


@dataclass(frozen=True)
class WhatIf:
    """A logged flight, and its prediction with another law.

    Attributes:
        flight: its name.
        time: from the start of the log on (k) [s].
        setpoint: commanded position in W (k, 3) [m].
        logged: states (k, 13), see `record.flight_dtype`.
        again: states with its own law, which show how well the disturbance explains the log (k,
            13).
        other: states with the other law (k, 13); NaN once the nominal vehicle is lost.
        low: lower edges of the band of position and velocity (k, 6) [m, m/s].
        high: upper edges.
        disturbance: force in W [N] and moment in B [N·m] (k, 6).
        stays: number of samples before the nominal vehicle is lost; all of them if it never is.
        lost: number of vehicles that do not stay in the air with the other law.
        grounded: number of those that reach the ground of the log.
        drawn: number of vehicles flown.
        saturated: shares of the time in which a rotor is at its limit (3): in the log, and of the
            nominal vehicle with its own law and with the other.
        remembers: whether its own law has memory, as integrals.
    """

    flight: str
    time: np.ndarray
    setpoint: np.ndarray
    logged: np.ndarray
    again: np.ndarray
    other: np.ndarray
    low: np.ndarray
    high: np.ndarray
    disturbance: np.ndarray
    stays: int
    lost: int
    grounded: int
    drawn: int
    saturated: tuple[float, float, float]
    remembers: bool

    @property
    def doubt(self) -> str:
        """Why the height may be wrong: motors at their limits do not hold it; else ""."""
        log, own, other = self.saturated
        if max(own, other) < DOUBTED_SATURATION_SHARE:
            return ""
        reason = ""
        # Without integrals, or where the log itself explains it, they are not the reason.
        if self.remembers and own - log >= DOUBTED_SATURATION_SHARE:
            reason = "integrals of inner loops may wind up against the disturbance, and "
        return (
            f"motors saturate {other:.0%} of the time with it, {own:.0%} where the model flies "
            f"{self.flight} with its own law and {log:.0%} in the log: {reason}its height may be "
            "wrong"
        )

    @property
    def difference(self) -> np.ndarray:
        """Other flight minus the log while the nominal vehicle stays, position and velocity."""
        return np.asarray((self.other - self.logged)[: self.stays, POSITION_VELOCITY_ROWS])

    @property
    def off_setpoint(self) -> np.ndarray:
        """RMS of the deviations of log and other flight from the setpoint meanwhile (2, 3) [m]."""
        off = np.array([each[:, 4:7] - self.setpoint for each in (self.logged, self.other)])
        off = off[:, : self.stays]
        return np.asarray(np.sqrt(np.mean(off**2, axis=1)))


class Explained:
    """A logged flight, explained by a vehicle, its law and a disturbance.

    The disturbance for each sampled vehicle is computed on its first flight and cached: from then
    on another law costs one flight for each vehicle. The flights of the last law are cached, too.

    Args:
        motion: the flight.
        vehicle: as known to its law.
        flown: the law that flew.
        uncertainty: of the vehicle.
        draws: number of sampled vehicles, in addition to the nominal one.
        seed: of the sample.

    Attributes:
        vehicle: as its law knows it.
        flown: the law that flew.
        doubt: why a result may be wrong, or is of a part of the log; else "".

    Raises:
        WorkbenchError: if it is never in the air.
    """

    def __init__(
        self,
        motion: LoggedMotion,
        vehicle: Vehicle,
        flown: Law,
        uncertainty: Uncertainty | None = None,
        draws: int = SAMPLED_VEHICLES,
        seed: int = 0,
    ) -> None:
        first, last = motion.longest_part(MAX_EXPLAINED_GAP_S)
        self._motion, self.vehicle, self.flown = motion, vehicle, flown
        left = motion.airborne[0] < first or last < motion.airborne[1]
        part = (
            f"{motion.name} has gaps of more than {MAX_EXPLAINED_GAP_S:g} s: flown again is the "
            f"longest part without one, {motion.period * first:.1f} to {motion.period * last:.1f} s"
        )
        doubts = (thrust_doubt(motion, vehicle), voltage_doubt(motion, flown.gains))
        self.doubt = "; ".join(filter(None, (*doubts, part if left else "")))
        if last - first < 2:
            raise WorkbenchError(f"{motion.name}: is never in the air, so there is nothing to fly")
        random = np.random.default_rng(seed)
        uncertain = uncertainty or Uncertainty()
        self._drawn = [
            (vehicle, (0.0, 0.0, 0.0)),
            *(drawn_vehicle(vehicle, uncertain, random) for _ in range(draws)),
        ]
        self._own = _law_start(motion, vehicle, flown)
        self._pushes: list[np.ndarray] = []
        self._other, self._flights, self._saturated = self._own, list[np.ndarray](), np.zeros(1)

    @property
    def drawn(self) -> int:
        """Number of vehicles: the nominal one, and the sampled ones."""
        return len(self._drawn)

    def flights(self, other: Law) -> Iterator[np.ndarray]:
        """Yield states (k, 13) of the flight with another law, of one vehicle after the other.

        The nominal one is the first. A law with another period gets the same disturbance, averaged
        over each of its own periods, so that the impulse is preserved.
        """
        if other != self._other.law:
            self._other, self._flights = _law_start(self._motion, self.vehicle, other), []
            self._saturated = np.zeros(1)
        begun, flights = self._other, self._flights
        for number in range(self.drawn):
            if number == len(flights):
                some = self._beside(number)
                pushes = [
                    _resampled_pushes(each, self.flown.period, begun)
                    for each in self._explain(some)
                ]
                counts = None if number else self._saturated
                found = self._fly(begun, some, np.array(pushes), saturated=counts)
                flights.extend(self._at_own_times(begun, each) for each in found)
            yield flights[number]

    def compare(self, flights: Sequence[np.ndarray]) -> WhatIf:
        """Return the comparison of flights of vehicles, the nominal one first, with the log."""
        own, nominal = self._own, slice(1)
        (pushes,) = self._explain(nominal)
        floor = self._motion.ground - MAX_BELOW_GROUND_M
        ends = [samples_in_air(each, own.targets, floor) for each in flights]
        lost = [(each, end) for each, end in zip(flights, ends, strict=True) if end < len(each)]
        staying = [each for each, end in zip(flights, ends, strict=True) if end == len(each)]
        other = flights[0].copy()
        other[ends[0] :] = np.nan
        low, high = _flight_band(staying or [other])
        counts = np.zeros(1)
        again = self._fly(own, nominal, pushes[None], saturated=counts)[0]
        full = self._motion.commands[slice(*self._motion.longest_part(MAX_EXPLAINED_GAP_S))]
        return WhatIf(
            flight=self._motion.name,
            time=own.time,
            setpoint=resampled(self._motion.setpoint, self._motion.period, own.time),
            logged=own.targets,
            again=again,
            other=other,
            low=low,
            high=high,
            disturbance=np.vstack([pushes, pushes[-1:]])[:, [0, 1, 2, 6, 7, 8]],
            stays=ends[0],
            lost=len(lost),
            grounded=sum(bool(each[end, 6] < floor) for each, end in lost),
            drawn=len(flights),
            saturated=(
                float((full.max(axis=1) > FULL_COMMAND_SHARE).mean()),
                float(counts[0]) / (len(own.time) - 1),
                float(self._saturated[0]) / (len(self._other.time) - 1),
            ),
            remembers=bool(own.law.controller.memory),
        )

    def _beside(self, number: int) -> slice:
        """Return which vehicles fly together with one, which is the first of them."""
        return slice(number, min(number + (LANES if number else 1), self.drawn))

    def _explain(self, some: slice) -> list[np.ndarray]:
        """Return the disturbance (K, 9) of each of some sampled vehicles for the log."""
        if some.stop > len(self._pushes):
            pushes = np.zeros((some.stop - (some.start or 0), len(self._own.voltages), PUSH_SIZE))
            states = self._fly(self._own, some, pushes, PUSH_TRIALS)
            if not np.isfinite(states).all():
                raise WorkbenchError(
                    f"{self._motion.name}: {self.vehicle.name} cannot be brought along this log: "
                    f"{WRONG_DRONE_REMEDY}. Choose its law, too"
                )
            self._pushes.extend(pushes)
        return self._pushes[some]

    def _at_own_times(self, begun: "_LawStart", states: np.ndarray) -> np.ndarray:
        """Return states at the updates of the law that flew."""
        if begun.law.period == self.flown.period:
            return states
        return resampled(states, begun.law.period, self._own.time - begun.time[0])

    def _fly(
        self,
        begun: "_LawStart",
        some: slice,
        pushes: np.ndarray,
        trials: int = 1,
        saturated: np.ndarray | None = None,
    ) -> np.ndarray:
        """Return states of some vehicles (N, K+1, 13); several trials also write the pushes.

        Each flight adds the number of its periods in which a rotor is at its limit (N).
        """
        law, (vehicles, winds) = begun.law, zip(*self._drawn[some], strict=True)
        model = make_compiled_model(self.vehicle, law.controller, law.gains, law.period, vehicles)
        return compiled_driven(law.controller).fly(
            model._replace(drag_areas=[drag_area(each.mass) for each in vehicles], winds=winds),
            begun.start,
            FlightCourses(
                begun.references[None],
                begun.voltages[None],
                pushes,
                begun.errors[None],
                begun.targets[None, 1:],
                begun.limits[None],
                np.zeros(len(vehicles)) if saturated is None else saturated,
            ),
            Observer(),
            trials=trials,
        )


class _LawStart(NamedTuple):
    """A law at the begin of the flight, and the log at its updates.

    Attributes:
        law: the law.
        start: of one flight.
        time: (K+1) [s].
        targets: states of the log (K+1, 13).
        errors: of the estimate (K, 11).
        references: (K, 8).
        voltages: (K).
        limits: see `rotor_limits` (K).
    """

    law: Law
    start: FlightStarts
    time: np.ndarray
    targets: np.ndarray
    errors: np.ndarray
    references: np.ndarray
    voltages: np.ndarray
    limits: np.ndarray


def _law_start(motion: LoggedMotion, vehicle: Vehicle, law: Law) -> _LawStart:
    first, last = motion.longest_part(MAX_EXPLAINED_GAP_S)
    begin = motion.period * first
    updates = math.floor(motion.period * (last - first) / law.period + 1e-9)
    time = begin + law.period * np.arange(updates + 1)

    def at(values: np.ndarray) -> np.ndarray:
        return resampled(values, motion.period, time)

    q, q_known = at(motion.q), at(motion.q_known)
    q /= np.linalg.norm(q, axis=1)[:, None]
    q_known /= np.linalg.norm(q_known, axis=1)[:, None]
    p, v = at(motion.p), at(motion.v)
    errors = np.zeros((updates, ESTIMATE_ERROR_SIZE))
    errors[:, 0:3], errors[:, 3:6] = (at(motion.p_known) - p)[:-1], (at(motion.v_known) - v)[:-1]
    errors[:, 8:11] = (rotation_matrices(q).inv() * rotation_matrices(q_known)).as_rotvec()[:-1]
    model = make_compiled_model(vehicle, law.controller, law.gains, law.period)
    listen = compiled_driven(law.controller).listen
    past = Past(motion, vehicle, law.controller, law.gains, model, listen)
    start = past.start(np.array([first]))
    references = past.references(np.array([first]), law.period * updates)[0]
    times = begin + law.period * np.arange(len(references))
    voltage = resampled(motion.voltage[:, None], motion.period, times)[:, 0] / past.full_voltage
    targets = np.column_stack([q, p, rotation_matrices(q).apply(at(motion.w)), v])
    return _LawStart(
        law,
        start._replace(states=targets[:1], shares=np.ones_like(start.shares)),
        time,
        targets,
        errors,
        references,
        np.where(np.isfinite(voltage), voltage, 1.0),
        at(rotor_limits(motion, vehicle)[:, None])[:-1, 0],
    )


def _resampled_pushes(pushes: np.ndarray, period: float, begun: _LawStart) -> np.ndarray:
    """Return pushes (K, 9) resampled to the periods of another law [s], with the same impulse."""
    if begun.law.period == period:
        return pushes
    impulse = period * np.vstack([np.zeros(PUSH_SIZE), np.cumsum(pushes, axis=0)])
    time = begun.time - begun.time[0]
    return np.diff(resampled(impulse, period, time), axis=0) / begun.law.period


def samples_in_air(states: np.ndarray, logged: np.ndarray, floor: float) -> int:
    """Return the number of samples in which a flight is finite, near the log, above a floor [m]."""
    size = 5.0 + 5.0 * float(np.ptp(logged[:, 4:7], axis=0).max())
    off = np.abs(states[:, 4:7] - logged[:, 4:7]).max(axis=1)
    lost = ~(np.isfinite(states).all(axis=1) & (off < size) & (states[:, 6] >= floor))
    return int(lost.argmax()) if lost.any() else len(states)


def _flight_band(flights: list[np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """Return the band of position and velocity (k, 6) of flights."""
    all_of = np.array([states[:, POSITION_VELOCITY_ROWS] for states in flights])
    tail = 0.5 * (1.0 - BAND_SHARE)
    low, high = np.quantile(all_of, (tail, 1.0 - tail), axis=0)
    return low - MIN_BAND_HALF_WIDTH_M, high + MIN_BAND_HALF_WIDTH_M
