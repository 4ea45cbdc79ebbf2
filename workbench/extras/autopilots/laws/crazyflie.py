"""PID cascade of the Crazyflie firmware 2025.12: position, velocity, attitude and rate.

Parameters have the firmware's names, with _ for its dot, its units, degrees, and its defaults.
Angles are roll, pitch and yaw; pitch has the firmware's legacy sign, nose up. x and y are forward
and left at the present yaw. A PID with gains kp, ki, kd, kff is

    i   <- clip(i + e dt, ±limit),   u = kp e + ki i - kd d(measured)/dt + kff desired

With e of each loop, at 102 Hz the position and velocity loops run

    v_d = clip(PID_pos(p_d - p), ±1.1 VelMax),   z: VelMax 0.5 m/s or more
    pitch_d = -clip(PID_vx(v_d - v), ±PLimit),   roll_d = -clip(PID_vy(v_d - v), ±RLimit)
    thrust  = clip(1000 PID_vz(v_d - v) + thrustBase, thrustMin .. 65535)

where the derivative of a velocity passes a second-order low-pass at 20 Hz. An axis without a
position command uses the commanded velocity instead of PID_pos; an axis with one ignores the
commanded velocity, also that of a path. Attitude and rate loops run at 512 Hz (500 Hz in the
firmware, and 100 Hz for the others); their outputs are clipped at ±32767:

    (p, q, r)_d = PID_att((roll, pitch, yaw)_d - (roll, pitch, yaw))
    (roll, pitch, yaw) = PID_rate((p, q, r)_d - (p, q, r))

The power distribution converts these to motor thrusts, with capped motors and battery
compensation, see `extras/autopilots/crazyflie_power.py`. The law returns their wrench.

Source: bitcraze/crazyflie-firmware, position_controller_pid.c, attitude_pid_controller.c, pid.c,
power_distribution_quadrotor.c, platform_defaults_cf2.h. docs/autopilots.md lists omissions.
"""

from workbench.common.parameter import Parameter
from workbench.controllers import (
    GRAVITY,
    POSITION_POINT,
    VELOCITY_POINT,
    Gains,
    KnownBody,
    KnownVehicle,
    LawResult,
    LawSetpoint,
    MeasuredMotion,
    Memory,
    Probes,
    State,
    arctan2,
    attitude_matrix,
    between,
    clipped,
    gain,
    into_body,
    level_heading,
    place_weights,
    position_error,
    probe,
    probe3,
    states,
    velocity_setpoint,
)
from workbench.controllers.pd_rule import rule as pd_rule
from workbench.extras.autopilots.betaflight_outer import RADIAN_DEG
from workbench.extras.autopilots.crazyflie_power import (
    FULL_MOTOR_SIGNAL,
    MOTOR_EFFECTS,
    larger_motors,
    motor_effects,
    power_distribution,
)
from workbench.extras.autopilots.filters import (
    LOWPASS_COEFFICIENTS,
    butterworth,
    second_order_filtered,
)
from workbench.extras.autopilots.loop_stages import (
    ATTITUDE_STAGE_POINT,
    RATE_SETPOINT_POINT,
    RATE_STAGE_POINT,
    TILT_SETPOINT_POINT,
    TORQUE_STAGE_POINT,
    stage_loops,
    stage_points,
)
from workbench.plant.vehicle import Vehicle

PERIOD = 1 / 512
DIVIDERS = (5,)
MAX_CRAZYFLIE_TORQUE = 32767.0
MAX_CLIMB_OUTPUT = 32.767
"""Largest output of the PID of climbing [1000 / 65535 of a motor's thrust]."""
PID_OUTPUT_OVERHEAD = 1.1
"""Largest output of a PID, over its limit."""
MIN_CLIMB_LIMIT = 0.5
"""Smallest limit of the vertical velocity [m/s]."""
DERIVATIVE_CUTOFF_HZ = 20.0
"""Cut-off of the low-pass after the derivative of a velocity [Hz]."""


