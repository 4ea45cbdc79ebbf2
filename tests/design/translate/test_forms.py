"""The same loop in other parts: held against polynomials."""

import numpy as np

from workbench.design.translate.forms import TurnGains


def polynomial(turn: TurnGains, *, of_error: bool = False) -> np.ndarray:
    """Return s² times the loop from the angle to minus the angular acceleration, by products.

    ω_sp = -(angle + angle_integral / s + angle_rate s) θ and ω = s θ, so that the error of the rate
    is -w θ with w = angle + angle_integral / s + (1 + angle_rate) s.
    """
    w = np.array([1.0 + turn.angle_rate, turn.angle, turn.angle_integral])  # times s
    if of_error:
        return np.polymul(w, [turn.slope, turn.rate, turn.rate_integral])
    return np.polyadd(np.polymul(w, [turn.rate, turn.rate_integral]), [turn.slope, 0, 0, 0, 0])


def random_turns(*, cascaded: bool):
    rng = np.random.default_rng(3)
    for _ in range(200):
        angle, rate = rng.uniform(2.0, 12.0), rng.uniform(5.0, 60.0)
        integral, slope = rng.uniform(0.0, 0.4) * angle * rate, rng.uniform(0.0, 0.5)
        more = (rng.uniform(0.0, 0.3) * angle**2, rng.uniform(0.0, 0.5)) if cascaded else (0.0, 0.0)
        yield TurnGains(angle, *more, rate, integral, slope)


def test_the_derivative_of_the_angle_goes_into_the_others_exactly(case):
    for turn in random_turns(cascaded=True):
        with case(turn):
            plain = turn.without_angle_rate()
            assert plain.angle_rate == 0.0
            np.testing.assert_allclose(polynomial(plain), polynomial(turn), rtol=1e-12)


def test_the_integral_of_the_angle_goes_into_that_of_the_rate_but_for_the_double_one(case):
    for turn in random_turns(cascaded=True):
        with case(turn):
            folded = turn.without_angle_integral()
            assert folded.angle_integral == folded.angle_rate == 0.0
            has, had = polynomial(folded), polynomial(turn)
            real = turn.without_angle_rate()
            if real.stiffness**2 < 4.0 * real.rate * real.stiffness_integral:
                continue  # there are no real gains of that loop
            np.testing.assert_allclose(has[:4], had[:4], rtol=1e-9)


def test_d_on_the_error_and_on_the_rate_make_one_loop(case):
    for turn in random_turns(cascaded=False):
        plain = turn.of_rate()
        if turn.stiffness**2 < 4.0 * plain.rate * turn.stiffness_integral:
            continue  # there are no real gains of that loop
        with case(turn):
            np.testing.assert_allclose(
                polynomial(plain), polynomial(turn, of_error=True), rtol=1e-9, atol=1e-9
            )
            other = turn.of_error()
            if other is not None and turn.stiffness_integral > 0.0:
                np.testing.assert_allclose(
                    polynomial(other, of_error=True), polynomial(turn), rtol=1e-9, atol=1e-9
                )
