"""Oracles: the standard's formulas written anew, scipy's spectra and matrix exponentials."""

import math

import numba
import numpy as np
import pytest
from scipy.linalg import expm
from scipy.signal import welch

from workbench.common.jitable import register_with_numba
from workbench.dynamics.air.update import intensities, lengths, step_filters, velocities

FOOT = 0.3048
HEIGHT = 50.0
AIRSPEED = 10.0
W20 = 15.4
PERIOD = 0.05
SAMPLES = 2**19
SEGMENT = 2**13

register_with_numba()


@numba.njit
def _flight(noise, height, airspeed, period, w20):
    series = np.empty((len(noise), 3))
    eddies = np.zeros(5)
    passed = np.inf
    for i in range(len(noise)):
        after = np.empty(5)
        step_filters(eddies, noise[i], height, airspeed, passed, after)
        series[i] = velocities(after, height, w20)
        eddies = after
        passed = period
    return series


def standard(height: float, w20: float) -> tuple[float, float, float, float]:
    """Return s_level, L_level, s_w, L_w of MIL-F-8785C, figures 10 and 11 in feet."""
    h = height / FOOT
    base = 0.177 + 0.000823 * h
    s_w = 0.1 * w20
    return s_w * base**-0.4, FOOT * h / base**1.2, s_w, FOOT * h


def spectrum(frequency: np.ndarray, s: float, length: float, along: bool) -> np.ndarray:
    """Return the one-sided power density over frequency in Hz, from that over rad/m."""
    k = 2.0 * math.pi * frequency / AIRSPEED
    x = (length * k) ** 2
    if along:
        density = s**2 * 2.0 * length / math.pi / (1.0 + x)
    else:
        density = s**2 * length / math.pi * (1.0 + 3.0 * x) / (1.0 + x) ** 2
    return density * 2.0 * math.pi / AIRSPEED


@pytest.fixture(scope="module")
def series():
    """Seven hours of it."""
    noise = np.random.default_rng(5).normal(size=(SAMPLES, 5))
    return _flight(noise, HEIGHT, AIRSPEED, PERIOD, W20)


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_spectra_are_the_standards(series, axis):
    """Within 10 % in every sixth of a decade, below a twentieth of the sampling rate."""
    s_level, l_level, s_w, l_w = standard(HEIGHT, W20)
    s, length = (s_w, l_w) if axis == 2 else (s_level, l_level)
    found_at, found = welch(series[:, axis], 1.0 / PERIOD, nperseg=SEGMENT, detrend=False)
    wanted = spectrum(found_at, s, length, along=axis == 0)
    edges = np.arange(math.log10(6.0 / (SEGMENT * PERIOD)), math.log10(0.05 / PERIOD), 1 / 6)
    bins = np.digitize(np.log10(np.maximum(found_at, 1e-9)), edges)
    ratios = [
        found[bins == number].sum() / wanted[bins == number].sum()
        for number in range(1, len(edges))
    ]
    assert len(ratios) > 8
    assert ratios == pytest.approx(np.ones(len(ratios)), abs=0.1)


def test_variances_are_the_standards_and_axes_do_not_go_together(series):
    s_level, _, s_w, _ = standard(HEIGHT, W20)
    covariance = np.cov(series.T)
    wanted = np.diag([s_level**2, s_level**2, s_w**2])
    assert np.diag(covariance) == pytest.approx(np.diag(wanted), rel=0.05)
    assert covariance == pytest.approx(wanted, abs=0.1 * s_level**2)


def test_it_begins_as_it_goes_on():
    """Many flights' first samples have the variance of a long one."""
    rng = np.random.default_rng(6)
    after = np.empty(5)
    firsts = []
    for _ in range(4000):
        step_filters(np.zeros(5), rng.normal(size=5), HEIGHT, AIRSPEED, math.inf, after)
        firsts.append(velocities(after, HEIGHT, W20))
    s_level, _, s_w, _ = standard(HEIGHT, W20)
    assert np.std(firsts, axis=0) == pytest.approx([s_level, s_level, s_w], rel=0.05)


@pytest.mark.parametrize("share", [1e-6, 1e-3, 0.1, 1.0, 20.0])
def test_a_step_is_the_filters_closed_form(share):
    """Decay by the matrix exponential; noise by Van Loan's (1978) integral of it."""
    A = np.array([[-1.0, 0.0], [1.0, -1.0]])
    block = np.block([[-A, np.diag([1.0, 0.0])], [np.zeros((2, 2)), A.T]]) * share
    right = expm(block)
    decay = expm(A * share)  # of its own: within the block e^20 rounds e^-20 away
    covariance = decay @ right[:2, 2:]
    _, _, _, length = standard(HEIGHT, W20)
    period = share * length / AIRSPEED

    def stepped(eddies, noise):
        after = np.empty(5)
        step_filters(np.array(eddies), np.array(noise), HEIGHT, AIRSPEED, period, after)
        return after[3:5]

    found = np.array([stepped([0, 0, 0, *unit], [0.0] * 5) for unit in np.eye(2)]).T
    assert found == pytest.approx(decay, abs=1e-12)
    root = np.array([stepped([0.0] * 5, [0, 0, 0, *unit]) for unit in np.eye(2)]).T
    assert root @ root.T == pytest.approx(covariance, rel=1e-6, abs=1e-12)


@pytest.mark.parametrize("height", [3.048, 10.0, 50.0, 304.8])
def test_intensities_and_lengths_are_the_standards(height):
    s_level, l_level, s_w, l_w = standard(height, W20)
    assert intensities(height, W20) == pytest.approx((s_level, s_w))
    assert lengths(height) == pytest.approx((l_level, l_w))


def test_all_axes_are_alike_at_a_thousand_feet():
    """There 0.177 + 0.823 is 1: the standard's low model meets its high one."""
    assert intensities(304.8, 10.0) == pytest.approx((1.0, 1.0))
    assert lengths(304.8) == pytest.approx((304.8, 304.8))


@pytest.mark.parametrize(("beyond", "bound"), [(-1.0, 3.048), (0.0, 3.048), (500.0, 304.8)])
def test_heights_beyond_the_model_count_as_its_bounds(beyond, bound):
    assert lengths(beyond) == lengths(bound)
    assert intensities(beyond, W20) == intensities(bound, W20)


def test_at_rest_eddies_come_by_at_a_metre_a_second():
    still, slow = np.empty(5), np.empty(5)
    eddies, noise = np.ones(5), np.ones(5)
    step_filters(eddies, noise, HEIGHT, 0.0, PERIOD, still)
    step_filters(eddies, noise, HEIGHT, 1.0, PERIOD, slow)
    assert still.tolist() == slow.tolist()