def _rows(
    group: str, names: str, units: str, of: str, table: tuple[tuple[str, tuple[float, ...]], ...]
) -> tuple[Parameter, ...]:
    """Return rows of kp, ki, kd and kff by the firmware's names, for the values of each axis."""
    helps = ("P gain", "I gain", "D gain", "feedforward")
    return tuple(
        gain(
            f"{group}_{axis}{name}",
            each,
            (0.0, max(10.0, 20.0 * value)),
            value,
            f"{of} {how}, {axis.strip('v_')}",
            group,
        )
        for axis, values in table
        for name, each, how, value in zip(names.split(), units.split(), helps, values, strict=False)
    )


ANGLE_PREFIXES = ("roll_", "pitch_", "yaw_")
PARAMETERS = (
    *_rows(
        "posCtlPid",
        "Kp Ki",
        "1/s 1/s^2",
        "position",
        (("x", (2.0, 0.0)), ("y", (2.0, 0.0)), ("z", (2.0, 0.5))),
    ),
    gain("posCtlPid_xVelMax", "m/s", (0.05, 20.0), 1.0, "maximum velocity, x", "posCtlPid"),
    gain("posCtlPid_yVelMax", "m/s", (0.05, 20.0), 1.0, "maximum velocity, y", "posCtlPid"),
    gain("posCtlPid_zVelMax", "m/s", (0.05, 20.0), 1.0, "maximum velocity, z", "posCtlPid"),
    *_rows(
        "velCtlPid",
        "Kp Ki Kd KFF",
        "deg*s/m deg/m deg*s^2/m 1",
        "velocity",
        (
            ("vx", (25.0, 1.0, 0.0, 0.0)),
            ("vy", (25.0, 1.0, 0.0, 0.0)),
            ("vz", (25.0, 15.0, 0.0, 0.0)),
        ),
    ),
    gain("posCtlPid_rLimit", "deg", (1.0, 60.0), 20.0, "maximum roll", "posCtlPid"),
    gain("posCtlPid_pLimit", "deg", (1.0, 60.0), 20.0, "maximum pitch", "posCtlPid"),
    gain(
        "posCtlPid_thrustBase", "1", (0.0, FULL_MOTOR_SIGNAL), 36000.0, "hover thrust", "posCtlPid"
    ),
    gain(
        "posCtlPid_thrustMin", "1", (0.0, FULL_MOTOR_SIGNAL), 20000.0, "minimum thrust", "posCtlPid"
    ),
    *_rows(
        "pid_attitude",
        "kp ki kd kff",
        "1/s 1/s^2 1 1",
        "attitude",
        tuple(
            zip(
                ANGLE_PREFIXES,
                ((6.0, 3.0, 0.0, 0.0), (6.0, 3.0, 0.0, 0.0), (6.0, 1.0, 0.35, 0.0)),
                strict=True,
            )
        ),
    ),
    *_rows(
        "pid_rate",
        "kp ki kd kff",
        "s/deg 1/deg s^2/deg 1",
        "rate",
        tuple(
            zip(
                ANGLE_PREFIXES,
                ((250.0, 500.0, 2.5, 0.0), (250.0, 500.0, 2.5, 0.0), (120.0, 16.7, 0.0, 0.0)),
                strict=True,
            )
        ),
    ),
    gain("thrust_max", "N", (0.001, 100.0), 0.12, "motor thrust at full scale", "Motors"),
    gain("vbat", "V", (1.0, 60.0), 4.2, "full battery voltage", "Motors"),
)
MAX_ATTITUDE_INTEGRALS = (20.0, 20.0, 360.0)
MAX_RATE_INTEGRALS = (33.3, 33.3, 166.7)
"""Largest integrals of attitude [deg s] and rate [deg]."""
MAX_POSITION_INTEGRAL = 5000.0
"""Largest integral of position and velocity."""

