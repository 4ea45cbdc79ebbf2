"""The numbers of a vehicle from its flights, by the smallest errors of prediction, with intervals.

What a model predicts of each sample, given the commands and the motion until then, differs from
what was measured by

    e = A(z) (y - y_model),   y = change of the angular velocity, and specific force

where A(z) whitens: an autoregressive filter that is fitted to the differences themselves, anew in
each round (generalised least squares: Clarke, "Generalised least squares estimation of the
parameters of a dynamic model", IFAC 1967; Ljung, "System Identification", 1999, section 10.4). Both
sides go through the same filter. A drone flies in a closed loop, so commands hold the gyro's noise;
white errors of prediction are what keeps that from bending the result (Ljung, section 13.4).

The rest is Gauss and Newton's method with derivatives by differences, from the best of a grid of
lags (Eschmann, Albani and Loianno, "Data-Driven System Identification of Quadrotors Subject to
Motor Delays", arXiv:2404.07837, section IV). Deviations are those of the information matrix with
blocks of three seconds left out one by one (the sandwich of Huber and White, as a jackknife), so
that errors which are coloured, or larger in one manoeuvre than in another, count as they are.

The model is the source that flies: the rotors follow the commands of the log as `dynamics.rotors`
says. From their speeds, and the measured angular velocity and velocity, that and
`dynamics.air.drag` have force and moment, `dynamics.rigid_body` the accelerations, and
`estimation.imu` what the accelerometer shows.
"""

import math
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from scipy.linalg import solve_toeplitz
from scipy.signal import butter, correlate, lfilter, oaconvolve, sosfiltfilt

from workbench.common.compiled import compile_cached
from workbench.design.identify.flight import SHARE, Flight, held_on_grid, on_even_grid
from workbench.design.identify.quantities import Quantity, with_quantities
from workbench.design.rollout.crafts import body_records, rotor_records
from workbench.design.rollout.engine import OPTIONS
from workbench.dynamics.air.drag import drag_force
from workbench.dynamics.rigid_body import body_acceleration, cross
from workbench.dynamics.rotors import rotor_load, speed_slope, static_thrust, within
from workbench.estimation.filters import lowpass
from workbench.estimation.imu import measured
from workbench.plant.drag import AIR_DENSITY, drag_area
from workbench.plant.vehicle import Vehicle

SOURCES = ("design/identify/fit.py", "dynamics", "estimation")
FAR = 1e6
"""Above the ground, which has no effect there [m]."""
SHORTEST, LONGEST = 0.5e-3, 2.1e-3
"""Step of the model [s]; between, there are `STEPS` in a rotor's lag: with fewer of them the lag of
a fast rotor came out half a percent long, and the inertia about z four percent small."""
STEPS = 16
RATE = 250.0
"""Most rows a second; samples that come faster are averaged, of log and model alike."""
MEMORY = 0.3
"""Of the whitening filter [s]. A longer one fits the slow gusts of this very flight, and so takes
trims and yaw for better known than they are; what hangs together for longer, `BLOCK` counts."""
MOST_SHARE = 0.1
"""Of the rows that it may have as its order."""
SHORTEST_FILTER = 1e-3
"""Delay below which a gyro's filter is no more than a delay [s]."""
BLOCK = 3.0
"""In which errors may hang together [s]."""
SLOW = 3.0
"""Up to which velocity counts for drag [Hz]."""
LAGS = (0.3, 0.55, 1.0, 1.8, 3.2)
"""Factors on the described time constants from which the search may begin."""
BEGINNING = 15.0
"""So much of the flights tells from which [s]."""
STARTED = ("thrust", "curve_0", "curve_1", "curve_2", "inertia_x", "inertia_y", "bias_z")
"""What is found for each of them before the search begins."""
WORKERS = 2
ROUNDS = 12
GRID = 0.03
"""Share of the model's step by which its times may be off, beside what the data show: a deviation
of lag and delays."""
REFITS = 4
"""Rounds after which the whitening filters stay as they are."""
HALVINGS = 6
"""Of a step that makes errors larger."""
AT_LAST = 0.5
"""Share of a deviation that it may be off where no step makes errors smaller."""
NEAR = 0.05
"""The search ends when no step is longer than this share of a deviation."""
CHANNELS = ("turn_x", "turn_y", "turn_z", "level_x", "level_y", "force")


