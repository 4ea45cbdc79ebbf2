"""Flights again: with their own law they are the log, with another one what the diagram flies."""

import dataclasses
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from workbench.control.controller_file import load_controller
from workbench.extras.flightdata.predict import what_if
from workbench.extras.flightdata.predict.driven import PUSH_SIZE
from workbench.extras.flightdata.predict.motion import resampled
from workbench.extras.flightdata.predict.uncertainty import Uncertainty, drawn_vehicle
from workbench.extras.flightdata.predict.what_if import Explained, Law
from workbench.gains.gain_choice import flight_gains
from workbench.plant.variation import Variation
from workbench.scenario.scenario import Scenario, VehicleConfig

DRONES = Path(__file__).parents[3] / "drones"
SOFTER = {"kp_position_xy": 1.5, "kp_velocity_x": 1.2, "kp_velocity_y": 1.2}
NOTHING = Uncertainty(*[0.0] * len(dataclasses.fields(Uncertainty)))


def laws(vehicle, changed):
    controller = load_controller("pd")
    own = dict(flight_gains(vehicle, controller=controller))
    return Law(controller, own), Law(controller, own | changed)


def flown_again(flown, own, other, uncertainty, draws=40):
    explained = Explained(flown.motion, flown.vehicle, own, uncertainty, draws)
    return explained.compare(list(explained.flights(other)))


def test_the_band_holds_nineteen_of_twenty_flights(simulate):
    """Forty-one flights beside each other by 1 cm: it leaves out one at either side."""
    flown = simulate(Scenario(), duration=0.5)
    own, _ = laws(flown.vehicle, {})
    explained = Explained(flown.motion, flown.vehicle, own, NOTHING, draws=0)
    (again,) = explained.flights(own)
    beside = [again + 0.01 * k * np.eye(13)[4] for k in range(-20, 21)]
    found = explained.compare(beside)
    assert (found.lost, found.drawn) == (0, 41)
    wide = [found.low[:, 0] - again[:, 4], found.high[:, 0] - again[:, 4]]
    np.testing.assert_allclose(wide[0], -0.19 - 1e-3, atol=1e-9)
    np.testing.assert_allclose(wide[1], 0.19 + 1e-3, atol=1e-9)
    np.testing.assert_allclose(found.high[:, 1:] - found.low[:, 1:], 2e-3, atol=1e-9)


def test_what_goes_below_the_ground_is_lost_there(simulate):
    """A log from the air has its ground at 0; 4 cm below it may be rounding, 6 cm are not."""
    flown = simulate(Scenario(), duration=0.5)
    own, _ = laws(flown.vehicle, {})
    explained = Explained(flown.motion, flown.vehicle, own, NOTHING, draws=0)
    (again,) = explained.flights(own)
    at = len(again) // 2

    def sunk(height):
        states = again.copy()
        states[at:, 6] = height
        return states

    away = again.copy()
    away[at:, 4] += 100.0
    found = explained.compare([sunk(-0.04), sunk(-0.06), away])
    assert (found.lost, found.grounded, found.drawn) == (2, 1, 3)
    assert found.stays == len(again) and np.isfinite(found.other).all()
    assert found.low[:, 2].min() >= -0.042
    found = explained.compare([sunk(-0.06), again])
    assert (found.lost, found.grounded, found.stays) == (1, 1, at)
    assert np.isnan(found.other[at:]).all() and np.isfinite(found.other[:at]).all()
    assert np.abs(found.difference).max() < 1e-3 and found.off_setpoint.max() < 1.0


def test_the_ground_is_the_lowest_height_of_a_log_that_shows_it(simulate):
    motion = simulate(Scenario(), duration=0.5).motion
    lifted = motion.p + [0.0, 0.0, 20.0]
    assert motion.ground == motion._replace(p=lifted).ground == 0.0
    assert motion._replace(p=motion.p - [0.0, 0.0, 7.0]).ground == motion.p[:, 2].min() - 7.0
    commands = motion.commands.copy()
    commands[0] = 0.0
    assert motion._replace(p=lifted, commands=commands).ground == lifted[:, 2].min()


