"""Oracle: each autopilot's law written twice, by two people, from the firmware alone.

The second ones, `NAME_oracle.py`, count in the firmware's own frames, signs and units. Both are
told the same in random updates, with what they remember carried on: motions from hover to tumbling,
errors from none to far beyond every limit, gains around their defaults, motors in saturation.
"""

from collections import namedtuple
from types import MappingProxyType

import numpy as np
import pytest
from ardupilot_oracle import ArduPilot
from betaflight_oracle import QUADX, Betaflight
from crazyflie_oracle import Crazyflie
from mellinger_oracle import Mellinger
from motion import Motion, Rotor, Wish, matrix, quaternion
from px4_oracle import Px4

from workbench.control.controller_file import load_controller
from workbench.control.guidance import (
    Guidance,
    KnownBody,
    KnownRotor,
    KnownVehicle,
    LawSetpoint,
    MeasuredMotion,
    Reference,
)
from workbench.plant.gravity import GRAVITY

LENGTH = 100
"""Updates of a sequence."""
ORACLES = {
    "px4": (lambda g, vehicle: Px4(g, vehicle, GRAVITY), ("quad", "uneven", "hexacopter")),
    "crazyflie": (Crazyflie, ("quad", "uneven", "other way")),
    "ardupilot": (
        lambda g, vehicle: ArduPilot(g, vehicle, GRAVITY),
        ("quad", "uneven", "hexacopter"),
    ),
    "betaflight": (Betaflight, ("quad", "uneven", "hexacopter", "other way")),
    "mellinger": (Mellinger, ("quad", "uneven", "other way")),
}
SWITCHES = {"MC_AIRMODE": (0.0, 1.0, 2.0), "MC_ACC_DECOUPLE": (0.0, 1.0)}
SWITCHES |= {"acro": (0.0, 1.0), "airmode": (0.0, 1.0)}
VERSIONS = {
    "betaflight": (4.2, 4.3, 4.4, 4.5, 4.6, 2025.12, 2026.6),
    "ardupilot": (4.3, 4.6, 4.7),
}
SWITCHES |= {
    f"{name}_type": (0.0, 1.0, 2.0, 3.0)
    for name in ("gyro_lpf1", "gyro_lpf2", "dterm_lpf1", "dterm_lpf2")
}
SWITCHES |= {"ATC_RATE_FF_ENAB": (0.0, 1.0), "ATC_ANGLE_BOOST": (0.0, 1.0)}
OPEN = {"max_speed": 1e4, "max_climb_rate": 1e4, "max_height": 1e6, "max_tilt": 0.8}
OPEN |= {"max_yaw_rate": 1e3, "spin_up_feedforward": 0.0}
"""The workbench's own limits stand before every law: here they let all pass."""


def made(places, turns) -> KnownVehicle:
    """Return a vehicle of rotors at places (x, y) and of senses, 1 counterclockwise from above."""
    rotors = []
    for (x, y), turn in zip(places, turns, strict=True):
        force = 1.0 - 0.1 * abs(x - y) / (1.0 + abs(x))  # uneven ones lean
        rotors.append(KnownRotor(force, y, -x, -0.016 * turn, 0.1, 8.0, 8.5e-6, 0.0))
    inertia = [0.02, 0.0, 0.0, 0.02, 0.0, 0.04]
    return KnownVehicle(1.5, inertia, 0.1, 0.02, 0.3, 0.0, tuple(rotors))


CROSS = [(0.2, -0.2), (-0.2, -0.2), (-0.2, 0.2), (0.2, 0.2)]
UNEVEN = [(0.13, 0.22), (0.15, -0.24), (-0.21, -0.18), (-0.19, 0.17)]
ROUND = [(0.3 * np.cos(a), 0.3 * np.sin(a)) for a in np.radians(np.arange(30, 390, 60))]
VEHICLES = {
    "quad": made(CROSS, (1, -1, 1, -1)),
    "uneven": made(UNEVEN, (-1, 1, -1, 1)),
    "other way": made(CROSS, (-1, 1, -1, 1)),
    "hexacopter": made(ROUND, (1, -1) * 3),
}