MEMORY = (
    *states("i_position", "m*s"),
    *states("i_velocity", "m"),
    *states("velocity_before", "m/s"),
    *states("filter_1", "m/s^2"),
    *states("filter_2", "m/s^2"),
    *states("i_attitude", "deg*s"),
    *states("attitude_before", "deg"),
    *states("i_rate", "deg"),
    *states("rate_before", "deg/s"),
    *states("asked", "deg"),
    State("thrust", "1"),
    State("runs", "1"),
)

POINTS = stage_points("deg", "deg")


def _named(group: str, axis: str, names: str) -> tuple[str, ...]:
    return tuple(f"{group}_{axis}{name}" for name in names.split())


LOOPS = stage_loops(
    [_named("posCtlPid", axis, "Kp Ki") for axis in "xyz"],
    [_named("velCtlPid", f"v{axis}", "Kp Ki") for axis in "xyz"],
    [_named("pid_attitude", name, "kp ki") for name in ANGLE_PREFIXES],
    [_named("pid_rate", name, "kp ki kd") for name in ANGLE_PREFIXES],
)

DESIGNED = (
    *MOTOR_EFFECTS,
    *(f"filter_{name}" for name in LOWPASS_COEFFICIENTS),
)


def design(vehicle: KnownVehicle, g: Gains, dt: float) -> list[float]:
    """Return effects of each motor's thrust, the turning direction of m1, and the low-pass."""
    return [*motor_effects(vehicle.rotors), *butterworth(DERIVATIVE_CUTOFF_HZ, DIVIDERS[0] * dt)]


PidGains = tuple[float, float, float, float]
"""kp, ki, kd and kff."""


def limited_integral(integral: float, error: float, most: float, dt: float) -> float:
    """Return an integral after an update, within its limit."""
    return clipped(integral + error * dt, most)


def wrapped_degrees(angle: float) -> float:
    """Return an angle within ±180 degrees, of one within ±540."""
    if angle > 180.0:
        return angle - 360.0
    if angle < -180.0:
        return angle + 360.0
    return angle


def pid_output(e: float, i: float, rate: float, wanted: float, gains: PidGains) -> float:
    """Return the output of a PID.

    Args:
        e: its error.
        i: its integral.
        rate: of change of the measurement.
        wanted: its setpoint.
        gains: kp, ki, kd and kff.
    """
    kp, ki, kd, kff = gains
    return kp * e + ki * i - kd * rate + kff * wanted


def velocity_gains(g: Gains) -> tuple[PidGains, PidGains, PidGains]:
    """Return kp, ki, kd and kff of the velocity along x, y and z."""
    return (
        (g.velCtlPid_vxKp, g.velCtlPid_vxKi, g.velCtlPid_vxKd, g.velCtlPid_vxKFF),
        (g.velCtlPid_vyKp, g.velCtlPid_vyKi, g.velCtlPid_vyKd, g.velCtlPid_vyKFF),
        (g.velCtlPid_vzKp, g.velCtlPid_vzKi, g.velCtlPid_vzKd, g.velCtlPid_vzKFF),
    )


def attitude_gains(g: Gains) -> tuple[PidGains, PidGains, PidGains]:
    """Return kp, ki, kd and kff of roll, pitch and yaw."""
    return (
        (
            g.pid_attitude_roll_kp,
            g.pid_attitude_roll_ki,
            g.pid_attitude_roll_kd,
            g.pid_attitude_roll_kff,
        ),
        (
            g.pid_attitude_pitch_kp,
            g.pid_attitude_pitch_ki,
            g.pid_attitude_pitch_kd,
            g.pid_attitude_pitch_kff,
        ),
        (
            g.pid_attitude_yaw_kp,
            g.pid_attitude_yaw_ki,
            g.pid_attitude_yaw_kd,
            g.pid_attitude_yaw_kff,
        ),
    )


