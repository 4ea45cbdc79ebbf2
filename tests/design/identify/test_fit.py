"""What identify compares with a log, sample by sample, on flights in closed form.

Between two samples each command is held, so a rotor's speed is w = u + (w_0 - u) exp(-t / tau)
exactly, and so are the thrust k w² and its integral.
"""

import dataclasses
import math
from pathlib import Path

import numpy as np
import pytest

from workbench.design.identify.fit import CHANNELS, Fit, Fitter, make_piece, model_rows, shifted
from workbench.design.identify.flight import Flight, free_flight, held_on_grid
from workbench.design.identify.quantities import Quantity
from workbench.design.identify.search import combined, identify
from workbench.plant.loading import load_vehicle
from workbench.plant.vehicle import Vehicle

DRONES = Path(__file__).parents[2] / "drones"
LAG = 0.05
EVERY = 0.02
"""Time between two steps of the commands [s]."""


@pytest.fixture(scope="module")
def vehicle() -> Vehicle:
    """A drone of four rotors with one time constant, whose thrust goes with the square alone."""
    plain = load_vehicle(DRONES / "crazyflie.urdf")
    rotors = tuple(
        dataclasses.replace(
            rotor,
            time_constant_up=LAG,
            time_constant_down=LAG,
            linear_motor_constant=0.0,
            inertia=0.0,
        )
        for rotor in plain.rotors
    )
    body = tuple(map(tuple, np.diag(np.diag(plain.inertia))))
    return dataclasses.replace(plain, rotors=rotors, p_BoBcm_B=(0.0, 0.0, 0.0), I_BBcm_B=body)


