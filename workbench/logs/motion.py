"""A flight record as the arrays that predictions start from."""

import math

import numpy as np

from workbench.common.errors import WorkbenchError
from workbench.design.predict.motion import Motion
from workbench.logs.flight_record import FlightRecord
from workbench.plant.vehicle import Vehicle

PERIOD, FINE = 0.01, 0.005
"""Of the grid of what was sampled at 100 Hz or so, and at twice that [s]."""
FAST = 150.0
"""Rate of positions from which on the grid is fine [Hz]."""
BRIDGE = math.inf
"""Longest gap that is interpolated across [s]."""
GAP = 0.2
"""In a longer one nothing counts as measured [s]."""
Q = tuple(f"q_{axis}" for axis in "wxyz")
NEEDED = (
    *(f"attitude.{field}" for field in Q),
    *(f"position_data.{axis}" for axis in "xyz"),
    *(f"velocity_data.v_{axis}" for axis in "xyz"),
    *(f"setpoint.{axis}" for axis in "xyz"),
)


def motion_of(flight: FlightRecord, vehicle: Vehicle) -> Motion:
    """Return a flight's motion, from its begin to where the on-board data end.

    Args:
        flight: with position, attitude, setpoint and motor commands.
        vehicle: that flew.

    Raises:
        WorkbenchError: if a signal is missing, or too much of one.
    """
    rotors = len(vehicle.rotors)
    commands = tuple(f"motors.command_{i + 1}" for i in range(rotors))
    speeds = tuple(f"rotors.speed.{i}" for i in range(rotors))
    full = np.ones(rotors)
    if not flight.has(commands) and flight.has(speeds):
        commands, full = speeds, np.array([each.max_rot_velocity for each in vehicle.rotors])
    missing = [name for name in (*NEEDED, *commands) if name not in flight]
    if missing:
        raise WorkbenchError(
            f"{flight.source}: has no {', '.join(missing[:4])}: a prediction needs position, "
            "velocity, attitude, the setpoint of the position, and the motors' commands; "
            "`workbench log` lists what there is"
        )
    gyro = tuple(f"imu.angular_velocity.{axis}" for axis in "xyz")
    rates = gyro if flight.has(gyro) else tuple(f"attitude.w_{axis}" for axis in "xyz")
    known = (
        *(f"estimate.{field}" for field in Q),
        *(f"estimate.{axis}" for axis in "xyz"),
        *(f"estimate.v_{axis}" for axis in "xyz"),
    )
    wanted = (*(f"attitude_setpoint.{name}" for name in ("roll", "pitch", "yaw", "thrust")),)
    names = (*NEEDED, *commands, *rates)
    names += known if flight.has(known) else ()
    names += wanted if flight.has(wanted) else ()
    names += ("battery.voltage",) if "battery.voltage" in flight else ()
    period = FINE if flight[NEEDED[4]].rate > FAST else PERIOD
    grid = flight.resample(names, period, BRIDGE)
    if len(grid.time) < 2:
        raise WorkbenchError(f"{flight.source}: its signals have no time in common")
    measured = flight.resample(names, period, GAP).whole

    def columns(*wanted: str) -> np.ndarray:
        return np.column_stack([grid[name] for name in wanted])

    def unit(q: np.ndarray) -> np.ndarray:
        return np.asarray(q / np.linalg.norm(q, axis=1)[:, None])

    nothing = np.full(len(grid.time), np.nan)
    q, p, v = unit(columns(*NEEDED[0:4])), columns(*NEEDED[4:7]), columns(*NEEDED[7:10])
    estimate = flight.has(known)
    return Motion(
        name=flight.name,
        period=period,
        q=q,
        p=p,
        v=v,
        w=columns(*rates),
        q_known=unit(columns(*known[0:4])) if estimate else q,
        p_known=columns(*known[4:7]) if estimate else p,
        v_known=columns(*known[7:10]) if estimate else v,
        setpoint=columns(*NEEDED[10:13]),
        attitude_setpoint=columns(*wanted[0:3])
        if flight.has(wanted)
        else np.repeat(nothing[:, None], 3, axis=1),
        thrust_setpoint=columns(wanted[3])[:, 0] if flight.has(wanted) else nothing,
        commands=columns(*commands) / full,
        voltage=columns("battery.voltage")[:, 0] if "battery.voltage" in flight else nothing,
        measured=measured,
    )