def _follow(commands: Any, rotors: Any, period: float, speeds: Any, slopes: Any) -> None:
    """Write speeds in the middle of every step, and their mean slopes, that follow commands.

    A slope jumps with the command: its mean is what spins the body up. A step is one of the
    classical Runge-Kutta method, and its middle is on the cubic through its ends.

    Args:
        commands: (N, n) held from each sample to the next [rad/s].
        rotors: (n) see `crafts.ROTOR`.
        period: between samples [s].
        speeds: (N, n) places [rad/s]; the first row is where they begin.
        slopes: (N, n) places [rad/s²].
    """
    for i in range(len(rotors)):
        rotor, speed = rotors[i], speeds[0, i]
        for k in range(len(commands)):
            command = within(commands[k, i], rotor)
            first = speed_slope(rotor, command, speed)
            second = speed_slope(rotor, command, speed + 0.5 * period * first)
            third = speed_slope(rotor, command, speed + 0.5 * period * second)
            fourth = speed_slope(rotor, command, speed + period * third)
            slopes[k, i] = (first + 2.0 * second + 2.0 * third + fourth) / 6.0
            end = speed + period * slopes[k, i]
            last = speed_slope(rotor, command, end)
            speeds[k, i] = 0.5 * (speed + end) + 0.125 * period * (first - last)
            speed = end


def _answers(
    speeds: Any, slopes: Any, gyro: Any, velocity: Any, half_drag: float, bodies: Any, rotors: Any,
    p_BI: Any, alpha: Any, force: Any,
) -> None:  # fmt: skip
    """Write angular accelerations (N, 3) [rad/s²] and specific forces at p_BI (N, 3) [m/s²].

    Args:
        speeds: (N, n) of the rotors [rad/s].
        slopes: (N, n) of their speeds [rad/s²].
        gyro: (N, 3) angular velocity in B [rad/s].
        velocity: (N, 3) in still air, in B [m/s].
        half_drag: see `drag_force`.
        bodies: (1) see `crafts.BODY`.
        rotors: (n) see `crafts.ROTOR`.
        p_BI: of the accelerometer, in B (3) [m].
        alpha: places.
        force: places.
    """
    level = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)
    body, state, acceleration = bodies[0], np.zeros(13), np.zeros(6)
    state[0] = 1.0
    c_x, c_y, c_z = body.p_BoBcm_B
    for k in range(len(speeds)):
        w_x, w_y, w_z = gyro[k]
        v_x, v_y, v_z = velocity[k]
        w_B, v_B = (w_x, w_y, w_z), (v_x, v_y, v_z)
        s_x, s_y, s_z = cross(w_B, (c_x, c_y, c_z))
        f_x, f_y, f_z = drag_force(half_drag, (v_x + s_x, v_y + s_y, v_z + s_z))
        m_x, m_y, m_z = cross((c_x, c_y, c_z), (f_x, f_y, f_z))
        for i in range(len(rotors)):
            rotor, speed, slope = rotors[i], speeds[k, i], slopes[k, i]
            static = static_thrust(rotor, 1.0, speed)
            load = rotor_load(rotor, speed, slope, 1.0, static, w_B, v_B, level, FAR)
            (l_x, l_y, l_z), (t_x, t_y, t_z), momentum = load
            g_x, g_y, g_z = cross(w_B, momentum)
            f_x, f_y, f_z = f_x + l_x, f_y + l_y, f_z + l_z
            m_x, m_y, m_z = m_x + t_x - g_x, m_y + t_y - g_y, m_z + t_z - g_z
        six = body_acceleration(
            level,
            w_B,
            (f_x, f_y, f_z),
            (m_x, m_y, m_z),
            body.mass,
            body.inertia,
            body.inverse,
            (c_x, c_y, c_z),
        )
        for i in range(3):
            state[7 + i] = gyro[k, i]
            acceleration[i] = six[i]
            acceleration[3 + i] = six[3 + i]
        shown = measured(state, acceleration, p_BI)
        for i in range(3):
            alpha[k, i] = six[i]
            force[k, i] = shown[3 + i]


compiled_follow = compile_cached(_follow, SOURCES, "the rotors of a log", **OPTIONS)
compiled_answers = compile_cached(_answers, SOURCES, "the motion of a log", **OPTIONS)


