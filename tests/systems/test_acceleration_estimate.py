"""Oracles: python-control's transfer function, and closed forms for a ramp."""

import control
import numpy as np
import pytest

from workbench.systems.acceleration_estimate import (
    ESTIMATE_TIME_CONSTANT_S,
    make_acceleration_estimate,
    sampled_estimate,
)

V_WB = slice(10, 13)


def sampled_response(velocities, period) -> np.ndarray:
    """Run the sampled filter, as its docstring says it runs."""
    share, rate = sampled_estimate(period)
    f = velocities[0]
    estimates = []
    for v in velocities:
        estimates.append(rate * (v - f))
        f += share * (v - f)
    return np.array(estimates)


def test_the_continuous_filter_is_the_filtered_derivative():
    system = make_acceleration_estimate()
    blocks = [system.A(), system.B()[:, V_WB], system.C(), system.D()[:, V_WB]]
    expected = control.tf([1, 0], [ESTIMATE_TIME_CONSTANT_S, 1])
    frequencies = np.logspace(-1, 4, 50)
    wanted = expected(1j * frequencies)
    for axis in range(3):
        one = control.ss(*[block[axis : axis + 1, axis : axis + 1] for block in blocks])
        assert one(1j * frequencies) == pytest.approx(wanted, rel=1e-9)


def test_axes_do_not_mix_and_only_velocity_counts():
    system = make_acceleration_estimate()
    assert (system.num_input_ports(), system.get_input_port().size()) == (1, 13)
    for matrix in (system.B(), system.D()):
        assert not matrix[:, :10].any()
        assert matrix[:, V_WB] == pytest.approx(np.diag(np.diag(matrix[:, V_WB])))
    assert system.A() == pytest.approx(np.diag(np.diag(system.A())))


@pytest.mark.parametrize("period", [1 / 1024, 1 / 256, 1 / 128, 0.05])
def test_sampled_it_follows_a_ramp_as_the_continuous_filter_does(period):
    """s / (1 + s tau) answers a t with a (1 - exp(-t / tau)), and in the end with a."""
    times = np.arange(200) * period
    found = sampled_response(3.0 * times, period)
    assert found == pytest.approx(
        3.0 * (1.0 - np.exp(-times / ESTIMATE_TIME_CONSTANT_S)), abs=1e-10
    )
    late = np.arange(0.0, 40 * ESTIMATE_TIME_CONSTANT_S, period)
    assert sampled_response(5.0 - 2.0 * late, period)[-1] == pytest.approx(-2.0, rel=1e-12)


def test_sampled_fast_it_is_the_continuous_filter():
    """A sine of 5 Hz through both; the sampled one holds its input, half a period of lag."""
    period = 1e-4
    times = np.arange(0.0, 0.5, period)
    sine = np.sin(2 * np.pi * 5 * times)
    wanted = control.forced_response(
        control.tf([1, 0], [ESTIMATE_TIME_CONSTANT_S, 1]), times, sine
    ).outputs.ravel()
    peak = float(np.abs(wanted).max())
    assert sampled_response(sine, period) == pytest.approx(wanted, abs=0.01 * peak)


def test_a_steady_velocity_is_no_acceleration():
    assert sampled_response(np.full(50, 7.0), 1 / 128) == pytest.approx(np.zeros(50))
