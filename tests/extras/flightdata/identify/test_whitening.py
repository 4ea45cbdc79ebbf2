"""Errors of prediction that hang together are made white, by the equations of what made them."""

import numpy as np
import pytest

from workbench.extras.flightdata.identify.whitening import Whitening, whiten, whitening

AHEAD = (0.8, -0.3)
DEVIATION = 0.2


@pytest.fixture(scope="module")
def hanging() -> tuple[np.ndarray, np.ndarray]:
    """Rows e of x = 0.8 x' - 0.3 x'' + 0.2 e, and these x, with an offset in a second channel."""
    e = np.random.default_rng(1).normal(size=(20000, 2))
    x = np.zeros_like(e)
    for k in range(len(e)):
        x[k] = DEVIATION * e[k]
        for back, share in enumerate(AHEAD, start=1):
            x[k] += share * x[k - back] if k >= back else 0.0
    return e, x


def test_what_made_the_errors_is_found_over_all_pieces(hanging):
    _, x = hanging
    found = whitening([x[:7000] + [0.0, 5.0], x[7000:] + [0.0, 5.0]], 2)
    np.testing.assert_allclose(found.coefficients, [[1.0, -0.8, 0.3]] * 2, atol=0.02)
    np.testing.assert_allclose(found.deviations, DEVIATION, rtol=0.02)
    assert found.cost == pytest.approx(2.0 * np.log(DEVIATION), abs=0.03)


def test_whitened_errors_are_those_that_came_in_without_the_rows_that_begin(hanging):
    """The first two rows lack those before them, so they are left out."""
    e, x = hanging
    exact = Whitening(np.array([[1.0, -0.8, 0.3]] * 2), np.full(2, DEVIATION))
    np.testing.assert_allclose(whiten(x[100:300], exact), e[102:300], atol=1e-9)
