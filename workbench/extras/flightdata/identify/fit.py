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

import numpy as np

from workbench.extras.flightdata.identify.flight_piece import Piece
from workbench.extras.flightdata.identify.model_rows import model_rows
from workbench.extras.flightdata.identify.quantities import IdentifiedQuantity
from workbench.extras.flightdata.identify.whitening import Whitening, whiten, whitening
from workbench.plant.vehicle import Vehicle

WHITENING_MEMORY_S = 0.3
"""Of the whitening filter [s]. A longer one fits the slow gusts of this very flight, and so takes
trims and yaw for better known than they are; what hangs together for longer, `ERROR_BLOCK_S`
counts."""
MAX_ORDER_SHARE = 0.1
"""Of the rows that it may have as its order."""
ERROR_BLOCK_S = 3.0
"""In which errors may hang together [s]."""
START_LAG_FACTORS = (0.3, 0.55, 1.0, 1.8, 3.2)
"""Factors on the described time constants from which the search may begin."""
START_SEARCH_SPAN_S = 15.0
"""So much of the flights tells from which [s]."""
START_QUANTITIES = ("thrust", "curve_0", "curve_1", "curve_2", "inertia_x", "inertia_y", "bias_z")
"""What is found for each of them before the search begins."""
FIT_THREADS = 2
MAX_FIT_ROUNDS = 40
"""Most searches take 5 to 8. Steps have a limit, so a thrust curve far from its start takes 25."""
TIME_GRID_SHARE = 0.03
"""Share of the model's step by which its times may be off, beside what the data show: a deviation
of lag and delays."""
WHITENING_ROUNDS = 4
"""Rounds after which the whitening filters stay as they are."""
MAX_FIT_HALVINGS = 6
"""Of a step that makes errors larger."""
COMPLETE_STEP_SHARE = 0.5
"""Share of a deviation that it may be off where no step makes errors smaller."""
CONVERGED_STEP_SHARE = 0.05
"""The search ends when no step is longer than this share of a deviation."""
FIT_CHANNELS = ("turn_x", "turn_y", "turn_z", "level_x", "level_y", "force")


def first_pieces(pieces: Sequence[Piece], seconds: float) -> list[Piece]:
    """Return the first pieces up to a time in all [s]; the last of them is cut."""
    found = []
    for piece in pieces:
        rows = min(len(piece.turn), round(seconds / piece.row))
        if rows * piece.row <= 10.0 * WHITENING_MEMORY_S:
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


@dataclass(frozen=True)
class Fit:
    """What was found.

    Attributes:
        names: of the k numbers.
        values: (k).
        covariance: (k, k).
        freedom: blocks less one, for Student's quantiles.
        innovations: (K, channels) white errors of prediction over their deviation.
        channels: that took part.
        complete: whether the search came to its end.
    """

    names: tuple[str, ...]
    values: np.ndarray
    covariance: np.ndarray
    freedom: int
    innovations: np.ndarray
    channels: tuple[str, ...]
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
        quantities: Sequence[IdentifiedQuantity],
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
        self._columns = [FIT_CHANNELS.index(name) for name in channels]
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
            stopped = longest < CONVERGED_STEP_SHARE or rounds == MAX_FIT_ROUNDS or self._stopped()
            if not stopped:
                rounds += 1
                self._tell(0.1 + 0.9 * rounds / (MAX_FIT_ROUNDS + 1.0))
                before = values
                values, rest = self._descended(values, step, rest, filters)
                stopped = values is before
            if stopped:
                complete = longest < COMPLETE_STEP_SHARE
                left = np.zeros_like(step) if complete else step
                return self._result(values, rest, slopes, filters, left)
            if rounds <= WHITENING_ROUNDS:
                filters = self._whitening(rest)

    def _descended(
        self, values: np.ndarray, step: np.ndarray, rest: list[np.ndarray], filters: Whitening
    ) -> tuple[np.ndarray, list[np.ndarray]]:
        """Return values after a step, halved until errors are no larger, and their differences."""
        before = self._cost(values, rest, filters)
        for _ in range(MAX_FIT_HALVINGS):
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
        """Return the start from which errors are least after one step, see `START_LAG_FACTORS`."""
        if "lag" not in self._names:
            return self._start
        place = self._names.index("lag")
        moved = [i for i, name in enumerate(self._names) if name in START_QUANTITIES]
        short = Fitter(
            self._vehicle,
            first_pieces(self._pieces, START_SEARCH_SPAN_S),
            self.quantities,
            self.channels,
            self._fixed,
            stopped=self._stopped,
        )
        found = []
        for number, factor in enumerate(START_LAG_FACTORS):
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
            self._tell(0.1 * (number + 1) / len(START_LAG_FACTORS))
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

        with ThreadPoolExecutor(FIT_THREADS) as pool:
            return list(pool.map(slope, range(len(values))))

    def _whitening(self, rest: list[np.ndarray]) -> Whitening:
        """Return the filters that whiten differences."""
        order = WHITENING_MEMORY_S / self._pieces[0].row
        return whitening(rest, round(min(order, MAX_ORDER_SHARE * sum(len(each) for each in rest))))

    def _biased(self, rest: np.ndarray, name: str) -> np.ndarray:
        """Return the slope of differences over a bias of the accelerometer."""
        slope = np.zeros_like(rest)
        channel = FIT_CHANNELS[3 + "xyz".index(name[-1])]
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
            size = max(1, round(ERROR_BLOCK_S / piece.row))
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
        left: np.ndarray,
    ) -> Fit:
        """Return what was found; `left` is the step that a search did not make (k)."""
        errors, rows, places = self._whitened(rest, slopes, filters)
        information, _ = self._information(values, errors, rows)
        covariance, count = self._jackknife(errors, rows, places, information)
        covariance += np.outer(left, left)
        off = TIME_GRID_SHARE * max(piece.period for piece in self._pieces)
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
            channels=self.channels,
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
