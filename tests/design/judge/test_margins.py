"""Margins, against closed forms, python-control, and the poles of loops that were changed."""

import dataclasses
import math
import warnings

import control
import numpy as np
import pytest

from workbench.control.controller_file import load_controller
from workbench.design.judge.loop_response import loop_responses
from workbench.design.judge.margins import UNSTABLE_LOOP_MARGINS, all_margins, loop_margins
from workbench.design.linear.operating_point import OperatingPoint

s = control.tf("s")
CONTINUOUS = {
    "third order": 4 / (s * (s + 1) * (s + 2)),
    "conditionally stable": 10 * (s + 1) ** 2 / s**3 / (0.01 * s + 1),
    "unstable plant": 100 * (s + 2) ** 2 / (s * (s**2 - s + 5) * (s / 200 + 1) ** 2),
    "faint resonance": 0.5 / s * (s**2 + 0.02 * s + 9.3) / (s**2 + 0.03 * s + 9),
    "limited by lead": 30 * s**2 / (s + 1) ** 3,
    "limited by lead, crosses thrice": 0.05 / s + 30 * s**2 / (s + 1) ** 3,
    "dips below -180 deg": 30 * (s + 3) ** 3 / (s * (s + 0.3) ** 3),
}
INEXACT = (
    "faint resonance",
    "dips below -180 deg",
    "limited by lead",
    "limited by lead, crosses thrice",
)
LOOPS = load_controller().loops
LOOP_POINTS = sorted({point for loop in LOOPS for point in (loop.error, loop.actuator)})
STEERED = [point for point in LOOP_POINTS if not point.startswith("position")]
HELD = [point for point in LOOP_POINTS if point.startswith("position")]


def sampled(loop, period=0.002):
    return control.sample_system(control.ss(loop), period, "zoh")


@pytest.fixture(params=[(name, period) for name in CONTINUOUS for period in (0.0, 0.002)], ids=str)
def textbook(request):
    """Return an open loop of python-control's."""
    name, period = request.param
    system = sampled(CONTINUOUS[name], period) if period else control.ss(CONTINUOUS[name])
    system.name = name
    return system


def radius(A) -> float:
    return float(np.abs(np.linalg.eigvals(A)).max())


def quietly(function, *args):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return function(*args)


def test_a_third_order_loop_has_the_margins_of_the_textbook(closed):
    found = loop_margins(closed(CONTINUOUS["third order"]), "it")
    assert found.gain_margin == pytest.approx(6.0 / 4.0, rel=1e-7)  # at sqrt(2), |L| = 4 / 6
    assert found.gain_reduction_margin == 0.0
    w = found.crossover
    assert w * math.hypot(1.0, w) * math.hypot(2.0, w) == pytest.approx(4.0, rel=1e-6)
    phase = math.pi / 2 - math.atan(w) - math.atan(w / 2)
    assert found.phase_margin == pytest.approx(phase, rel=1e-6)
    assert found.delay_margin == pytest.approx(phase / w, rel=1e-6)


def test_a_sampled_integrator_in_closed_form(closed):
    k, period = 40.0, 0.01
    found = loop_margins(closed(control.tf([k * period], [1, -1], period)), "it")
    assert found.gain_margin == pytest.approx(2.0 / (k * period), rel=1e-9)  # at half the rate
    w = 2.0 / period * math.asin(k * period / 2.0)
    assert found.crossover == pytest.approx(w, rel=1e-7)
    assert found.phase_margin == pytest.approx(math.pi / 2 - w * period / 2, rel=1e-7)
    assert found.peak_sensitivity == pytest.approx(1.0 / (1.0 - k * period / 2.0), rel=1e-7)
    share = k * period / 2.0  # L at half the rate is -share
    assert found.disk_margin == pytest.approx(2 * (1 - share) / (1 + share), rel=1e-7)


def test_a_continuous_integrator_in_closed_form(closed):
    found = loop_margins(closed(3.0 / s), "it")
    assert found.gain_margin == math.inf
    assert found.phase_margin == pytest.approx(math.pi / 2, rel=1e-7)
    assert found.delay_margin == pytest.approx(math.pi / 6, rel=1e-7)
    assert found.disk_margin == pytest.approx(2.0, rel=1e-3)
    assert found.bandwidth == pytest.approx(3.0 * math.sqrt(10**0.3 - 1.0), rel=1e-5)


