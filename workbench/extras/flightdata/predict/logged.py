"""The parts of a flight that predictions need: its motion, and the law that flew."""

import math
from collections.abc import Mapping, Sequence

import numpy as np

from workbench.common.errors import WorkbenchError
from workbench.common.flight import Flight
from workbench.control.controller_file import load_controller
from workbench.control.installed_laws import installed_laws
from workbench.extras.flightdata.predict.motion import WRONG_DRONE_REMEDY, LoggedMotion
from workbench.extras.flightdata.predict.what_if import Law
from workbench.gains.gain_choice import flight_gains
from workbench.logs.logged_signal import (
    GYRO_SIGNALS,
    MOTOR_COMMAND_PREFIX,
    ROTOR_SPEED_PREFIX,
    SETPOINT_SIGNALS,
    SPEED_COMMAND_PREFIX,
    component_names,
)
from workbench.plant.vehicle import Vehicle

COARSE_MOTION_PERIOD_S, FINE_MOTION_PERIOD_S = 0.01, 0.005
"""Periods of the grid for samples at about 100 Hz, and at twice that [s]."""
MIN_FINE_GRID_RATE_HZ = 150.0
"""Rate of positions from which on the fine grid is used [Hz]."""
MAX_MOTION_BRIDGE_S = math.inf
"""Longest gap to interpolate across [s]."""
MAX_MEASURED_GAP_S = 0.2
"""In a longer gap nothing counts as measured [s]."""
MAX_COORDINATE_M = 1e6
"""Largest plausible coordinate of a drone [m]."""
MAX_SAMPLE_JUMP_M = 1.0
"""Largest plausible movement between two samples [m]."""
TRUE_STATE_SIGNALS = (
    *component_names("attitude.q_", "wxyz"),
    *component_names("position_data."),
    *component_names("velocity_data.v_"),
)
"""Signals of the true attitude, position and velocity."""
LOGGED_ESTIMATE_SIGNALS = (
    *component_names("estimate.q_", "wxyz"),
    *component_names("estimate."),
    *component_names("estimate.v_"),
)
"""The same as known to the flight computer."""
ANGULAR_RATE_SIGNALS = (
    GYRO_SIGNALS,
    component_names("attitude.w_"),
    component_names("estimate.w_"),
)
"""Signals of the angular velocity in B, the best first; else it follows from the attitude."""
ATTITUDE_SETPOINT_SIGNALS = component_names(
    "attitude_setpoint.", ("roll", "pitch", "yaw", "thrust")
)
LAW_BY_LOGGED_NAME = {"PID": "crazyflie", "Mellinger": "mellinger"}
"""Control laws, by other names in logs."""
LAW_BY_FIRMWARE_PREFIX = {
    "PX4": "px4",
    "ArduCopter": "ardupilot",
    "APM:Copter": "ardupilot",
    "Betaflight": "betaflight",
    "Crazyflie": "crazyflie",
}
"""Control laws by the prefix of the firmware's name, for logs that do not name the law."""
UNKNOWN_LAW_NAMES = ("", "?")


def flown_law_name(flight: Flight, own: Mapping[str, str] | None = None) -> str:
    """Return the name of the law that flew, "" if the log does not state it.

    Args:
        flight: the log.
        own: paths of the user's own files, by the names of their laws.

    Raises:
        WorkbenchError: if it names an unknown one.
    """
    said, known = str(flight.parameters.get("controller", "")), LAW_BY_LOGGED_NAME | dict(own or {})
    if said in known:
        return known[said]
    if said in installed_laws():
        return said
    if said not in UNKNOWN_LAW_NAMES:
        raise WorkbenchError(
            f"{flight.source}: was flown by {said}, which is not a shipped control law: name its "
            "file"
        )
    found = (
        law for name, law in LAW_BY_FIRMWARE_PREFIX.items() if flight.firmware.startswith(name)
    )
    return next(found, "")


def flown_law(
    flight: Flight, vehicle: Vehicle, name: str, values: Mapping[str, float] | None = None
) -> Law:
    """Return a law with the gains in the log, which replace other values.

    Args:
        flight: the log.
        vehicle: the one that flew, as known to the law.
        name: of a shipped law, or the path of a file.
        values: of its parameters, where the log does not state them; None for those of the vehicle.

    Raises:
        WorkbenchError: if the law cannot be read, or a value is out of its range.
    """
    controller = load_controller(name)
    names = {row.name for row in controller.parameters}
    known = {
        key: float(value)
        for key, value in {**(values or {}), **flight.parameters}.items()
        if key in names and isinstance(value, int | float)
    }
    return Law(controller, flight_gains(vehicle, "", known, controller))


