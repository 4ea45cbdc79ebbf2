"""ArduPilot Copter's control (4.7's sources), written anew, in its own frames: NED and FRD.

Sources: libraries/AC_AttitudeControl (AC_PosControl, AC_AttitudeControl, AC_AttitudeControl_Multi),
AC_PID (AC_PID, AC_PID_2D, AC_PID_Basic, AC_P_1D, AC_P_2D), AP_Math/control.cpp, AP_Motors
(AP_MotorsMatrix, AP_Motors_Thrust_Linearization). Limits that the motors report count for the next
loop. All filters begin at rest, at their first samples.

Left out as the law leaves it out, see docs/autopilots.md: a shaped target is damped in both
directions, a level acceleration is cut whatever the way, and parts run from the outer to the inner.
"""

from functools import cache

import numpy as np
from motion import (
    R_FRD_FLU,
    R_NED_ENU,
    cross,
    inverse,
    matrix,
    multiply,
    quaternion,
    thrust_at,
    wrench,
)
from scipy.signal import butter

UP = np.array([0.0, 0.0, -1.0])
THRUST_ERROR = np.radians(30.0)
YAW_ERROR = np.radians(45.0)
THROTTLE_CUTOFF = 2.0
AXES = "RLL", "PIT", "YAW"
ROUNDING = 1e-12
"""Yaw is cut so that a motor just reaches its end: that is no cut of roll and pitch."""


class Pid:
    """AC_PID: filters on target, error and its slope; a limit lets the integral only shrink."""

    def __init__(self):
        self.began, self.integral, self.slope = False, 0.0, 0.0

    def update(self, g, name, target, measured, dt, limit, imax=None):
        """Return P + I + D, and the feed-forward."""
        p, i, d, ff, most = (getattr(g, f"{name}_{x}") for x in ("P", "I", "D", "FF", "IMAX"))
        hz = {x: getattr(g, f"{name}_{x}") for x in ("FLTT", "FLTE", "FLTD")}
        if self.began:
            before = self.error
            self.target += alpha(hz["FLTT"], dt) * (target - self.target)
            self.error += alpha(hz["FLTE"], dt) * (self.target - measured - self.error)
            self.slope += alpha(hz["FLTD"], dt) * ((self.error - before) / dt - self.slope)
        else:
            self.began, self.target, self.error = True, target, target - measured
        if i == 0.0:
            self.integral = 0.0
        elif not limit or self.integral * self.error < 0.0:
            most = most if imax is None else imax
            self.integral = min(max(self.integral + self.error * i * dt, -most), most)
        return p * self.error + self.integral + d * self.slope, ff * self.target