def shifted(values: np.ndarray, late: float) -> np.ndarray:
    """Return samples (N, ...) as they were so many periods before, between samples on lines."""
    whole = math.floor(late)
    share = late - whole
    rows = np.arange(len(values))
    first = values[np.clip(rows - whole, 0, len(values) - 1)]
    second = values[np.clip(rows - whole - 1, 0, len(values) - 1)]
    return (1.0 - share) * first + share * second


@dataclass(frozen=True)
class Piece:
    """A run of samples as the model takes it, on its grid.

    Attributes:
        period: of the grid [s].
        early: how much before the mean time of measured samples the grid's lie [s].
        every: how many of its samples lie between those of the log.
        block: how many samples of the log make a row.
        force_delay: of the accelerometer's filters [s].
        commands: (M, n) on the grid; speeds [rad/s] or shares.
        gyro: (M, 3); so velocity.
        velocity: zeros where it is not known.
        voltage: (M) over its mean, ones where it is not known.
        turn: (K, 3) measured changes of the angular velocity over time [rad/s²].
        force: (K, 3) measured [m/s²].
    """

    period: float
    early: float
    every: int
    block: int
    kind: str
    force_delay: float
    commands: np.ndarray
    gyro: np.ndarray
    velocity: np.ndarray
    voltage: np.ndarray
    turn: np.ndarray
    force: np.ndarray

    @property
    def row(self) -> float:
        """Between rows [s]."""
        return self.period * self.every * self.block


def make_piece(flight: Flight, vehicle: Vehicle, mean_voltage: float | None = None) -> Piece:
    """Return a run of even samples as the model of a vehicle takes it.

    Args:
        flight: the run.
        vehicle: as it is described.
        mean_voltage: which counts as 1 [V]; without it the run's own.
    """
    own = 1.0 if flight.voltage is None else float(np.mean(flight.voltage))
    longest = min(LONGEST, max(SHORTEST, vehicle.rotor_lag / STEPS))
    early = -0.5 * flight.period
    flight = thinned(flight, longest)
    early += 0.5 * flight.period
    every = max(1, math.ceil(flight.period / longest - 1e-6))
    block = max(1, math.ceil(flight.rate / RATE - 1e-6))
    grid = np.interp(
        np.arange((len(flight.time) - 1) * every + 1) / every,
        np.arange(len(flight.time)),
        flight.time,
    )
    velocity, voltage = flight.velocity, flight.voltage
    gyro = blocks(flight.gyro, block)
    return Piece(
        period=flight.period / every,
        early=early,
        every=every,
        block=block,
        kind=flight.kind,
        force_delay=lowpass_delay(flight.force_lowpass),
        commands=np.ascontiguousarray(held_on_grid(flight.time, flight.commands, grid)),
        gyro=on_even_grid(flight.time, flight.gyro, grid),
        velocity=np.zeros((len(grid), 3))
        if velocity is None
        else on_even_grid(flight.time, smoothed(velocity, flight.period), grid),
        voltage=np.ones(len(grid))
        if voltage is None
        else on_even_grid(flight.time, voltage, grid) / (mean_voltage or own),
        turn=np.diff(gyro, axis=0) / (flight.period * block),
        force=blocks(flight.force, block)[1:],
    )


def filtered(values: np.ndarray, delay: float, period: float) -> np.ndarray:
    """Return angular velocities or specific forces (N, 3) behind a sensor's filters.

    They are taken for one low-pass of second order with their delay at low frequencies [s], which
    is what most flight controllers have; where that is too short for one, for a delay.
    """
    if delay < SHORTEST_FILTER:
        return shifted(values, delay / period)
    # of the trapezoidal rule without its cut-off prewarped, which keeps the delay
    cutoff = math.atan(period / (math.sqrt(2.0) * delay)) / (math.pi * period)
    a_11, a_12, a_21, a_22, b_1, b_2, c_1, c_2, d = lowpass(cutoff, 2.0, period)
    # the transfer function of the section, for a filter that runs in compiled code
    numerator = [
        d,
        c_1 * b_1 + c_2 * b_2 - d * (a_11 + a_22),
        c_1 * (a_12 * b_2 - a_22 * b_1)
        + c_2 * (a_21 * b_1 - a_11 * b_2)
        + d * (a_11 * a_22 - a_12 * a_21),
    ]
    denominator = [1.0, -(a_11 + a_22), a_11 * a_22 - a_12 * a_21]
    first = values[:1]
    return np.asarray(first + lfilter(numerator, denominator, values - first, axis=0))


