"""Measured loops against a simulation by scipy, statistics, and the linear model in flight."""

import dataclasses
import math

import numpy as np
import pytest
from scipy.signal import lfilter

from workbench.common.errors import WorkbenchError
from workbench.design.judge.loop_measurement import Measurement, fly_measurement, loop_injection
from workbench.design.judge.margins import UNSTABLE_LOOP_MARGINS
from workbench.design.judge.measured_loop import MIN_COHERENCE, MeasuredLoop, measured_loop
from workbench.design.linear.study import LinearStudy
from workbench.plant.thrust_frame import thrust_frame
from workbench.scenario.multisine import multisine
from workbench.scenario.scenario import Injection, Scenario
from workbench.session.injected import InjectedSignal

LIGHT = {"turbulence": 7.7}
ASKED = Injection("acceleration_x", 0.5, 1.0, 40.0, 6)


def flown(noise=0.0, periods=5, seed=0):
    """What comes of an injection into a loop of scipy's, one period left out: L = 3 / (z - 0.9)."""
    wave = multisine(ASKED.lowest, ASKED.highest, 1 / 100)
    sent = np.tile(ASKED.size * wave.values, periods + 1)
    disturbed = noise * np.random.default_rng(seed).standard_normal(len(sent))
    # u = -L (u + d) + n / (1 + L), so that n is the noise of the open loop's output
    came = lfilter([0.0, -0.3], [1.0, -0.6], sent) + disturbed
    count = len(wave.values)
    return InjectedSignal(ASKED, wave, came[count:].reshape(periods, count))


def true_loop(frequency):
    return 0.3 / (np.exp(1j * frequency / 100) - 0.9)


def test_a_loop_without_noise_is_exact():
    found = measured_loop(flown())
    np.testing.assert_allclose(found.response, true_loop(found.frequency), rtol=1e-6)
    assert found.coherence.min() > 0.999 and found.deviation.max() < 1e-6
    assert found.frequency[0] == pytest.approx(1.0, rel=0.01)
    assert found.frequency[-1] <= 40.0


def test_spread_and_coherence_are_as_honest_as_they_say():
    """Of many noisy measurements: errors are as large as the spread says, and coherence never
    flatters more often than one in twenty."""
    errors, coherent = [], []
    for seed in range(60):
        found = measured_loop(flown(0.3, seed=seed))
        ratio = found.response / true_loop(found.frequency)
        errors.append(np.log(np.abs(ratio)) / found.deviation)
        coherent.append(found.coherence)
    # Student's t of 8 degrees of freedom has a standard deviation of 1.15
    assert 0.9 < np.median(np.std(errors, axis=0)) < 1.4
    many = measured_loop(flown(0.3, periods=2000))
    share = np.mean(np.array(coherent) > many.coherence, axis=0)
    assert np.mean(share) < 0.07


def test_a_multisine_is_what_it_says():
    wave = multisine(0.5, 50.0, 1 / 128)
    assert wave.values.std() == pytest.approx(1.0, rel=1e-9)
    assert np.abs(wave.values).max() < 3.0
    assert (wave.lines % 2 == 1).all()
    sizes = np.abs(np.fft.rfft(wave.values))
    others = np.delete(sizes, wave.lines)
    assert others.max() < 1e-9 * sizes.max()
    assert multisine(0.5, 50.0, 1 / 128).values.tolist() == wave.values.tolist()


def close(found, least):
    """Within 1 dB and 5 degrees up to the bandwidth, where it is coherent."""
    measured = found.measured
    counts = (measured.coherence >= MIN_COHERENCE) & (measured.frequency <= found.margins.bandwidth)
    assert counts.sum() >= least, found.loop
    size, phase = found.worst()
    assert size <= 1.0 and math.degrees(phase) <= 5.0, (found.loop, size, math.degrees(phase))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("controller", "settings", "name", "lowest"),
    [("pd", {}, "roll", 2.0), ("pid", LIGHT, "velocity_z", 0.5)],
    ids=["pd", "pid, light turbulence"],
)
def test_velocity_and_attitude_loops_are_those_of_the_model(controller, settings, name, lowest):
    scenario = Scenario(controller=controller)
    close(fly_measurement(name, scenario=scenario, settings=settings, lowest=lowest), least=3)


