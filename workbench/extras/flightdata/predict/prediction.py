"""Predictions from many instants of a log, their errors, and simple methods for comparison.

Methods, each from the same instants:

- `closed loop`: the law flies the vehicle from setpoints, see `flown`, without later motor
  commands.
- `rates fade`: from the logged motor commands, with the attitude from rates that decay within 0.1
  s.
- `attitude given`: from the logged motor commands and the logged attitude, see `ATTITUDE_BLEND`:
only the
  translation is predicted.
- `nothing changes`: velocity and attitude stay constant.
- `setpoint, late`: the position follows the setpoint with a delay.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from workbench.control.controller import Controller
from workbench.design.response_metrics import response_lag
from workbench.extras.flightdata.predict.flown import (
    CompiledModel,
    FlightCourses,
    compiled_driven,
    make_compiled_model,
)
from workbench.extras.flightdata.predict.known import Observer
from workbench.extras.flightdata.predict.motion import LoggedMotion, resampled, rotation_matrices
from workbench.extras.flightdata.predict.past import (
    ALL_EFFECTS,
    Effects,
    Past,
    air_rates,
    driven_thrust,
    rotor_lagged,
)
from workbench.plant.gravity import GRAVITY
from workbench.plant.vehicle import Vehicle

(
    CLOSED_LOOP_METHOD,
    FADING_RATES_METHOD,
    GIVEN_ATTITUDE_METHOD,
    CONSTANT_METHOD,
    LATE_SETPOINT_METHOD,
) = PREDICTION_METHODS = (
    "closed loop",
    "rates fade",
    "attitude given",
    "nothing changes",
    "setpoint, late",
)
SETPOINT_LAG_S = 0.53
"""Delay of a setpoint, the median of NanoBench's PID flights [s]."""
RATE_DECAY_S = 0.1
"""Time constant of decaying body rates [s]."""
ATTITUDE_BLEND = 0.3
"""Weight of the attitude of the flight computer, relative to the measured one, in the given
attitude: the errors of both are independent and of similar size."""
START_SPACING_S = 0.1
"""Period between starts [s]."""
ERROR_HORIZON_S = 0.5
"""Horizon of predictions [s]."""
MIN_PAST_S = 1.0
"""Time in the air before the first start, as predictions need a past [s]."""
MIN_SETPOINT_MOTION_M = 0.3
"""Smallest motion of the setpoint along an axis to measure a lag [m]."""
TRUE_OBSERVER = Observer(drag=0.0)
"""Observer of a flight computer that knows its true motion."""


@dataclass(frozen=True)
class HorizonErrors:
    """The errors of a method over the horizon.

    Attributes:
        method: see above.
        ahead: times from the start on (h) [s].
        position: distance of each of N predictions (N, h) [m].
        velocity: size of the error (N, h) [m/s].
        attitude: angle of the rotation between predicted and true attitude (N, h) [rad]; NaN if not
            predicted.
    """

    method: str
    ahead: np.ndarray
    position: np.ndarray
    velocity: np.ndarray
    attitude: np.ndarray


@dataclass(frozen=True)
class WholeFlight:
    """A whole flight from its first instant in the air on, closed loop from setpoints.

    Attributes:
        flight: its name.
        time: from the start of the log on (k) [s].
        real: true position (k, 3) [m].
        flown: position of the model (k, 3) [m].
        rmse: of the position [m].
        late_rmse: of the delayed setpoint [m].
        lags: of the model's position behind the setpoint, along moving level axes [s].
        real_lags: the same for the flight [s].
    """

    flight: str
    time: np.ndarray
    real: np.ndarray
    flown: np.ndarray
    rmse: float
    late_rmse: float
    lags: tuple[float, ...]
    real_lags: tuple[float, ...]


@dataclass(frozen=True)
class FlightPrediction:
    """The predictions of a model for one flight.

    Attributes:
        flight: its name.
        starts: instants of the starts (N) [s].
        errors: of each method.
        whole: of the closed loop over the whole flight.
    """

    flight: str
    starts: np.ndarray
    errors: tuple[HorizonErrors, ...]
    whole: WholeFlight