def beginnings(pieces: Sequence[Piece], seconds: float) -> list[Piece]:
    """Return the first pieces up to a time in all [s]; the last of them is cut."""
    found = []
    for piece in pieces:
        rows = min(len(piece.turn), round(seconds / piece.row))
        if rows * piece.row <= 10.0 * MEMORY:
            break
        many = (rows + 1) * piece.block * piece.every
        found.append(
            replace(
                piece,
                commands=piece.commands[:many],
                gyro=piece.gyro[:many],
                velocity=piece.velocity[:many],
                voltage=piece.voltage[:many],
                turn=piece.turn[:rows],
                force=piece.force[:rows],
            )
        )
        seconds -= rows * piece.row
    return found


def lowpass_delay(cutoff: float) -> float:
    """Return the delay of a low-pass of second order [s] with a cut-off [Hz], 0 for none."""
    return math.sqrt(2.0) / (2.0 * math.pi * cutoff) if cutoff else 0.0


def blocks(values: np.ndarray, size: int) -> np.ndarray:
    """Return the means of samples (N, k) in blocks of a size."""
    whole = len(values) // size
    return values[: whole * size].reshape(whole, size, -1).mean(axis=1)


def smoothed(velocity: np.ndarray, period: float) -> np.ndarray:
    """Return velocities (N, 3) without what is faster than drag can show, and not late.

    Noise of what drag goes with would make drag look smaller than it is.
    """
    share = 2.0 * SLOW * period
    if share > 0.9 or len(velocity) < 30:
        return velocity
    return np.asarray(sosfiltfilt(butter(2, share, output="sos"), velocity, axis=0))


def thinned(flight: Flight, longest: float) -> Flight:
    """Return a flight with means of neighbours where its samples come faster than is needed [s]."""
    size = max(1, math.floor(longest / flight.period + 1e-6))
    if size == 1:
        return flight
    return replace(
        flight,
        time=blocks(flight.time[:, None], size)[:, 0],
        commands=blocks(flight.commands, size),
        gyro=blocks(flight.gyro, size),
        force=blocks(flight.force, size),
        velocity=None if flight.velocity is None else blocks(flight.velocity, size),
        voltage=None if flight.voltage is None else blocks(flight.voltage[:, None], size)[:, 0],
        good=np.empty(0, dtype=bool),
    )


def model_rows(vehicle: Vehicle, values: dict[str, float], piece: Piece) -> np.ndarray:
    """Return what a vehicle's model says of a piece (K, 6), see `CHANNELS`.

    Where `lag_turn` is tried, rotors turn the body with another lag than they lift it with.
    """
    apart = values.get("lag_turn", 0.0)
    rows = _model_rows(vehicle, values, piece)
    if apart:
        other = values | {"lag": values["lag"] + apart}
        rows[:, :3] = _model_rows(vehicle, other, piece)[:, :3]
    return rows


def _model_rows(vehicle: Vehicle, values: dict[str, float], piece: Piece) -> np.ndarray:
    """Return the rows of one lag.

    Args:
        vehicle: as it is described.
        values: what is tried, see `quantities.looked_for`.
        piece: of a flight.
    """
    tried = with_quantities(vehicle, values)
    rotors = rotor_records(tried.rotors)
    most = np.array([rotor.max_rot_velocity for rotor in tried.rotors])
    if piece.kind == SHARE:
        supply = piece.voltage ** values.get("voltage", 0.0)
        commands = piece.commands * supply[:, None] * most
    else:
        commands = piece.commands
    speeds, slopes = np.empty((2, *commands.shape))
    speeds[0] = commands[0]
    compiled_follow(commands, rotors, piece.period, speeds, slopes)
    late = (values.get("delay", 0.0) - piece.early) / piece.period
    speeds, slopes = shifted(speeds, late), shifted(slopes, late)
    if piece.kind == SHARE:
        share = speeds / most
        curve = [values[f"curve_{power}"] for power in range(3)]
        thrust = curve[0] + curve[1] * share + curve[2] * share**2
        slope = curve[1] + 2.0 * curve[2] * share
        root = np.sqrt(np.maximum(thrust, 1e-4))
        slopes = 0.5 * slope / root * slopes
        speeds = root * most
    alpha, force = np.empty((2, len(speeds), 3))
    compiled_answers(
        speeds,
        slopes,
        piece.gyro,
        piece.velocity,
        0.5 * AIR_DENSITY * drag_area(vehicle.mass),
        body_records([tried]),
        rotors,
        np.zeros(3),
        alpha,
        force,
    )
    # these are means of steps; an IMU shows what is at their edges
    turned = np.zeros_like(alpha)
    turned[1:] = piece.period * np.cumsum(alpha[:-1], axis=0)
    force[1:] = 0.5 * (force[1:] + force[:-1])
    turned = filtered(turned, values.get("gyro_delay", 0.0), piece.period)[:: piece.every]
    turn = np.diff(blocks(turned, piece.block), axis=0) / piece.row
    if piece.force_delay:
        force = filtered(force, piece.force_delay, piece.period)
    bias = [values.get(f"bias_{axis}", 0.0) for axis in "xyz"]
    return np.hstack([turn, blocks(force[:: piece.every], piece.block)[1:] + bias])


