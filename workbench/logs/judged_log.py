"""A flight record for a spec: the arrays of a recording, and the signals named in its case.

Arrays of the recording are on one even grid, that of the fastest of them, with linear interpolation
between samples and NaN in gaps. Signals with the log's own names keep their times.
"""

import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from workbench.common.errors import WorkbenchError
from workbench.design.regress.flight import LEAST_KNOWN, JudgedLog, Trace
from workbench.design.regress.measures import MEASURED
from workbench.design.regress.signals import POINT, USE
from workbench.design.regress.spec import SKIP, Case, LogConfig, Spec
from workbench.logs.flight_reader import read_flight
from workbench.logs.flight_record import GYRO, FlightRecord, make_signal, parts
from workbench.logs.measured_flight import SHARE, motor_commands
from workbench.logs.readers.rotations import ANGLES, QUATERNION, in_world, quaternion
from workbench.logs.step_response import find_loop, step_response
from workbench.plant.vehicle import Vehicle
from workbench.scenario.configured import configured_vehicle
from workbench.session.recording import Recording

FINEST = 1e-3
"""Shortest period of the grid [s]."""
BRIDGE = 2.6
"""Number of periods of a signal to interpolate across; anything longer is a gap."""
BEFORE = 3.0
"""Time before the span that is read, too [s]."""
LONGEST = {"x": 1.25, "y": 1.25, "z": 1.25, "v_x": 0.75, "v_y": 0.75, "v_z": 0.75}
"""Longest lag in the search, by loop, and for all other loops [s]."""
LONGEST_OTHER = 0.5
_VECTORS = ("p_WB", "v_WB", "w_WB", "vdot_WB", "wdot_WB", "wind_W")


def read_case(spec: Spec, case: Case) -> JudgedLog:
    """Return the flight of a case with a log; if there is no log, the flight states this.

    Raises:
        WorkbenchError: if the log cannot be read, or lacks a signal that the case names.
    """
    config = case.log
    assert config is not None
    vehicle = configured_vehicle(spec.content.vehicle)
    place = Path(config.file)
    if config.missing == SKIP and not place.is_file():
        return _absent(vehicle, f"there is no log {place.name}")
    record = read_flight(place, config.mapping or None, log_number=config.number or None)
    return judged_log(record, vehicle, case, config)


def judged_log(record: FlightRecord, vehicle: Vehicle, case: Case, config: LogConfig) -> JudgedLog:
    """Return a flight record in the form that a case judges.

    Args:
        record: of the log.
        vehicle: the one that flew.
        case: with signals, loop and metrics.
        config: the part of the log, and the order of its motors.

    Raises:
        WorkbenchError: if the log lacks a signal that the case names, or the span.
    """
    begin, end = config.span or (0.0, record.end)
    if not 0.0 <= begin < end or record.end - begin < LEAST_KNOWN * (end - begin):
        raise WorkbenchError(
            f"{record.source}: lasts from 0 to {record.end:.4g} s, but the span is {begin:g} .. "
            f"{end:g} s: name a part of it"
        )
    end = min(end, record.end)
    loop = find_loop(record, case.loop)[:2] if case.loop else ()
    signal = case.signal or (loop[1] if loop else "")
    named = dict.fromkeys([*loop, *filter(lambda name: POINT in name, (signal, *case.signals))])
    missing: dict[str, str] = {}
    recording = _recording(record, vehicle, config.order, max(0.0, begin - BEFORE), end, missing)
    measured: dict[str, float] = {}
    if any(name in MEASURED for name in case.limits):
        measured = _measured(record, case.loop, (begin, end), missing)
    return JudgedLog(
        recording=recording,
        edge=begin,
        axis="",
        signal=signal,
        command=None,
        end=end,
        traces={name: _trace(record, name) for name in named},
        loop=loop,
        longest=LONGEST.get(case.loop, LONGEST_OTHER),
        missing=missing,
        measured=measured,
        skip=config.missing == SKIP,
    )


def _absent(vehicle: Vehicle, why: str) -> JudgedLog:
    recording = _filled(vehicle, np.empty(0))
    return JudgedLog(recording, edge=0.0, axis="", signal="", command=None, absent=why)


def _trace(record: FlightRecord, name: str) -> Trace:
    signal = record[name]
    return Trace(signal.unit or "1", signal.time, signal.values, signal.gaps)


def _measured(
    record: FlightRecord, loop: str, span: tuple[float, float], missing: dict[str, str]
) -> dict[str, float]:
    """Return the metrics of the step response of a loop, from a part of a log.

    Reasons not to trust them are added to `missing`.
    """
    signals = {}
    for name in find_loop(record, loop)[:2]:
        whole = record[name]
        part = (whole.time >= span[0]) & (whole.time <= span[1])
        signals[name] = make_signal(name, whole.unit, whole.time[part], whole.values[part])
    cut = FlightRecord(record.name, record.source, record.format, signals, end=span[1])
    try:
        found = step_response(cut, loop)
    except WorkbenchError as error:
        missing |= dict.fromkeys(MEASURED, str(error))
        return {}
    if not found.trusted:
        doubts = "; ".join(found.doubts)
        missing |= dict.fromkeys(MEASURED, f"the step response is not reliable: {doubts}")
    values = (found.rise, 100.0 * found.overshoot, found.final)
    return dict(zip(MEASURED, values, strict=True))