def test_motors_at_their_limit_put_the_height_in_doubt(simulate):
    """They give 0.9 of the weight at most, and 1.9; in the log they are full for an eighth."""
    flown = simulate(Scenario(), duration=0.5)
    hover = flown.vehicle.hover_speeds[0]
    for share, expected in ((0.9, 1.0), (1.9, 0.0)):
        rotors = tuple(
            dataclasses.replace(rotor, max_rot_velocity=hover * share**0.5)
            for rotor in flown.vehicle.rotors
        )
        vehicle = dataclasses.replace(flown.vehicle, rotors=rotors)
        own, other = laws(vehicle, {"kp_position_xy": 1.5})
        commands = np.where(flown.motion.time[:, None] < 0.0625, 1.0, flown.motion.commands)
        motion = flown.motion._replace(commands=commands)
        explained = Explained(motion, vehicle, own, NOTHING, draws=0)
        found = explained.compare(list(explained.flights(other)))
        assert found.saturated == pytest.approx((0.125, expected, expected), abs=0.03)
        assert bool(found.doubt) is (expected == 1.0)
        # pd has no integrals; where the log's own motors are at their limits, they are the reason
        assert own.controller.name == "pd" and "integrals" not in found.doubt
        integrating = dataclasses.replace(found, remembers=True)
        assert ("integrals of inner loops" in integrating.doubt) is (expected == 1.0)
        as_often = dataclasses.replace(integrating, saturated=(expected, expected, expected))
        assert "integrals" not in as_often.doubt
    assert explained.compare(list(explained.flights(own))).saturated[2] == 0.0


def test_a_part_without_a_long_gap_is_flown_again(simulate):
    """Of 0.5 s in the air all but the first 0.1 s and 3 ms are without a gap of 0.5 s."""
    flown = simulate(Scenario(), duration=1.0)
    own, _ = laws(flown.vehicle, {})
    time = flown.motion.time
    measured = (time < 0.1) | (time >= 0.65)
    part = Explained(flown.motion._replace(measured=measured), flown.vehicle, own, NOTHING, 0)
    (states,) = part.flights(own)
    found = part.compare([states])
    assert found.time[0] == pytest.approx(0.65, abs=0.01)
    assert "has gaps of more than 0.5 s" in part.doubt and "0.7 to 1.0 s" in part.doubt
    whole = Explained(flown.motion, flown.vehicle, own, NOTHING, 0)
    assert whole.doubt == ""
    battery = dataclasses.replace(own, gains=own.gains | {"vbat": 4.2})
    shares = flown.motion._replace(voltage=np.full(len(time), np.nan), speeds_shown=False)
    assert "no battery voltage" in Explained(shares, flown.vehicle, battery, NOTHING, 0).doubt


def test_sampled_vehicles_scatter_as_the_uncertainty_says(vehicle):
    """Logarithms of their factors over 400 draws; a standard deviation is then known to 3.5 %, and
    a correlation to 0.05."""
    random, uncertain = np.random.default_rng(0), Uncertainty()
    drawn = [drawn_vehicle(vehicle, uncertain, random) for _ in range(400)]
    rotor = vehicle.rotors[0]
    apart = (
        ([each.mass / vehicle.mass for each, _ in drawn], 0.02),
        ([each.inertia[0, 0] / vehicle.inertia[0, 0] for each, _ in drawn], 0.1),
        ([each.rotors[0].motor_constant / rotor.motor_constant for each, _ in drawn], 0.02),
        ([each.rotors[0].time_constant_up / rotor.time_constant_up for each, _ in drawn], 0.1),
        (
            [
                each.rotors[0].rotor_drag_coefficient / rotor.rotor_drag_coefficient
                for each, _ in drawn
            ],
            0.3,
        ),
        ([np.exp(wind[0]) for _, wind in drawn], 2.0),
        ([np.exp(wind[1]) for _, wind in drawn], 2.0),
    )
    for factors, size in apart:
        assert np.std(np.log(factors)) == pytest.approx(size, rel=0.14)
        assert abs(np.mean(np.log(factors))) < 0.2 * size
    hang_together = np.corrcoef(np.log([factors for factors, _ in apart])) - np.eye(len(apart))
    assert np.abs(hang_together).max() < 0.2


def test_a_push_has_the_same_impulse_at_another_period():
    """100 updates of 1/100 s in place of 128 of 1/128 s; one of 1 N for all of them stays so."""
    pushes = np.random.default_rng(0).normal(size=(128, PUSH_SIZE))
    pushes[:, 0] = 1.0
    begun = SimpleNamespace(law=SimpleNamespace(period=0.01), time=3.0 + 0.01 * np.arange(101))
    found = what_if._resampled_pushes(pushes, 1.0 / 128.0, begun)
    np.testing.assert_allclose(found[:, 0], 1.0)
    np.testing.assert_allclose(found.sum(axis=0) / 100.0, pushes.sum(axis=0) / 128.0, atol=1e-12)