class Whitening(NamedTuple):
    """Autoregressive filters (c, order + 1), and the deviations of what they leave (c)."""

    coefficients: np.ndarray
    deviations: np.ndarray

    @property
    def cost(self) -> float:
        """Logarithm of the likelihood that is lost by a row."""
        return float(np.log(self.deviations).sum())


@dataclass(frozen=True)
class Fit:
    """What was found.

    Attributes:
        names: of the k numbers.
        values: (k).
        covariance: (k, k).
        freedom: blocks less one, for Student's quantiles.
        innovations: (K, channels) white errors of prediction over their deviation.
        deviations: (channels) of the errors of prediction.
        channels: that took part.
        rounds: that were made.
        complete: whether the search came to its end.
    """

    names: tuple[str, ...]
    values: np.ndarray
    covariance: np.ndarray
    freedom: int
    innovations: np.ndarray
    deviations: np.ndarray
    channels: tuple[str, ...]
    rounds: int
    complete: bool

    def value(self, name: str) -> float:
        """Return a number."""
        return float(self.values[self.names.index(name)])

    def deviation(self, name: str) -> float:
        """Return its standard deviation."""
        place = self.names.index(name)
        return float(np.sqrt(self.covariance[place, place]))

    @property
    def named(self) -> dict[str, float]:
        """All numbers by name."""
        return dict(zip(self.names, map(float, self.values), strict=True))


