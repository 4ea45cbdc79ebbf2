"""The contents of a logged flight: clock offsets, use of motors, and what can be identified."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from workbench.common.flight import Flight
from workbench.common.series import Span
from workbench.logs.logged_loop import LOGGED_LOOPS
from workbench.logs.logged_signal import (
    ACCELEROMETER_SIGNALS,
    GYRO_SIGNALS,
    MOTOR_COMMAND_PREFIX,
    ROTOR_SPEED_PREFIX,
    SETPOINT_SIGNALS,
    SPEED_COMMAND_PREFIX,
    component_names,
)

MAX_CLOCK_OFFSET_S = 0.2
"""Limit of the offset between two clocks [s]."""
MIN_OFFSET_CORRELATION = 0.6
"""Smallest correlation for an offset between two streams to be reported."""
MIN_TURNING_SHARE = 0.1
"""Share of the full command above which a motor turns."""
MOTOR_START_MARGIN_S = 2.0
"""Time after motors start, and before they stop, in which the drone may be on the ground [s]."""
SATURATED_SHARE = 0.995
"""Share of the full command from which on a motor is saturated."""
MIN_IDENTIFY_RATE_HZ = 180.0
"""Rate of gyro and commands needed for rotor lag and inertia [Hz], as in `identify`."""
_OFFSET_STEP_S = 0.005
"""Step of the search for an offset [s]."""
_MAX_OFFSET_GAP_S = 0.05


@dataclass(frozen=True)
class ClockOffset:
    """The time offset between two streams of the same motion.

    Attributes:
        earlier: name of one stream.
        later: name of the other stream.
        offset: delay of the second behind the first; negative if it is ahead [s].
        correlation: of both streams at that offset.
    """

    earlier: str
    later: str
    offset: float
    correlation: float


@dataclass(frozen=True)
class IdentifiableQuantity:
    """A quantity, and whether it can be identified from a log.

    Attributes:
        what: the quantity.
        can: whether the log has the necessary signals.
        why: the signals that it has or lacks.
    """

    what: str
    can: bool
    why: str


@dataclass(frozen=True)
class FlightContents:
    """The contents of a logged flight.

    Attributes:
        turning: time in which a motor turns [s]; NaN if the log has neither commands nor speeds.
        saturated: share of that time with a saturated motor; NaN if the log has only speeds, as the
            largest speed is unknown.
        known_until: time after which no on-board signal was measured [s].
        offsets: between streams.
        findable: what can be identified.
        loops: those with a measurable step response, see `logged_loop.LOGGED_LOOPS`.
    """

    turning: float
    saturated: float
    known_until: float
    offsets: tuple[ClockOffset, ...]
    findable: tuple[IdentifiableQuantity, ...]
    loops: tuple[str, ...]


def contents_of_flight(flight: Flight) -> FlightContents:
    """Return the contents of a logged flight."""
    turning, saturated = _motor_times(flight)
    # Motion capture may continue after the radio link has ended.
    outside = ("position_data.", "velocity_data.", "attitude.")
    ends = [
        float(signal.time[-1])
        for name, signal in flight.signals.items()
        if len(signal.time) and not name.startswith(outside)
    ]
    loops = tuple(
        name
        for name, loop in LOGGED_LOOPS.items()
        if any(each in flight for each in loop.setpoints)
        and any(each in flight for each in loop.responses)
    )
    return FlightContents(
        turning,
        saturated,
        max(ends, default=flight.end),
        tuple(_offsets(flight)),
        tuple(_identifiable(flight, turning)),
        loops,
    )


def _is_turning(name: str, values: np.ndarray) -> np.ndarray:
    """Return when a motor turns, from commands or speeds; the largest speed counts as full."""
    full = 1.0 if name.startswith(MOTOR_COMMAND_PREFIX) else float(np.nanmax(values, initial=0.0))
    return np.asarray(values > MIN_TURNING_SHARE * full)


def _motor_times(flight: Flight) -> tuple[float, float]:
    """Return the time in which a motor turns [s], and the share of it with one at its limit."""
    names = flight.motors(MOTOR_COMMAND_PREFIX, SPEED_COMMAND_PREFIX, ROTOR_SPEED_PREFIX)
    if not names:
        return np.nan, np.nan
    time = flight[names[0]].time
    values = np.column_stack([flight[name].at(time, _MAX_OFFSET_GAP_S)[0] for name in names])
    largest = np.nanmax(np.where(np.isfinite(values), values, 0.0), axis=1)
    steps = np.diff(time, append=time[-1])
    steps = np.minimum(steps, 5.0 * float(np.median(steps)))
    total = float(steps[_is_turning(names[0], largest)].sum())
    if not names[0].startswith(MOTOR_COMMAND_PREFIX):
        return total, np.nan
    return total, float(steps[largest >= SATURATED_SHARE].sum()) / total if total else 0.0


def _offsets(flight: Flight) -> list[ClockOffset]:
    """Return the offsets between the streams of the same motion."""
    pairs = (
        (
            "body rate of motion capture",
            component_names("attitude.w_"),
            "gyro",
            GYRO_SIGNALS,
        ),
        ("gyro", GYRO_SIGNALS, "estimated rate", component_names("estimate.w_")),
        (
            "position",
            component_names("position_data."),
            "estimated position",
            component_names("estimate."),
        ),
        (
            "velocity",
            component_names("velocity_data.v_"),
            "estimated velocity",
            component_names("estimate.v_"),
        ),
        (
            "attitude of motion capture",
            component_names("position_data.", ("roll", "pitch")),
            "estimated attitude",
            component_names("estimate.", ("roll", "pitch")),
        ),
    )
    found = []
    for earlier, first, later, second in pairs:
        if flight.has([*first, *second]):
            made = clock_offset(flight, first, second)
            if made is not None and made[1] >= MIN_OFFSET_CORRELATION:
                found.append(ClockOffset(earlier, later, *made))
    turned = _attitude_rate(flight)
    if turned is not None and turned[1] >= MIN_OFFSET_CORRELATION:
        found.append(ClockOffset("gyro", "rate of the estimated attitude", *turned))
    return found


def _attitude_rate(flight: Flight) -> tuple[float, float] | None:
    """Return the delay of the estimated attitude's rate behind the gyro [s], and correlation."""
    turn = component_names("estimate.q_", "wxyz")
    span = _common_span(flight, [*GYRO_SIGNALS, *turn])
    if span is None:
        return None
    grid = flight.resample([*GYRO_SIGNALS, *turn], _OFFSET_STEP_S, _MAX_OFFSET_GAP_S, span)
    q = grid.values[:, 3:]
    # w = 2 q* dq/dt, in the body's axes.
    rate = np.gradient(q, _OFFSET_STEP_S, axis=0)
    w = 2.0 * (q[:, :1] * rate[:, 1:] - rate[:, :1] * q[:, 1:] - np.cross(q[:, 1:], rate[:, 1:]))
    return _best_offset(grid.values[:, :3], w)


