"""PX4's multicopter control (v1.16), written anew from its sources, in its own frames: NED and FRD.

Position to thrust vector: src/modules/mc_pos_control/PositionControl. Attitude to rates:
mc_att_control/AttitudeControl. Rates to torque: lib/rate_control and mc_rate_control. Torque and
thrust to motors: lib/control_allocation, the pseudo-inverse with sequential desaturation, and
lib/mixer_module/functions/FunctionMotors. Filters of the gyro: sensors/vehicle_angular_velocity,
where a low-pass of second order is for the rates and one of first order for their slope. All
filters begin at rest, at the first sample.
"""

import numpy as np
from motion import (
    R_FRD_FLU,
    R_NED_ENU,
    clip,
    cross,
    inverse,
    matrix,
    multiply,
    quaternion,
    thrust_at,
    wrench,
)
from scipy.signal import butter

G = 9.80665
EPSILON = 1.1920929e-7
"""FLT_EPSILON."""
CT = 6.5
"""CA_ROTOR_CT: it cancels but for the thresholds of the allocation."""
ROLL, PITCH, YAW, Z = 0, 1, 2, 5


class Px4:
    """The position controller down to the motors of one vehicle, with its parameters `g`."""

    def __init__(self, g, vehicle, gravity=G):
        self.g, self.rotors, self.gravity = g, vehicle.rotors, gravity
        self.allocation = Allocation(vehicle.rotors, int(g.MC_AIRMODE))
        self.v_int = np.zeros(3)
        self.q_sp, self.thrust_sp, self.yaw_rate_sp = None, 0.0, 0.0
        self.rate_sp, self.rate_int = np.zeros(3), np.zeros(3)
        self.yaw_sp = None
        self.gyro, self.slope, self.rate_before, self.yaw_torque = None, np.zeros(3), None, None
        self.unallocated = np.zeros(3)

    def update(self, motion, wish, dt, elapsed):
        """Return the wrench; `elapsed` of the attitude's and the position's parts, 0 if not due."""
        R = R_NED_ENU @ motion.R @ R_FRD_FLU
        self.yaw_rate_sp = -wish.yaw_rate
        if self.yaw_sp is None:
            self.yaw_sp = np.arctan2(R[1, 0], R[0, 0])
        else:  # as the trajectories of its automatic modes: a heading that turns, and its rate
            self.yaw_sp += self.yaw_rate_sp * dt
        if elapsed[1] > 0.0:
            self.position(motion, wish, elapsed[1])
        if elapsed[0] > 0.0:
            self.attitude(R)
        rate, slope = self.filtered(R_FRD_FLU @ motion.w, dt)
        torque = self.rates(rate, slope, dt)
        motors = self.allocation.allocate(torque, self.thrust_sp)
        self.unallocated = self.allocation.unallocated
        return wrench(self.rotors, [*map(self.motor_thrust, self.rotors, motors)])

    def position(self, motion, wish, dt):
        """Position and velocity in NED to a thrust vector, of that an attitude and a thrust."""
        g = self.g
        p, v, v_dot = (R_NED_ENU @ x for x in (motion.p, motion.v, motion.a))
        v_ff, a_ff = R_NED_ENU @ wish.v, R_NED_ENU @ wish.a
        error = (R_NED_ENU @ wish.p - p) * [wish.holds_xy, wish.holds_xy, wish.holds_z]
        v_position = error * [g.MPC_XY_P, g.MPC_XY_P, g.MPC_Z_P]
        v_sp = v_position + v_ff
        v_sp[:2] = constrain_xy(v_position[:2], v_ff[:2], g.MPC_XY_VEL_MAX)
        v_sp[2] = min(max(v_sp[2], -g.MPC_Z_VEL_MAX_UP), g.MPC_Z_VEL_MAX_DN)

        gains = (
            [g.MPC_XY_VEL_P_ACC, g.MPC_XY_VEL_P_ACC, g.MPC_Z_VEL_P_ACC],
            [g.MPC_XY_VEL_I_ACC, g.MPC_XY_VEL_I_ACC, g.MPC_Z_VEL_I_ACC],
            [g.MPC_XY_VEL_D_ACC, g.MPC_XY_VEL_D_ACC, g.MPC_Z_VEL_D_ACC],
        )
        k_p, k_i, k_d = map(np.array, gains)
        v_error = v_sp - v
        a_sp = a_ff + k_p * v_error + self.v_int - k_d * v_dot

        hover, least, most = g.MPC_THR_HOVER, max(g.MPC_THR_MIN, 1e-3), g.MPC_THR_MAX
        z_specific_force = -self.gravity + (0.0 if g.MPC_ACC_DECOUPLE > 0.5 else a_sp[2])
        body_z = np.array([-a_sp[0], -a_sp[1], -z_specific_force])
        body_z = limit_tilt(body_z / np.linalg.norm(body_z), np.radians(g.MPC_TILTMAX_AIR))
        thrust = body_z * min((a_sp[2] * hover / self.gravity - hover) / body_z[2], -least)

        if (thrust[2] >= -least and v_error[2] >= 0) or (thrust[2] <= -most and v_error[2] <= 0):
            v_error[2] = 0.0
        xy = np.linalg.norm(thrust[:2])
        thrust[2] = max(thrust[2], -np.sqrt(max(0.0, most**2 - min(xy, g.MPC_THR_XY_MARG) ** 2)))
        room = np.sqrt(max(most**2 - thrust[2] ** 2, 0.0))
        if xy > room:
            thrust[:2] *= room / xy
        produced = thrust[:2] * self.gravity / hover
        if a_sp[:2] @ a_sp[:2] > produced @ produced:
            v_error[:2] -= 2.0 / k_p[0] * (a_sp[:2] - produced)
        self.v_int = self.v_int + k_i * v_error * dt
        self.v_int[2] = clip(self.v_int[2], self.gravity)

        self.q_sp = attitude_of(-thrust, self.yaw_sp)
        self.thrust_sp = -np.linalg.norm(thrust)

    def attitude(self, R):
        """Attitude to a setpoint of rates: tilt first, yaw with less weight."""
        g = self.g
        q, q_d = quaternion(R), self.q_sp
        weight = min(max(g.MC_YAW_WEIGHT, 0.0), 1.0)
        gain = np.array([g.MC_ROLL_P, g.MC_PITCH_P, g.MC_YAW_P])
        if weight > 1e-4:
            gain[2] /= weight
        reduced = between(matrix(q)[:, 2], matrix(q_d)[:, 2])
        turned_over = max(abs(reduced[1]), abs(reduced[2])) > 1.0 - 1e-5
        reduced = q_d if turned_over else multiply(reduced, q)
        left = canonical(multiply(inverse(reduced), q_d))
        left = np.clip(left, -1.0, 1.0)
        turn = [np.cos(weight * np.arccos(left[0])), np.sin(weight * np.arcsin(left[3]))]
        q_d = multiply(reduced, np.array([turn[0], 0.0, 0.0, turn[1]]))
        error = 2.0 * canonical(multiply(inverse(q), q_d))[1:]
        rate = error * gain + R.T @ [0.0, 0.0, self.yaw_rate_sp]
        most = np.radians([g.MC_ROLLRATE_MAX, g.MC_PITCHRATE_MAX, g.MC_YAWRATE_MAX])
        self.rate_sp = clip(rate, most)

    def filtered(self, rate, dt):
        """Return the rates filtered and their slope filtered."""
        g = self.g
        if self.gyro is None:
            self.gyro = SecondOrder(g.IMU_GYRO_CUTOFF, 1.0 / dt, rate)
            self.rate_before = rate
        rate = self.gyro.apply(rate)
        slope = (rate - self.rate_before) / dt
        self.rate_before = rate
        self.slope = first_order(self.slope, slope, g.IMU_DGYRO_CUTOFF, dt)
        return rate, self.slope

    def rates(self, rate, slope, dt):
        """Return the torque setpoint: PID with feed-forward, D on the slope of the rates."""
        g = self.g
        axes = ("ROLL", "PITCH", "YAW")
        k, p, i, d, ff = (
            np.array([getattr(g, f"MC_{axis}RATE_{term}") for axis in axes])
            for term in ("K", "P", "I", "D", "FF")
        )
        error = self.rate_sp - rate
        torque = k * p * error + self.rate_int - k * d * slope + ff * self.rate_sp
        if self.unallocated @ self.unallocated >= 1e-6:
            error = np.where(self.unallocated > EPSILON, np.minimum(error, 0.0), error)
            error = np.where(self.unallocated < -EPSILON, np.maximum(error, 0.0), error)
        factor = np.maximum(0.0, 1.0 - (error / np.radians(400.0)) ** 2)
        most = np.array([g.MC_RR_INT_LIM, g.MC_PR_INT_LIM, g.MC_YR_INT_LIM])
        self.rate_int = clip(self.rate_int + factor * k * i * error * dt, most)
        if self.yaw_torque is None:
            self.yaw_torque = torque[2]
        self.yaw_torque = first_order(self.yaw_torque, torque[2], g.MC_YAW_TQ_CUTOFF, dt)
        return np.array([torque[0], torque[1], self.yaw_torque])

    def motor_thrust(self, rotor, control):
        """Return the thrust of a rotor at its control: thrust curve, then Gazebo's speeds."""
        g, a = self.g, self.g.THR_MDL_FAC
        if a > EPSILON and control > EPSILON:
            b = 1.0 - a
            control = -b / (2.0 * a) + np.sqrt((b / (2.0 * a)) ** 2 + control / a)
        return thrust_at(rotor, g.SIM_GZ_EC_MIN + control * (g.SIM_GZ_EC_MAX - g.SIM_GZ_EC_MIN))


