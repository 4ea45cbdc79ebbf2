"""Oracle: python-control, one response at a time."""

import control
import numpy as np
import pytest

from workbench.design.step_metrics import StepMetrics, step_info, step_metrics

TIME = np.arange(0.0, 3.0, 1.0 / 128.0)
NAMES = {
    "rise_time": "RiseTime",
    "settling_time": "SettlingTime",
    "overshoot": "Overshoot",
    "undershoot": "Undershoot",
    "peak": "Peak",
    "peak_time": "PeakTime",
    "steady_state_value": "SteadyStateValue",
}
"""Ours and python-control's."""


def responses(command: float) -> np.ndarray:
    """Return steps that swing, creep, start the wrong way, never settle, or come to nothing."""
    rng = np.random.default_rng(4)
    rows = []
    for damping in np.linspace(0.05, 1.5, 30):
        frequency, zero = rng.uniform(0.5, 10.0), rng.uniform(-0.3, 0.3)
        system = control.tf(
            [zero * frequency**2, frequency**2], [1.0, 2.0 * damping * frequency, frequency**2]
        )
        rows.append(control.step_response(system, TIME).outputs * rng.uniform(0.5, 1.1))
    rows += [rng.normal(size=len(TIME)), np.ones(len(TIME)), -rows[3]]
    return command * np.array(rows)


@pytest.mark.parametrize("command", [1.0, -8.0])
def test_they_are_those_of_python_control(command):
    rows = responses(command)
    metrics = step_info(TIME, rows, command)
    for index, row in enumerate(rows):
        info = control.step_info(row, T=TIME)
        for name, theirs in NAMES.items():
            wanted = pytest.approx(info[theirs], rel=1e-12, nan_ok=True)
            assert getattr(metrics, name)[index] == wanted, (name, index)
        off = 100.0 * abs(row[-1] - command) / abs(command)
        assert metrics.steady_state_error[index] == pytest.approx(off, rel=1e-12)


def test_one_response_has_the_same_numbers_as_plain_floats():
    row = responses(2.0)[20]
    alone, info = step_metrics(TIME, row, 2.0), control.step_info(row, T=TIME)
    for name, theirs in NAMES.items():
        assert type(getattr(alone, name)) is float
        assert getattr(alone, name) == pytest.approx(info[theirs], rel=1e-12)
    assert StepMetrics(*alone.numbers.values()).numbers == alone.numbers  # in the record's order


def test_a_response_that_ends_before_has_none():
    """python-control gives it an infinite peak."""
    row = responses(1.0)[0]
    row[200:] = np.nan
    metrics = step_info(TIME, np.array([row, np.ones(len(TIME))]), 1.0)
    info = control.step_info(row, T=TIME)
    assert metrics.peak[0] == info["Peak"] == np.inf
    for name in ("rise_time", "settling_time", "overshoot", "undershoot", "steady_state_error"):
        assert np.isnan(getattr(metrics, name)[0])
        assert np.isfinite(getattr(metrics, name)[1])


def test_a_response_that_comes_back_to_nothing_is_no_failure():
    """Shares of nothing are infinite or not known."""
    row = np.sin(np.linspace(0.0, np.pi, len(TIME)))
    row[-1] = 0.0
    with np.errstate(all="ignore"):
        info = control.step_info(row, T=TIME)
    metrics = step_info(TIME, row[None, :], 1.0)
    assert metrics.overshoot[0] == pytest.approx(info["Overshoot"], nan_ok=True)
    assert metrics.rise_time[0] == info["RiseTime"]
    assert metrics.settling_time[0] == pytest.approx(info["SettlingTime"], nan_ok=True)
    assert metrics.steady_state_error[0] == 100.0


def test_numbers_of_a_step_that_means_little_are_withheld():
    """First order: flown for so many time constants, begun so far away, and neither."""
    tau = 0.4

    def numbers(time_constants: float, start: float = 0.0):
        time = np.linspace(0.0, time_constants * tau, 500)
        return step_metrics(time, 1.0 + (start - 1.0) * np.exp(-time / tau), 1.0)

    settled = numbers(8.0)
    assert settled.withheld == ""
    assert settled.rise_time == pytest.approx(tau * np.log(9.0), rel=0.01)
    short = numbers(3.0)
    assert short.withheld == "the step has not settled within 1.2 s; fly it for longer"
    gone = ("rise_time", "settling_time", "overshoot", "undershoot")
    ends = ("steady_state_value", "steady_state_error")
    assert np.isnan([short.numbers[name] for name in (*gone, *ends)]).all()
    assert short.peak == pytest.approx(1.0 - np.exp(-3.0))
    moving = numbers(8.0, start=0.3)
    assert moving.withheld == "the step did not begin at rest; let the drone settle first"
    assert np.isnan([moving.numbers[name] for name in gone]).all()
    assert moving.steady_state_error == pytest.approx(0.0, abs=0.1)


def test_a_response_counts_as_settled_only_where_it_is_nearly_there():
    """What a first-order response that counts as settled has still to go is within 2 %."""
    for time_constants in np.linspace(1.0, 8.0, 71):
        time = np.linspace(0.0, time_constants, 2000)
        settled = step_metrics(time, 1.0 - np.exp(-time), 1.0).withheld == ""
        assert not settled or np.exp(-time_constants) < 0.02
        assert settled or time_constants < 4.5