class Predictor:
    """A vehicle and a law, to predict flights.

    Args:
        vehicle: as known to the law, and as it flies.
        controller: the law.
        gains: of all its parameters, by name.
        period: between its updates [s].
        observer: dynamics of the error of the estimate.
        effects: of the past to include.
    """

    def __init__(
        self,
        vehicle: Vehicle,
        controller: Controller,
        gains: dict[str, float],
        period: float,
        observer: Observer | None = None,
        effects: Effects = ALL_EFFECTS,
    ) -> None:
        self.vehicle, self.controller, self.gains = vehicle, controller, gains
        self.observer, self.effects = observer or Observer(), effects
        self.model: CompiledModel = make_compiled_model(vehicle, controller, gains, period)
        self._functions = compiled_driven(controller)

    def predict(
        self, motion: LoggedMotion, horizon: float = ERROR_HORIZON_S, every: float = START_SPACING_S
    ) -> FlightPrediction | None:
        """Return predictions of a flight, None if it is in the air for less than the horizon.

        Args:
            motion: the flight.
            horizon: of predictions [s].
            every: period between starts [s].
        """
        first, last = motion.airborne
        ahead = round(horizon / motion.period)
        settled = first + round(MIN_PAST_S / motion.period)
        samples = np.arange(settled, last - ahead, max(1, round(every / motion.period)))
        samples = samples[motion.measured[samples[:, None] + np.arange(ahead + 1)].all(axis=1)]
        if len(samples) == 0:
            return None
        past = self._past(motion)
        found = [self._closed(motion, past, samples, ahead)]
        blended = motion._replace(q=blend(motion))
        for method, known, turned in (
            (FADING_RATES_METHOD, past, _fading_attitudes(motion, samples, ahead)),
            (GIVEN_ATTITUDE_METHOD, self._past(blended), _given_attitudes(blended, samples, ahead)),
        ):
            flown = _driven(motion, known, self.vehicle, samples, turned)
            found.append(_horizon_errors(motion, samples, method, *flown))
        found += [_constant_motion(motion, samples, ahead), _late_setpoint(motion, samples, ahead)]
        return FlightPrediction(
            motion.name,
            motion.time[samples],
            tuple(found),
            self._whole(motion, past, first, last),
        )

    def _past(self, motion: LoggedMotion) -> Past:
        listen = self._functions.listen
        return Past(motion, self.vehicle, self.controller, self.gains, self.model, listen)

    def _fly(self, past: Past, samples: np.ndarray, duration: float, keep: float) -> np.ndarray:
        """Return states (N, h, 13) of closed loops from samples on, at most `keep` [s] apart."""
        start, model = past.start(samples, self.effects), self.model
        return self._functions.fly(
            model,
            start,
            FlightCourses(
                past.references(samples, duration), start.voltages[:, None], start.pushes
            ),
            self.observer if self.effects.tilt and past.estimated else TRUE_OBSERVER,
            max(1, math.floor(keep / model.period + 1e-9)),
        )

    def _closed(
        self, motion: LoggedMotion, past: Past, samples: np.ndarray, ahead: int
    ) -> HorizonErrors:
        duration, period = ahead * motion.period, self.model.period
        states = self._fly(past, samples, duration + period, period)
        flown = period * np.arange(states.shape[1])
        times = motion.period * np.arange(ahead + 1)
        place = np.minimum((times / period).astype(int), len(flown) - 2)
        share = ((times - flown[place]) / period)[:, None]
        at = states[:, place] + share * (states[:, place + 1] - states[:, place])
        return _horizon_errors(
            motion, samples, CLOSED_LOOP_METHOD, at[:, :, 4:7], at[:, :, 10:13], at[:, :, 0:4]
        )

    def _whole(self, motion: LoggedMotion, past: Past, first: int, last: int) -> WholeFlight:
        start = np.array([first])
        keep = max(1, math.floor(motion.period / self.model.period + 1e-9))
        step = keep * self.model.period
        states = self._fly(past, start, motion.period * (last - first), step)[0]
        time = motion.period * first + step * np.arange(len(states))
        real = resampled(motion.p, motion.period, time)
        asked = resampled(motion.setpoint, motion.period, time)
        late = resampled(motion.setpoint, motion.period, time - SETPOINT_LAG_S)
        flown = states[:, 4:7]
        moves = [axis for axis in (0, 1) if np.ptp(asked[:, axis]) > MIN_SETPOINT_MOTION_M]
        return WholeFlight(
            motion.name,
            time,
            real,
            flown,
            _rmse(flown - real),
            _rmse(late - real),
            tuple(response_lag(time, asked[:, axis], flown[:, axis]) for axis in moves),
            tuple(response_lag(time, asked[:, axis], real[:, axis]) for axis in moves),
        )


def predict_flights(
    predictors: dict[str, Predictor],
    motions: Sequence[tuple[str, LoggedMotion]],
    horizon: float = ERROR_HORIZON_S,
    every: float = START_SPACING_S,
    progress: Callable[[float], None] | None = None,
) -> list[FlightPrediction]:
    """Return predictions of flights, each by the predictor for its name."""
    found = []
    for number, (name, motion) in enumerate(motions):
        prediction = predictors[name].predict(motion, horizon, every)
        if prediction:
            found.append(prediction)
        if progress:
            progress((number + 1) / len(motions))
    return found


def blend(motion: LoggedMotion) -> np.ndarray:
    """Return attitudes (m, 4) between the measured and the flight computer's ones, see
    `ATTITUDE_BLEND`.
    """
    attitude = rotation_matrices(motion.q)
    between = (attitude.inv() * rotation_matrices(motion.q_known)).as_rotvec()
    q = (attitude * Rotation.from_rotvec(ATTITUDE_BLEND * between)).as_quat()[:, [3, 0, 1, 2]]
    return np.asarray(q)


