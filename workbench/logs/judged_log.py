"""A logged flight for a spec: the arrays of a recording, and the signals named in its case.

Arrays of the recording are on one even grid, that of the fastest of them, with linear interpolation
between samples and NaN in gaps. Signals with the log's own names keep their times.
"""

import math
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from workbench.common.errors import WorkbenchError
from workbench.common.flight import Flight
from workbench.design.regress.case_log import MIN_KNOWN_SHARE, JudgedLog
from workbench.design.regress.measures import LOOP_LOG_METRICS
from workbench.design.regress.signals import ROTOR_USE_INPUT, SENSOR_SEPARATOR
from workbench.design.regress.spec import MISSING_SKIP, LogConfig, Spec, SpecCase
from workbench.logs.flight_reader import read_flight
from workbench.logs.logged_loop import find_logged_loop
from workbench.logs.logged_signal import GYRO_SIGNALS, component_names
from workbench.logs.motor_commands import FULL_SHARE_COMMANDS, motor_commands
from workbench.logs.readers.rotations import (
    EULER_ANGLE_NAMES,
    QUATERNION_NAMES,
    quaternion_from_angles,
    vectors_in_world,
)
from workbench.logs.step_response import identify_step_response
from workbench.plant.vehicle import Vehicle
from workbench.scenario.configured import configured_vehicle
from workbench.session.recording import Recording

MIN_JUDGED_PERIOD_S = 1e-3
"""Shortest period of the grid [s]."""
MAX_BRIDGED_PERIODS = 2.6
"""Number of periods of a signal to interpolate across; anything longer is a gap."""
SPAN_LEAD_S = 3.0
"""Time before the span that is read, too [s]."""
MAX_LAG_BY_LOOP_S = {"x": 1.25, "y": 1.25, "z": 1.25, "v_x": 0.75, "v_y": 0.75, "v_z": 0.75}
"""Longest lag in the search, by loop, and for all other loops [s]."""
MAX_OTHER_LAG_S = 0.5
_VECTOR_QUANTITIES = ("p_WB", "v_WB", "w_WB", "vdot_WB", "wdot_WB", "wind_W")


def read_case(spec: Spec, case: SpecCase) -> JudgedLog:
    """Return the flight of a case with a log; if there is no log, the flight states this.

    Raises:
        WorkbenchError: if the log cannot be read, or lacks a signal that the case names.
    """
    config = case.log
    assert config is not None
    vehicle = configured_vehicle(spec.content.vehicle)
    place = Path(config.file)
    if config.missing == MISSING_SKIP and not place.is_file():
        return _absent(vehicle, f"there is no log {place.name}")
    flight = read_flight(place, config.mapping or None, log_number=config.number or None)
    return judged_log(flight, vehicle, case, config)


def judged_log(flight: Flight, vehicle: Vehicle, case: SpecCase, config: LogConfig) -> JudgedLog:
    """Return a logged flight in the form that a case judges.

    Args:
        flight: of the log.
        vehicle: the one that flew.
        case: with signals, loop and metrics.
        config: the part of the log, and the order of its motors.

    Raises:
        WorkbenchError: if the log lacks a signal that the case names, or the span.
    """
    begin, end = config.span or (0.0, flight.end)
    if not 0.0 <= begin < end or flight.end - begin < MIN_KNOWN_SHARE * (end - begin):
        raise WorkbenchError(
            f"{flight.source}: lasts from 0 to {flight.end:.4g} s, but the span is {begin:g} .. "
            f"{end:g} s: name a part of it"
        )
    end = min(end, flight.end)
    loop = find_logged_loop(flight, case.loop)[:2] if case.loop else ()
    signal = case.signal or (loop[1] if loop else "")
    named = dict.fromkeys(
        [*loop, *filter(lambda name: SENSOR_SEPARATOR in name, (signal, *case.signals))]
    )
    missing: dict[str, str] = {}
    recording = _recording(
        flight, vehicle, config.order, max(0.0, begin - SPAN_LEAD_S), end, missing
    )
    measured: dict[str, float] = {}
    if any(name in LOOP_LOG_METRICS for name in case.limits):
        measured = _step_metrics(flight, case.loop, (begin, end), missing)
    return JudgedLog(
        recording=recording,
        edge=begin,
        axis="",
        signal=signal,
        command=None,
        end=end,
        traces={name: replace(flight[name], unit=flight[name].unit or "1") for name in named},
        loop=loop,
        longest=MAX_LAG_BY_LOOP_S.get(case.loop, MAX_OTHER_LAG_S),
        missing=missing,
        measured=measured,
        skip=config.missing == MISSING_SKIP,
    )


