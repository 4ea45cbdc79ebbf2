"""Excitation flights of one minute with noise in the loop, compiled: the truth of the tests.

Vehicle, law, delays, filters and noise are all written here, so that what `identify` reads was made
by nothing of its own. Steps are of Heun's method.
"""

import dataclasses
import math
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np

from workbench.common.compiled import compile_cached
from workbench.common.jitable import register_jitable
from workbench.estimation.filters import lowpass
from workbench.extras.flightdata.identify.flight import IdentificationFlight
from workbench.plant.drag import drag_area
from workbench.plant.gravity import AIR_DENSITY
from workbench.plant.rotors import allocation_matrix
from workbench.plant.vehicle import Vehicle

STEP = 1 / 1000
EVERY = 2
"""Physics steps between control updates."""
GYRO_LOWPASS = 90.0
"""Second order [Hz]."""
GRAVITY = 9.80665


@dataclass(frozen=True)
class Truth:
    """What a flight is flown with.

    Attributes:
        lag: factor on both time constants.
        inertia: factors on the moments of inertia (3).
        thrust: factor on all thrusts.
        drag: rotor drag, as level deceleration over speed in hover [1/s].
        delay: of commands, in steps of 1 ms.
        center: offset of the centre of mass (2) [m].
        turn: share by which rotors that turn counter-clockwise give more, and the others less.
    """

    lag: float
    inertia: tuple[float, float, float]
    thrust: float
    drag: float
    delay: int
    center: tuple[float, float]
    turn: float

    @classmethod
    def drawn(cls, rng: np.random.Generator, vehicle: Vehicle) -> "Truth":
        """Return another vehicle of its kind."""
        span = 0.5 * vehicle.span
        return cls(
            lag=rng.uniform(0.7, 1.4),
            inertia=tuple(rng.uniform(0.8, 1.25, 3)),
            thrust=rng.uniform(0.9, 1.15),
            drag=rng.uniform(0.2, 0.45),
            delay=int(rng.integers(1, 5)),
            center=tuple(span * rng.uniform(-0.04, 0.04, 2)),
            turn=rng.uniform(-0.04, 0.04),
        )


def true_vehicle(vehicle: Vehicle, truth: Truth) -> Vehicle:
    """Return what flies: a vehicle that differs from the one that is known."""
    root = np.sqrt(truth.inertia)
    inertia = vehicle.inertia * np.outer(root, root)
    center = np.array(vehicle.p_BoBcm_B) + (*truth.center, 0.0)
    rotors = [
        dataclasses.replace(
            rotor,
            motor_constant=rotor.motor_constant
            * truth.thrust
            * (1.0 + rotor.direction * truth.turn),
            linear_motor_constant=rotor.linear_motor_constant
            * truth.thrust
            * (1.0 + rotor.direction * truth.turn),
            time_constant_up=truth.lag * rotor.time_constant_up,
            time_constant_down=truth.lag * rotor.time_constant_down,
        )
        for rotor in vehicle.rotors
    ]
    made = dataclasses.replace(
        vehicle,
        p_BoBcm_B=tuple(center),
        I_BBcm_B=tuple(map(tuple, inertia)),
        rotors=tuple(rotors),
    )
    pull = truth.drag * vehicle.mass / sum(made.hover_speeds)
    rotors = [dataclasses.replace(each, rotor_drag_coefficient=pull) for each in rotors]
    return dataclasses.replace(made, rotors=tuple(rotors))


def most_moments(vehicle: Vehicle) -> np.ndarray:
    """Return moments (3) that leave something for thrust [N·m]."""
    weight = vehicle.mass * GRAVITY
    torque = np.mean([rotor.moment_constant for rotor in vehicle.rotors])
    return weight * np.array([0.07 * vehicle.span, 0.07 * vehicle.span, 0.5 * torque])


def excitation(rng: np.random.Generator, duration: float, speed: float, climb: float) -> np.ndarray:
    """Return velocities, yaw rate, roll and pitch asked for at each update (N, 6), in squares."""
    times = np.arange(0.0, duration, EVERY * STEP)
    asked = np.zeros((len(times), 6))
    for axis, most in enumerate((speed, speed, climb, 1.0, 0.2, 0.2)):
        t = 1.0
        shortest, longest = (0.05, 0.5) if axis > 3 else (0.2, 2.0)
        while t < duration - 1.0:
            half = math.exp(rng.uniform(math.log(shortest), math.log(longest)))
            amplitude = most * rng.uniform(0.5, 1.0) * rng.choice((-1.0, 1.0))
            for sign in (1.0, -1.0):
                asked[(times >= t) & (times < t + half), axis] = sign * amplitude
                t += half
    return asked