@pytest.mark.parametrize("period", [0.0, 0.002])
def test_a_phase_margin_is_of_the_side_that_is_nearer(closed, period):
    """s² / (s + 1)³ has the phase 180° - 3 arctan w, and at w = tan(a) the size sin² a cos a.

    Scaled to cross at a = 10° and, closer to -180° from the other side than from this one, once
    more at b near 88°: 30° of lead are left at the first, 95° of lag at the second.
    """
    a = math.radians(10.0)
    size = math.sin(a) ** 2 * math.cos(a)
    # cos³ b - cos b + size = 0, of which cos a is a root: so is what solves the quadratic left
    b = math.acos((math.sqrt(math.cos(a) ** 2 + 4.0 * size / math.cos(a)) - math.cos(a)) / 2.0)
    assert math.sin(b) ** 2 * math.cos(b) == pytest.approx(size)
    loop = control.ss(s**2 / (s + 1) ** 3 / size)
    found = loop_margins(closed(sampled(loop, period) if period else loop), "it")
    lag = 2.0 * math.pi - 3.0 * b
    assert found.phase_margin == pytest.approx(3.0 * a, rel=1e-3 if period else 1e-6)
    assert found.phase_margin < 0.4 * lag
    # the hold turns what crosses at 30 rad/s by a degree or two more
    assert found.crossover == pytest.approx(math.tan(b), rel=1e-3 if period else 1e-6)
    assert found.delay_margin == pytest.approx(lag / math.tan(b), rel=0.03 if period else 1e-6)


def test_a_delay_margin_is_of_the_side_to_which_a_delay_turns(closed):
    """k s² / ((s² + 2 d s + 1) (s / p + 1)) leads around its resonance, where it is above 1.

    With D = 1 - w² + 2 d w j the phase is 180° less arg D + arctan(w / p): so much lead is left,
    and a delay has all the rest of 360° to go.
    """
    k, d, p = 0.3, 0.1, 30.0
    found = loop_margins(closed(k * s**2 / (s**2 + 2 * d * s + 1) / (s / p + 1)), "it")
    square = np.polymul([1.0, 4.0 * d**2 - 2.0, 1.0], [1.0 / p**2, 1.0])  # of 1 / |L|, in w²
    roots = np.roots(np.polysub(square, [k**2, 0.0, 0.0]))
    crossings = np.sqrt(roots[roots.real > 0.0].real)
    lead = np.angle(1.0 - crossings**2 + 2.0j * d * crossings) + np.arctan(crossings / p)
    assert len(crossings) == 2
    assert found.crossover == pytest.approx(crossings.max(), rel=1e-6)
    assert found.phase_margin == pytest.approx(lead.min(), rel=1e-6)
    assert found.delay_margin == pytest.approx(((2 * math.pi - lead) / crossings).min(), rel=1e-6)


def test_gain_and_phase_margins_are_python_controls(closed, textbook):
    if textbook.dt and textbook.name in INEXACT:
        pytest.skip("python-control's polynomials are not exact enough; the poles' test has these")
    found = loop_margins(closed(textbook), "it")
    gains, phases, _, at_phase, at_gain, _ = quietly(
        lambda: control.stability_margins(textbook, returnall=True)
    )
    # python-control leaves out half the sampling rate, where L is real too
    above = gains[gains > 1.0].min(initial=math.inf)
    below = gains[(gains < 1.0) & (gains > 1e-6)].max(initial=0.0)
    if textbook.dt:
        edge = -1.0 / textbook(-1.0 + 0.0j).real
        above = min(above, edge) if edge > 1.0 else above
    assert found.gain_margin == pytest.approx(above, rel=1e-5)
    assert found.gain_reduction_margin == pytest.approx(below, rel=1e-5)
    wrapped = np.abs((phases + 180.0) % 360.0 - 180.0)
    assert math.degrees(found.phase_margin) == pytest.approx(wrapped.min(), rel=1e-5)
    assert found.crossover == pytest.approx(at_gain.max(), rel=1e-5)


