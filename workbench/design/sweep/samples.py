"""Where in the space of its ranges a sweep looks: on a grid, at random, or evenly by Sobol."""

import math
from collections.abc import Sequence

import numpy as np

from workbench.common.errors import WorkbenchError, unknown_name
from workbench.design.sweep.ranges import SweepRange

METHODS = ("grid", "random", "sobol")
MOST_CANDIDATES = 100_000


def sample(ranges: Sequence[SweepRange], method: str, samples: int, seed: int) -> np.ndarray:
    """Return candidates, (N, len(ranges)).

    A grid has all combinations of its ranges' points, the last range fastest. Sobol's sequence
    (scrambled, scipy.stats.qmc) fills the space more evenly than chance does; best with a power of
    two.

    Args:
        ranges: what is swept.
        method: one of `METHODS`.
        samples: how many, for random and sobol.
        seed: for random and sobol; equal seeds give equal candidates.

    Raises:
        WorkbenchError: if that cannot be sampled.
    """
    if method not in METHODS:
        raise unknown_name("method", method, METHODS)
    names = [each.name for each in ranges]
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice or not names:
        what = f"{twice} is swept twice" if twice else "nothing is swept"
        raise WorkbenchError(f"{what}: give each parameter one range, as kp_roll=100..400:9")
    count = math.prod(each.points for each in ranges) if method == "grid" else samples
    if not 1 <= count <= MOST_CANDIDATES:
        raise WorkbenchError(
            f"{count} candidates cannot be swept: give 1 to {MOST_CANDIDATES}, or use the method "
            "sobol, which needs fewer than a grid"
        )
    if seed < 0:
        raise WorkbenchError(f"the seed is {seed}: give 0 or more")
    if method == "grid":
        mesh = np.meshgrid(*(each.grid for each in ranges), indexing="ij")
        return np.stack([values.ravel() for values in mesh], axis=1)
    if method == "random":
        shares = np.random.default_rng(seed).random((samples, len(ranges)))
    else:
        from scipy.stats import qmc

        sobol = qmc.Sobol(len(ranges), scramble=True, seed=seed)
        shares = sobol.random_base2(math.ceil(math.log2(samples)))[:samples]
    columns = [each.spread(shares[:, index]) for index, each in enumerate(ranges)]
    return np.stack(columns, axis=1)