def test_the_own_law_returns_the_log_and_a_push_is_found(simulate):
    push = (0.4, -0.3, 0.2)
    flown = simulate(Scenario(), push=push)
    own, _ = laws(flown.vehicle, {})
    found = flown_again(flown, own, own, NOTHING, draws=2)
    assert np.abs(found.again - found.logged)[:, 4:7].max() < 1e-3
    assert np.abs(found.other - found.logged)[:, 4:7].max() < 1e-3
    assert np.all(found.high - found.low >= 2e-3 - 1e-9)
    pushed = (found.time > 1.6) & (found.time < 1.9)
    before = (found.time > 1.2) & (found.time < 1.4)
    told = (found.disturbance[pushed] - found.disturbance[before].mean(axis=0))[:, :3]
    assert told.mean(axis=0) == pytest.approx(push, abs=0.02)


@pytest.mark.slow
def test_other_gains_make_the_flight_that_the_diagram_makes(simulate):
    wind = {"wind_x": 1.5, "wind_y": -1.0}
    flown, truth = simulate(Scenario(), wind), simulate(Scenario(), {**wind, **SOFTER})
    own, other = laws(flown.vehicle, SOFTER)
    found = flown_again(flown, own, other, NOTHING, draws=2)
    real = resampled(truth.states[:, 4:7], truth.motion.period, found.time)
    changed = np.abs(real - found.logged[:, 4:7]).max()
    assert changed > 0.1
    assert np.abs(found.other[:, 4:7] - real).max() < 0.05 * changed


@pytest.mark.slow
def test_another_law_of_another_period_makes_the_flight_that_the_diagram_makes(simulate):
    """A Crazyflie that pd flew at 128 Hz, and its own firmware's law would at 500 Hz; a push."""
    drone, push = VehicleConfig(model=str(DRONES / "nanobench.urdf")), (0.1, -0.08, 0.05)
    flown = simulate(Scenario(vehicle=drone), push=push)
    truth = simulate(Scenario(controller="crazyflie", vehicle=drone), push=push)
    own, other = (
        Law(controller, dict(flight_gains(flown.vehicle, controller=controller)))
        for controller in map(load_controller, ("pd", "crazyflie"))
    )
    found = flown_again(flown, own, other, NOTHING, draws=2)
    real = resampled(truth.states[:, 4:7], truth.motion.period, found.time)
    changed = np.abs(real - found.logged[:, 4:7]).max()
    assert changed > 0.1
    assert np.abs(found.other[:, 4:7] - real).max() < 0.02 * changed


@pytest.mark.slow
def test_the_truth_lies_in_the_band_nine_times_of_ten_and_not_always(simulate):
    """Twelve flights in gusts and wind, of vehicles out of those that the band counts with."""
    random = np.random.default_rng(7)
    uncertainty = Uncertainty(thrust=0.0, drag=0.0)  # the diagram varies neither
    inside = []
    for seed in range(12):
        deviations = uncertainty.mass, uncertainty.inertia, uncertainty.rotor_lag
        mass, inertia, lag = np.exp(random.standard_normal(3) * deviations).tolist()
        scenario = Scenario()
        scenario.vehicle.variation = Variation(mass=mass, inertia=inertia, rotor_lag=lag)
        scenario.sensors.seed = seed
        wind_x, wind_y = (uncertainty.wind * random.standard_normal(2)).tolist()
        hidden = {"turbulence": 1.0, "wind_x": wind_x, "wind_y": wind_y}
        flown = simulate(scenario, hidden)
        truth = simulate(scenario, {**hidden, **SOFTER})
        own, other = laws(flown.vehicle, SOFTER)
        found = flown_again(flown, own, other, uncertainty)
        real = resampled(truth.states[:, 4:7], truth.motion.period, found.time)
        settled = found.time > 0.5  # nothing differs before
        within = (real >= found.low[:, :3]) & (real <= found.high[:, :3])
        inside.append(within[settled].mean())
    assert 0.90 <= np.mean(inside) < 1.0