def test_a_textbook_gain_margin_is_where_poles_cross(closed, textbook):
    model = closed(textbook)
    found = loop_margins(model, "it")
    factors = ((found.gain_margin, 1.0), (found.gain_reduction_margin, -1.0))
    crossing = [(factor, outwards) for factor, outwards in factors if 0.0 < factor < math.inf]
    assert crossing or textbook.name == "limited by lead", "its phase does not reach -180 deg"
    for factor, outwards in crossing:
        inside, outside = (
            model.A_cut + factor * (1.0 + side * outwards * 1e-5) * np.outer(model.b, model.c)
            for side in (-1.0, 1.0)
        )
        assert grows(inside, model.period) < 0.0 < grows(outside, model.period)


def grows(A, period) -> float:
    return radius(A) - 1.0 if period else float(np.linalg.eigvals(A).real.max())


def test_disk_margin_and_peak_are_those_of_python_control_on_a_fine_grid(closed, textbook):
    found = loop_margins(closed(textbook), "it")
    top = math.pi / textbook.dt if textbook.dt else 1e4
    at = np.append(np.geomspace(1e-2, top, 4000), np.linspace(2.9, 3.1, 4001))
    alpha, _, _ = quietly(control.disk_margins, textbook, np.sort(at))
    assert found.disk_margin == pytest.approx(alpha, rel=1e-3)
    assert found.disk_margin <= alpha * (1.0 + 1e-7)
    # not by control.feedback: its system without states warns on NumPy 2.5
    peak = np.abs(1.0 / (1.0 + quietly(textbook.frequency_response, at).complex)).max()
    assert found.peak_sensitivity == pytest.approx(peak, rel=1e-3)
    assert found.peak_sensitivity >= peak * (1.0 - 1e-7)


@pytest.mark.parametrize("name", ["third order", "unstable plant"])
def test_the_bandwidth_is_python_controls(closed, name):
    loop = CONTINUOUS[name]
    found = loop_margins(closed(loop), "it")
    assert found.bandwidth == pytest.approx(control.bandwidth(control.feedback(loop)), rel=1e-3)


@pytest.mark.parametrize("period", [0.0, 0.01])
def test_the_bandwidth_leaves_out_what_is_lost_at_the_very_lowest_frequencies(closed, period):
    slow = s / (s + 0.003)  # as of a heading that turns into the wind
    with_it, without = (
        loop_margins(closed(sampled(loop, period) if period else loop), "it").bandwidth
        for loop in (4.0 / (s + 0.4) * slow, 4.0 / (s + 0.4))
    )
    assert with_it == pytest.approx(without, rel=5e-3)


def test_the_bandwidth_of_the_yaw_rate_is_that_of_hover_in_forward_flight(study, steering):
    forward = study.sampled(OperatingPoint(velocity=(5.0, 0.0, 0.0)))
    hover, flown = (loop_margins(m, "yaw_acceleration").bandwidth for m in (steering, forward))
    assert hover == pytest.approx(4.23, abs=0.01)
    assert flown == pytest.approx(hover, rel=0.01)


def test_a_gain_margin_is_where_poles_cross_the_unit_circle(case, steering, holding):
    for point in STEERED + HELD:
        with case(point):
            model = holding if point in HELD else steering
            found = loop_margins(model, point)
            place = [not name.startswith("p_") and name != "yaw" for name in model.state_names]
            kept = np.ix_(place, place) if point in STEERED else np.ix_(*[range(len(place))] * 2)
            A_cut, b, c = model.cut(point)
            factors = [found.gain_margin, found.gain_reduction_margin]
            assert factors[0] < 1000.0
            for factor, outwards in zip(factors, (1.0, -1.0), strict=True):
                if factor == 0.0:
                    continue
                inside, outside = (
                    (A_cut + factor * (1.0 + side * outwards * 1e-4) * np.outer(b, c))[kept]
                    for side in (-1.0, 1.0)
                )
                heading = 1e-7 if point in HELD else 0.0  # nothing reads it: its pole is at 1
                assert radius(inside) < 1.0 + heading
                assert radius(outside) > 1.0 + heading


@pytest.mark.parametrize("point", ["roll_acceleration", "pitch_error", "velocity_x_error"])
def test_a_delay_margin_is_how_many_samples_a_loop_can_be_delayed(steering, point):
    found = loop_margins(steering, point)
    whole = int(found.delay_margin / steering.period)
    assert delayed_radius(steering, point, whole) < 1.0
    assert delayed_radius(steering, point, whole + 1) > 1.0


