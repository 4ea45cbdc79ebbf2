"""A batch of candidates, shared out over threads in blocks."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from workbench.control.controller import Controller
from workbench.design.rollout.candidates import Candidates
from workbench.design.rollout.chunks import run_chunks
from workbench.design.rollout.compiled_block import compiled_block
from workbench.design.rollout.craft import Crafts
from workbench.design.rollout.rows import LANES
from workbench.design.rollout.schedule import Schedule

Keep = Callable[[int, int, np.ndarray], None]
"""Takes samples (M, k, 16) of the candidates from a first up to before a last one; the array
belongs to it no longer than the call."""


class Flown(NamedTuple):
    """What became of the candidates that were flown, the first `done`.

    Attributes:
        done: how many.
        peak_use: (done) largest share of its speed limit at which any rotor ran.
        lost_at: (done) when it was lost, from the edge on [s], NaN if it was not.
    """

    done: int
    peak_use: np.ndarray
    lost_at: np.ndarray


class Batch(NamedTuple):
    """N candidates that fly on the same schedule.

    Attributes:
        controller: whose law flies.
        candidates: N of them.
        crafts: what flies, K.
        which: (N) the craft of each candidate.
        schedule: of all.
    """

    controller: Controller
    candidates: Candidates
    crafts: Crafts
    which: np.ndarray
    schedule: Schedule

    @property
    def size(self) -> int:
        """How many candidates there are."""
        return len(self.which)

    @property
    def time(self) -> np.ndarray:
        """Time of the samples (M) from the edge on [s]."""
        when = self.schedule
        instants = np.arange(when.edge, when.end + 1, when.stride)
        return instants * when.period - when.edge_time

    def fly(
        self,
        kept: tuple[int, ...],
        keep: Keep,
        threads: int,
        progress: Callable[[float], None] | None = None,
        stop: Callable[[], bool] | None = None,
    ) -> Flown:
        """Fly them.

        Args:
            kept: which k of the state's numbers to sample.
            keep: called with the samples of each block, by several threads.
            threads: that fly at a time.
            progress: called with the flown share, 0 .. 1.
            stop: asked every few blocks; when it returns true, no more are flown.
        """
        peak_use, lost_at = np.zeros(self.size), np.full(self.size, -1)
        shape = (len(self.time), len(kept), LANES)

        fly_block = compiled_block(self.controller)

        def work(first_block: int, last_block: int) -> None:
            samples = np.empty(shape)
            for first in range(first_block * LANES, last_block * LANES, LANES):
                last = min(first + LANES, self.size)
                fly_block(
                    self.candidates.part(first, last),
                    self.crafts.chosen(self.which[first:last]),
                    self.schedule,
                    np.array(kept),
                    samples,
                    peak_use[first:last],
                    lost_at[first:last],
                )
                keep(first, last, samples)

        blocks = run_chunks(work, -(-self.size // LANES), threads, progress, stop)
        done = min(blocks * LANES, self.size)
        after = np.maximum(0.0, lost_at * self.schedule.period - self.schedule.edge_time)
        lost = np.where(lost_at < 0, np.nan, after)
        return Flown(done, peak_use[:done], lost[:done])

    def curves(
        self,
        kept: tuple[int, ...],
        threads: int,
        progress: Callable[[float], None] | None = None,
        stop: Callable[[], bool] | None = None,
    ) -> tuple[np.ndarray, Flown]:
        """Fly them and keep every sample; the arguments are those of `fly`.

        Returns:
            The samples (done, M, k) of those that were flown, and what became of them.
        """
        found = np.full((self.size, len(self.time), len(kept)), np.nan)

        def keep(first: int, last: int, samples: np.ndarray) -> None:
            found[first:last] = samples[:, :, : last - first].transpose(2, 0, 1)

        flown = self.fly(kept, keep, threads, progress, stop)
        return found[: flown.done], flown