def motion_of(flight: Flight, vehicle: Vehicle) -> LoggedMotion:
    """Return the motion of a flight, from its begin to the end of the on-board data.

    Without a separate measurement, the motion is that known to the flight computer.

    Args:
        flight: with position, attitude, setpoint and motor commands.
        vehicle: the one that flew.

    Raises:
        WorkbenchError: if a signal is missing, or most of it is.
    """
    truth = (
        TRUE_STATE_SIGNALS
        if flight.has(TRUE_STATE_SIGNALS) or not flight.has(LOGGED_ESTIMATE_SIGNALS)
        else LOGGED_ESTIMATE_SIGNALS
    )
    commands = flight.motors(MOTOR_COMMAND_PREFIX, SPEED_COMMAND_PREFIX, ROTOR_SPEED_PREFIX)
    full = np.array([each.max_rot_velocity for each in vehicle.rotors])
    _check_predictable(flight, vehicle, truth, commands)
    rates = next((each for each in ANGULAR_RATE_SIGNALS if flight.has(each)), ())
    names = (*truth, *SETPOINT_SIGNALS, *commands, *rates)
    names += (
        LOGGED_ESTIMATE_SIGNALS
        if truth is TRUE_STATE_SIGNALS and flight.has(LOGGED_ESTIMATE_SIGNALS)
        else ()
    )
    names += ATTITUDE_SETPOINT_SIGNALS if flight.has(ATTITUDE_SETPOINT_SIGNALS) else ()
    names += ("battery.voltage",) if "battery.voltage" in flight else ()
    period = (
        FINE_MOTION_PERIOD_S
        if flight[truth[4]].rate > MIN_FINE_GRID_RATE_HZ
        else COARSE_MOTION_PERIOD_S
    )
    grid = flight.resample(names, period, MAX_MOTION_BRIDGE_S)
    if len(grid.time) < 2:
        raise WorkbenchError(f"{flight.source}: its signals have no time in common")
    p = np.column_stack([grid[name] for name in truth[4:7]])
    if not (np.abs(p) < MAX_COORDINATE_M).all():
        at = grid.time[np.argmin((np.abs(p) < MAX_COORDINATE_M).all(axis=1))]
        raise WorkbenchError(
            f"{flight.source}: the position at {at:.2f} s is not a position ({np.abs(p).max():.3g} "
            "m): leave out damaged data"
        )
    jumps = np.linalg.norm(np.diff(p, axis=0), axis=1) > MAX_SAMPLE_JUMP_M
    measured = flight.resample(names, period, MAX_MEASURED_GAP_S).whole
    measured &= ~(np.append(jumps, False) | np.append(False, jumps))

    def columns(wanted: Sequence[str]) -> np.ndarray:
        return np.column_stack([grid[name] for name in wanted])

    def unit(q: np.ndarray) -> np.ndarray:
        return np.asarray(q / np.linalg.norm(q, axis=1)[:, None])

    nothing = np.full(len(grid.time), np.nan)
    known = LOGGED_ESTIMATE_SIGNALS if flight.has(LOGGED_ESTIMATE_SIGNALS) else truth
    wanted = (
        columns(ATTITUDE_SETPOINT_SIGNALS)
        if flight.has(ATTITUDE_SETPOINT_SIGNALS)
        else np.repeat(nothing[:, None], 4, axis=1)
    )
    q = unit(columns(truth[0:4]))
    return LoggedMotion(
        name=flight.name,
        period=period,
        q=q,
        p=p,
        v=columns(truth[7:10]),
        w=columns(rates) if rates else _turning(q, period),
        q_known=unit(columns(known[0:4])),
        p_known=columns(known[4:7]),
        v_known=columns(known[7:10]),
        setpoint=columns(SETPOINT_SIGNALS),
        attitude_setpoint=wanted[:, 0:3],
        thrust_setpoint=wanted[:, 3],
        commands=columns(commands)
        / (1.0 if commands[0].startswith(MOTOR_COMMAND_PREFIX) else full),
        lag_shown=commands[0].startswith(ROTOR_SPEED_PREFIX),
        speeds_shown=not commands[0].startswith(MOTOR_COMMAND_PREFIX),
        voltage=columns(["battery.voltage"])[:, 0] if "battery.voltage" in flight else nothing,
        measured=measured,
    )


def _turning(q: np.ndarray, period: float) -> np.ndarray:
    """Return the angular velocity in B (n, 3) [rad/s] of unit quaternions B to W (n, 4).

    w = 2 q* dq/dt; all readers give quaternions whose signs do not jump.
    """
    rate = np.gradient(q, period, axis=0)
    w, part = q[:, :1], q[:, 1:]
    return np.asarray(2.0 * (w * rate[:, 1:] - rate[:, :1] * part - np.cross(part, rate[:, 1:])))


def _check_predictable(
    flight: Flight, vehicle: Vehicle, truth: Sequence[str], commands: Sequence[str]
) -> None:
    """Check that a log has the signals for a prediction, and as many motors as rotors.

    Raises:
        WorkbenchError: that names what is missing.
    """
    told, rotors = len(commands), len(vehicle.rotors)
    if told not in (0, rotors):
        raise WorkbenchError(
            f"{flight.source}: has {told} motors, but {vehicle.name} has {rotors}: "
            f"{WRONG_DRONE_REMEDY}"
        )
    needed = {
        "position": truth[4:7],
        "velocity": truth[7:10],
        "attitude": truth[0:4],
        "setpoint of the position": SETPOINT_SIGNALS,
        "motors' commands": commands or ("motors.command_1",),
    }
    missing = [what for what, names in needed.items() if not flight.has(names)]
    if missing:
        raise WorkbenchError(
            f"{flight.source}: has no {', no '.join(missing)}: a prediction needs position, "
            "velocity, attitude, the setpoint of the position, and the motors' commands; "
            "`workbench log` lists what there is"
        )
