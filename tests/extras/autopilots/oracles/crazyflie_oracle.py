"""The Crazyflie's PID controller (firmware 2025.12), written anew, in its legacy signs and units.

Sources: src/modules/src/controller/ (controller_pid, position_controller_pid,
attitude_pid_controller), src/utils/src/pid.c, power_distribution_quadrotor.c, and the battery's
compensation of src/drivers/src/motors.c with the numbers of the 2.1+.

Angles are in degrees and pitch is positive nose up, so state.attitude.pitch and gyro.y are of the
other sign than about y of FLU. control.yaw is positive to the right. Thrusts are in 65535ths.
"""

import numpy as np
from motion import clip, wrench
from scipy.optimize import brentq

FULL = 65535.0
VMOTOR2THRUST = (-0.02476537915958403, 0.06523793527519485, -0.026792504967750107)
VMOTOR2THRUST += (0.006776789303971145,)
THRUST_MAX = 0.12
"""Of the motor that VMOTOR2THRUST is of [N]."""
ROLL_LIMIT, YAW_LIMIT = 20.0, 360.0
RATE_LIMIT, YAW_RATE_LIMIT = 33.3, 166.7
DEFAULT_LIMIT = 5000.0
"""DEFAULT_PID_INTEGRATION_LIMIT."""


class Pid:
    """pid.c: the integral is clipped, then multiplied; D is on the measurement.

    It begins at the first measurement, which the firmware takes to be 0 for rates and velocities.
    """

    def __init__(self, limit, cutoff=None):
        self.limit, self.before, self.cutoff, self.integral = limit, None, cutoff, 0.0
        self.delay = [0.0, 0.0]

    def update(self, gains, desired, measured, dt, most=0.0, yaw=False):
        """Return the output for gains kp, ki, kd, kff; `most` 0 sets no limit."""
        kp, ki, kd, kff = gains
        before = measured if self.before is None else self.before
        error, delta = desired - measured, before - measured
        if yaw:
            error, delta = wrapped(error), wrapped(delta)
        slope = delta / dt if self.cutoff is None else self.filtered(delta / dt, dt)
        self.integral = clip(self.integral + error * dt, self.limit)
        self.before = measured
        output = kp * error + kd * slope + ki * self.integral + kff * desired
        return clip(output, most) if most else output

    def filtered(self, sample, dt):
        """lpf2pApply: direct form 2."""
        ohm = np.tan(np.pi * self.cutoff * dt)
        c = 1.0 + np.sqrt(2.0) * ohm + ohm**2
        b = ohm**2 / c * np.array([1.0, 2.0, 1.0])
        a = 2.0 * (ohm**2 - 1.0) / c, (1.0 - np.sqrt(2.0) * ohm + ohm**2) / c
        first = sample - a[0] * self.delay[0] - a[1] * self.delay[1]
        output = b @ [first, *self.delay]
        self.delay = [first, self.delay[0]]
        return output