def clock_offset(
    flight: Flight, first: Sequence[str], second: Sequence[str]
) -> tuple[float, float] | None:
    """Return the delay of some signals behind others [s], and their correlation at it.

    Args:
        flight: the log.
        first: signals.
        second: as many signals of the same quantities.
    """
    span = _common_span(flight, [*first, *second])
    if span is None:
        return None
    grid = flight.resample([*first, *second], _OFFSET_STEP_S, _MAX_OFFSET_GAP_S, span)
    return _best_offset(grid.values[:, : len(first)], grid.values[:, len(first) :])


def _best_offset(first: np.ndarray, second: np.ndarray) -> tuple[float, float] | None:
    """Return the offset of samples (n, k) behind others [s], and the correlation there.

    It has the largest correlation over all columns together, of samples known in both, with
    parabolic interpolation between steps of the grid.
    """
    most = round(MAX_CLOCK_OFFSET_S / _OFFSET_STEP_S)
    both: np.ndarray = np.all(np.isfinite(first) & np.isfinite(second), axis=1)
    if both.sum() < 8 * most:
        return None
    known = np.broadcast_to(both[:, None], first.shape).astype(float)
    a, b = (
        np.where(both[:, None], values - values[both].mean(axis=0), 0.0)
        for values in (first, second)
    )
    size = 2 * len(a)

    def at_lags(x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Return the sums of x(t) y(t + lag) for all lags, by their Fourier transforms."""
        product = np.conj(np.fft.rfft(x, size, axis=0)) * np.fft.rfft(y, size, axis=0)
        return np.asarray(np.fft.irfft(product, size, axis=0).sum(axis=1)[lags])

    lags = np.arange(-most, most + 1)
    power = np.maximum(at_lags(a * a, known) * at_lags(known, b * b), 0.0)
    shared = at_lags(a, b)
    found = np.divide(shared, np.sqrt(power), out=np.zeros_like(shared), where=power > 1e-12)
    best = int(np.argmax(found))
    if not 0 < best < len(found) - 1:
        return None
    before, at, after = found[best - 1 : best + 2]
    bend = before - 2.0 * at + after
    part = 0.5 * (before - after) / bend if bend < 0.0 else 0.0
    return float((lags[best] + part) * _OFFSET_STEP_S), float(at)


def _common_span(flight: Flight, names: Sequence[str]) -> Span | None:
    """Return the common time span of signals, in the air as far as the motors show it [s].

    A landing is a shock that streams show differently, and on the ground nothing moves.
    """
    if not flight.has(names) or any(len(flight[name].time) < 2 for name in names):
        return None
    begin = max(float(flight[name].time[0]) for name in names)
    end = min(float(flight[name].time[-1]) for name in names)
    for motor in flight.motors(MOTOR_COMMAND_PREFIX, SPEED_COMMAND_PREFIX, ROTOR_SPEED_PREFIX)[:1]:
        turns = flight[motor].time[_is_turning(motor, flight[motor].values)]
        if len(turns) and turns[-1] - turns[0] > 4.0 * MOTOR_START_MARGIN_S:
            begin, end = (
                max(begin, turns[0] + MOTOR_START_MARGIN_S),
                min(end, turns[-1] - MOTOR_START_MARGIN_S),
            )
    return (begin, end) if end - begin > 4.0 * MAX_CLOCK_OFFSET_S else None


def _identifiable(flight: Flight, turning: float) -> list[IdentifiableQuantity]:
    """Return what can be identified, from the signals of the log and their rates."""
    commands = flight.motors(MOTOR_COMMAND_PREFIX, SPEED_COMMAND_PREFIX)
    motion = "position_data" if "position_data.x" in flight else "estimate"
    speed = "velocity_data" if "velocity_data.v_x" in flight else "estimate"
    turn = "attitude" if "attitude.q_w" in flight else "estimate"

    def judged(
        what: str, needs: dict[str, Sequence[str]], fast: Sequence[str] = ()
    ) -> IdentifiableQuantity:
        missing = [kind for kind, names in needs.items() if not names or not flight.has(names)]
        if missing:
            return IdentifiableQuantity(what, False, f"the log has no {' and no '.join(missing)}")
        if not turning > 1.0:
            return IdentifiableQuantity(what, False, "the motors never turn for a second")
        slow = [name for name in fast if flight[name].rate < MIN_IDENTIFY_RATE_HZ]
        if slow:
            rate = min(flight[name].rate for name in slow)
            return IdentifiableQuantity(
                what,
                False,
                f"{rate:.0f} Hz alias a rate loop: log at {MIN_IDENTIFY_RATE_HZ:g} Hz or faster",
            )
        return IdentifiableQuantity(what, True, ", ".join(needs))

    attitude = component_names(f"{turn}.q_", "wxyz")
    velocity = component_names(f"{speed}.v_")
    return [
        judged("thrust over mass", {"commands": commands, "accelerometer": ACCELEROMETER_SIGNALS}),
        judged(
            "thrust over voltage",
            {
                "commands as shares": flight.motors(MOTOR_COMMAND_PREFIX),
                "accelerometer": ACCELEROMETER_SIGNALS,
                "voltage": ["battery.voltage"],
            },
        ),
        judged(
            "rotor lag",
            {"commands": commands, "accelerometer": ACCELEROMETER_SIGNALS},
            [*commands, ACCELEROMETER_SIGNALS[2]],
        ),
        judged("inertia", {"commands": commands, "gyro": GYRO_SIGNALS}, [*commands, *GYRO_SIGNALS]),
        judged(
            "drag",
            {"accelerometer": ACCELEROMETER_SIGNALS, "velocity": velocity, "attitude": attitude},
        ),
        judged(
            "prediction in closed loop",
            {
                "setpoints": SETPOINT_SIGNALS,
                "position": component_names(f"{motion}."),
                "attitude": attitude,
            },
        ),
    ]
