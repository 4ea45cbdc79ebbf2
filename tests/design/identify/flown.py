"""Excitation flights of one minute with noise in the loop, compiled: the truth of the tests.

The vehicle is the workbench's (`step_vehicle`); law, delays, filters and noise are written here, so
that what `identify` reads was made by nothing of its own.
"""

import dataclasses
import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from workbench.common.compiled import compile_cached
from workbench.design.identify.flight import Flight
from workbench.dynamics.rigid_body import into_body, into_world, rigid_body, rotation
from workbench.dynamics.vehicle_step import rotor_rows, step_vehicle
from workbench.estimation.filters import lowpass
from workbench.estimation.imu import measured
from workbench.plant.drag import AIR_DENSITY, drag_area
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


def _fly(
    asked, rotors, body, pressure, allocation, gains, caps, hover, law, noise, section, delay, out
):  # type: ignore[no-untyped-def]
    n = len(rotors)
    state = np.zeros(13)
    state[0] = 1.0
    state[6] = 30.0
    last, none, air, twist = np.zeros(6), np.zeros(6), np.zeros(3), np.zeros(3)
    mean = np.zeros(6)
    shares = np.ones(n)
    supply = np.array([1.0, 0.0, 0.0, 1.0])
    speeds = hover.copy()
    commands = hover.copy()
    waiting = np.zeros((delay + 1, n))
    waiting[:] = hover
    middles, slopes, ends = np.zeros(n), np.zeros(n), np.zeros(n)
    filtered = np.zeros((3, 2))
    mass = body[0]
    p = np.zeros(3)
    gyro = np.zeros(3)
    up = 0.0
    for k in range(len(out)):
        exact = into_body(rotation(state[0:4]), state[7:10])
        R = rotation(state[0:4])
        for i in range(3):
            u = exact[i] + noise[k, i]
            x_1, x_2 = filtered[i, 0], filtered[i, 1]
            gyro[i] = section[6] * x_1 + section[7] * x_2 + section[8] * u
            filtered[i, 0] = section[0] * x_1 + section[1] * x_2 + section[4] * u
            filtered[i, 1] = section[2] * x_1 + section[3] * x_2 + section[5] * u
            out[k, i] = gyro[i]
        v_B = into_body(R, state[10:13])
        for i in range(3):
            out[k, 6 + i] = v_B[i] + noise[k, 6 + i]
        if k % 2 == 0:
            want = asked[k // 2]
            a_x = law[0] * (want[0] - state[10])
            a_y = law[0] * (want[1] - state[11])
            most = law[3]
            a_x = min(max(a_x, -most), most)
            a_y = min(max(a_y, -most), most)
            up += 0.5 * law[1] * (want[2] - state[12]) * 0.002
            a_z = law[1] * (want[2] - state[12]) + up
            b_x, b_y, _ = into_body(R, np.array([a_x, a_y, 0.0]))
            b = into_body(R, np.array([0.0, 0.0, 1.0]))
            # the tilt that is wanted, less the one that there is
            e_x = b[1] + b_y / 9.80665 - want[4]
            e_y = -b[0] - b_x / 9.80665 - want[5]
            e_x = min(max(e_x, -0.4), 0.4)
            e_y = min(max(e_y, -0.4), 0.4)
            a_z = min(max(a_z, -law[4]), law[4])
            thrust = mass * (9.80665 + a_z) / max(0.5, b[2])
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
                lin = rotors[i, 15]
                T = max(T, 0.0) / rotors[i, 16]
                commands[i] = min(math.sqrt(0.25 * lin * lin + T) - 0.5 * lin, rotors[i, 19])
                commands[i] = max(commands[i], 0.3 * hover[i])
        for i in range(n):
            out[k, 9 + i] = commands[i]
            waiting[k % (delay + 1), i] = commands[i]
        late = waiting[(k + 1) % (delay + 1)]
        for i in range(3):
            air[i] = 0.999 * air[i] + noise[k, 9 + i]
            none[i] = 0.0
            twist[i] = 0.99 * twist[i] + noise[k, 12 + i]
        t_W = into_world(R, twist)
        for i in range(3):
            none[3 + i] = t_W[i]
        new, acceleration = step_vehicle(
            state,
            last,
            speeds,
            late,
            shares,
            air,
            none,
            pressure,
            supply,
            body,
            rotors,
            0.001,
            middles,
            slopes,
            ends,
        )
        # the physics has accelerations in the middle of its steps, a log at their beginning
        for i in range(6):
            mean[i] = 0.5 * (last[i] + acceleration[i])
        exact_force = measured(state, mean, p)
        for i in range(3):
            out[k, 3 + i] = exact_force[3 + i] + noise[k, 3 + i]
        for i in range(13):
            state[i] = new[i]
        for i in range(6):
            last[i] = acceleration[i]
        for i in range(n):
            speeds[i] = ends[i]


compiled_fly = compile_cached(
    _fly,
    ("dynamics", "estimation"),
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
) -> Flight:
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
        rotor_rows(flown.rotors, STEP),
        rigid_body(flown.mass, flown.inertia, flown.p_BoBcm_B).packed(),
        0.5 * AIR_DENSITY * drag_area(flown.mass),
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
    return Flight(
        time=STEP * np.arange(many),
        commands=out[:, 9:],
        gyro=out[:, 0:3],
        force=out[:, 3:6],
        velocity=out[:, 6:9],
    )