def _rmse(errors: np.ndarray) -> float:
    """Return the root mean square of the lengths of errors (k, 3)."""
    return float(np.sqrt(np.mean(np.sum(errors**2, axis=1))))


def _horizon_errors(
    motion: LoggedMotion,
    samples: np.ndarray,
    method: str,
    position: np.ndarray,
    velocity: np.ndarray,
    attitude: np.ndarray | None,
) -> HorizonErrors:
    """Return the errors of predictions (N, h, 3), (N, h, 3) and (N, h, 4)."""
    many, steps = position.shape[:2]
    places = samples[:, None] + np.arange(steps)
    angle = np.full((many, steps), np.nan)
    if attitude is not None:
        real = rotation_matrices(motion.q[places].reshape(-1, 4))
        turned = rotation_matrices(np.broadcast_to(attitude, (many, steps, 4)).reshape(-1, 4))
        angle = (real.inv() * turned).magnitude().reshape(many, steps)
    return HorizonErrors(
        method,
        motion.period * np.arange(steps),
        np.linalg.norm(position - motion.p[places], axis=2),
        np.linalg.norm(velocity - motion.v[places], axis=2),
        angle,
    )


def _constant_motion(motion: LoggedMotion, samples: np.ndarray, ahead: int) -> HorizonErrors:
    times = motion.period * np.arange(ahead + 1)[:, None]
    velocity = np.repeat(motion.v[samples][:, None], ahead + 1, axis=1)
    position = motion.p[samples][:, None] + times * velocity
    attitude = np.repeat(motion.q[samples][:, None], ahead + 1, axis=1)
    return _horizon_errors(motion, samples, CONSTANT_METHOD, position, velocity, attitude)


def _late_setpoint(motion: LoggedMotion, samples: np.ndarray, ahead: int) -> HorizonErrors:
    late = resampled(motion.setpoint, motion.period, motion.time - SETPOINT_LAG_S)
    places = samples[:, None] + np.arange(ahead + 1)
    position = motion.p[samples][:, None] + late[places] - late[samples][:, None]
    velocity = np.full_like(position, np.nan)  # it jumps
    return _horizon_errors(motion, samples, LATE_SETPOINT_METHOD, position, velocity, None)


def _given_attitudes(motion: LoggedMotion, samples: np.ndarray, ahead: int) -> np.ndarray:
    """Return the logged attitudes (N, h, 4)."""
    return motion.q[samples[:, None] + np.arange(ahead + 1)]


def _fading_attitudes(motion: LoggedMotion, samples: np.ndarray, ahead: int) -> np.ndarray:
    """Return attitudes (N, h, 4) from rates that decay from those at the start."""
    times = motion.period * np.arange(ahead + 1)
    angles = RATE_DECAY_S * (1.0 - np.exp(-times / RATE_DECAY_S))[:, None]
    turned = motion.w[samples][:, None] * angles
    start = rotation_matrices(np.repeat(motion.q[samples], ahead + 1, axis=0))
    q = (start * Rotation.from_rotvec(turned.reshape(-1, 3))).as_quat()[:, [3, 0, 1, 2]]
    return np.asarray(q.reshape(len(samples), ahead + 1, 4))


def _driven(
    motion: LoggedMotion, past: Past, vehicle: Vehicle, samples: np.ndarray, attitude: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return positions, velocities and attitudes for the logged commands and given attitudes.

    Only the translation is predicted, from thrust with rotor lag, rotor drag, and the earlier level
    force.
    """
    period = motion.period
    thrust = rotor_lagged(driven_thrust(motion, vehicle)[:, None], motion, vehicle)[:, 0]
    share, level = past.lift(samples, thrust)
    many, steps = attitude.shape[:2]
    turn = rotation_matrices(attitude.reshape(-1, 4)).as_matrix().reshape(many, steps, 3, 3)
    places = samples[:, None] + np.arange(steps)
    lift = share[:, None] * thrust[places] / vehicle.mass
    level = np.column_stack([level, np.zeros(many)]) / vehicle.mass
    rates = air_rates(vehicle)
    position, velocity = np.empty((many, steps, 3)), np.empty((many, steps, 3))
    p, v = motion.p[samples].copy(), motion.v[samples].copy()
    for step in range(steps):
        position[:, step], velocity[:, step] = p, v
        R = turn[:, step]
        if step + 1 < steps:
            R = 0.5 * (R + turn[:, step + 1])
        v_B = np.einsum("nji,nj->ni", R, v)
        force = level - rates * v_B
        force[:, 2] += lift[:, step]
        a = np.einsum("nij,nj->ni", R, force) - [0.0, 0.0, GRAVITY]
        p = p + period * (v + 0.5 * period * a)
        v = v + period * a
    return position, velocity, attitude
