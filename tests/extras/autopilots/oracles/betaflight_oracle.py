"""Betaflight's angle and rate mode, of versions 4.2 to 2026.6, written anew from its sources.

Sources: src/main/flight/pid.c, pid_init.c, mixer.c, mixer_init.c, common/filter.c, sensors/gyro.c.
Rates are in deg/s, of roll to the right, pitch nose down and yaw to the left: the signs of FLU.
Throttle and motors are shares; gains are the whole numbers of its CLI. In a loop first the PID
runs, then the mixer, which tells the next PID, 0.125 ms later, what throttle does to it; the law
has longer updates, and takes that of the same one. So it is with the targets of angles.

Left out as the law leaves it out: sticks and what smooths them, so a feed-forward is the slope of
the setpoint, and none in angle mode; the first climb's attenuation at low throttle. Shares of the
mixer are those of the rotors' moments, which are QUADX for four in X. `outer` is no part of
Betaflight: it is the law's loop of position and velocity, from its description.
"""

import numpy as np
from motion import clip, thrust_at, wrench

PTERM, ITERM, DTERM, FEEDFORWARD = 0.032029, 0.244381, 0.000529, 0.013754 * 0.01
PT2, PT3 = 1.553773974, 1.961459177
AXES = "roll", "pitch", "yaw"
QUADX = ((-1.0, 1.0, -1.0), (-1.0, -1.0, 1.0), (1.0, 1.0, 1.0), (1.0, -1.0, -1.0))
"""Roll, pitch and yaw of the motors at rear right, front right, rear left and front left."""
G = 9.81


class Pt:
    """A cascade of `order` filters of first order, which begins at a value."""

    def __init__(self, order, value=0.0):
        self.states = [value] * order

    def apply(self, sample, cutoff, dt):
        """Return the output after a sample; a cut-off of 0 Hz lets it pass."""
        if cutoff <= 0.0:
            return sample
        omega = 2.0 * np.pi * cutoff * (1.0, PT2, PT3)[len(self.states) - 1] * dt
        for i, state in enumerate(self.states):
            sample = self.states[i] = state + omega / (omega + 1.0) * (sample - state)
        return sample


class Svf:
    """svfLowpassFilterApply of 2026.6; with a fixed cut-off the biquad of before."""

    def __init__(self, value=0.0):
        self.one, self.two = 0.0 * value, value

    def apply(self, sample, cutoff, dt):
        if cutoff <= 0.0:
            return sample
        f = np.tan(np.pi * min(cutoff, 0.45 / dt) * dt)
        v1 = (self.one + f * (sample - self.two)) / (1.0 + f * (f + np.sqrt(2.0)))
        v2 = self.two + f * v1
        self.one, self.two = 2.0 * v1 - self.one, 2.0 * v2 - self.two
        return v2


def low_pass(kind, value):
    """Return the filter of a type, by its place among PT1, BIQUAD, PT2, PT3."""
    return Svf(value) if kind == 1.0 else Pt({0.0: 1, 2.0: 2, 3.0: 3}[kind], value)