class Body(NamedTuple):
    """A rigid body: mass, inertia about its centre of mass and its inverse, that centre in B, and
    half the air's density times its drag area."""

    mass: float
    inertia: np.ndarray
    inverse: np.ndarray
    center: np.ndarray
    half_drag: float


class Propellers(NamedTuple):
    """Constants of n rotors, see `plant.rotors.Rotor`."""

    p_BR: np.ndarray
    axis_B: np.ndarray
    direction: np.ndarray
    motor_constant: np.ndarray
    linear_speed: np.ndarray
    moment_constant: np.ndarray
    inertia: np.ndarray
    time_constant_up: np.ndarray
    time_constant_down: np.ndarray
    max_rot_velocity: np.ndarray
    rotor_drag_coefficient: np.ndarray


@register_jitable
def _attitude(q):  # type: ignore[no-untyped-def]
    """Return R_WB of a quaternion."""
    w, x, y, z = q / math.sqrt(np.sum(q * q))
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


@register_jitable
def _rates(state, commands, air, twist, body, rotors):  # type: ignore[no-untyped-def]
    """Return the derivative of a state, and the specific force at the origin in B.

    A state is a quaternion, place and velocity in W, angular velocity in B, and rotor speeds.
    """
    q, v, w, speeds = state[0:4], state[7:10], state[10:13], state[13:]
    R, rates = _attitude(q), np.zeros(len(state))
    through, center = R.T @ (v - air), body.center
    way = through + np.cross(w, center)
    force, moment = -body.half_drag * math.sqrt(np.sum(way * way)) * way, twist.copy()
    for i in range(len(speeds)):
        axis, turn, speed = rotors.axis_B[i], rotors.direction[i], speeds[i]
        error = min(max(commands[i], 0.0), rotors.max_rot_velocity[i]) - speed
        up = 0.5 * error * (1.0 + (error / math.sqrt(error * error + 9.0)) ** 3)
        slope = up / rotors.time_constant_up[i] + (error - up) / rotors.time_constant_down[i]
        rates[13 + i] = slope
        thrust = rotors.motor_constant[i] * speed * (speed + rotors.linear_speed[i])
        way = through + np.cross(w, rotors.p_BR[i])
        way = way - np.sum(way * axis) * axis
        push = thrust * axis - rotors.rotor_drag_coefficient[i] * speed * way
        force = force + push
        moment = moment + np.cross(rotors.p_BR[i] - center, push)
        moment = moment - turn * (rotors.moment_constant[i] * thrust) * axis
        spin = turn * rotors.inertia[i] * axis
        moment = moment - slope * spin - np.cross(w, speed * spin)
    turning = body.inverse @ (moment - np.cross(w, body.inertia @ w))
    felt = force / body.mass - np.cross(turning, center) - np.cross(w, np.cross(w, center))
    rates[0] = -0.5 * np.sum(q[1:] * w)
    rates[1:4] = 0.5 * (q[0] * w + np.cross(q[1:], w))
    rates[4:7] = v
    rates[7:10] = R @ felt
    rates[9] -= 9.80665
    rates[10:13] = turning
    return rates, felt