def rate_gains(g: Gains) -> tuple[PidGains, PidGains, PidGains]:
    """Return kp, ki, kd and kff of the rates of roll, pitch and yaw."""
    return (
        (g.pid_rate_roll_kp, g.pid_rate_roll_ki, g.pid_rate_roll_kd, g.pid_rate_roll_kff),
        (g.pid_rate_pitch_kp, g.pid_rate_pitch_ki, g.pid_rate_pitch_kd, g.pid_rate_pitch_kff),
        (g.pid_rate_yaw_kp, g.pid_rate_yaw_ki, g.pid_rate_yaw_kd, g.pid_rate_yaw_kff),
    )


def update(
    measured: MeasuredMotion,
    setpoint: LawSetpoint,
    g: Gains,
    vehicle: KnownBody,
    memory: Memory,
    dt: float,
    loops: Probes,
) -> LawResult:
    """Return the wrench in T, F [N] and m [N·m], and the memory."""
    m, v = memory, measured.v_WBcm
    R = attitude_matrix(measured.q_WT)
    cos, sin, level = level_heading(R)
    roll = RADIAN_DEG * arctan2(R[7], R[8])
    pitch = -RADIAN_DEG * arctan2(-R[6], level)
    yaw = RADIAN_DEG * arctan2(R[3], R[0])
    w = into_body(R, measured.w_WB)
    p, q, r = RADIAN_DEG * w[0], -RADIAN_DEG * w[1], RADIAN_DEG * w[2]
    first = m.runs < 0.5

    asked = velocity_setpoint((0.0, 0.0, 0.0), measured, setpoint, g)
    yaw_d = yaw if first else wrapped_degrees(m.asked_z + RADIAN_DEG * asked[3] * dt)

    v_x, v_y, v_z = cos * v[0] + sin * v[1], cos * v[1] - sin * v[0], v[2]
    roll_d, pitch_d, thrust = m.asked_x, m.asked_y, m.thrust
    i_x, i_y, i_z = m.i_position_x, m.i_position_y, m.i_position_z
    i_vx, i_vy, i_vz = m.i_velocity_x, m.i_velocity_y, m.i_velocity_z
    before = m.velocity_before_x, m.velocity_before_y, m.velocity_before_z
    one = m.filter_1_x, m.filter_1_y, m.filter_1_z
    two = m.filter_2_x, m.filter_2_y, m.filter_2_z
    e_W = position_error(measured, setpoint)
    e = cos * e_W[0] + sin * e_W[1], cos * e_W[1] - sin * e_W[0], e_W[2]
    x, y, z = probe3(e, POSITION_POINT, loops)
    since = measured.elapsed[0]
    if since > 0.0 or first:
        period = since if since > 0.0 else DIVIDERS[0] * dt
        i_x = limited_integral(i_x, x, MAX_POSITION_INTEGRAL, period)
        i_y = limited_integral(i_y, y, MAX_POSITION_INTEGRAL, period)
        i_z = limited_integral(i_z, z, MAX_POSITION_INTEGRAL, period)
        climb = g.posCtlPid_zVelMax
        climb = climb if climb > MIN_CLIMB_LIMIT else MIN_CLIMB_LIMIT + 0.0 * climb
        s_x = clipped(
            g.posCtlPid_xKp * x + g.posCtlPid_xKi * i_x, PID_OUTPUT_OVERHEAD * g.posCtlPid_xVelMax
        )
        s_y = clipped(
            g.posCtlPid_yKp * y + g.posCtlPid_yKi * i_y, PID_OUTPUT_OVERHEAD * g.posCtlPid_yVelMax
        )
        s_z = clipped(g.posCtlPid_zKp * z + g.posCtlPid_zKi * i_z, PID_OUTPUT_OVERHEAD * climb)
        path, hold_xy, hold_z = place_weights(setpoint)
        placed, risen = path + hold_xy, path + hold_z
        reference = setpoint.reference
        back = (
            placed * (cos * s_x - sin * s_y) - path * reference[0],
            placed * (sin * s_x + cos * s_y) - path * reference[1],
            risen * s_z - path * reference[2],
        )
        s_W = velocity_setpoint(back, measured, setpoint, g)
        s_x, s_y, s_z = cos * s_W[0] + sin * s_W[1], cos * s_W[1] - sin * s_W[0], s_W[2]
        e_x, e_y, e_z = s_x - v_x, s_y - v_y, s_z - v_z
    else:
        s_x, s_y, s_z, period = 0.0 * x, 0.0 * x, 0.0 * x, dt
        e_x, e_y, e_z = 0.0 * x, 0.0 * x, 0.0 * x
    e_x, e_y, e_z = probe3((e_x, e_y, e_z), VELOCITY_POINT, loops)
    if since > 0.0 or first:
        if first:
            before = v_x, v_y, v_z
        slope = (v_x - before[0]) / period, (v_y - before[1]) / period, (v_z - before[2]) / period
        low = (g.filter_b0, g.filter_b1, g.filter_b2, g.filter_a1, g.filter_a2)
        (d_x, d_y, d_z), now = second_order_filtered(slope, one, two, low)
        i_vx = limited_integral(i_vx, e_x, MAX_POSITION_INTEGRAL, period)
        i_vy = limited_integral(i_vy, e_y, MAX_POSITION_INTEGRAL, period)
        i_vz = limited_integral(i_vz, e_z, MAX_POSITION_INTEGRAL, period)
        for_x, for_y, for_z = velocity_gains(g)
        ahead = pid_output(e_x, i_vx, d_x, s_x, for_x)
        left = pid_output(e_y, i_vy, d_y, s_y, for_y)
        up = pid_output(e_z, i_vz, d_z, s_z, for_z)
        two, one, before = one, now, (v_x, v_y, v_z)
        pitch_d = -clipped(
            clipped(ahead, PID_OUTPUT_OVERHEAD * g.posCtlPid_pLimit), g.posCtlPid_pLimit
        )
        roll_d = -clipped(
            clipped(left, PID_OUTPUT_OVERHEAD * g.posCtlPid_rLimit), g.posCtlPid_rLimit
        )
        thrust = 1000.0 * clipped(up, MAX_CLIMB_OUTPUT) + g.posCtlPid_thrustBase
        thrust = between(thrust, g.posCtlPid_thrustMin, FULL_MOTOR_SIGNAL)

    # the firmware's pitch is positive nose up, that of the loop points about y of T
    roll_sp = probe(roll_d, TILT_SETPOINT_POINT, loops)
    pitch_sp = -probe(-pitch_d, TILT_SETPOINT_POINT + 1, loops)
    errors = roll_sp - roll, pitch_sp - pitch, wrapped_degrees(yaw_d - yaw)
    e_x, e_y, e_z = probe3(errors, ATTITUDE_STAGE_POINT, loops)
    i_roll = limited_integral(m.i_attitude_x, e_x, MAX_ATTITUDE_INTEGRALS[0], dt)
    i_pitch = limited_integral(m.i_attitude_y, e_y, MAX_ATTITUDE_INTEGRALS[1], dt)
    i_yaw = limited_integral(m.i_attitude_z, e_z, MAX_ATTITUDE_INTEGRALS[2], dt)
    slope_x = 0.0 * roll if first else (roll - m.attitude_before_x) / dt
    slope_y = 0.0 * roll if first else (pitch - m.attitude_before_y) / dt
    slope_z = 0.0 * roll if first else wrapped_degrees(yaw - m.attitude_before_z) / dt
    for_roll, for_pitch, for_yaw = attitude_gains(g)
    p_d = pid_output(e_x, i_roll, slope_x, roll_sp, for_roll)
    q_d = pid_output(e_y, i_pitch, slope_y, pitch_sp, for_pitch)
    r_d = pid_output(e_z, i_yaw, slope_z, yaw_d, for_yaw)
    p_d = probe(p_d, RATE_SETPOINT_POINT, loops)
    q_d = -probe(-q_d, RATE_SETPOINT_POINT + 1, loops)

    e_p, e_q, e_r = probe3((p_d - p, q_d - q, r_d - r), RATE_STAGE_POINT, loops)
    i_p = limited_integral(m.i_rate_x, e_p, MAX_RATE_INTEGRALS[0], dt)
    i_q = limited_integral(m.i_rate_y, e_q, MAX_RATE_INTEGRALS[1], dt)
    i_r = limited_integral(m.i_rate_z, e_r, MAX_RATE_INTEGRALS[2], dt)
    slope_x = 0.0 * roll if first else (p - m.rate_before_x) / dt
    slope_y = 0.0 * roll if first else (q - m.rate_before_y) / dt
    slope_z = 0.0 * roll if first else (r - m.rate_before_z) / dt
    for_roll, for_pitch, for_yaw = rate_gains(g)
    t_x = clipped(pid_output(e_p, i_p, slope_x, p_d, for_roll), MAX_CRAZYFLIE_TORQUE)
    t_y = clipped(pid_output(e_q, i_q, slope_y, q_d, for_pitch), MAX_CRAZYFLIE_TORQUE)
    t_z = clipped(pid_output(e_r, i_r, slope_z, r_d, for_yaw), MAX_CRAZYFLIE_TORQUE)
    t_x, t_y, t_z = probe3((t_x, t_y, t_z), TORQUE_STAGE_POINT, loops)

    wrench = power_distribution(thrust, (t_x, t_y, t_z), g, g.vbat * measured.voltage)
    outer = (i_x, i_y, i_z, i_vx, i_vy, i_vz, *before, *one, *two)
    inner = (i_roll, i_pitch, i_yaw, roll, pitch, yaw, i_p, i_q, i_r, p, q, r)
    return wrench, (*outer, *inner, roll_d, pitch_d, yaw_d, thrust, 1.0 + 0.0 * thrust)


