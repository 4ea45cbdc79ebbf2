"""What identify compares with a log, and what it states, on flights in closed form.

Between two samples each command is held, so a rotor's speed is w = u + (w_0 - u) exp(-t / tau)
exactly, and so are the thrust k w² and its integral.
"""

import dataclasses
import math
from pathlib import Path

import numpy as np
import pytest
from scipy import signal
from scipy.integrate import solve_ivp

from workbench.common.series import held_on_grid
from workbench.design.rollout.vehicle_batch import rotor_records
from workbench.dynamics.rotor_response import split_error
from workbench.extras.flightdata.identify.fit import FIT_CHANNELS, Fit, Fitter
from workbench.extras.flightdata.identify.flight import IdentificationFlight, free_flight
from workbench.extras.flightdata.identify.flight_piece import STEPS_PER_ROTOR_LAG, make_piece
from workbench.extras.flightdata.identify.held_back import prediction_errors
from workbench.extras.flightdata.identify.identified_number import (
    hover_command,
    identified_rows,
    thrust_to_weight_at,
)
from workbench.extras.flightdata.identify.model_rows import (
    compiled_rotor_speeds,
    delayed_samples,
    model_rows,
    sensor_filtered,
)
from workbench.extras.flightdata.identify.quantities import IdentifiedQuantity, spin_up
from workbench.extras.flightdata.identify.report import make_report, noise_densities
from workbench.extras.flightdata.identify.search import (
    IdentificationResult,
    _with_lag,
    combined_lag,
    identify,
)
from workbench.plant.loading import load_vehicle
from workbench.plant.vehicle import Vehicle

DRONES = Path(__file__).parents[3] / "drones"
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
) -> IdentificationFlight:
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
    return IdentificationFlight(
        time=np.arange(count) / rate, commands=commands, gyro=gyro, force=force
    )


def test_spin_up_is_a_rotors_momentum_in_hover_over_its_drag_torque():
    """By hand for 4 rotors that lift 2 kg: w² = 2 g / 4 / 1e-5, so J w / (0.016 * 1e-5 w²)."""
    plain = load_vehicle(DRONES / "crazyflie.urdf")
    rotors = tuple(
        dataclasses.replace(
            rotor,
            motor_constant=1e-5,
            moment_constant=0.016,
            linear_motor_constant=0.0,
            inertia=6e-5,
            max_rot_velocity=2000.0,
        )
        for rotor in plain.rotors
    )
    speed = math.sqrt(2.0 * 9.81 / 4.0 / 1e-5)
    wanted = 6e-5 * speed / (0.016 * 1e-5 * speed**2)
    assert spin_up(dataclasses.replace(plain, mass=2.0, rotors=rotors)) == pytest.approx(wanted)


def test_the_model_says_of_each_row_what_was_measured_in_it(vehicle, case):
    """At rates at which samples are split, taken as they are, and averaged, and with a delay."""
    for rate, delay in ((250, 0.0), (500, 0.0), (500, 5e-3), (1000, 7.5e-3), (2000, 0.0)):
        with case(rate, delay):
            piece = make_piece(flown(vehicle, rate, 0.6, delay), vehicle)
            rows = model_rows(vehicle, {"delay": delay}, piece)
            for name, measured in (("turn_x", piece.turn[:, 0]), ("force", piece.force[:, 2])):
                off = np.abs(rows[:, FIT_CHANNELS.index(name)] - measured)[5:]
                # a row in which the command steps may be off by more
                assert np.quantile(off, 0.75) < 0.002 * np.ptp(measured), name


def test_rotors_follow_a_log_as_the_blended_equation_says(vehicle):
    """Up, down and within the blend, at a sixteenth of the shorter of two time constants."""
    up, down = 0.0125, 0.025
    rotor = dataclasses.replace(vehicle.rotors[0], time_constant_up=up, time_constant_down=down)
    step, begin = up / STEPS_PER_ROTOR_LAG, 900.0
    asked = np.repeat([300.0, 900.0, 903.0, 600.0, 0.0, 9e9], 40)
    speeds, slopes = np.empty((2, len(asked), 1))
    speeds[0] = begin
    compiled_rotor_speeds(asked[:, None], rotor_records([rotor]), step, speeds, slopes)

    def rate(_, w, command):
        parts = split_error(command - w[0])
        return [parts[0] / up + parts[1] / down]

    for k, command in enumerate(np.minimum(asked, rotor.max_rot_velocity)):
        times = (0.5 * step, step)
        found = solve_ivp(
            rate, (0.0, step), [begin], t_eval=times, args=(command,), rtol=1e-11, atol=1e-11
        )
        middle, end = found.y[0]
        assert speeds[k, 0] == pytest.approx(middle, abs=2e-3)
        assert step * slopes[k, 0] == pytest.approx(end - begin, abs=2e-3)
        begin = begin + step * slopes[k, 0]