def delayed_radius(model, point, samples) -> float:
    """Return the spectral radius with a loop delayed, place and heading left out."""
    place = [not name.startswith("p_") and name != "yaw" for name in model.state_names]
    A, b, c = model.cut(point)
    A, b, c = A[np.ix_(place, place)], b[place], c[place]
    m = len(A)
    if not samples:
        return radius(A + np.outer(b, c))
    late = np.zeros((m + samples, m + samples))
    late[:m, :m] = A
    late[:m, m] = b
    for index in range(samples - 1):
        late[m + index, m + index + 1] = 1.0
    late[-1, :m] = c
    return radius(late)


@pytest.mark.parametrize("point", ["roll_error", "yaw_acceleration", "velocity_z_error"])
def test_margins_of_the_real_loop_are_python_controls_of_its_frequency_data(steering, point):
    found = loop_margins(steering, point)
    at = np.geomspace(0.05, math.pi / steering.period * 0.9999, 3000)
    data = control.frd(steering.open_loop(point), at)
    gain, phase, _, _, crossover, _ = quietly(control.stability_margins, data)
    assert math.degrees(found.phase_margin) == pytest.approx(abs(phase), rel=1e-4)
    assert found.crossover == pytest.approx(crossover, rel=1e-4)
    if math.isinf(gain):  # no crossing below the Nyquist frequency: there the loop is real
        gain = 1.0 / abs(steering.open_loop(point)(-1.0))
    assert found.gain_margin == pytest.approx(gain, rel=1e-4)
    alpha = quietly(control.disk_margins, steering.open_loop(point), at)[0]
    assert found.disk_margin == pytest.approx(alpha, rel=1e-4)


def test_the_response_is_the_one_of_a_direct_solution(steering):
    w = np.geomspace(0.05, 400.0, 50)
    found = loop_responses(steering, STEERED).at(w)
    for row, point in zip(found, STEERED, strict=True):
        A, b, c = steering.cut(point)
        direct = [
            -c @ np.linalg.solve(z * np.eye(len(A)) - A, b)
            for z in np.exp(1j * w * steering.period)
        ]
        assert row == pytest.approx(np.array(direct), rel=1e-6)


def test_many_points_at_once_are_as_one_by_one(steering):
    for point, found in zip(STEERED, all_margins(steering, STEERED), strict=True):
        alone = loop_margins(steering, point)
        numbers = [value for value in vars(found).values() if math.isfinite(value)]
        single = [value for value in vars(alone).values() if math.isfinite(value)]
        assert numbers == pytest.approx(single, rel=1e-6)


def test_integrators_that_no_loop_closes_change_nothing(closed):
    plain = closed(sampled(CONTINUOUS["third order"]))
    m = len(plain.A)
    A = np.eye(m + 2)
    A[:m, :m] = plain.A_cut
    A[m, 0] = A[m + 1, m] = 0.002  # a place, and what adds up places
    b, c = np.append(plain.b, [0.0, 0.0]), np.append(plain.c, [0.0, 0.0])
    found = loop_margins(type(plain)(A, b, c, plain.period), "it")
    assert found.stable
    assert found.phase_margin == pytest.approx(loop_margins(plain, "it").phase_margin, rel=1e-6)
    assert found.gain_margin == pytest.approx(loop_margins(plain, "it").gain_margin, rel=1e-6)


@pytest.mark.parametrize("period", [0.0, 0.002])
def test_an_unstable_loop_bears_nothing(closed, period):
    loop = 7 / (s * (s + 1) * (s + 2))
    found = loop_margins(closed(sampled(loop, period) if period else loop), "it")
    assert found == UNSTABLE_LOOP_MARGINS
    assert not found.stable


def test_a_loop_without_gain_bears_anything(closed):
    plain = closed(1 / ((s + 1) * (s + 2)))
    found = loop_margins(dataclasses.replace(plain, b=0.0 * plain.b), "it")
    assert found.gain_margin == found.phase_margin == found.delay_margin == math.inf
    assert found.peak_sensitivity == pytest.approx(1.0)
    assert found.disk_margin == pytest.approx(2.0)


def test_positive_feedback_at_rest_limits_the_gain(closed):
    found = loop_margins(closed(-0.25 / (s + 1)), "it")
    assert found.gain_margin == pytest.approx(4.0, rel=1e-7)