class ArduPilot:
    """Position controller, attitude controller and motors of one vehicle, with parameters `g`."""

    def __init__(self, g, vehicle, gravity=9.80665):
        self.g, self.gravity = g, gravity
        self.motors = Motors(g, vehicle.rotors)
        self.ne_error, self.ne_slope, self.ne_integral = None, np.zeros(2), np.zeros(2)
        self.ne_limit = np.zeros(2)
        self.d_error, self.d_slope, self.d_integral = None, 0.0, 0.0
        self.climb = Pid()
        self.rates = [Pid() for _ in AXES]
        self.target, self.w_target, self.a_target = None, np.zeros(3), np.zeros(3)
        self.gyro = None

    def update(self, motion, wish, dt, _elapsed):
        """Return the wrench."""
        R = R_NED_ENU @ motion.R @ R_FRD_FLU
        q = quaternion(R)
        gyro = self.filtered(R_FRD_FLU @ motion.w, dt)
        if self.target is None:
            self.target = q
        thrust_vector = np.array([*self.level(motion, wish, dt), -self.gravity])
        throttle = self.vertical(motion, wish, dt)
        w, feedforward = self.attitude(q, thrust_vector, -wish.yaw_rate, gyro, dt)
        outputs = []
        for i, axis in enumerate(AXES):
            limit = self.motors.limits[i]
            pid, ff = self.rates[i].update(self.g, f"ATC_RAT_{axis}", w[i], gyro[i], dt, limit)
            outputs.append(pid + ff * (feedforward if axis == "YAW" else 1.0))
        return self.motors.output(outputs, throttle, R[2, 2], dt)

    def filtered(self, gyro, dt):
        """Return the rates behind INS_GYRO_FILTER, of second order."""
        cutoff = self.g.INS_GYRO_FILTER
        if not 0.0 < cutoff < 0.5 / dt:
            return gyro
        b, a = low_pass(cutoff, dt)
        x1, x2, y1, y2 = self.gyro or (gyro, gyro, gyro, gyro)
        y = b[0] * gyro + b[1] * x1 + b[2] * x2 - a[1] * y1 - a[2] * y2
        self.gyro = (gyro, x1, y, y1)
        return y

    def level(self, motion, wish, dt):
        """NE_update_controller: return the acceleration to north and east."""
        g = self.g
        v_desired, a_desired = (R_NED_ENU @ wish.v)[:2], (R_NED_ENU @ wish.a)[:2]
        error = (R_NED_ENU @ (wish.p - motion.p))[:2] * wish.holds_xy
        if g.PSC_NE_POS_P > 0.0:  # AC_P_2D::set_limits: without P there is none
            most = inv_sqrt_controller(g.WP_SPD, g.PSC_NE_POS_P, g.WP_ACC)
            error = shortened(error, most)
        length = np.linalg.norm(error)
        v = v_desired.copy()
        if length > 0.0:
            v += error / length * sqrt_controller(length, g.PSC_NE_POS_P, g.WP_ACC, 0.0)
        error = v - (R_NED_ENU @ motion.v)[:2]
        if self.ne_error is None:
            self.ne_error = error
        before = self.ne_error
        self.ne_error = before + alpha(g.PSC_NE_VEL_FLTE, dt) * (error - before)
        slope = (self.ne_error - before) / dt
        self.ne_slope = self.ne_slope + alpha(g.PSC_NE_VEL_FLTD, dt) * (slope - self.ne_slope)
        grown = self.ne_error * g.PSC_NE_VEL_I * dt
        length = np.linalg.norm(self.ne_integral)
        self.ne_integral = self.ne_integral + grown
        if grown @ self.ne_limit > 0.0:
            self.ne_integral = shortened(self.ne_integral, length)
        self.ne_integral = shortened(self.ne_integral, g.PSC_NE_VEL_IMAX)
        a = g.PSC_NE_VEL_P * self.ne_error + self.ne_integral + g.PSC_NE_VEL_D * self.ne_slope
        a = a + a_desired
        most = self.gravity * np.tan(np.radians(g.ATC_ANGLE_MAX))
        limited = a @ a > most**2
        self.ne_limit = a if limited else np.zeros(2)
        return shortened(a, most)

    def vertical(self, motion, wish, dt):
        """D_update_controller: return the throttle without the boost of a tilt."""
        g = self.g
        lower, upper = self.motors.limits[3:]
        error = -(wish.p[2] - motion.p[2]) * wish.holds_z
        if g.PSC_D_POS_P > 0.0:
            up = inv_sqrt_controller(g.WP_SPD_UP, g.PSC_D_POS_P, g.WP_ACC_Z)
            down = inv_sqrt_controller(g.WP_SPD_DN, g.PSC_D_POS_P, g.WP_ACC_Z)
            error = min(max(error, -up), down)
        v = sqrt_controller(error, g.PSC_D_POS_P, g.WP_ACC_Z, 0.0) - wish.v[2]
        error = v + motion.v[2]
        if self.d_error is None:
            self.d_error = error
        before = self.d_error
        self.d_error = before + alpha(g.PSC_D_VEL_FLTE, dt) * (error - before)
        slope = (self.d_error - before) / dt
        self.d_slope += alpha(g.PSC_D_VEL_FLTD, dt) * (slope - self.d_slope)
        if g.PSC_D_VEL_I == 0.0:
            self.d_integral = 0.0
        elif not ((lower and self.d_error > 0.0) or (upper and self.d_error < 0.0)):
            most = g.PSC_D_VEL_IMAX
            grown = self.d_integral + self.d_error * g.PSC_D_VEL_I * dt
            self.d_integral = min(max(grown, -most), most)
        a = g.PSC_D_VEL_P * self.d_error + self.d_integral + g.PSC_D_VEL_D * self.d_slope
        a -= wish.a[2]
        most = max(g.PSC_D_ACC_IMAX, g.MOT_THST_HOVER)
        pid, ff = self.climb.update(g, "PSC_D_ACC", a, -motion.a[2], dt, lower or upper, most)
        return g.MOT_THST_HOVER - pid - ff

    def attitude(self, q, thrust_vector, heading_rate, gyro, dt):
        """input_thrust_vector_rate_heading: return the rates and the share of feed-forward."""
        g = self.g
        self.target = normalised(multiply(self.target, from_axis_angle(self.w_target * dt)))
        turn, error, _ = thrust_rotation(from_thrust_vector(thrust_vector), self.target)
        if g.ATC_RATE_FF_ENAB > 0.5 and g.firmware < 4.7:
            tops = [np.radians(getattr(g, f"ATC_RATE_{name}_MAX")) for name in "RPY"]
            for i, name in enumerate("RPY"):
                accel = np.radians(getattr(g, f"ATC_ACC_{name}_MAX"))
                wanted = heading_rate
                if name != "Y":
                    wanted = sqrt_controller(error[i], 1.0 / max(g.ATC_INPUT_TC, 0.01), accel, dt)
                self.w_target[i] = input_shaping_ang_vel(self.w_target[i], wanted, accel, dt)
            self.w_target, self.a_target = limit_rates(self.w_target, *tops), np.zeros(3)
        elif g.ATC_RATE_FF_ENAB > 0.5:
            for i, name in enumerate("RPY"):
                most = np.radians(getattr(g, f"ATC_RATE_{name}_MAX"))
                accel = np.radians(getattr(g, f"ATC_ACC_{name}_MAX")) or np.radians(1800.0)
                now = self.w_target[i], self.a_target[i]
                if name == "Y":
                    self.a_target[i] = shaped_rate(heading_rate, *now, accel, dt)
                else:
                    self.a_target[i] = shaped(error[i], *now, most, accel, g.ATC_INPUT_TC, dt)
                self.w_target[i] += self.a_target[i] * dt
        else:
            yaw = from_axis_angle(np.array([0.0, 0.0, heading_rate * dt]))
            self.target = normalised(multiply(multiply(self.target, turn), yaw))
            self.w_target, self.a_target = np.zeros(3), np.zeros(3)
        return self.run_quat(q, gyro, dt)

    def run_quat(self, q, gyro, dt):
        """attitude_controller_run_quat."""
        g = self.g
        turn, error, angle = thrust_rotation(self.target, q)
        accel_yaw = accel_of(g.ATC_ACC_Y_MAX, 10.0, 120.0)
        if g.ATC_RAT_YAW_P > 0.0:
            most = inv_sqrt_controller(1.0 / g.ATC_RAT_YAW_P, g.ATC_ANG_YAW_P, accel_yaw)
            most = min(most, YAW_ERROR)
            if g.ATC_ANG_YAW_P > 0.0 and abs(error[2]) > most:
                error[2] = min(max(error[2], -most), most)
                yaw = from_axis_angle(np.array([0.0, 0.0, error[2]]))
                self.target = multiply(multiply(q, turn), yaw)
        w = np.empty(3)
        for i, (axis, name) in enumerate(zip(AXES, "RPY", strict=True)):
            p, acc = getattr(g, f"ATC_ANG_{axis}_P"), getattr(g, f"ATC_ACC_{name}_MAX")
            limits = (10.0, 120.0) if name == "Y" else (40.0, 720.0)
            lim = accel_of(acc, *limits) if acc else 0.0
            w[i] = sqrt_controller(error[i], p, lim, dt) if acc else p * error[i]
        w = limit_rates(w, *(np.radians(getattr(g, f"ATC_RATE_{x}_MAX")) for x in "RPY"))
        feedforward = matrix(multiply(inverse(q), self.target)) @ self.w_target
        share = 1.0
        if angle > 2.0 * THRUST_ERROR:
            w[2] = gyro[2]
        elif angle > THRUST_ERROR:
            share = 1.0 - (angle - THRUST_ERROR) / THRUST_ERROR
            w[:2] += feedforward[:2] * share
            w[2] = gyro[2] * (1.0 - share) + (w[2] + feedforward[2]) * share
        else:
            w = w + feedforward
        return w, share