@pytest.mark.slow
def test_a_loop_is_measured_at_its_error_and_holding_a_place_too(case):
    for name, cut, lowest in (("velocity_x", "error", 1.5), ("position_x", "actuator", 0.5)):
        with case((name, cut)):
            close(fly_measurement(name, cut=cut, lowest=lowest), least=1)


def test_what_cannot_be_measured_is_refused(case):
    for arguments, said in (
        ({"name": "velocty_x"}, "unknown loop 'velocty_x'"),
        ({"name": "roll", "settings": {"kp_roll": 2500.0, "kd_roll": 1.0}}, "is unstable"),
        ({"name": "roll", "lowest": 0.0}, "reaches from 0"),
        ({"name": "roll", "highest": 1e9}, "half the rate of the law"),
        ({"name": "roll", "periods": 2}, "has 2 periods"),
        ({"name": "roll", "size": math.nan}, "size injected is nan"),
        ({"name": "roll", "size": 500.0, "periods": 3, "lowest": 8.0}, "smaller size"),
    ):
        with case(said), pytest.raises(WorkbenchError, match=said):
            fly_measurement(**arguments)


def test_the_worst_difference_counts_where_the_measurement_is_coherent_and_within_the_bandwidth():
    frequency = np.array([1.0, 2.0, 3.0, 30.0])
    ratio = np.array([1.1, 0.8 * np.exp(-0.2j), 5.0, 7.0])
    coherence = np.array([1.0, MIN_COHERENCE, 0.9 * MIN_COHERENCE, 1.0])
    model = np.array([2.0j, 1.0 + 1.0j, 3.0, 0.1])
    measured = MeasuredLoop("p", frequency, ratio * model, coherence, np.zeros(4), 7)
    margins = dataclasses.replace(UNSTABLE_LOOP_MARGINS, bandwidth=10.0)
    found = Measurement("drone", "roll", "actuator", ASKED, measured, model, margins)
    assert found.worst() == pytest.approx((-20.0 * math.log10(0.8), 0.2))
    silent = dataclasses.replace(measured, coherence=np.zeros(4))
    assert dataclasses.replace(found, measured=silent).worst() is None


def test_an_injection_uses_up_one_of_its_limits_and_no_other(case):
    """RMS of the sampled model by its matrices; a command is a thrust before the rotors' lag."""
    study = LinearStudy(Scenario())
    frame, lag = thrust_frame(study.setup.vehicle), study.setup.vehicle.rotor_lag
    most = np.array([rotor.max_thrust for rotor in frame.rotors])
    room = np.minimum(most - frame.hover_thrusts, frame.hover_thrusts - frame.idle_thrusts)
    limits = {f"thrust_{k + 1}": 0.1 * each for k, each in enumerate(room)}
    limits |= {"roll": math.radians(6.0), "pitch": math.radians(6.0)}
    limits |= {"v_x": 0.7, "v_y": 0.7, "v_z": 0.7}
    limits |= {"roll_error": 0.03, "pitch_error": 0.03}
    binding = set()
    model = study.sampled()
    for loop in map(study.controller.loop, ("velocity_z", "roll", "yaw_rate")):
        found = loop_injection(model, loop, study.setup.vehicle)
        wave = multisine(found.lowest, found.highest, model.period)
        system = model.state_space([found.point], list(limits))
        sizes = found.size * np.abs(np.fft.rfft(wave.values))[wave.lines] / len(wave.values)
        response = np.array(
            [
                system.C @ np.linalg.solve(z * np.eye(len(system.A)) - system.A, system.B)
                + system.D
                for z in np.exp(1j * wave.frequency * model.period)
            ]
        )[:, :, 0]
        response[:, : len(most)] *= (1.0 + 1j * lag * wave.frequency)[:, None]
        rms = np.sqrt(2.0 * (np.abs(response * sizes[:, None]) ** 2).sum(axis=0))
        used = rms / list(limits.values())
        with case(loop.name):
            assert used.max() == pytest.approx(1.0, rel=1e-6)
        binding.add(list(limits)[int(used.argmax())])
    assert any(name.startswith("thrust") for name in binding), binding