def test_the_models_specific_force_is_behind_the_accelerometers_filter(vehicle):
    """A Butterworth filter of second order at 30 Hz, by scipy."""
    flight = flown(vehicle, 1000, 0.6)
    first, section = flight.force[0], signal.butter(2, 30.0, fs=1000.0, output="sos")
    behind = signal.sosfilt(section, flight.force - first, axis=0)
    flight = dataclasses.replace(flight, force=behind + first, force_lowpass=30.0)
    piece = make_piece(flight, vehicle)
    off = np.abs(model_rows(vehicle, {"delay": 0.0}, piece)[:, 5] - piece.force[:, 2])[5:]
    assert np.quantile(off, 0.75) < 0.005 * np.ptp(piece.force[:, 2])


def test_behind_a_filter_a_ramp_is_late_by_its_delay(case):
    time = 0.001 * np.arange(400)
    for delay in (0.0004, 0.003, 0.011):
        with case(delay):
            found = sensor_filtered(time[:, None] * [1.0, -2.0], delay, 0.001)
            np.testing.assert_allclose(
                found[200:], (time[200:, None] - delay) * [1.0, -2.0], atol=1e-6
            )


def test_where_lags_are_apart_rotation_has_its_own(vehicle):
    piece = make_piece(flown(vehicle, 250, 0.4), vehicle)
    apart = model_rows(vehicle, {"lag": 0.1, "lag_turn": 0.2}, piece)
    lift, turn = (model_rows(vehicle, {"lag": lag}, piece) for lag in (0.1, 0.1 + 0.2))
    np.testing.assert_array_equal(apart, np.hstack([turn[:, :3], lift[:, 3:]]))
    assert np.abs(turn - lift)[:, [0, 5]].max() > 0.1


def test_the_voltage_of_a_run_is_over_the_mean_of_all(vehicle):
    flight = dataclasses.replace(flown(vehicle, 250, 0.4), voltage=np.full(100, 15.6))
    np.testing.assert_allclose(make_piece(flight, vehicle, 15.0).voltage, 15.6 / 15.0)
    np.testing.assert_allclose(make_piece(flight, vehicle).voltage, 1.0)


def test_samples_of_before_lie_on_lines_between_samples(case):
    values = np.arange(20.0)[:, None] ** 2 * [1.0, -2.0]
    for late in (0.0, 1.0, 2.25, -0.25, -3.0):
        with case(late):
            then = np.arange(20.0) - late
            expected = np.interp(then, np.arange(20.0), np.arange(20.0) ** 2)
            found = delayed_samples(values, late)
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
    thrust = [IdentifiedQuantity("thrust", 0.0, 0.002, math.inf, "force")]
    off, deviations = [], []
    for stop in (False, True):
        fitter = Fitter(vehicle, [piece], thrust, ["force"], stopped=lambda stop=stop: stop)
        found = fitter.fit(np.zeros(1))
        assert found.complete is not stop
        off.append(abs(found.value("thrust") - math.log(1.1)))
        deviations.append(found.deviation("thrust"))
    assert off[0] < 1e-3 and deviations[0] < 1e-3
    assert off[1] == pytest.approx(math.log(1.1)) and off[1] < 1.1 * deviations[1]


def test_a_search_from_far_away_ends_at_the_truth(vehicle):
    """Of steps of 60 steps of a quantity at most, a distance of 20 of these takes 20."""
    piece = make_piece(flown(vehicle, 200.0, 8.0), vehicle)
    thrust = [IdentifiedQuantity("thrust", 0.0, 0.0005, math.inf, "force")]
    found = Fitter(vehicle, [piece], thrust, ["force"]).fit(np.array([-0.6]))
    assert found.complete
    assert abs(found.value("thrust")) < 0.01