class Motors:
    """AP_MotorsMatrix and the thrust's linearisation; limits of roll, pitch, yaw, low and high."""

    def __init__(self, g, rotors):
        self.g, self.rotors = g, rotors
        moments = np.array([R_FRD_FLU @ rotor.moment for rotor in rotors])
        self.factors = 0.5 * moments / np.max(np.abs(moments), axis=0)
        self.limits = [False] * 5
        self.throttle = None

    def output(self, rpy, throttle_in, cos_tilt, dt):
        """Return the wrench for roll, pitch and yaw, and a throttle."""
        g = self.g
        boosted = throttle_in
        if g.ATC_ANGLE_BOOST > 0.5:
            boosted *= min(max(10.0 * cos_tilt, 0.0), 1.0) / min(max(cos_tilt, 0.1), 1.0)
        most = min(max(max(throttle_in, boosted), 0.0), 1.0)
        mix = g.ATC_THR_MIX_MAX
        average = max(most, most * max(0.0, 1.0 - mix) + g.MOT_THST_HOVER * mix)
        if self.throttle is None:
            self.throttle = boosted
        self.throttle += alpha(THROTTLE_CUTOFF, dt) * (boosted - self.throttle)
        self.throttle = min(max(self.throttle, 0.0), 1.0)
        thrusts = self.mixed(*rpy, self.throttle, average)
        signals = [self.actuator(x) for x in thrusts]
        speeds = [g.motor_speed * x for x in signals]
        return wrench(
            self.rotors, [thrust_at(r, w) for r, w in zip(self.rotors, speeds, strict=True)]
        )

    def mixed(self, roll, pitch, yaw, throttle, average):
        """output_armed_stabilizing: return the motors' thrusts, and set the limits."""
        limit_yaw, lower, upper = False, throttle <= 0.0, throttle >= 1.0
        average = min(max(average, throttle), 1.0)
        best = min(0.5, average)
        by_yaw = self.factors[:, 2]
        out = self.factors[:, :2] @ [roll, pitch]
        allowed = 1.0
        for x, factor in zip(out, by_yaw, strict=True):
            room = 1.0 - (best + x) if yaw * factor > 0.0 else best + x
            if factor:
                allowed = min(allowed, abs(max(room, 0.0) / factor))
        allowed = max(allowed, 0.001 * self.g.MOT_YAW_HEADROOM)
        if abs(yaw) > allowed:
            yaw, limit_yaw = min(max(yaw, -allowed), allowed), True
        out = out + yaw * by_yaw
        low, high = np.min(out), np.max(out)
        scale = min(1.0, 1.0 / (high - low)) if high > low + 1.0 + ROUNDING else 1.0
        if average + low < -ROUNDING:
            scale = min(scale, -average / low)
        low, high = low * scale, high * scale
        best, extra = -low, throttle + low
        limited = scale < 1.0
        if limited:
            upper = upper or extra > ROUNDING
            extra = 0.0
        elif extra < 0.0:
            extra = 0.0
        elif extra > 1.0 - (best + high) + ROUNDING:
            extra, upper = 1.0 - (best + high), True
        self.limits = [limited, limited, limited or limit_yaw, lower, upper]
        return best + extra + scale * out

    def actuator(self, thrust):
        """Return a motor's signal: the inverse of a thrust curve between the ends of its range."""
        g, e = self.g, self.g.MOT_THST_EXPO
        t = min(max(thrust, 0.0), 1.0)
        ratio = t if e == 0.0 else (e - 1.0 + np.sqrt((1.0 - e) ** 2 + 4.0 * e * t)) / (2.0 * e)
        return g.MOT_SPIN_MIN + (g.MOT_SPIN_MAX - g.MOT_SPIN_MIN) * min(max(ratio, 0.0), 1.0)