class Allocation:
    """Pseudo-inverse, its columns scaled, and sequential desaturation between 0 and 1."""

    def __init__(self, rotors, airmode):
        self.airmode = airmode
        self.effectiveness = np.zeros((6, len(rotors)))
        for i, rotor in enumerate(rotors):
            self.effectiveness[:3, i] = CT * (R_FRD_FLU @ rotor.moment)
            self.effectiveness[5, i] = -CT * rotor.force
        mix = np.linalg.pinv(self.effectiveness)
        roll, pitch = (
            np.sqrt(np.sum(column**2) / (np.sum(np.abs(column) > 1e-3) / 2.0))
            for column in (mix[:, ROLL], mix[:, PITCH])
        )
        thrust = np.mean(np.linalg.norm(mix[:, 3:], axis=1))
        self.scale = np.array([max(roll, pitch)] * 2 + [np.max(mix[:, YAW])] + [thrust] * 3)
        mix = mix / np.where(self.scale > EPSILON, self.scale, 1.0)
        self.mix = np.where(np.abs(mix) < 1e-3, 0.0, mix)
        self.low, self.high = 0.0, 1.0

    def allocate(self, torque, thrust):
        """Return the motors' controls for a torque and a thrust along z down."""
        wanted = np.array([*torque, 0.0, 0.0, thrust])
        roll, pitch, yaw, z = (self.mix[:, axis] for axis in (ROLL, PITCH, YAW, Z))
        u = roll * torque[0] + pitch * torque[1] + z * thrust
        if self.airmode == 2:
            u = self.desaturated(u + yaw * torque[2], z)
            u = self.desaturated(u, yaw)
        else:
            if self.airmode == 1:
                u = self.desaturated(u, z)
            else:
                u = self.desaturated(u, z, increase_only=True)
                u = self.desaturated(u, roll)
                u = self.desaturated(u, pitch)
            self.high += 0.15 * (self.high - self.low)
            u = self.desaturated(u + yaw * torque[2], yaw)
            self.high = 1.0
            u = self.desaturated(u, z, increase_only=True)
        u = np.clip(u, self.low, self.high)
        self.unallocated = (wanted - (self.effectiveness @ u) * self.scale)[:3]
        return u

    def desaturated(self, u, column, increase_only=False):
        """Return u moved along a column until as little as possible is out of bounds."""
        gain = self.gain(u, column)
        if increase_only and gain < 0.0:
            return u
        u = u + gain * column
        return u + 0.5 * self.gain(u, column) * column

    def gain(self, u, column):
        """Return the least plus the largest step along the column that brings a motor in."""
        steps = [0.0]
        for x, share in zip(u, column, strict=True):
            if abs(share) >= 0.2 and x < self.low:
                steps.append((self.low - x) / share)
            if abs(share) >= 0.2 and x > self.high:
                steps.append((self.high - x) / share)
        return min(steps) + max(steps)