def test_intervals_have_the_freedom_of_independent_blocks(vehicle):
    """Errors may hang together for 3 s: 30 s have 10 blocks, and one is lost to the mean."""
    piece = make_piece(flown(vehicle, 250, 30.0), vehicle)
    thrust = [IdentifiedQuantity("thrust", 0.0, 0.002, math.inf, "force")]
    assert Fitter(vehicle, [piece], thrust, ["force"]).fit(np.zeros(1)).freedom == 9


def test_what_is_known_before_draws_a_search_back(vehicle):
    """Known to a millionth, a thrust stays as it is described, wherever the search begins."""
    piece = make_piece(flown(vehicle, 250, 6.0, thrust=1.1), vehicle)
    known = [IdentifiedQuantity("thrust", 0.0, 0.002, 1e-6, "force")]
    found = Fitter(vehicle, [piece], known, ["force"]).fit(np.array([0.05]))
    assert abs(found.value("thrust")) < 1e-3


def found_of(
    vehicle: Vehicle, values: dict[str, float], covariance, flight: IdentificationFlight
) -> IdentificationResult:
    """Return a result of a search with such values (k) and covariance (k, k)."""
    none = np.empty(0)
    numbers = np.array([*values.values()])
    fit = Fit((*values,), numbers, covariance, 20, none, FIT_CHANNELS, complete=True)
    return IdentificationResult(vehicle, (flight,), fit, None, {}, 10.0)


def test_two_lags_that_do_not_agree_spread_as_far_as_they_are_apart(vehicle):
    """DerSimonian and Laird with two alike: their mean, with half their distance as deviation."""
    sigma, apart = 0.02, 0.3
    covariance = sigma**2 * np.array([[1.0, -1.0], [-1.0, 2.0]])
    flight = flown(vehicle, 250, 0.1)
    lag, spread, each = combined_lag(
        found_of(vehicle, {"lag": 0.1, "lag_turn": apart}, covariance, flight).fit
    )
    assert lag == pytest.approx(0.1 + 0.5 * apart)
    assert spread == pytest.approx(0.5 * apart)
    assert each == pytest.approx((0.1, sigma, 0.1 + apart, sigma))


def test_a_lag_that_is_not_known_spreads_all_other_numbers(vehicle):
    """A lag of 0.2 with a deviation of 0.05, for each of which the thrust moves by -3."""
    alone = 0.01 * np.array([[4.0, 1.0], [1.0, 9.0]])
    at = found_of(vehicle, {"thrust": 1.0, "drag": 2.0}, alone, flown(vehicle, 250, 0.1)).fit
    moved = dataclasses.replace(at, values=at.values + 0.05 * np.array([-3.0, 1.0]))
    found = _with_lag(at, moved, 0.2, 0.05)
    per_lag = np.array([1.0, -3.0, 1.0])
    expected = 0.05**2 * np.outer(per_lag, per_lag)
    expected[1:, 1:] += alone
    assert found.names == ("lag", "thrust", "drag")
    np.testing.assert_allclose(found.values, [0.2, 1.0, 2.0])
    np.testing.assert_allclose(found.covariance, expected)


def test_lag_and_delay_together_are_known_better_where_one_makes_up_for_the_other(vehicle):
    """The variance of a sum, of 50 ms exp(x) + d with 20 blocks: 2.086 deviations are 95 %."""
    x, d = 0.1, 0.004
    lag = LAG * math.exp(x)
    of_lag, of_delay, together = 0.04, 0.002, -0.9 * 0.04 * 0.002
    covariance = np.diag([of_lag**2, of_delay**2, 1e-6])
    covariance[0, 1] = covariance[1, 0] = together
    values = {"lag": x, "delay": d, "thrust": 0.0}
    found = found_of(vehicle, values, covariance, flown(vehicle, 250, 0.1))
    rows = {row.name: row for row in identified_rows(found)}
    width = 2.086 * math.sqrt((of_lag * lag) ** 2 + of_delay**2 + 2.0 * lag * together)
    both = rows["lag_with_delay"]
    assert (both.value, both.low, both.high) == pytest.approx(
        (lag + d, lag + d - width, lag + d + width), rel=1e-3
    )
    alone = rows["rotor_lag"]
    ends = [LAG * math.exp(x + sign * 2.086 * of_lag) for sign in (-1.0, 1.0)]
    assert (alone.low, alone.high) == pytest.approx(ends, rel=1e-3)