@cache
def low_pass(hz, dt):
    """Return the coefficients of a filter of second order."""
    return butter(2, hz, fs=1.0 / dt)


def alpha(hz, dt):
    """calc_lowpass_alpha_dt: 1 where there is no filter."""
    return dt / (dt + 1.0 / (2.0 * np.pi * hz)) if hz > 0.0 else 1.0


def sqrt_controller(error, p, second, dt):
    """Return the rate for an error, whose slope is within a limit; 0 sets none."""
    if second <= 0.0:
        rate = error * p
    elif p == 0.0:
        rate = np.sign(error) * np.sqrt(2.0 * second * abs(error))
    else:
        linear = second / p**2
        rate = error * p
        if abs(error) > linear:
            rate = np.sign(error) * np.sqrt(2.0 * second * (abs(error) - 0.5 * linear))
    return min(max(rate, -abs(error) / dt), abs(error) / dt) if dt > 0.0 else rate


def inv_sqrt_controller(output, p, second):
    """Return the error that makes an output."""
    if p == 0.0 or second <= 0.0:
        if p == 0.0:
            return output**2 / (2.0 * second) if second > 0.0 else 0.0
        return output / p
    if abs(output) < second / p:
        return output / p
    return np.sign(output) * (0.5 * second / p**2 + output**2 / (2.0 * second))