def rule(vehicle: Vehicle) -> dict[str, float]:
    """Return values for a vehicle; the firmware's for one of a Crazyflie's size.

    For others the gains of the PD cascade in this form: rate kp = kd, attitude kp = 0.3 kd, and
    integrals and derivatives in the firmware's proportions.
    """
    motors = larger_motors(vehicle)
    if motors is None:
        return {}
    pd = pd_rule(vehicle)
    values = {
        "thrust_max": motors.thrust_max,
        "posCtlPid_thrustMin": 0.3 * FULL_MOTOR_SIGNAL,
        "spin_up_feedforward": pd["spin_up_feedforward"],
        "max_climb_rate": pd["max_climb_rate"],
    }
    for axis, kp in (("roll", "kd_roll"), ("pitch", "kd_pitch"), ("yaw", "kp_yaw_rate")):
        rate = pd[kp] / RADIAN_DEG / getattr(motors, axis)
        values[f"pid_rate_{axis}_kp"] = rate
        values[f"pid_rate_{axis}_ki"] = (0.14 if axis == "yaw" else 2.0) * rate
        values[f"pid_rate_{axis}_kd"] = (0.0 if axis == "yaw" else 0.01) * rate
        values[f"pid_attitude_{axis}_kp"] = 0.3 * pd[kp]
        values[f"pid_attitude_{axis}_ki"] = 0.03 * pd[kp]
        values[f"pid_attitude_{axis}_kd"] = 0.0
    for axis in "xy":
        values[f"velCtlPid_v{axis}Kp"] = RADIAN_DEG * pd[f"kp_velocity_{axis}"] / GRAVITY
        values[f"velCtlPid_v{axis}Ki"] = 0.04 * values[f"velCtlPid_v{axis}Kp"]
        values[f"posCtlPid_{axis}Kp"] = pd["kp_position_xy"]
    climb = vehicle.mass * FULL_MOTOR_SIGNAL / (1000.0 * len(vehicle.rotors) * motors.thrust_max)
    values["velCtlPid_vzKp"] = pd["kp_velocity_z"] * climb
    values["velCtlPid_vzKi"] = 0.6 * values["velCtlPid_vzKp"]
    values["posCtlPid_zKp"] = pd["kp_position_z"]
    values["posCtlPid_zKi"] = 0.25 * pd["kp_position_z"]
    return values