def flown(
    vehicle: Vehicle, rate: float, duration: float, delay: float = 0.0, thrust: float = 1.0
) -> Flight:
    """Return a flight in which the rotors of either side do the same, so that it rolls and climbs.

    Args:
        vehicle: that flies.
        rate: of the samples [1/s].
        duration: of the flight [s].
        delay: of the commands [s], in whole eighths of a millisecond.
        thrust: factor on all thrusts.
    """
    every = round(8000 / rate) if delay else 1
    fine = 1.0 / (rate * every)
    count = round(duration * rate)
    asked = np.random.default_rng(3).uniform(0.8, 1.2, (math.ceil(duration / EVERY), 2))
    left = np.array([rotor.p_BR[1] > 0.0 for rotor in vehicle.rotors])
    k = thrust * np.array([rotor.motor_constant for rotor in vehicle.rotors])
    arms = np.array([rotor.p_BR[1] for rotor in vehicle.rotors])
    hover = vehicle.hover_speeds

    def command(step: int) -> np.ndarray:
        side = asked[max(0, step) // round(EVERY / fine)]
        return np.where(left, side[0], side[1]) * hover

    gyro, force = np.zeros((2, count, 3))
    commands = np.zeros((count, len(k)))
    decay, w, roll = math.exp(-fine / LAG), command(0), 0.0
    for step in range(count * every):
        if step % every == 0:
            gyro[step // every, 0] = roll
            force[step // every, 2] = np.sum(k * w**2) / vehicle.mass
            commands[step // every] = command(step)
        u = command(step - round(delay / fine))
        b = w - u
        squares = (
            u**2 * fine + 2.0 * u * b * LAG * (1.0 - decay) + 0.5 * b**2 * LAG * (1 - decay**2)
        )
        roll += float(arms @ (k * squares)) / vehicle.inertia[0, 0]
        w = u + b * decay
    return Flight(time=np.arange(count) / rate, commands=commands, gyro=gyro, force=force)


def test_the_model_says_of_each_row_what_was_measured_in_it(vehicle, case):
    """At rates at which samples are split, taken as they are, and averaged, and with a delay."""
    for rate, delay in ((250, 0.0), (500, 0.0), (500, 5e-3), (1000, 7.5e-3), (2000, 0.0)):
        with case(rate, delay):
            piece = make_piece(flown(vehicle, rate, 0.6, delay), vehicle)
            rows = model_rows(vehicle, {"delay": delay}, piece)
            for name, measured in (("turn_x", piece.turn[:, 0]), ("force", piece.force[:, 2])):
                off = np.abs(rows[:, CHANNELS.index(name)] - measured)[5:]
                # a row in which the command steps may be off by more
                assert np.quantile(off, 0.75) < 0.002 * np.ptp(measured), name


def test_samples_of_before_lie_on_lines_between_samples(case):
    values = np.arange(20.0)[:, None] ** 2 * [1.0, -2.0]
    for late in (0.0, 1.0, 2.25, -0.25, -3.0):
        with case(late):
            then = np.arange(20.0) - late
            expected = np.interp(then, np.arange(20.0), np.arange(20.0) ** 2)
            found = shifted(values, late)
            np.testing.assert_allclose(found, expected[:, None] * [1.0, -2.0], atol=1e-12)


def test_a_command_holds_from_its_sample_on():
    times, values = np.array([1.0, 2.0, 3.0]), np.array([[10.0], [20.0], [30.0]])
    grid = np.array([0.5, 1.0, 1.5, 2.0 - 1e-12, 2.0, 2.999, 3.0, 9.0])
    assert held_on_grid(times, values, grid)[:, 0].tolist() == [10, 10, 10, 20, 20, 20, 30, 30]


def test_a_search_that_is_stopped_says_how_far_it_may_be_off(vehicle):
    """Of thrusts that are a tenth larger than described: one step away, which is not made."""
    flight = flown(vehicle, 250, 30.0, thrust=1.1)
    noise = 0.02 * np.random.default_rng(5).normal(size=flight.force.shape)
    piece = make_piece(dataclasses.replace(flight, force=flight.force + noise), vehicle)
    thrust = [Quantity("thrust", 0.0, 0.002, math.inf, "force")]
    off, deviations = [], []
    for stop in (False, True):
        fitter = Fitter(vehicle, [piece], thrust, ["force"], stopped=lambda stop=stop: stop)
        found = fitter.fit(np.zeros(1))
        assert found.complete is not stop
        off.append(abs(found.value("thrust") - math.log(1.1)))
        deviations.append(found.deviation("thrust"))
    assert off[0] < 1e-3 and deviations[0] < 1e-3
    assert off[1] == pytest.approx(math.log(1.1)) and off[1] < 1.1 * deviations[1]


def test_two_lags_that_do_not_agree_spread_as_far_as_they_are_apart():
    """DerSimonian and Laird with two alike: their mean, with half their distance as deviation."""
    sigma, apart = 0.02, 0.3
    covariance = sigma**2 * np.array([[1.0, -1.0], [-1.0, 2.0]])
    none = np.empty(0)
    values = np.array([0.1, apart])
    fit = Fit(("lag", "lag_turn"), values, covariance, 20, none, none, (), 1, complete=True)
    lag, spread, each = combined(fit)
    assert lag == pytest.approx(0.1 + 0.5 * apart)
    assert spread == pytest.approx(0.5 * apart)
    assert each == pytest.approx((0.1, sigma, 0.1 + apart, sigma))


def test_the_slowest_log_decides_what_is_asked_for(vehicle, case):
    fast, slow = (flown(vehicle, rate, 10.0) for rate in (250, 100))
    told = dataclasses.replace(fast, command_rate=100.0)
    for name, flights, is_fast in (
        ("fast", [fast], True),
        ("both", [fast, slow], False),
        ("the other way round", [slow, fast], False),
        ("slow commands", [told], False),
    ):
        with case(name):
            found = identify(vehicle, flights, stopped=lambda: True)
            assert found.fast is is_fast
            assert any("aliased" in why for why in found.refused.values()) is not is_fast


def test_free_flight_keeps_away_from_take_off_impacts_and_landing():
    """Commands are averaged over a second: at half of them, the second's middle, it flies."""
    time = np.arange(0.0, 30.0, 0.01)
    flies = (time >= 5.0) & (time < 25.0)
    force = np.tile([0.0, 0.0, 9.8], (len(time), 1))
    force[1500] = [0.0, 0.0, 40.0]
    gyro = np.zeros((len(time), 3))
    gyro[2000, 1] = 18.0
    flight = free_flight(
        Flight(time, np.repeat(np.where(flies, 500.0, 0.0)[:, None], 4, axis=1), gyro, force)
    )
    begins = time[np.flatnonzero(np.diff(flight.good.astype(int)) == 1) + 1]
    ends = time[np.flatnonzero(np.diff(flight.good.astype(int)) == -1)]
    np.testing.assert_allclose(begins, [6.0, 16.0, 21.0], atol=0.03)
    np.testing.assert_allclose(ends, [14.0, 19.0, 24.0], atol=0.03)
    runs = flight.pieces(5.0)
    assert [round(each.time[0]) for each in runs] == [6]