class Crazyflie:
    """The PID cascade down to the motors of one vehicle, with its parameters `g`."""

    def __init__(self, g, vehicle):
        self.g, self.vehicle = g, vehicle
        self.x, self.y, self.z = (Pid(DEFAULT_LIMIT, cutoff=20.0) for _ in "xyz")
        self.vx, self.vy, self.vz = (Pid(DEFAULT_LIMIT, cutoff=20.0) for _ in "xyz")
        self.rates = Pid(RATE_LIMIT), Pid(RATE_LIMIT), Pid(YAW_RATE_LIMIT)
        self.attitudes = Pid(ROLL_LIMIT), Pid(ROLL_LIMIT), Pid(YAW_LIMIT)
        self.began = False
        self.desired, self.thrust = np.zeros(3), 0.0

    def update(self, motion, wish, dt, elapsed):
        """Return the wrench; `elapsed` of the position's part, 0 if it is not due."""
        g = self.g
        attitude = legacy_attitude(motion.R)
        gyro = np.degrees(motion.w) * [1.0, -1.0, 1.0]
        if self.began:
            self.desired[2] = wrapped(self.desired[2] + np.degrees(wish.yaw_rate) * dt)
        else:
            self.desired = attitude.copy()
        self.began = True
        if elapsed[0] > 0.0:
            self.position(motion, wish, np.radians(attitude[2]), elapsed[0])
        names = "roll", "pitch", "yaw"
        control = []
        for i, name in enumerate(names):
            gains = gains_of(g, f"pid_attitude_{name}_"), gains_of(g, f"pid_rate_{name}_")
            args = self.desired[i], attitude[i], dt
            wanted = self.attitudes[i].update(gains[0], *args, yaw=name == "yaw")
            control.append(clip(self.rates[i].update(gains[1], wanted, gyro[i], dt), 32767.0))
        roll, pitch, yaw = control[0], control[1], -control[2]
        return motors_wrench(g, self.vehicle, self.thrust, roll, pitch, yaw, motion.voltage)

    def position(self, motion, wish, yaw, dt):
        """positionController and velocityController, in the axes of the heading."""
        g = self.g
        R = np.array([[np.cos(yaw), np.sin(yaw)], [-np.sin(yaw), np.cos(yaw)]])
        (x_sp, y_sp), (x, y) = R @ wish.p[:2], R @ motion.p[:2]
        (vx_sp, vy_sp), (vx, vy) = R @ wish.v[:2], R @ motion.v[:2]
        vz_sp = wish.v[2]
        if wish.holds_xy:
            k_x, k_y = ((g.posCtlPid_xKp, g.posCtlPid_xKi), (g.posCtlPid_yKp, g.posCtlPid_yKi))
            vx_sp = self.x.update((*k_x, 0.0, 0.0), x_sp, x, dt, 1.1 * g.posCtlPid_xVelMax)
            vy_sp = self.y.update((*k_y, 0.0, 0.0), y_sp, y, dt, 1.1 * g.posCtlPid_yVelMax)
        if wish.holds_z:
            most = 1.1 * max(g.posCtlPid_zVelMax, 0.5)
            gains = (g.posCtlPid_zKp, g.posCtlPid_zKi, 0.0, 0.0)
            vz_sp = self.z.update(gains, wish.p[2], motion.p[2], dt, most)
        r_most, p_most = g.posCtlPid_rLimit, g.posCtlPid_pLimit
        pitch = -self.vx.update(gains_of(g, "velCtlPid_vx", "K"), vx_sp, vx, dt, 1.1 * p_most)
        roll = -self.vy.update(gains_of(g, "velCtlPid_vy", "K"), vy_sp, vy, dt, 1.1 * r_most)
        self.desired[0], self.desired[1] = clip(roll, r_most), clip(pitch, p_most)
        most = np.floor(FULL / 2.0) / 1000.0
        raw = self.vz.update(gains_of(g, "velCtlPid_vz", "K"), vz_sp, motion.v[2], dt, most)
        thrust = max(1000.0 * raw + g.posCtlPid_thrustBase, g.posCtlPid_thrustMin)
        self.thrust = min(max(thrust, 0.0), FULL)


def gains_of(g, prefix, letter="k"):
    """Return kp, ki, kd and kff of a group; the velocity's are Kp, Ki, Kd and KFF."""
    names = ("kp", "ki", "kd", "kff") if letter == "k" else ("Kp", "Ki", "Kd", "KFF")
    return tuple(getattr(g, prefix + name) for name in names)


def legacy_attitude(R) -> np.ndarray:
    """Return roll, pitch (nose up) and yaw of R_WT in degrees."""
    roll, pitch = np.arctan2(R[2, 1], R[2, 2]), -np.arcsin(np.clip(-R[2, 0], -1.0, 1.0))
    return np.degrees([roll, pitch, np.arctan2(R[1, 0], R[0, 0])])


def wrapped(angle):
    """Return an angle less than a turn and a half from 0 within half a turn."""
    if angle > 180.0:
        return angle - 360.0
    return angle + 360.0 if angle < -180.0 else angle


def motors_wrench(g, vehicle, thrust, roll, pitch, yaw, voltage):
    """powerDistributionLegacy, the battery's compensation, the cap, and what the rotors make."""
    rotors, turns = in_order(vehicle.rotors)
    yaw, roll, pitch = turns * yaw, 0.5 * roll, 0.5 * pitch
    asked = [
        thrust - roll + pitch + yaw,
        thrust - roll - pitch - yaw,
        thrust + roll - pitch + yaw,
        thrust + roll + pitch - yaw,
    ]
    supply = voltage * g.vbat
    pwm = np.array([FULL * motor_voltage(x / FULL * THRUST_MAX) / supply for x in asked])
    pwm = np.maximum(pwm - max(np.max(pwm) - FULL, 0.0), 0.0)
    thrusts = [max(curve(x / FULL * supply), 0.0) / THRUST_MAX * g.thrust_max for x in pwm]
    return wrench(rotors, thrusts)


def curve(volts):
    """Return a motor's thrust at a voltage [N]."""
    a, b, c, d = VMOTOR2THRUST
    return a + b * volts + c * volts**2 + d * volts**3


def motor_voltage(thrust):
    """Return the voltage of a thrust; the curve rises everywhere. No thrust needs none."""
    if thrust <= 0.0:
        return 0.0
    return brentq(lambda volts: curve(volts) - thrust, 0.0, 30.0, xtol=1e-15, rtol=1e-15)


def in_order(rotors):
    """Return the rotors at front right, rear right, rear left, front left; and the sense of yaw."""
    signs = [(rotor.moment[0] > 0.0, rotor.moment[1] > 0.0) for rotor in rotors]
    corners = [(False, False), (False, True), (True, True), (True, False)]
    ordered = [rotors[signs.index(corner)] for corner in corners]
    return ordered, 1.0 if ordered[0].moment[2] < 0.0 else -1.0