def test_a_hover_command_is_where_the_curve_carries_the_weight(vehicle):
    """Of a u + b u² of the described largest thrust, a quadratic equation."""
    most = sum(rotor.max_thrust for rotor in vehicle.rotors) / (vehicle.mass * 9.81)
    a, b = 0.25, 0.6
    values = {"curve_0": 0.0, "curve_1": a, "curve_2": b}
    found = found_of(vehicle, values, 1e-6 * np.eye(3), flown(vehicle, 250, 0.1))
    command, low, high = hover_command(found)
    assert command == pytest.approx((math.sqrt(a**2 + 4.0 * b / most) - a) / (2.0 * b), abs=1e-5)
    assert low < command < high
    assert thrust_to_weight_at(found, 1.0)[0] == pytest.approx(most * (a + b))


def test_noise_is_stated_over_the_root_of_frequency(vehicle):
    """White samples at 250 Hz have half of that as band: 0.01 rad/s are 0.01 / sqrt(125)."""
    random, flight = np.random.default_rng(2), flown(vehicle, 250, 40.0)
    noisy = dataclasses.replace(
        flight,
        gyro=0.01 * random.normal(size=flight.gyro.shape),
        force=0.3 * random.normal(size=flight.force.shape),
    )
    found = found_of(vehicle, {"delay": 0.0}, np.eye(1), noisy)
    assert noise_densities(found) == pytest.approx(np.array([0.01, 0.3]) / math.sqrt(125), rel=0.03)


def test_the_true_model_predicts_what_a_constant_does_not(vehicle):
    found = found_of(vehicle, {"delay": 0.0}, np.eye(1), flown(vehicle, 250, 4.0))
    of = prediction_errors(found)
    assert of.turn < 1e-3 * of.constant_turn
    assert of.force < 0.03 * of.constant_force  # at the steps of the commands


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


def test_a_result_is_validated_on_what_it_has_not_seen(vehicle):
    """In the last fifth of a flight the accelerometer is off by 2 m/s²."""
    flight = flown(vehicle, 100, 20.0)
    noise = 0.02 * np.random.default_rng(5).normal(size=flight.force.shape)
    off = np.where(flight.time >= 16.0, 2.0, 0.0)[:, None] * [0.0, 0.0, 1.0]
    report = make_report(
        vehicle, [dataclasses.replace(flight, force=flight.force + noise + off)], []
    )
    assert report.held_back is not None
    assert report.held_back.force == pytest.approx(2.0, rel=0.02)
    # the speeds of either side are even between 0.8 and 1.2 of hover, so their squares deviate by
    # 0.8 / sqrt(12) of it, and the mean of two sides by less
    deviation = 9.81 * 0.8 / math.sqrt(12.0) / math.sqrt(2.0)
    assert report.held_back.commanded_force == pytest.approx(deviation, rel=0.1)


def test_free_flight_keeps_away_from_take_off_impacts_and_landing():
    """Commands are averaged over a second: at half of them, the second's middle, it flies."""
    time = np.arange(0.0, 30.0, 0.01)
    flies = (time >= 5.0) & (time < 25.0)
    force = np.tile([0.0, 0.0, 9.8], (len(time), 1))
    force[1500] = [0.0, 0.0, 40.0]
    gyro = np.zeros((len(time), 3))
    gyro[2000, 1] = 18.0
    flight = free_flight(
        IdentificationFlight(
            time, np.repeat(np.where(flies, 500.0, 0.0)[:, None], 4, axis=1), gyro, force
        )
    )
    begins = time[np.flatnonzero(np.diff(flight.good.astype(int)) == 1) + 1]
    ends = time[np.flatnonzero(np.diff(flight.good.astype(int)) == -1)]
    np.testing.assert_allclose(begins, [6.0, 16.0, 21.0], atol=0.03)
    np.testing.assert_allclose(ends, [14.0, 19.0, 24.0], atol=0.03)
    runs = flight.pieces(5.0)
    assert [round(each.time[0]) for each in runs] == [6]