def input_shaping_ang_vel(rate, wanted, accel_max, dt):
    """Of 4.3 to 4.6, with PILOT_Y_RATE_TC 0: return the target's rate."""
    if accel_max <= 0.0:
        return wanted
    return min(max(wanted, rate - accel_max * dt), rate + accel_max * dt)


def shaped(angle, rate, accel, rate_max, accel_max, tc, dt):
    """shape_angle_vel_accel of 4.7, to rest, for an angle left to go: return the acceleration."""
    angle = (angle + np.pi) % (2.0 * np.pi) - np.pi
    jerk_max = accel_max / tc
    k = jerk_max / accel_max
    command = sqrt_controller(angle, k, accel_max, dt)
    inside = abs(angle) <= accel_max / k**2
    command -= (k if inside else accel_max / abs(command)) * rate / k
    if rate_max > 0.0:
        command = min(max(command, -rate_max), rate_max)
    return shaped_accel((command - rate) * k, accel, accel_max, jerk_max, dt)


def shaped_rate(wanted, rate, accel, accel_max, dt):
    """The yaw rate's shaping, by a PILOT_Y_RATE_TC of 0: ten loops of 400 Hz."""
    tc = 10.0 / 400.0
    return shaped_accel((wanted - rate) / tc, accel, accel_max, accel_max / tc, dt)


def shaped_accel(wanted, accel, accel_max, jerk_max, dt):
    """shape_accel: return an acceleration whose slope is within the jerk."""
    wanted = min(max(wanted, -accel_max), accel_max)
    return accel + min(max(wanted - accel, -jerk_max * dt), jerk_max * dt)


def accel_of(degrees, least, most):
    """Return half an acceleration within limits, all in deg/s² [rad/s²]."""
    return np.radians(min(max(0.5 * degrees, least), most))


def limit_rates(w, roll, pitch, yaw):
    """ang_vel_limit: roll and pitch together; 0 sets no limit."""
    w = w.copy()
    if roll and pitch:
        length = np.hypot(w[0] / roll, w[1] / pitch)
        w[:2] /= max(length, 1.0)
    else:
        for i, most in ((0, roll), (1, pitch)):
            if most:
                w[i] = min(max(w[i], -most), most)
    if yaw:
        w[2] = min(max(w[2], -yaw), yaw)
    return w


def shortened(v, most):
    """Return a vector no longer than `most`."""
    length = np.linalg.norm(v)
    return v * (most / length) if length > most else v


def normalised(q):
    return q / np.linalg.norm(q)


def from_axis_angle(v):
    """Return the quaternion of a rotation vector."""
    angle = np.linalg.norm(v)
    if angle == 0.0:
        return np.array([1.0, 0.0, 0.0, 0.0])
    return np.array([np.cos(0.5 * angle), *(np.sin(0.5 * angle) * v / angle)])


def axis_angle(q):
    """to_axis_angle: return the rotation vector, within half a turn."""
    length = np.linalg.norm(q[1:])
    if length == 0.0:
        return np.zeros(3)
    angle = 2.0 * np.arctan2(length, q[0])
    angle = (angle + np.pi) % (2.0 * np.pi) - np.pi
    return q[1:] / length * angle


def from_thrust_vector(v):
    """attitude_from_thrust_vector, with no heading."""
    v = v / np.linalg.norm(v)
    normal = cross(UP, v)
    length = np.linalg.norm(normal)
    axis = normal / length if length > 0.0 else UP
    return from_axis_angle(axis * np.arctan2(length, UP @ v))


def thrust_rotation(target, body):
    """thrust_vector_rotation_angles: return the correction, the error and the thrust's error."""
    wanted, now = matrix(target) @ UP, matrix(body) @ UP
    normal = cross(now, wanted)
    length = np.linalg.norm(normal)
    angle = np.arctan2(length, now @ wanted)
    axis = normal / length if length > 0.0 else UP
    turn = from_axis_angle(matrix(body).T @ axis * angle)
    heading = axis_angle(multiply(multiply(inverse(turn), inverse(body)), target))
    error = axis_angle(turn)
    return turn, np.array([error[0], error[1], heading[2]]), angle
