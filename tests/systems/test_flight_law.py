"""Oracle: the functions that the law is made of, each tested in its own file, put in a row here."""

import numpy as np
import pytest

from workbench.systems.acceleration_estimate import sampled_estimate
from workbench.systems.cascade import (
    Guidance,
    wanted_specific_force,
    wanted_velocity,
    wanted_wrench,
)
from workbench.systems.flight_law import (
    control_update,
    law_constants,
    packed,
    packed_update,
    rotor_commands,
    unpacked,
)
from workbench.systems.mixer import mix
from workbench.systems.rotor_response import rotor_period, step_rotor

PERIOD = 1 / 128


def commands(signals, gains, constants) -> list[float]:
    found = [0.0] * 4
    rotor_commands(*signals, gains, constants, found)
    return found


def commands_in_a_row(vehicle, signals, gains) -> list[float]:
    state, acceleration, reference, guide = signals
    wanted = wanted_velocity(state[4:7], reference, guide, gains)
    f_W = wanted_specific_force(state[10:13], acceleration, wanted, gains)
    inertia = vehicle.inertia[np.triu_indices(3)].tolist()
    wrench = wanted_wrench(state[:4], state[7:10], f_W, wanted[3], vehicle.mass, inertia, gains)
    most = [rotor.motor_constant * rotor.max_rot_velocity**2 for rotor in vehicle.rotors]
    least = [0.01 * thrust for thrust in most]  # a tenth of the speed
    thrusts = [0.0] * 4
    mix(*wrench, law_constants(vehicle, 0.0).allocation, least, most, thrusts)
    return [(f / r.motor_constant) ** 0.5 for f, r in zip(thrusts, vehicle.rotors, strict=True)]


def test_commands_are_cascade_mixer_and_root_in_a_row(vehicle, gains, random_signals):
    rng = np.random.default_rng(8)
    constants = law_constants(vehicle, 0.0)
    for _ in range(300):
        signals = random_signals(rng)
        wanted = commands_in_a_row(vehicle, signals, gains)
        assert commands(signals, gains, constants) == pytest.approx(wanted, rel=1e-12)


def test_hovering_in_place_takes_the_hover_speeds(vehicle, gains):
    state = [1.0, 0, 0, 0, 1, 2, 3, 0, 0, 0, 0, 0, 0]
    hold = Guidance(1.0, 1.0, 1.0, 0.0, 1.0, 1.0, 1.0, 2.0, 3.0)
    found = commands((state, [0.0] * 3, [0.0] * 8, hold), gains, law_constants(vehicle, 0.0))
    assert found == pytest.approx(vehicle.hover_speeds)


@pytest.mark.parametrize(("motors", "lift", "share"), [(0.0, 1.0, 0.0), (0, 0, 0), (1.0, 0.0, 0.1)])
def test_without_motors_rotors_stop_and_without_lift_they_idle(
    vehicle, gains, random_signals, motors, lift, share
):
    state, acceleration, reference, guide = random_signals(np.random.default_rng(9))
    guide = [motors, lift, *guide[2:]]
    signals = (state, acceleration, reference, guide)
    found = commands(signals, gains, law_constants(vehicle, 0.0))
    assert found == pytest.approx([share * rotor.max_rot_velocity for rotor in vehicle.rotors])


def updated(signals, gains, constants, memory) -> tuple[np.ndarray, np.ndarray]:
    state, _, reference, guide = signals
    thrusts, after = np.zeros(4), np.zeros(11)
    control_update(
        state,
        reference,
        guide,
        gains,
        constants,
        sampled_estimate(PERIOD),
        memory,
        thrusts,
        after,
    )
    return thrusts, after


def test_an_update_estimates_commands_and_steps_the_rotors(vehicle, gains, random_signals):
    rng = np.random.default_rng(10)
    constants = law_constants(vehicle, PERIOD)
    share, rate = sampled_estimate(PERIOD)
    for _ in range(200):
        state, _, reference, guide = random_signals(rng)
        memory = np.concatenate([rng.uniform(0, 1100, 8), rng.normal(size=3)])
        v_WB, filtered = np.array(state[10:13]), memory[8:]
        acceleration = rate * (v_WB - filtered)
        signals = (state, acceleration, reference, guide)
        asked = commands_in_a_row(vehicle, signals, gains)
        steps = [
            step_rotor(command, speed, rotor_period(rotor, PERIOD))
            for command, speed, rotor in zip(asked, memory[:4], vehicle.rotors, strict=True)
        ]
        thrusts, after = updated(signals, gains, constants, memory)
        assert thrusts == pytest.approx([thrust for thrust, _ in steps], rel=1e-12)
        assert after[:4] == pytest.approx([speed for _, speed in steps], rel=1e-12)
        assert after[4:8] == pytest.approx(asked, rel=1e-12)
        assert after[8:] == pytest.approx(filtered + share * (v_WB - filtered), abs=1e-12)


def test_an_update_in_place_is_the_same(vehicle, gains, random_signals):
    """Drake may hand over the same memory to read and to write."""
    rng = np.random.default_rng(11)
    constants = law_constants(vehicle, PERIOD)
    signals = random_signals(rng)
    memory = np.concatenate([rng.uniform(0, 1100, 8), rng.normal(size=3)])
    _, after = updated(signals, gains, constants, memory)
    state, _, reference, guide = signals
    thrusts = np.zeros(4)
    control_update(
        state, reference, guide, gains, constants, sampled_estimate(PERIOD), memory, thrusts, memory
    )
    assert memory.tolist() == after.tolist()


def test_packing_loses_nothing(vehicle):
    constants = law_constants(vehicle, PERIOD)
    back = unpacked(*packed(constants))
    for name, value in constants._asdict().items():
        assert np.array(getattr(back, name)).tolist() == np.array(value).tolist(), name


def test_the_packed_update_is_the_update(vehicle, gains, random_signals):
    rng = np.random.default_rng(12)
    constants = law_constants(vehicle, PERIOD)
    signals = random_signals(rng)
    memory = np.concatenate([rng.uniform(0, 1100, 8), rng.normal(size=3)])
    state, _, reference, guide = (np.array(signal) for signal in signals)
    thrusts, after = np.zeros(4), np.zeros(11)
    packed_update(
        state,
        reference,
        guide,
        np.array(gains),
        *packed(constants),
        sampled_estimate(PERIOD),
        memory,
        thrusts,
        after,
    )
    wanted_thrusts, wanted_after = updated(signals, gains, constants, memory)
    assert thrusts == pytest.approx(wanted_thrusts, rel=1e-12)
    assert after == pytest.approx(wanted_after, rel=1e-12)
