"""Whether the EKF's errors are as large as it says, over flights with the noise that it expects.

Y. Bar-Shalom, X. R. Li and T. Kirubarajan, Estimation with Applications to Tracking and Navigation,
2001, section 5.4: normalized estimation errors (NEES) and innovations (NIS) squared.
"""

import numpy as np
import pytest
from scipy import stats
from scipy.spatial.transform import Rotation

from workbench.estimation import ekf_state
from workbench.estimation.samples import Mounting
from workbench.estimation.settings import EkfSettings

DURATION = 10.0
SPACED = 64
"""Updates between two looks at the errors."""
MOUNTING = Mounting(p_BG=(-0.05, 0.0, 0.1), p_BP=(0.02, 0.04, 0.0), p_BR=(0.0, 0.05, -0.05))
SETTINGS = EkfSettings()
KINDS = {
    "gps place": slice(0, 3),
    "gps velocity": slice(3, 6),
    "height": slice(6, 7),
    "heading": slice(7, 8),
    "distance": slice(8, 9),
}


def fly(kit, flown, seed, settings=SETTINGS, **how):
    """Return NEES of attitude, place and velocity now and then, and NIS by channel (N, 9)."""
    rng = np.random.default_rng(seed)
    memory, biases = kit.begin(flown, settings, rng)
    z = kit.samples(flown, MOUNTING, settings, rng, biases, **how)
    numbers, mounting = np.array(settings), MOUNTING.packed()
    errors, innovations = [], np.empty((len(z), 9))
    for k in range(1, len(z)):
        kit.ekf(memory, z[k], numbers, mounting, kit.period)
        told = memory[ekf_state.INNOVATIONS_INDEX :].reshape(-1, 2)[:9]
        innovations[k] = told[:, 0] ** 2 / told[:, 1]
        if k % SPACED == 0:
            R = Rotation.from_quat(memory[:4], scalar_first=True)
            off = (R.inv() * flown.R[k]).as_rotvec()
            error = np.concatenate([off, flown.p[k] - memory[4:7], flown.v[k] - memory[7:10]])
            P = memory[ekf_state.COVARIANCE_INDEX : ekf_state.INNOVATIONS_INDEX].reshape(15, 15)[
                :9, :9
            ]
            errors.append(error @ np.linalg.solve(P, error))
    return np.array(errors), innovations[1:]


def bounds(degrees, count):
    """Return between which a mean of so many squares lies in 95 % of all cases."""
    return stats.chi2.interval(0.95, degrees * count) / np.array(count)


@pytest.mark.parametrize(
    ("flights", "seeds"),
    [
        (["figure of eight"], 12),
        pytest.param(["hover", "figure of eight", "full speed"], 50, marks=pytest.mark.slow),
    ],
    ids=["one flight", "all"],
)
def test_errors_and_innovations_are_as_large_as_the_covariance_says(case, kit, flights, seeds):
    for name in flights:
        flown = kit.flights[name](DURATION)
        runs = [fly(kit, flown, seed, age=6) for seed in range(seeds)]
        nees = np.array([errors for errors, _ in runs])
        with case(name, "NEES"):
            # errors of one flight are of one piece: so many flights count, not so many looks
            low, high = bounds(9, seeds)
            assert low < nees.mean() < high
        nis = np.concatenate([innovations for _, innovations in runs])
        for kind, channels in KINDS.items():
            with case(name, "NIS", kind):
                squares = nis[:, channels][np.isfinite(nis[:, channels])]
                low, high = bounds(1, squares.size)
                assert low < squares.mean() < high
