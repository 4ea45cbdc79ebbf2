"""What the model predicts of each sample of a piece of a flight, compiled."""

import math

import numpy as np
from scipy.signal import lfilter

from workbench.common.compiled import compile_cached
from workbench.design.rollout.compiled_flights import FLIGHT_COMPILE_OPTIONS
from workbench.design.rollout.vehicle_batch import body_records, rotor_records
from workbench.dynamics.air.drag import drag_force
from workbench.dynamics.rigid_body import body_acceleration, cross
from workbench.dynamics.rotors import rotor_load, speed_slope, static_thrust, within_speed_limits
from workbench.estimation.filters import lowpass
from workbench.estimation.imu import ideal_imu_sample
from workbench.extras.flightdata.identify.flight_piece import Piece, block_means
from workbench.extras.flightdata.identify.quantities import with_quantities
from workbench.logs.motor_commands import FULL_SHARE_COMMANDS
from workbench.plant.drag import drag_area
from workbench.plant.gravity import AIR_DENSITY
from workbench.plant.vehicle import Vehicle

FIT_SOURCES = ("extras/flightdata/identify/model_rows.py", "dynamics", "estimation")
FAR_ABOVE_GROUND_M = 1e6
"""Above the ground, which has no effect there [m]."""
MIN_FILTER_DELAY_S = 1e-3
"""Delay below which a gyro's filter is no more than a delay [s]."""


def _follow_commands(
    commands: np.ndarray,
    rotors: np.ndarray,
    period: float,
    speeds: np.ndarray,
    slopes: np.ndarray,
) -> None:
    """Write speeds in the middle of every step, and their mean slopes, that follow commands.

    A slope jumps with the command: its mean is what spins the body up. A step is one of the
    classical Runge-Kutta method, and its middle is on the cubic through its ends.

    Args:
        commands: (N, n) held from each sample to the next [rad/s].
        rotors: (n) see `vehicle_batch.ROTOR_DTYPE`.
        period: between samples [s].
        speeds: (N, n) places [rad/s]; the first row is where they begin.
        slopes: (N, n) places [rad/s²].
    """
    for i in range(len(rotors)):
        rotor, speed = rotors[i], speeds[0, i]
        for k in range(len(commands)):
            command = within_speed_limits(commands[k, i], rotor)
            first = speed_slope(rotor, command, speed)
            second = speed_slope(rotor, command, speed + 0.5 * period * first)
            third = speed_slope(rotor, command, speed + 0.5 * period * second)
            fourth = speed_slope(rotor, command, speed + period * third)
            slopes[k, i] = (first + 2.0 * second + 2.0 * third + fourth) / 6.0
            end = speed + period * slopes[k, i]
            last = speed_slope(rotor, command, end)
            speeds[k, i] = 0.5 * (speed + end) + 0.125 * period * (first - last)
            speed = end


def _calc_responses(
    speeds: np.ndarray,
    slopes: np.ndarray,
    gyro: np.ndarray,
    velocity: np.ndarray,
    half_drag: float,
    bodies: np.ndarray,
    rotors: np.ndarray,
    p_BI: np.ndarray,
    alpha: np.ndarray,
    force: np.ndarray,
) -> None:
    """Write angular accelerations (N, 3) [rad/s²] and specific forces at p_BI (N, 3) [m/s²].

    Args:
        speeds: (N, n) of the rotors [rad/s].
        slopes: (N, n) of their speeds [rad/s²].
        gyro: (N, 3) angular velocity in B [rad/s].
        velocity: (N, 3) in still air, in B [m/s].
        half_drag: see `drag_force`.
        bodies: (1) see `vehicle_batch.BODY_DTYPE`.
        rotors: (n) see `vehicle_batch.ROTOR_DTYPE`.
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
            load = rotor_load(rotor, speed, slope, 1.0, static, w_B, v_B, level, FAR_ABOVE_GROUND_M)
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
        shown = ideal_imu_sample(state, acceleration, p_BI)
        for i in range(3):
            alpha[k, i] = six[i]
            force[k, i] = shown[3 + i]


compiled_rotor_speeds = compile_cached(
    _follow_commands, FIT_SOURCES, "the rotors of a log", **FLIGHT_COMPILE_OPTIONS
)
compiled_responses = compile_cached(
    _calc_responses, FIT_SOURCES, "the motion of a log", **FLIGHT_COMPILE_OPTIONS
)


def delayed_samples(values: np.ndarray, late: float) -> np.ndarray:
    """Return samples (N, ...) as they were so many periods before, between samples on lines."""
    whole = math.floor(late)
    share = late - whole
    rows = np.arange(len(values))
    first = values[np.clip(rows - whole, 0, len(values) - 1)]
    second = values[np.clip(rows - whole - 1, 0, len(values) - 1)]
    return (1.0 - share) * first + share * second


def sensor_filtered(values: np.ndarray, delay: float, period: float) -> np.ndarray:
    """Return angular velocities or specific forces (N, 3) behind a sensor's filters.

    They are taken for one low-pass of second order with their delay at low frequencies [s], which
    is what most flight controllers have; where that is too short for one, for a delay.
    """
    if delay < MIN_FILTER_DELAY_S:
        return delayed_samples(values, delay / period)
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


def model_rows(vehicle: Vehicle, values: dict[str, float], piece: Piece) -> np.ndarray:
    """Return what a vehicle's model says of a piece (K, 6), see `FIT_CHANNELS`.

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
        values: tried ones by name, see `quantities.identifiable_quantities`.
        piece: of a flight.
    """
    tried = with_quantities(vehicle, values)
    rotors = rotor_records(tried.rotors)
    most = np.array([rotor.max_rot_velocity for rotor in tried.rotors])
    if piece.kind == FULL_SHARE_COMMANDS:
        supply = piece.voltage ** values.get("voltage", 0.0)
        commands = piece.commands * supply[:, None] * most
    else:
        commands = piece.commands
    speeds, slopes = np.empty((2, *commands.shape))
    speeds[0] = commands[0]
    compiled_rotor_speeds(commands, rotors, piece.period, speeds, slopes)
    late = (values.get("delay", 0.0) - piece.early) / piece.period
    speeds, slopes = delayed_samples(speeds, late), delayed_samples(slopes, late)
    if piece.kind == FULL_SHARE_COMMANDS:
        share = speeds / most
        curve = [values[f"curve_{power}"] for power in range(3)]
        thrust = curve[0] + curve[1] * share + curve[2] * share**2
        slope = curve[1] + 2.0 * curve[2] * share
        root = np.sqrt(np.maximum(thrust, 1e-4))
        slopes = 0.5 * slope / root * slopes
        speeds = root * most
    alpha, force = np.empty((2, len(speeds), 3))
    compiled_responses(
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
    turned = sensor_filtered(turned, values.get("gyro_delay", 0.0), piece.period)[:: piece.every]
    turn = np.diff(block_means(turned, piece.block), axis=0) / piece.row
    if piece.force_delay:
        force = sensor_filtered(force, piece.force_delay, piece.period)
    bias = [values.get(f"bias_{axis}", 0.0) for axis in "xyz"]
    return np.hstack([turn, block_means(force[:: piece.every], piece.block)[1:] + bias])