def _absent(vehicle: Vehicle, why: str) -> JudgedLog:
    recording = _filled(vehicle, np.empty(0))
    return JudgedLog(recording, edge=0.0, axis="", signal="", command=None, absent=why)


def _step_metrics(
    flight: Flight, loop: str, span: tuple[float, float], missing: dict[str, str]
) -> dict[str, float]:
    """Return the metrics of the step response of a loop, from a part of a log.

    Reasons not to trust them are added to `missing`.
    """
    signals = {name: flight[name] for name in find_logged_loop(flight, loop)[:2]}
    try:
        found = identify_step_response(replace(flight, signals=signals).between(*span), loop)
    except WorkbenchError as error:
        missing |= dict.fromkeys(LOOP_LOG_METRICS, str(error))
        return {}
    if not found.trusted:
        doubts = "; ".join(found.doubts)
        missing |= dict.fromkeys(LOOP_LOG_METRICS, f"the step response is not reliable: {doubts}")
    values = (found.rise, 100.0 * found.overshoot, found.final)
    return dict(zip(LOOP_LOG_METRICS, values, strict=True))


def _recording(
    flight: Flight,
    vehicle: Vehicle,
    order: Sequence[int],
    begin: float,
    end: float,
    missing: dict[str, str],
) -> Recording:
    """Return the arrays of a recording that a log has, and note why others are missing."""
    turn = [component_names(f"{topic}.", QUATERNION_NAMES) for topic in ("attitude", "estimate")]
    angles = [
        component_names(f"{topic}.", EULER_ANGLE_NAMES) for topic in ("position_data", "estimate")
    ]
    body = [component_names("attitude.w_"), GYRO_SIGNALS, component_names("estimate.w_")]
    sources: dict[str, Sequence[tuple[str, ...]]] = {
        "p_WB": [component_names("position_data."), component_names("estimate.")],
        "q_WB": [*turn, *angles],
        "v_WB": [component_names("velocity_data.v_"), component_names("estimate.v_")],
        "w_WB": [component_names("velocity_data.w_"), *body],
        "vdot_WB": [component_names("estimate.a_")],
    }
    taken = {  # the first whole set that the log has
        field: next(filter(flight.has, sets), ()) for field, sets in sources.items()
    }
    for field, sets in sources.items():
        if not taken[field]:
            wanted = " or ".join(f"{names[0]} .." for names in sets)
            missing[field] = f"the log has no {wanted}"
    names = dict.fromkeys(name for found in taken.values() for name in found)
    motors = _motor_samples(flight, vehicle, order, missing)
    rates = [flight[name].rate for name in names] + [rate for _, _, rate in motors.values()]
    period = max(
        1.0 / max([rate for rate in rates if rate > 0.0], default=100.0), MIN_JUDGED_PERIOD_S
    )
    time = begin + period * np.arange(math.floor((end - begin) / period + 1e-9) + 1)
    time = np.minimum(time, end)  # beyond it by a rounding, the last sample would be unknown
    columns = {name: _signal_at(flight, name, time) for name in names}

    def of(field: str) -> np.ndarray:
        if not taken[field]:
            return np.full((len(time), 4 if field == "q_WB" else 3), np.nan)
        return np.column_stack([columns[name] for name in taken[field]])

    q = of("q_WB")
    if q.shape[1] == 3:
        q = quaternion_from_angles(*q.T)
    q /= np.linalg.norm(q, axis=1, keepdims=True)
    w = of("w_WB")
    if taken["w_WB"] in body:
        w = vectors_in_world(q, w)
    arrays = {
        "p_WB": of("p_WB"),
        "q_WB": q,
        "v_WB": of("v_WB"),
        "w_WB": w,
        "vdot_WB": of("vdot_WB"),
    }
    for field, (times, values, rate) in motors.items():
        arrays[field] = _interpolated_rows(
            times, values, time, MAX_BRIDGED_PERIODS / rate if rate > 0.0 else 0.0
        )
    return _filled(vehicle, time, **arrays)