def _recording(
    record: FlightRecord,
    vehicle: Vehicle,
    order: Sequence[int],
    begin: float,
    end: float,
    missing: dict[str, str],
) -> Recording:
    """Return the arrays of a recording that a log has, and note why others are missing."""
    turn = [parts(f"{topic}.", QUATERNION) for topic in ("attitude", "estimate")]
    angles = [parts(f"{topic}.", ANGLES) for topic in ("position_data", "estimate")]
    body = [parts("attitude.w_"), GYRO, parts("estimate.w_")]
    sources: dict[str, Sequence[tuple[str, ...]]] = {
        "p_WB": [parts("position_data."), parts("estimate.")],
        "q_WB": [*turn, *angles],
        "v_WB": [parts("velocity_data.v_"), parts("estimate.v_")],
        "w_WB": [parts("velocity_data.w_"), *body],
        "vdot_WB": [parts("estimate.a_")],
    }
    taken = {  # the first whole set that the log has
        field: next(filter(record.has, sets), ()) for field, sets in sources.items()
    }
    for field, sets in sources.items():
        if not taken[field]:
            wanted = " or ".join(f"{names[0]} .." for names in sets)
            missing[field] = f"the log has no {wanted}"
    names = dict.fromkeys(name for found in taken.values() for name in found)
    motors = _motors(record, vehicle, order, missing)
    rates = [record[name].rate for name in names] + [rate for _, _, rate in motors.values()]
    period = max(1.0 / max([rate for rate in rates if rate > 0.0], default=100.0), FINEST)
    time = begin + period * np.arange(math.floor((end - begin) / period + 1e-9) + 1)
    columns = {name: _at(record, name, time) for name in names}

    def of(field: str) -> np.ndarray:
        if not taken[field]:
            return np.full((len(time), 4 if field == "q_WB" else 3), np.nan)
        return np.column_stack([columns[name] for name in taken[field]])

    q = of("q_WB")
    if q.shape[1] == 3:
        q = quaternion(*q.T)
    q /= np.linalg.norm(q, axis=1, keepdims=True)
    w = of("w_WB")
    if taken["w_WB"] in body:
        w = in_world(q, w)
    arrays = {
        "p_WB": of("p_WB"),
        "q_WB": q,
        "v_WB": of("v_WB"),
        "w_WB": w,
        "vdot_WB": of("vdot_WB"),
    }
    for field, (times, values, rate) in motors.items():
        arrays[field] = _held(times, values, time, BRIDGE / rate if rate > 0.0 else 0.0)
    return _filled(vehicle, time, **arrays)


def _motors(
    record: FlightRecord, vehicle: Vehicle, order: Sequence[int], missing: dict[str, str]
) -> dict[str, tuple[np.ndarray, np.ndarray, float]]:
    """Return times (N), values (N, n) and rate of the commands, speeds and thrusts in a log."""
    rotors = vehicle.rotors
    limits = np.array([rotor.max_rot_velocity for rotor in rotors])
    found: dict[str, tuple[np.ndarray, np.ndarray, float]] = {}
    speeds = _speeds(record, len(rotors), order)
    try:
        time, commands, kind = motor_commands(record, len(rotors), order)
        commands = commands * limits if kind == SHARE else commands
        found["commanded_speeds"] = (time, commands, _rate(time))
    except WorkbenchError as error:
        if speeds is None:
            missing["commanded_speeds"] = missing[USE] = str(error)
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
    record: FlightRecord, rotors: int, order: Sequence[int]
) -> tuple[np.ndarray, np.ndarray, float] | None:
    """Return times, speeds (N, n) of the rotors and their rate; None if a log has none."""
    places = [number - 1 for number in order] or list(range(rotors))
    names = [f"rotors.speed.{place}" for place in places]
    if not record.has(names):
        return None
    time = record[names[0]].time
    values = np.column_stack([np.interp(time, record[n].time, record[n].values) for n in names])
    return time, values, record[names[0]].rate


def _rate(time: np.ndarray) -> float:
    return 1.0 / float(np.median(np.diff(time))) if len(time) > 1 else 0.0


def _at(record: FlightRecord, name: str, time: np.ndarray) -> np.ndarray:
    signal = record[name]
    return signal.at(time, BRIDGE / signal.rate if signal.rate > 0.0 else 0.0)[0]


def _held(times: np.ndarray, values: np.ndarray, grid: np.ndarray, longest: float) -> np.ndarray:
    """Return rows (N, n) interpolated linearly, NaN where samples are too far apart."""
    made = np.column_stack(
        [np.interp(grid, times, column, left=np.nan, right=np.nan) for column in values.T]
    )
    for place in np.flatnonzero(np.diff(times) > longest):
        made[(grid > times[place] + 1e-9) & (grid < times[place + 1] - 1e-9)] = np.nan
    return made


def _filled(vehicle: Vehicle, time: np.ndarray, **arrays: np.ndarray) -> Recording:
    """Return a recording of some arrays, with NaN for the rest."""
    sizes = {"q_WB": 4, "reference": 8, **dict.fromkeys(_VECTORS, 3)}
    sizes |= dict.fromkeys(("commanded_speeds", "rotor_speeds", "thrusts"), len(vehicle.rotors))
    rest = {
        name: np.full((len(time), size), np.nan)
        for name, size in sizes.items()
        if name not in arrays
    }
    plain = {name: np.full(len(time), np.nan) for name in ("mode", "charge", "clearance")}
    return Recording(vehicle=vehicle, time=time, **arrays, **rest, **plain)