class Betaflight:
    """PID and mixer of one vehicle, with its parameters `g`."""

    def __init__(self, g, vehicle):
        self.g, self.vehicle = g, vehicle
        self.began, self.wanted, self.yaw_p = False, 0.0, None
        self.targets, self.outer_integral = np.zeros(2), np.zeros(3)
        self.integral, self.gravity, self.tpa = np.zeros(3), 0.0, 1.0
        self.attitude = Pt(3, np.zeros(2))
        old = g is not None and g.firmware < 4.3
        self.range = [Svf() if old else Pt(2) for _ in AXES]
        self.boost = [Pt(1 if old else 2, 1.0) for _ in AXES]
        self.anti_gravity = Pt(2)
        moments = np.array([rotor.moment for rotor in vehicle.rotors])
        self.shares = moments / np.max(np.abs(moments), axis=0)

    def update(self, motion, wish, dt, elapsed):
        """Return the wrench; `elapsed` of the outer loop, 0 if it is not due."""
        R = motion.R
        heading = np.arctan2(R[1, 0], R[0, 0])
        angles = np.degrees([np.arctan2(R[2, 1], R[2, 2]), -np.arcsin(np.clip(R[2, 0], -1, 1))])
        if elapsed[0] > 0.0:
            self.outer(motion, wish, heading, elapsed[0])
        targets = self.targets
        if self.g.acro > 0.5:
            targets = self.g.outer_p_angle * (targets - angles)
        gyro = np.degrees(motion.w)
        thrusts = self.loop(gyro, angles, targets, np.degrees(wish.yaw_rate), dt)
        return wrench(self.vehicle.rotors, thrusts)

    def outer(self, motion, wish, heading, dt):
        """Make angles and a throttle of place and velocity."""
        g = self.g
        holds = np.array([wish.holds_xy, wish.holds_xy, wish.holds_z])
        back = [g.outer_p_position, g.outer_p_position, g.outer_p_height]
        error = wish.v + back * (wish.p - motion.p) * holds - motion.v
        p = np.array([g.outer_p_velocity, g.outer_p_velocity, g.outer_p_climb])
        i = np.array([g.outer_i_velocity, g.outer_i_velocity, g.outer_i_climb])
        a = p * error + self.outer_integral + wish.a
        level = a[:2] * min(1.0, G * np.tan(g.max_tilt) / max(np.linalg.norm(a[:2]), 1e-12))
        fore = np.cos(heading) * level[0] + np.sin(heading) * level[1]
        left = np.cos(heading) * level[1] - np.sin(heading) * level[0]
        pitch, roll = np.arctan2(fore, G), np.arctan2(-left, np.hypot(fore, G))
        self.targets = clip(np.degrees([roll, pitch]), g.angle_limit)
        lift = (1.0 + a[2] / G) * np.hypot(np.linalg.norm(level), G) / G
        idle = 1e-4 * g.motor_idle
        signal = (idle + (1.0 - idle) * g.outer_hover) * np.sqrt(max(lift, 1e-3))
        wanted = (signal - idle) / (1.0 - idle)
        self.wanted = min(max(wanted, 0.0), 1.0)
        missing = np.array([*(a[:2] - level), wanted - self.wanted])
        grown = self.outer_integral + i * error * dt
        self.outer_integral = np.where(missing * error > 0.0, self.outer_integral, grown)

    def begin(self, gyro, setpoint, throttle):
        """Let all filters rest at their first samples."""
        self.began = True
        g, self.d_before = self.g, gyro
        kinds = g.gyro_lpf2_type, g.gyro_lpf1_type, g.dterm_lpf1_type, g.dterm_lpf2_type
        self.gyro_2, self.gyro_1, self.d_1, self.d_2 = (low_pass(kind, gyro) for kind in kinds)
        self.relax, self.setpoint = [Pt(1, each) for each in setpoint], setpoint
        self.throttle_before = throttle
        self.throttle_slow = Pt(1, throttle)

    def loop(self, gyro, angles, targets, yaw_rate, dt):
        """Return the motors' thrusts: angle mode, with angles and targets of roll and pitch [deg].

        `yaw_rate` [deg/s] is of the setpoint; in rate mode `targets` are rates [deg/s].
        """
        g = self.g
        if g.acro > 0.5:
            setpoint = np.array([*targets, yaw_rate])
        else:
            setpoint = self.level(angles, targets, yaw_rate, dt)
        if not self.began:
            self.begin(gyro, setpoint, self.wanted)
        share = self.wanted
        self.attend(share, dt)
        gyro = self.gyro_2.apply(gyro, g.gyro_lpf2_static_hz, dt)
        gyro = self.gyro_1.apply(gyro, dynamic(g, "gyro_lpf1", share), dt)
        slow = self.d_1.apply(gyro, dynamic(g, "dterm_lpf1", share), dt)
        slow = self.d_2.apply(slow, g.dterm_lpf2_static_hz, dt)
        slope, self.d_before = (self.d_before - slow) / dt, slow
        sums = [self.axis(i, setpoint[i], gyro[i], slope[i], dt) for i in range(3)]
        self.setpoint = setpoint
        return self.mix(sums, share, dt)

    def level(self, angles, targets, yaw_rate, dt):
        """pidLevel: return setpoints of the rates; yaw turns about the world's z."""
        g = self.g
        earth = 0.01 * g.angle_earth_ref
        targets = clip(np.asarray(targets), g.angle_limit)
        rate = (targets - angles) * 0.1 * g.angle_p_gain
        rate[0] -= yaw_rate * np.sin(np.radians(targets[1])) * earth
        rate[1] += yaw_rate * np.sin(np.radians(targets[0])) * earth
        cutoff = 50.0 if g.firmware >= 4.5 else 250.0
        rate = rate if g.firmware < 4.4 else self.attitude.apply(rate, cutoff, dt)
        yaw = yaw_rate * np.cos(np.radians(earth * np.max(np.abs(targets))))
        return np.array([*rate, yaw])

    def axis(self, i, setpoint, gyro, slope, dt):
        """Return the sum of an axis, clipped, in thousandths of the motors' range."""
        g, name = self.g, AXES[i]
        p, i_gain, d, f = (getattr(g, f"{term}_{name}") for term in "pidf")
        d_max = getattr(g, f"d_max_{name}")
        yaw, angle_mode = i == 2, g.acro < 0.5
        most = g.pidsum_limit_yaw if yaw else g.pidsum_limit
        error = setpoint - gyro

        smooth = self.relax[i].apply(setpoint, g.iterm_relax_cutoff, dt)
        threshold = 8.0 if angle_mode and g.firmware >= 4.5 else 40.0
        relaxed = 1.0 if yaw else max(0.0, 1.0 - abs(setpoint - smooth) / threshold)

        p_term = PTERM * p * error
        if yaw:
            self.yaw_p = self.yaw_p or Pt(1, p_term)
            p_term = self.yaw_p.apply(p_term, g.yaw_lowpass_hz, dt)
        accelerator = 0.0 if yaw else 0.34 * self.gravity
        growth = (ITERM * i_gain * (2.5 if yaw else 1.0) + accelerator) * error * relaxed * dt
        limit = g.iterm_limit if g.firmware < 4.6 else 0.01 * g.iterm_windup * most
        self.integral[i] = clip(self.integral[i] + growth, limit)

        delta = 0.0 if angle_mode and not yaw else (setpoint - self.setpoint[i]) / dt
        multiplier = 1.0
        if d > 0.0 and d_max > d:
            old = g.firmware < 4.3
            factor, smooth, span = (0.00005, 10.0, 80.0) if old else (0.00008, 35.0, 85.0)
            quick = abs(self.range[i].apply(slope, span, dt)) * factor * g.d_max_gain / smooth
            advance = g.d_max_advance * (1.0 if g.firmware > 2000.0 else 0.01 * g.d_max_gain)
            ahead = abs(delta) * factor * advance / smooth
            multiplier = 1.0 + (d_max / d - 1.0) * max(quick, ahead)
            multiplier = min(self.boost[i].apply(multiplier, smooth, dt), d_max / d)
        d_term = DTERM * d * slope * multiplier * self.tpa
        if not yaw:
            calm = max(abs(setpoint) / 50.0, 1.0)
            p_term *= 1.0 + self.gravity / calm * 0.01 * g.anti_gravity_p_gain * 0.0034
        return clip(p_term + self.integral[i] + d_term + FEEDFORWARD * f * delta, most)

    def mix(self, sums, throttle, dt):
        """mixTable: return the motors' thrusts."""
        g = self.g
        roll, pitch, yaw = np.array(sums) / 1000.0
        slow = self.throttle_slow.apply(throttle, g.throttle_boost_cutoff, dt)
        if g.throttle_boost > 0.0:
            throttle = min(max(throttle + 0.1 * g.throttle_boost * (throttle - slow), 0.0), 1.0)
        linear = 0.01 * g.thrust_linear
        if 4.2 < g.firmware < 2026.0:
            throttle /= 1.0 + (linear - 0.5 * linear**2) * (1.0 - throttle) ** 2
        elif linear:
            throttle *= throttle * linear + 1.0 - linear

        mix = self.shares @ [roll, pitch, yaw]
        high, low = max(np.max(mix), 0.0), min(np.min(mix), 0.0)
        scale = 0.5 + throttle if g.airmode < 0.5 and throttle < 0.5 else 1.0
        scale /= max(high - low, 1.0)
        throttle = min(max(throttle, -low * scale), 1.0 - high * scale)
        u = mix * scale + throttle
        if g.firmware > 2026.0:
            u = u * (1.0 + linear * (1.0 - u) * (1.0 + linear * (1.0 - u - u)))
        elif g.firmware > 4.2:
            u = u * (1.0 + linear * (1.0 - u) ** 2)
        elif linear:
            b = (1.0 - linear) / (2.0 * linear)
            u = np.where(u > 0.0, np.sqrt(np.maximum(u, 0.0) / linear + b * b) - b, u)
        idle = 1e-4 * g.motor_idle
        signals = np.clip(idle + (1.0 - idle) * u, idle, 1.0)
        speeds = g.motor_speed * signals
        return [thrust_at(r, w) for r, w in zip(self.vehicle.rotors, speeds, strict=True)]

    def attend(self, throttle, dt):
        """Keep throttle, and what anti-gravity and the attenuation of D make of it."""
        g = self.g
        slope = abs(throttle - self.throttle_before) / dt * (1.0 - throttle) ** 2
        if throttle > self.throttle_before:
            slope *= 0.5 * (1.0 - throttle)
        smooth = self.anti_gravity.apply(slope, g.anti_gravity_cutoff_hz, dt)
        self.gravity = smooth * g.anti_gravity_gain
        breakpoint_ = min((g.tpa_breakpoint - 1000.0) / 1000.0, 0.99)
        rate = 0.01 * g.tpa_rate / (1.0 - breakpoint_)
        self.tpa = 1.0 - rate * max(throttle - breakpoint_, 0.0)
        self.throttle_before = throttle


def dynamic(g, name, throttle):
    """dynLpfGyroUpdate: return a cut-off that rises with throttle, or the static one [Hz]."""
    low, high, expo = (getattr(g, f"{name}_dyn_{end}") for end in ("min_hz", "max_hz", "expo"))
    if low == 0.0:
        return getattr(g, f"{name}_static_hz")
    if expo == 0.0:
        return max(throttle * (1.0 - throttle * throttle / 3.0) * 1.5 * high, low)
    curve = throttle * (1.0 - throttle) * 0.1 * expo + throttle
    return low + (high - low) * curve
