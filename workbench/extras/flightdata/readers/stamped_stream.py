"""The time stamps of one stream of a log, without overflows of the counter and damaged stamps."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from workbench.common.flight import LogRemark
from workbench.common.series import SIGNAL_GAP_PERIODS

MAX_FOLLOWING_PERIODS = 20
"""Number of periods within which a sample follows the one before."""
MAX_DAMAGED_SAMPLES = 3
"""Largest number of samples that do not make a restart of the clock: their stamps are damaged."""
MAX_DAMAGED_SHARE = 0.1
"""Largest share of a stream that may be damaged, or may consist of copies."""
ISOLATION_DURATIONS, MIN_ISOLATION_S = 10.0, 60.0
"""`MAX_DAMAGED_SAMPLES` samples at an end of a log are damaged if they are so many durations of the
rest, and so many seconds more, away from it."""
MAX_CLOCK_RESTARTS = 100
"""Largest number of restarts of a stream; what follows more of them is left out."""
DAMAGED_TIME_REMARK = "with a time that does not fit those around it, left out"
_COUNTER_RANGE = 2.0**32
_COUNTER_PERIODS_S = (1e-6, 1e-3)
"""Periods of counters of 32 bits [s]; logs may state their time in another unit."""
MAX_OVERFLOW_PERIODS = 5
"""Number of periods within which a sample follows that before an overflow."""


class Stamps(NamedTuple):
    """The time stamps of a stream, in the order of the file.

    Attributes:
        ticks: (n); NaN where there is none.
        places: (n) increasing, comparable between streams: where each sample is in the file.
        same: (n) whether a sample equals the one before it in its stamp and all its values.
    """

    ticks: np.ndarray
    places: np.ndarray
    same: np.ndarray


@dataclass(eq=False)
class StampedStream:
    """A stream on the way from its stamps to its times.

    Attributes:
        name: of the stream.
        places: (n) of the samples in the file.
        ticks: (n), without overflows and shared stamps; NaN for samples that are left out.
        period: usual step between two samples [ticks].
        restarts: samples (index) before and after a step back of the clock.
        doubtful: likewise, with the few samples that are damaged unless other streams step back
            at the same place in the file.
        part: (n) number of restarts of the log before a sample.
    """

    name: str
    places: np.ndarray
    ticks: np.ndarray
    period: float
    restarts: list[tuple[int, int]] = field(default_factory=list)
    doubtful: list[tuple[int, int, np.ndarray]] = field(default_factory=list)
    part: np.ndarray = field(default_factory=lambda: np.empty(0))

    @property
    def rows(self) -> np.ndarray:
        """Samples with a time."""
        return np.flatnonzero(np.isfinite(self.ticks))


class ClockFaults:
    """Samples by kind of fault.

    Args:
        noun: of a sample.
        numbers: of all places in remarks; None to count the samples of each stream from 1.
        places: of the samples, by stream.
    """

    def __init__(
        self, noun: str, numbers: np.ndarray | None, places: Mapping[str, np.ndarray]
    ) -> None:
        self._noun, self._numbers, self._places = noun, numbers, places
        self._found: dict[str, list[tuple[str, np.ndarray]]] = {}

    def add(self, kind: str, stream: str, samples: np.ndarray) -> None:
        """Add the samples of a stream with a fault."""
        if len(samples):
            self._found.setdefault(kind, []).append((stream, samples))

    def place(self, stream: str, sample: int) -> str:
        """Return where a sample is, as "line 12" or "sample 12 of imu"."""
        if self._numbers is not None:
            return f"{self._noun} {self._numbers[self._places[stream][sample]]}"
        return f"{self._noun} {sample + 1}{f' of {stream}' if len(self._places) > 1 else ''}"

    def count(self, groups: Iterable[tuple[str, np.ndarray]]) -> int:
        """Return the number of samples of streams, or of places if these have numbers."""
        if self._numbers is None:
            return sum(len(samples) for _, samples in groups)
        places = [self._places[stream][samples] for stream, samples in groups]
        return len(np.unique(np.concatenate(places)))

    def remarks(self, times: Mapping[str, np.ndarray]) -> list[LogRemark]:
        """Return a remark for each kind of fault."""
        found = []
        for kind, groups in self._found.items():
            stream, samples = groups[0]
            first = int(samples.min())
            known = np.flatnonzero(np.isfinite(times[stream]))
            place = self.place(stream, first)
            if len(known):
                after = min(int(np.searchsorted(known, first)), len(known) - 1)
                place += f", at {times[stream][known[after]]:.3f} s"
            count = self.count(groups)
            which = "" if count == 1 else "the first one is "
            found.append(LogRemark(f"{self._noun}s {kind}: {count}, {which}{place}", count, place))
        return found


def unwrapped_stream(
    name: str, stamps: Stamps, tick: float, counter: bool, faults: ClockFaults
) -> StampedStream:
    """Return a stream with overflows undone, and its restarts."""
    ticks = np.array(stamps.ticks, dtype=float)
    known = np.isfinite(ticks)
    faults.add("without a time, left out", name, np.flatnonzero(~known))
    rows, spread = _spread(name, ticks, np.flatnonzero(known), stamps.same, faults)
    ticks[:] = np.nan
    ticks[rows] = spread
    steps = np.diff(spread)
    rising = steps[steps > 0.0]
    period = float(np.median(rising)) if len(rising) else 0.0
    stream = StampedStream(name, stamps.places, ticks, period)
    damaged = _follow_blocks(stream, rows, tick, counter)
    ticks[damaged] = np.nan
    faults.add(DAMAGED_TIME_REMARK, name, damaged)
    return stream


def _spread(
    name: str, ticks: np.ndarray, rows: np.ndarray, same: np.ndarray, faults: ClockFaults
) -> tuple[np.ndarray, np.ndarray]:
    """Return the rows that are kept of some (k), and their ticks without shared stamps (k)."""
    shared = _repeats_previous(ticks[rows])
    if not shared.any():
        return rows, ticks[rows]
    if shared[1:].all():
        faults.add("whose time never changes, left out", name, rows[1:])
        return rows[:1], ticks[rows[:1]]
    few = shared.sum() <= MAX_DAMAGED_SHARE * len(rows)
    if few:
        copies = shared & same[rows]
        faults.add("that repeat the one before, left out", name, rows[copies])
        rows = rows[~copies]
        shared = _repeats_previous(ticks[rows])
    firsts = np.flatnonzero(~shared)
    counts = np.diff(np.append(firsts, len(rows)))
    at = ticks[rows[firsts]]
    room = np.append(np.diff(at), 0.0) / counts
    usual = float(np.median(room[room > 0.0])) if (room > 0.0).any() else 0.0
    # The usual period holds at an end and before a gap. If few samples share a stamp, the stream
    # has to be even there.
    fits = (room > 0.0) & (room <= SIGNAL_GAP_PERIODS * usual)
    known = fits | (room <= 0.0) | (not few)
    step = np.where(fits, room, usual)
    group = np.repeat(np.arange(len(firsts)), counts)
    inside = np.arange(len(rows)) - firsts[group]
    lost = (inside > 0) & ~known[group]
    faults.add("that share the time of the one before, left out", name, rows[lost])
    faults.add(
        "that share the time of the one before, spread up to the next time",
        name,
        rows[(inside > 0) & ~lost],
    )
    return rows[~lost], (at[group] + inside * step[group])[~lost]


def _repeats_previous(ticks: np.ndarray) -> np.ndarray:
    """Return which ticks equal those before them (n)."""
    return np.concatenate([np.zeros(min(len(ticks), 1), dtype=bool), np.diff(ticks) == 0.0])


def _follow_blocks(
    stream: StampedStream, rows: np.ndarray, tick: float, counter: bool
) -> np.ndarray:
    """Go through the blocks of a stream without jumps: undo overflows, add restarts.

    Returns:
        The samples with damaged stamps.
    """
    ticks, period = stream.ticks, stream.period
    near = MAX_FOLLOWING_PERIODS * period
    steps = np.diff(ticks[rows])
    edges = np.flatnonzero((steps <= 0.0) | (steps > near)) + 1
    blocks = [rows[a:b] for a, b in pairwise([0, *edges.tolist(), len(rows)])]
    counters = [_COUNTER_RANGE, *(_COUNTER_RANGE * each / tick for each in _COUNTER_PERIODS_S)]
    damaged = [np.empty(0, dtype=int)]
    runs: list[list[np.ndarray]] = [[]]  # blocks between two restarts
    offset = 0.0
    for block, following in zip(blocks, [*blocks[1:], None], strict=True):
        while True:
            run = runs[-1]
            first = ticks[block[0]] + offset
            before = float(ticks[run[-1][-1]]) if run else -np.inf
            tail = np.concatenate([block[:0], *run[-MAX_DAMAGED_SAMPLES - 1 :]])
            tail = tail[ticks[tail] >= first]
            few = len(block) <= max(
                MAX_DAMAGED_SAMPLES, MAX_DAMAGED_SHARE * len(rows)
            ) and not 0 < len(tail) < len(block)
            if following is not None and run and few:
                pause = ticks[following[0]] + offset - before
                between = before < first < before + pause
                if not between and 0.0 < pause <= near + len(block) * period:
                    damaged.append(block)
                    break
            if first > before:
                ticks[block] += offset
                run.append(block)
                break
            back, size = before - first, sum(map(len, run[: MAX_DAMAGED_SAMPLES + 1]))
            alone = following is None and len(block) <= MAX_DAMAGED_SAMPLES
            wraps = [
                each for each in counters if 0.0 < each - back <= MAX_OVERFLOW_PERIODS * period
            ]
            if counter and not alone and 0.0 < _COUNTER_RANGE - back <= MIN_ISOLATION_S / tick:
                wraps = [_COUNTER_RANGE]
            if wraps:
                offset += wraps[0]
            elif len(tail) <= MAX_DAMAGED_SAMPLES < size:
                stream.doubtful.append((int(run[-1][-1]), int(block[0]), tail))
                while ticks[run[-1][-1]] >= first:
                    last_block = run.pop()
                    earlier = last_block[ticks[last_block] < first]
                    run += [earlier] if len(earlier) else []
            elif size <= MAX_DAMAGED_SAMPLES and stream.restarts:
                damaged += run
                runs.pop()
                stream.restarts.pop()
            elif size <= MAX_DAMAGED_SAMPLES or alone:
                lost = np.concatenate(run) if size <= MAX_DAMAGED_SAMPLES else block
                stream.doubtful.append((int(run[-1][-1]), int(block[0]), lost))
                runs.append([])
            elif len(stream.restarts) == MAX_CLOCK_RESTARTS:
                damaged.append(block)
                break
            else:
                stream.restarts.append((int(run[-1][-1]), int(block[0])))
                runs.append([])
    return np.sort(np.concatenate(damaged))
