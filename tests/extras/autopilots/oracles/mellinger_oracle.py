"""The Crazyflie's Mellinger controller (firmware 2025.12), written anew.

Source: src/modules/src/controller/controller_mellinger.c; power distribution and battery as in
`crazyflie_oracle`. Moments are in 65535ths; about y they are of the other sign than in FLU.
"""

import numpy as np
from crazyflie_oracle import legacy_attitude, motors_wrench
from motion import clip, cross

G = 9.81
"""GRAVITY_MAGNITUDE."""


class Mellinger:
    """The controller and the motors of one vehicle, with its parameters `g`."""

    def __init__(self, g, vehicle):
        self.g, self.vehicle = g, vehicle
        self.i_position, self.i_attitude, self.before = np.zeros(3), np.zeros(3), None

    def update(self, motion, wish, dt, _elapsed):
        """Return the wrench."""
        g, R = self.g, motion.R
        holds = np.array([wish.holds_xy, wish.holds_xy, wish.holds_z])
        r = np.where(holds, wish.p - motion.p, 0.0)
        v = wish.v - motion.v
        most = np.array([g.ctrlMel_i_range_xy, g.ctrlMel_i_range_xy, g.ctrlMel_i_range_z])
        self.i_position = clip(self.i_position + r * dt, most)
        kp, kd, ki = (
            np.array([getattr(g, f"ctrlMel_{name}_{axis}") for axis in ("xy", "xy", "z")])
            for name in ("kp", "kd", "ki")
        )
        acceleration = wish.a + [0.0, 0.0, G]
        target = g.ctrlMel_mass * acceleration + kp * r + kd * v + ki * self.i_position
        thrust = g.ctrlMel_massThrust * (target @ R[:, 2])

        yaw = np.radians(legacy_attitude(R)[2]) + wish.yaw_rate * dt
        z = target / np.linalg.norm(target)
        y = cross(z, [np.cos(yaw), np.sin(yaw), 0.0])
        y = y / np.linalg.norm(y)
        R_des = np.column_stack([cross(y, z), y, z])
        skew = R_des.T @ R - R.T @ R_des
        e_R = np.array([skew[2, 1], -skew[0, 2], skew[1, 0]])  # y: the Crazyflie's own sign
        rate = motion.w * [1.0, -1.0, 1.0]
        e_w = np.array([0.0, 0.0, wish.yaw_rate]) - rate
        slope = np.zeros(3) if self.before is None else (self.before - rate) / dt
        self.before = rate
        most = [g.ctrlMel_i_range_m_xy, g.ctrlMel_i_range_m_xy, g.ctrlMel_i_range_m_z]
        self.i_attitude = clip(self.i_attitude - e_R * dt, np.array(most))
        kR, kw, ki = (
            np.array([getattr(g, f"ctrlMel_{name}_{axis}") for axis in ("xy", "xy", "z")])
            for name in ("kR", "kw", "ki_m")
        )
        kd_w = g.ctrlMel_kd_omega_rp * np.array([1.0, 1.0, 0.0])
        moment = -kR * e_R + kw * e_w + ki * self.i_attitude + kd_w * slope
        if thrust <= 0.0:
            self.i_position, self.i_attitude, moment = np.zeros(3), np.zeros(3), np.zeros(3)
            thrust = max(thrust, 0.0)
        roll, pitch, yaw = clip(moment * [1.0, 1.0, -1.0], 32000.0)
        return motors_wrench(g, self.vehicle, thrust, roll, pitch, yaw, motion.voltage)