def test_betaflights_shares_of_four_in_a_cross_are_quadx():
    cross = oracle_vehicle(VEHICLES["other way"])
    rear_right_first = [1, 0, 2, 3]
    np.testing.assert_array_equal(Betaflight(None, cross).shares[rear_right_first], QUADX)


@pytest.mark.parametrize("name", ORACLES)
def test_a_law_and_its_oracle_are_one(name, case):
    compare(name, 1000, case)


@pytest.mark.slow
@pytest.mark.parametrize("name", ORACLES)
def test_a_law_and_its_oracle_are_one_over_4000_updates(name, case):
    compare(name, 4_000, case)


def test_ardupilots_gains_of_exactly_zero_ask_for_the_root_of_the_error_alone(case):
    """As in its sqrt_controller: a P of 0 is no loop that is switched off."""
    names = ("PSC_NE_POS_P", "PSC_D_POS_P", "ATC_ANG_RLL_P", "ATC_ANG_PIT_P", "ATC_ANG_YAW_P")
    for given in (dict.fromkeys(names, 0.0), {"ATC_ANG_YAW_P": 0.0}, {"ATC_RAT_YAW_P": 0.0}):
        with case(given):
            compare("ardupilot", 200, case, given)


def compare(name, count, case, given=MappingProxyType({})):
    make_oracle, vehicles = ORACLES[name]
    law = load_controller(name)
    saturated = 0
    for seed in range(count // LENGTH):
        rng = np.random.default_rng(seed)
        with case(f"{vehicles[seed % len(vehicles)]}, seed {seed}"):
            vehicle = VEHICLES[vehicles[seed % len(vehicles)]]
            g = drawn_gains(law, vehicle, rng, given)
            oracle = make_oracle(g, oracle_vehicle(vehicle))
            ours, theirs = flown(law, oracle, g, vehicle, rng)
            force, moment = np.max(np.abs(theirs[:, 0])), np.max(np.abs(theirs[:, 1:]))
            scale = np.maximum([force, moment, moment, moment], 1e-6)
            assert np.all(np.isfinite(theirs))
            np.testing.assert_array_less(np.abs(ours - theirs) / scale, 1e-9)
            saturated += np.any(np.abs(theirs[1:] - theirs[:-1]) > 0.1 * scale)
    assert saturated > 0.2 * count / LENGTH  # they are no flights at rest


def flown(law, oracle, g, vehicle, rng):
    """Return the wrenches of the law and of its oracle over a sequence of updates."""
    remembered = namedtuple("Memory", [state.name for state in law.memory])
    memory, dt = remembered(*law.initial_memory), law.period
    body = KnownBody(*vehicle[:-1])
    ours, theirs, wish = [], [], None
    every = max(law.dividers, default=1)  # what is asked for changes where all parts are told
    for number, motion in enumerate(motions(rng, dt)):
        elapsed = tuple(n * dt if number % n == 0 else 0.0 for n in law.dividers)
        if number % every == 0 and (wish is None or rng.random() < 0.2):
            wish, asked = drawn_wish(motion, rng)
        q = quaternion(motion.R) * rng.uniform(0.5, 2.0)
        rest = rng.normal(size=3), rng.normal(size=4)
        w_W = motion.R @ motion.w
        measured = MeasuredMotion(
            motion.p, motion.v, motion.a, q, w_W, *rest, motion.voltage, elapsed
        )
        found, memory = law.update(measured, asked, g, body, memory, dt, None)
        memory = remembered(*memory)
        ours.append(found)
        theirs.append(oracle.update(motion, wish, dt, elapsed))
    return np.array(ours, dtype=float), np.array(theirs)


def oracle_vehicle(vehicle):
    rotors = [
        Rotor(r.force, np.array([r.m_x, r.m_y, r.m_z]), r.motor_constant, r.linear_speed)
        for r in vehicle.rotors
    ]
    return vehicle._replace(rotors=rotors)


def drawn_gains(law, vehicle, rng, given):
    """Return the law's g: around their defaults, some at a limit, those given, and those that it
    designs."""
    values = {}
    for row in law.parameters:
        default = row.default if row.default else 0.05 * row.maximum
        drawn = default * np.exp(rng.uniform(-1.0, 1.0))
        if rng.random() < 0.1:
            drawn = row.minimum if row.minimum > 0.0 or not row.default else row.default
        if row.name == "MPC_THR_MAX":  # below the margin PX4 finds no root
            drawn = rng.uniform(0.6, 1.0)
        if row.name == "MOT_THST_EXPO":  # at 1 a first touch of thrust has infinite slope
            drawn = rng.uniform(-0.9, 0.9)
        values[row.name] = float(np.clip(drawn, row.minimum, row.maximum))
    if "firmware" in values:
        values["firmware"] = rng.choice(VERSIONS[law.name])
    values |= (
        {name: rng.choice(SWITCHES[name]) for name in SWITCHES if name in values} | OPEN | given
    )
    every = [*values, *law.designed]
    return namedtuple("Gains", every)(*law.gains(values, vehicle, law.period))


def motions(rng, dt):
    """Yield the motions of a sequence: noisy walks, now and then a jump."""
    swing, far, fast = 10.0 ** rng.uniform(-2, 0.7), 10.0 ** rng.uniform(-1, 1.5), rng.uniform(0, 6)
    p, v, a, w, R = far * rng.normal(size=3), *rng.normal(size=(3, 3)), np.eye(3)
    R = matrix(unit(rng.normal(size=4) * [1.0, swing, swing, 1.0]))
    for _ in range(LENGTH):
        if rng.random() < 0.02:
            R = matrix(unit(rng.normal(size=4) * [1.0, swing, swing, 1.0]))
            v = fast * rng.normal(size=3)
        a = 0.9 * a + rng.normal(size=3)
        v = v + dt * a
        p = p + dt * v
        w = 0.98 * w + 0.2 * swing * rng.normal(size=3)
        R = R @ matrix(unit(np.array([1.0, *(0.5 * dt * w)])))
        yield Motion(p, v, a, R, w, rng.uniform(0.75, 1.0))


def unit(q):
    return q / np.linalg.norm(q)


def drawn_wish(motion, rng):
    """Return what is asked for, as the oracles and as the laws are told it."""
    place = motion.p + 10.0 ** rng.uniform(-2, 1.5) * rng.normal(size=3)
    speed, path = 10.0 ** rng.uniform(-1, 1) * rng.normal(size=3), rng.normal(size=3)
    yaw_rate = rng.choice([0.0, rng.normal()])
    none = np.zeros(3)
    kind = rng.integers(4)
    if kind == 0:  # along a path
        wish = Wish(place, True, True, speed, path, yaw_rate)
        reference = Reference(*speed, yaw_rate, *place, 1.0)
        guidance = Guidance(1.0, 1.0, 1.0, 0.0, 0.0, 0.0, *none)
    elif kind == 1:  # a place is held
        wish = Wish(place, True, True, none, none, yaw_rate)
        reference = Reference(*none, yaw_rate, *none, 0.0)
        guidance = Guidance(1.0, 1.0, 1.0, 0.0, 1.0, 1.0, *place)
    elif kind == 2:  # it sinks or climbs over a place
        climb = np.array([0.0, 0.0, rng.normal()])
        wish = Wish(place, True, False, climb, none, yaw_rate)
        reference = Reference(*none, yaw_rate, *none, 0.0)
        guidance = Guidance(1.0, 1.0, 1.0, climb[2], 1.0, 0.0, *place)
    else:  # a pilot steers
        wish = Wish(place, False, False, speed, none, yaw_rate)
        reference = Reference(*speed, yaw_rate, *none, 0.0)
        guidance = Guidance(1.0, 1.0, 1.0, 0.0, 0.0, 0.0, *none)
    return wish, LawSetpoint(reference, guidance, tuple(wish.a))