def _fly(asked, rotors, body, allocation, gains, caps, hover, law, noise, section, delay, out):  # type: ignore[no-untyped-def]
    n = len(hover)
    state = np.zeros(13 + n)
    state[0] = 1.0
    state[6] = 30.0
    state[13:] = hover
    air, twist = np.zeros(3), np.zeros(3)
    commands = hover.copy()
    waiting = np.zeros((delay + 1, n))
    waiting[:] = hover
    filtered = np.zeros((3, 2))
    gyro = np.zeros(3)
    up = 0.0
    for k in range(len(out)):
        R, v = _attitude(state[0:4]), state[7:10]
        for i in range(3):
            u = state[10 + i] + noise[k, i]
            x_1, x_2 = filtered[i, 0], filtered[i, 1]
            gyro[i] = section[6] * x_1 + section[7] * x_2 + section[8] * u
            filtered[i, 0] = section[0] * x_1 + section[1] * x_2 + section[4] * u
            filtered[i, 1] = section[2] * x_1 + section[3] * x_2 + section[5] * u
            out[k, i] = gyro[i]
        v_B = R.T @ v
        for i in range(3):
            out[k, 6 + i] = v_B[i] + noise[k, 6 + i]
        if k % 2 == 0:
            want = asked[k // 2]
            a_x = law[0] * (want[0] - v[0])
            a_y = law[0] * (want[1] - v[1])
            most = law[3]
            a_x = min(max(a_x, -most), most)
            a_y = min(max(a_y, -most), most)
            up += 0.5 * law[1] * (want[2] - v[2]) * 0.002
            a_z = law[1] * (want[2] - v[2]) + up
            b_x, b_y, _ = R.T @ np.array([a_x, a_y, 0.0])
            b = R[2]
            # the tilt that is wanted, less the one that there is
            e_x = b[1] + b_y / 9.80665 - want[4]
            e_y = -b[0] - b_x / 9.80665 - want[5]
            e_x = min(max(e_x, -0.4), 0.4)
            e_y = min(max(e_y, -0.4), 0.4)
            a_z = min(max(a_z, -law[4]), law[4])
            thrust = body.mass * (9.80665 + a_z) / max(0.5, b[2])
            r = law[2]
            wish = np.array(
                [
                    gains[0] * r * (-0.4 * r * e_x - gyro[0]),
                    gains[1] * r * (-0.4 * r * e_y - gyro[1]),
                    gains[2] * 0.5 * r * (want[3] - gyro[2]),
                ]
            )
            for i in range(3):
                wish[i] = min(max(wish[i], -caps[i]), caps[i])
            for i in range(n):
                T = (
                    allocation[i, 0] * thrust
                    + allocation[i, 1] * wish[0]
                    + allocation[i, 2] * wish[1]
                    + allocation[i, 3] * wish[2]
                )
                lin, most = rotors.linear_speed[i], rotors.max_rot_velocity[i]
                T = max(T, 0.0) / rotors.motor_constant[i]
                commands[i] = min(math.sqrt(0.25 * lin * lin + T) - 0.5 * lin, most)
                commands[i] = max(commands[i], 0.3 * hover[i])
        for i in range(n):
            out[k, 9 + i] = commands[i]
            waiting[k % (delay + 1), i] = commands[i]
        late = waiting[(k + 1) % (delay + 1)]
        for i in range(3):
            air[i] = 0.999 * air[i] + noise[k, 9 + i]
            twist[i] = 0.99 * twist[i] + noise[k, 12 + i]
        first, felt = _rates(state, late, air, twist, body, rotors)
        out[k, 3:6] = felt + noise[k, 3:6]
        second, _ = _rates(state + 0.001 * first, late, air, twist, body, rotors)
        state = state + 0.0005 * (first + second)


compiled_fly = compile_cached(
    _fly,
    ("common/jitable.py",),
    "the flights of a test",
    text=Path(__file__).read_text(encoding="utf-8"),
)


def fly(
    vehicle: Vehicle,
    truth: Truth,
    rng: np.random.Generator,
    duration: float = 60.0,
    gyro_noise: float = 0.01,
    force_noise: float = 0.3,
    air: float = 0.3,
    turning: float = 1.0,
) -> IdentificationFlight:
    """Return the flight of one minute that a log would hold, at 1 kHz."""
    flown = true_vehicle(vehicle, truth)
    many = round(duration / STEP)
    driven = air * math.sqrt(1.0 - 0.999**2)
    twist = turning * np.diag(vehicle.inertia) * math.sqrt(1.0 - 0.99**2)
    noise = rng.normal(size=(many, 15)) * np.concatenate(
        ([gyro_noise] * 3, [force_noise] * 3, [0.03] * 3, [driven] * 3, twist)
    )
    lag = max(0.02, vehicle.rotor_lag)
    rate = min(0.27 / lag, 20.0)
    reserve = 0.5 * (flown.thrust_to_weight - 1.0) * GRAVITY
    law = np.array([min(1.6, 0.1 * rate), 2.0, rate, 4.0, reserve])
    out = np.zeros((many, 9 + len(vehicle.rotors)))
    margin = min(1.5, 0.5 * (vehicle.thrust_to_weight - 1.0) * 9.8 / 2.0)
    compiled_fly(
        excitation(rng, duration, 2.5, margin),
        Propellers(
            *(
                np.array([getattr(rotor, name) for rotor in flown.rotors], dtype=float)
                for name in Propellers._fields
            )
        ),
        Body(
            flown.mass,
            flown.inertia,
            np.linalg.inv(flown.inertia),
            np.array(flown.p_BoBcm_B),
            0.5 * AIR_DENSITY * drag_area(flown.mass),
        ),
        allocation_matrix(flown.rotors, flown.p_BoBcm_B),
        np.diag(vehicle.inertia).copy(),
        most_moments(vehicle),
        flown.hover_speeds,
        law,
        noise,
        np.array(lowpass(GYRO_LOWPASS, 2.0, STEP)),
        truth.delay,
        out,
    )
    assert np.isfinite(out).all()
    return IdentificationFlight(
        time=STEP * np.arange(many),
        commands=out[:, 9:],
        gyro=out[:, 0:3],
        force=out[:, 3:6],
        velocity=out[:, 6:9],
    )