def _motor_samples(
    flight: Flight, vehicle: Vehicle, order: Sequence[int], missing: dict[str, str]
) -> dict[str, tuple[np.ndarray, np.ndarray, float]]:
    """Return times (N), values (N, n) and rate of the commands, speeds and thrusts in a log."""
    rotors = vehicle.rotors
    limits = np.array([rotor.max_rot_velocity for rotor in rotors])
    found: dict[str, tuple[np.ndarray, np.ndarray, float]] = {}
    speeds = _speeds(flight, len(rotors), order)
    try:
        time, commands, kind = motor_commands(flight, len(rotors), order)
        commands = commands * limits if kind == FULL_SHARE_COMMANDS else commands
        found["commanded_speeds"] = (time, commands, _sample_rate(time))
    except WorkbenchError as error:
        if speeds is None:
            missing["commanded_speeds"] = missing[ROTOR_USE_INPUT] = str(error)
        else:
            found["commanded_speeds"] = speeds
    if speeds is not None:
        found["rotor_speeds"] = speeds
        times, values, rate = speeds
        squared = np.array([rotor.motor_constant for rotor in rotors])
        linear = np.array([rotor.linear_motor_constant for rotor in rotors])
        found["thrusts"] = (times, squared * values**2 + linear * values, rate)
    else:
        why = "the log has no speeds of the rotors (rotors.speed.0 ..)"
        missing |= {"rotor_speeds": why, "thrusts": why}
        if "commanded_speeds" in found:
            found["rotor_speeds"] = found["commanded_speeds"]
    missing["charge"] = "a log has no charge: use battery.voltage"
    return found


def _speeds(
    flight: Flight, rotors: int, order: Sequence[int]
) -> tuple[np.ndarray, np.ndarray, float] | None:
    """Return times, speeds (N, n) of the rotors and their rate; None if a log has none."""
    places = [number - 1 for number in order] or list(range(rotors))
    names = [f"rotors.speed.{place}" for place in places]
    if not flight.has(names):
        return None
    time = flight[names[0]].time
    values = np.column_stack([np.interp(time, flight[n].time, flight[n].values) for n in names])
    return time, values, flight[names[0]].rate


def _sample_rate(time: np.ndarray) -> float:
    return 1.0 / float(np.median(np.diff(time))) if len(time) > 1 else 0.0


def _signal_at(flight: Flight, name: str, time: np.ndarray) -> np.ndarray:
    signal = flight[name]
    return signal.at(time, MAX_BRIDGED_PERIODS / signal.rate if signal.rate > 0.0 else 0.0)[0]


def _interpolated_rows(
    times: np.ndarray, values: np.ndarray, grid: np.ndarray, longest: float
) -> np.ndarray:
    """Return rows (N, n) interpolated linearly, NaN where samples are too far apart."""
    made = np.column_stack(
        [np.interp(grid, times, column, left=np.nan, right=np.nan) for column in values.T]
    )
    for place in np.flatnonzero(np.diff(times) > longest):
        made[(grid > times[place] + 1e-9) & (grid < times[place + 1] - 1e-9)] = np.nan
    return made


def _filled(vehicle: Vehicle, time: np.ndarray, **arrays: np.ndarray) -> Recording:
    """Return a recording of some arrays, with NaN for the rest."""
    sizes = {"q_WB": 4, "reference": 8, **dict.fromkeys(_VECTOR_QUANTITIES, 3)}
    sizes |= dict.fromkeys(("commanded_speeds", "rotor_speeds", "thrusts"), len(vehicle.rotors))
    rest = {
        name: np.full((len(time), size), np.nan)
        for name, size in sizes.items()
        if name not in arrays
    }
    plain = {name: np.full(len(time), np.nan) for name in ("mode", "charge", "clearance")}
    return Recording(vehicle=vehicle, time=time, **arrays, **rest, **plain)