class SecondOrder:
    """LowPassFilter2p: Butterworth, by the bilinear transform; it begins at rest at a sample."""

    def __init__(self, cutoff, rate, sample):
        self.on = 0.0 < cutoff < 0.5 * rate
        if self.on:
            self.b, self.a = butter(2, cutoff, fs=rate)
            self.x, self.y = [sample] * 2, [sample] * 2

    def apply(self, sample):
        if not self.on:
            return sample
        (x1, x2), (y1, y2), b, a = self.x, self.y, self.b, self.a
        y = b[0] * sample + b[1] * x1 + b[2] * x2 - a[1] * y1 - a[2] * y2
        self.x, self.y = [sample, x1], [y, y1]
        return y


def first_order(state, sample, cutoff, dt):
    """AlphaFilter: return the state after a sample; a cut-off of 0 lets it pass."""
    if cutoff <= 0.0:
        return sample
    return state + dt / (1.0 / (2.0 * np.pi * cutoff) + dt) * (sample - state)


def constrain_xy(first, second, most):
    """Return first + second, no longer than `most`: of the second only as much as fits."""
    total = first + second
    if np.linalg.norm(total) <= most:
        return total
    if np.linalg.norm(first) >= most or np.linalg.norm(second - first) < 0.001:
        return first / np.linalg.norm(first) * most
    if np.linalg.norm(first) < 0.001:
        return second / np.linalg.norm(second) * most
    u = second / np.linalg.norm(second)
    along = u @ first
    return first + u * (-along + np.sqrt(along**2 - (first @ first - most**2)))


def limit_tilt(body_z, most):
    """Return a unit vector no farther than an angle from down."""
    down = np.array([0.0, 0.0, 1.0])
    angle = min(np.arccos(np.clip(body_z @ down, -1.0, 1.0)), most)
    rejection = body_z - (body_z @ down) * down
    if rejection @ rejection < EPSILON:
        rejection[0] = 1.0
    return np.cos(angle) * down + np.sin(angle) * rejection / np.linalg.norm(rejection)


def attitude_of(body_z, yaw):
    """Return the attitude with this z axis and this heading, a quaternion."""
    z = body_z / np.linalg.norm(body_z)
    x = cross([-np.sin(yaw), np.cos(yaw), 0.0], z)
    if z[2] < 0.0:
        x = -x
    x = x / np.linalg.norm(x)
    return quaternion(np.column_stack([x, cross(z, x), z]))


def between(a, b):
    """Return the shortest rotation from unit vector a to b."""
    q = np.array([1.0 + a @ b, *cross(a, b)])
    return q / np.linalg.norm(q)


def canonical(q):
    """Return the one of q and -q whose real part is positive."""
    return q if q[0] >= 0.0 else -q