class Fitter:
    """Least errors of prediction over some pieces of flights.

    Attributes:
        quantities: that are looked for.
        channels: that are heard.
    """

    def __init__(
        self,
        vehicle: Vehicle,
        pieces: Sequence[Piece],
        quantities: Sequence[Quantity],
        channels: Sequence[str],
        fixed: dict[str, float] | None = None,
        tell: Callable[[float], None] = lambda share: None,
        stopped: Callable[[], bool] = lambda: False,
    ) -> None:
        self.quantities = tuple(quantities)
        self.channels = tuple(channels)
        self._vehicle = vehicle
        self._pieces = pieces
        self._fixed = fixed or {}
        self._columns = [CHANNELS.index(name) for name in channels]
        self._measured = [np.hstack([p.turn, p.force])[:, self._columns] for p in pieces]
        self._tell = tell
        self._stopped = stopped
        self._names = tuple(each.name for each in quantities)
        self._steps = np.array([each.step for each in quantities])
        self._priors = np.array([each.prior for each in quantities])
        self._start = np.array([each.start for each in quantities])

    def differences(self, values: np.ndarray) -> list[np.ndarray]:
        """Return measured less modelled rows (K, channels) of each piece."""
        named = self._fixed | dict(zip(self._names, values, strict=True))
        return [
            each - model_rows(self._vehicle, named, piece)[:, self._columns]
            for each, piece in zip(self._measured, self._pieces, strict=True)
        ]

    def fit(self, start: np.ndarray | None = None) -> Fit:
        """Search, from the best of some lags, or from a start (k)."""
        values = self._best_lag() if start is None else start
        rounds = 0
        rest = self.differences(values)
        filters = self._whitening(rest)
        while True:
            slopes = self._slopes(values, rest)
            step, inverse = self._step(values, rest, slopes, filters)
            longest = float(np.max(np.abs(step) / np.sqrt(np.diag(inverse))))
            stopped = longest < NEAR or rounds == ROUNDS or self._stopped()
            if not stopped:
                rounds += 1
                self._tell(0.1 + 0.9 * rounds / (ROUNDS + 1.0))
                before = values
                values, rest = self._descended(values, step, rest, filters)
                stopped = values is before
            if stopped:
                complete = longest < AT_LAST
                left = np.zeros_like(step) if complete else step
                return self._result(values, rest, slopes, filters, rounds, left)
            if rounds <= REFITS:
                filters = self._whitening(rest)

    def _descended(
        self, values: np.ndarray, step: np.ndarray, rest: list[np.ndarray], filters: Whitening
    ) -> tuple[np.ndarray, list[np.ndarray]]:
        """Return values after a step, halved until errors are no larger, and their differences."""
        before = self._cost(values, rest, filters)
        for _ in range(HALVINGS):
            tried = self.differences(values + step)
            if self._cost(values + step, tried, filters) <= before:
                return values + step, tried
            step = 0.5 * step
        return values, rest

    def _cost(self, values: np.ndarray, rest: list[np.ndarray], filters: Whitening) -> float:
        """Return half the sum of squared errors of prediction, and of what priors say."""
        known = np.sum(((values - self._start) / self._priors) ** 2)
        return 0.5 * float(known + sum(np.sum(whiten(each, filters) ** 2) for each in rest))

    def _best_lag(self) -> np.ndarray:
        """Return the start from which errors are least after one step, see `LAGS`."""
        if "lag" not in self._names:
            return self._start
        place = self._names.index("lag")
        moved = [i for i, name in enumerate(self._names) if name in STARTED]
        short = Fitter(
            self._vehicle,
            beginnings(self._pieces, BEGINNING),
            self.quantities,
            self.channels,
            self._fixed,
            stopped=self._stopped,
        )
        found = []
        for number, factor in enumerate(LAGS):
            if self._stopped():
                break
            start = self._start.copy()
            start[place] = math.log(factor)
            rest = short.differences(start)
            slopes = short._slopes(start, rest, moved)
            step, _ = short._step(start, rest, slopes, short._whitening(rest))
            start = start + step
            cost = short._whitening(short.differences(start)).cost
            found.append((cost, tuple(start)))
            self._tell(0.1 * (number + 1) / len(LAGS))
        return np.array(min(found)[1]) if found else self._start

    def _slopes(
        self, values: np.ndarray, rest: list[np.ndarray], moved: Sequence[int] | None = None
    ) -> list[list[np.ndarray]]:
        """Return the slopes of differences by quantity; 0 for those that are not moved."""

        def slope(place: int) -> list[np.ndarray]:
            if moved is not None and place not in moved:
                return [np.zeros_like(each) for each in rest]
            if self._names[place].startswith("bias_"):
                return [self._biased(each, self._names[place]) for each in rest]
            beside = values.copy()
            beside[place] += self._steps[place]
            return [
                (b - a) / self._steps[place]
                for a, b in zip(rest, self.differences(beside), strict=True)
            ]

        with ThreadPoolExecutor(WORKERS) as pool:
            return list(pool.map(slope, range(len(values))))

    def _whitening(self, rest: list[np.ndarray]) -> Whitening:
        """Return the filters that whiten differences."""
        order = MEMORY / self._pieces[0].row
        return whitening(rest, round(min(order, MOST_SHARE * sum(len(each) for each in rest))))

    def _biased(self, rest: np.ndarray, name: str) -> np.ndarray:
        """Return the slope of differences over a bias of the accelerometer."""
        slope = np.zeros_like(rest)
        channel = CHANNELS[3 + "xyz".index(name[-1])]
        if channel in self.channels:
            slope[:, self.channels.index(channel)] = -1.0
        return slope

    def _whitened(
        self,
        rest: list[np.ndarray],
        slopes: list[list[np.ndarray]],
        filters: Whitening,
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return errors (K, c), slopes (K, c, k), and the number of each row's block (K)."""
        errors, rows, places = [], [], []
        first = 0
        for number, (each, piece) in enumerate(zip(rest, self._pieces, strict=True)):
            errors.append(whiten(each, filters))
            rows.append(np.stack([whiten(s[number], filters) for s in slopes], axis=-1))
            size = max(1, round(BLOCK / piece.row))
            block = np.arange(len(errors[-1])) // size
            if len(block) and len(errors[-1]) % size < size // 2:
                block = np.minimum(block, max(0, len(errors[-1]) // size - 1))
            places.append(first + block)
            first = places[-1][-1] + 1
        return np.concatenate(errors), np.concatenate(rows), np.concatenate(places)

    def _step(
        self,
        values: np.ndarray,
        rest: list[np.ndarray],
        slopes: list[list[np.ndarray]],
        filters: Whitening,
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return a step of Gauss and Newton's (k), and the inverse of the information (k, k)."""
        errors, rows, _ = self._whitened(rest, slopes, filters)
        information, pull = self._information(values, errors, rows)
        inverse = np.linalg.pinv(information, hermitian=True)
        step = inverse @ pull
        longest = np.max(np.abs(step) / (60.0 * self._steps))
        return step / max(1.0, longest), inverse

    def _information(
        self, values: np.ndarray, errors: np.ndarray, rows: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return the information matrix (k, k) and the pull of the errors and priors (k)."""
        information = np.einsum("nci,ncj->ij", rows, rows)
        pull = -np.einsum("nci,nc->i", rows, errors)
        known = 1.0 / self._priors**2
        return information + np.diag(known), pull - known * (values - self._start)

    def _result(
        self,
        values: np.ndarray,
        rest: list[np.ndarray],
        slopes: list[list[np.ndarray]],
        filters: Whitening,
        rounds: int,
        left: np.ndarray,
    ) -> Fit:
        """Return what was found; `left` is the step that a search did not make (k)."""
        errors, rows, places = self._whitened(rest, slopes, filters)
        information, _ = self._information(values, errors, rows)
        covariance, count = self._jackknife(errors, rows, places, information)
        covariance += np.outer(left, left)
        off = GRID * max(piece.period for piece in self._pieces)
        for place, name in enumerate(self._names):
            if name in ("delay", "gyro_delay"):
                covariance[place, place] += off**2
            elif name == "lag":
                lag = math.exp(values[place]) * self._vehicle.rotor_lag
                covariance[place, place] += (off / lag) ** 2
        return Fit(
            names=self._names,
            values=values,
            covariance=covariance,
            freedom=max(1, count - 1),
            innovations=errors,
            deviations=filters.deviations,
            channels=self.channels,
            rounds=rounds,
            complete=not left.any(),
        )

    def _jackknife(
        self, errors: np.ndarray, rows: np.ndarray, places: np.ndarray, information: np.ndarray
    ) -> tuple[np.ndarray, int]:
        """Return the covariance (k, k) that leaving out one block at a time shows, and how many.

        What is left out weighs with its own information (CR3 of Bell and McCaffrey, "Bias
        reduction in standard errors for linear regression with multi-stage samples", 2002).
        """
        count = int(places[-1]) + 1
        spread = np.diag(1.0 / self._priors**2)
        inverse = np.linalg.pinv(information, hermitian=True)
        for number in range(count):
            inside = places == number
            own = np.einsum("nci,ncj->ij", rows[inside], rows[inside])
            pull = np.einsum("nci,nc->i", rows[inside], errors[inside])
            without = np.eye(len(pull)) - own @ inverse
            pull = np.linalg.lstsq(without, pull, rcond=1e-6)[0]
            spread += np.outer(pull, pull) * (count - 1) / count
        return inverse @ spread @ inverse, count


def whitening(rest: list[np.ndarray], order: int) -> Whitening:
    """Return the filters, by Yule and Walker's equations over all pieces.

    Args:
        rest: rows (K, c) of each piece.
        order: of the filters.
    """
    filters, deviations = [], []
    many = sum(len(each) for each in rest)
    for channel in range(rest[0].shape[1]):
        # an offset is the model's to explain: a filter that took it in would take it out
        mean = sum(float(each[:, channel].sum()) for each in rest) / many
        lags = np.zeros(order + 1)
        for each in rest:
            x = each[:, channel] - mean
            lags += correlate(x, x, "full", "fft")[len(x) - 1 : len(x) + order]
        lags[0] = lags[0] * (1.0 + 1e-9) + 1e-30
        made = solve_toeplitz(lags[:-1], lags[1:])
        filters.append(np.concatenate(([1.0], -made)))
        deviations.append(math.sqrt(max(lags[0] - made @ lags[1:], 1e-30) / many))
    return Whitening(np.array(filters), np.array(deviations))


def whiten(rows: np.ndarray, filters: Whitening) -> np.ndarray:
    """Return rows (K, c) through the filters, over their deviations, without those that begin."""
    order = filters.coefficients.shape[1] - 1
    through = oaconvolve(rows, filters.coefficients.T, mode="full", axes=0)
    return through[order : len(rows)] / filters.deviations
