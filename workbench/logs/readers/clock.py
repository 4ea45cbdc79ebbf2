"""The times of a log's samples from its time stamps: one function for all readers.

Stamps of real logs do not always increase: a counter of 32 bits overflows, a reboot starts the
clock again, a damaged frame has any number, and a coarse clock gives several samples one stamp.
What the log determines is computed. What it does not determine is left out, or put behind the rest,
with a remark that has number and place:

- An overflow is undone.
- Samples that share a stamp are spread up to the next stamp. If only few do, and repeat the values
  of the sample before, they are copies and left out.
- A stamp that does not fit its neighbours is ignored, with its sample: they fit each other.
- Where the clock starts again or steps back, the rest follows behind a gap of a second, which is
  longer than what is interpolated across. It is the clock of all streams if those around it that
  can show it step back, too; else the samples of the stream go on after one period.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from workbench.logs.flight_record import GAP, Remark, Span

NEAR = 20
"""Number of periods within which a sample follows the one before."""
SHORT = 3
"""Largest number of samples that do not make a restart of the clock: their stamps are damaged."""
FEW = 0.1
"""Largest share of a stream that may be damaged, or may consist of copies."""
ISOLATED, LONGEST_PAUSE = 10.0, 60.0
"""`SHORT` samples at an end of a log are damaged if they are so many durations of the rest, and so
many seconds more, away from it."""
MOST_RESTARTS = 100
"""Largest number of restarts of a stream; what follows more of them is left out."""
PAUSE = 1.0
"""Gap at a restart of the clock, whose length the log does not state [s]."""
LATEST = 1e7
"""Latest time in a log [s], a third of a year; a later one is a damaged number."""
DAMAGED = "with a time that does not fit those around it, left out"
_COUNTER = 2.0**32
_COUNTED = (1e-6, 1e-3)
"""Periods of counters of 32 bits [s]; logs may state their time in another unit."""
WRAPPED = 5
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


class Clock(NamedTuple):
    """The times of all samples of a log.

    Attributes:
        times: (n) by stream [s], from 0 on, increasing; NaN for samples that are left out. Streams
            may have earlier samples if the log states its begin.
        breaks: the times before and after each restart of all streams [s].
        begin: tick of time 0.
        end: latest time [s].
        remarks: on what was left out, spread or put behind.
    """

    times: Mapping[str, np.ndarray]
    breaks: tuple[Span, ...]
    begin: float
    end: float
    remarks: tuple[Remark, ...]


def stamps_of(
    ticks: np.ndarray, values: Iterable[np.ndarray] = (), places: np.ndarray | None = None
) -> Stamps:
    """Return the stamps of a stream.

    Args:
        ticks: (n).
        values: (n) each, of the fields of the samples; NaN equals NaN.
        places: (n) of the samples in the file; not needed for a single stream.
    """
    ticks = np.asarray(ticks, dtype=float)
    same = np.zeros(len(ticks), dtype=bool)
    same[1:] = np.diff(ticks) == 0.0
    for each in values if same.any() else ():
        equal = (each[1:] == each[:-1]) | (np.isnan(each[1:]) & np.isnan(each[:-1]))
        same[1:] &= equal
    return Stamps(ticks, np.arange(len(ticks)) if places is None else places, same)


@dataclass(eq=False)
class _Stream:
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


class _Restart(NamedTuple):
    """A restart of the clock of all streams.

    Attributes:
        after: it is behind this place in the file.
        place: first place of the new clock.
        seen: the streams that step back, and their first samples behind it.
    """

    after: float
    place: float
    seen: tuple[tuple[_Stream, int], ...]


class _Faults:
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

    def remarks(self, times: Mapping[str, np.ndarray]) -> list[Remark]:
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
            found.append(Remark(f"{self._noun}s {kind}: {count}, {which}{place}", count, place))
        return found


def read_clock(
    streams: Mapping[str, Stamps],
    tick: float,
    *,
    counter: bool = False,
    begin: float | None = None,
    noun: str = "sample",
    numbers: np.ndarray | None = None,
) -> Clock:
    """Return the times of the samples of all streams of a log.

    Args:
        streams: by name.
        tick: [s].
        counter: whether the stamps are known to come from a counter of 32 bits.
        begin: tick of time 0, if the log states it; earlier samples then have negative times.
        noun: of a sample in remarks: line, frame, ...
        numbers: of all places in remarks, as those of lines, which count once for all streams;
            None to count the samples of each stream from 1.
    """
    faults = _Faults(noun, numbers, {name: stamps.places for name, stamps in streams.items()})
    found = [
        _stream(name, stamps, tick, counter, faults)
        for name, stamps in streams.items()
        if len(stamps.ticks)
    ]
    restarts, own = _restarts(found, faults)
    places = [restart.place for restart in restarts]
    for stream in found:
        stream.part = np.searchsorted(places, stream.places, side="right")
    breaks: list[Span] = []
    stepped: list[tuple[_Stream, int, int, float, str]] = []
    for number, restart in enumerate(restarts, start=1):
        ended, back = _put_behind(found, number, restart, PAUSE / tick)
        breaks.append((ended, ended + PAUSE / tick))
        rest = faults.count(
            [(each.name, each.rows[each.part[each.rows] >= number]) for each in found]
        )
        what = f"a gap of unknown length that counts as {PAUSE:g} s"
        stepped.append((*restart.seen[0], rest, back, what))
    for stream, before, index in own:
        back = float(stream.ticks[before] - stream.ticks[index])
        stream.ticks[index:] += back + stream.period
        rest = faults.count([(stream.name, stream.rows[stream.rows >= index])])
        stepped.append((stream, index, rest, back, "one period, as the other clocks go on"))
    for stream in found:
        rows = stream.rows
        latest = np.maximum.accumulate(stream.ticks[rows])
        late = rows[1:][stream.ticks[rows[1:]] <= latest[:-1]]
        stream.ticks[late] = np.nan
        faults.add("that are older than those before, left out", stream.name, late)
    _leave_out_isolated(found, tick, faults)
    whole = [stream.ticks[stream.rows] for stream in found if len(stream.rows)]
    zero = min((float(ticks[0]) for ticks in whole), default=0.0)
    last = max((float(ticks[-1]) for ticks in whole), default=zero)
    if begin is not None and zero < begin < last:
        zero = begin
    times = {name: np.empty(0) for name in streams}
    for stream in found:
        time = (stream.ticks - zero) * tick
        beyond = np.flatnonzero(time > LATEST)
        time[beyond] = np.nan
        faults.add("with an impossible time, left out", stream.name, beyond)
        times[stream.name] = time
    told = []
    for stream, index, rest, back, what in stepped:
        place = f"{faults.place(stream.name, index)}, at {times[stream.name][index]:.3f} s"
        text = (
            f"the clock goes back by {back * tick:.3f} s: {place}: the {rest} {noun}s from there "
            f"on follow those before after {what}"
        )
        told.append(Remark(text, rest, place))
    ends = [float(np.nanmax(each)) for each in times.values() if np.isfinite(each).any()]
    return Clock(
        times=times,
        breaks=tuple(((a - zero) * tick, (b - zero) * tick) for a, b in sorted(breaks)),
        begin=zero,
        end=max(ends, default=0.0),
        remarks=(*told, *faults.remarks(times)),
    )


def _stream(name: str, stamps: Stamps, tick: float, counter: bool, faults: _Faults) -> _Stream:
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
    stream = _Stream(name, stamps.places, ticks, period)
    damaged = _follow(stream, rows, tick, counter)
    ticks[damaged] = np.nan
    faults.add(DAMAGED, name, damaged)
    return stream


def _spread(
    name: str, ticks: np.ndarray, rows: np.ndarray, same: np.ndarray, faults: _Faults
) -> tuple[np.ndarray, np.ndarray]:
    """Return the rows that are kept of some (k), and their ticks without shared stamps (k)."""
    shared = _shared(ticks[rows])
    if not shared.any():
        return rows, ticks[rows]
    if shared[1:].all():
        faults.add("whose time never changes, left out", name, rows[1:])
        return rows[:1], ticks[rows[:1]]
    few = shared.sum() <= FEW * len(rows)
    if few:
        copies = shared & same[rows]
        faults.add("that repeat the one before, left out", name, rows[copies])
        rows = rows[~copies]
        shared = _shared(ticks[rows])
    firsts = np.flatnonzero(~shared)
    counts = np.diff(np.append(firsts, len(rows)))
    at = ticks[rows[firsts]]
    room = np.append(np.diff(at), 0.0) / counts
    usual = float(np.median(room[room > 0.0])) if (room > 0.0).any() else 0.0
    # The usual period holds at an end and before a gap. If few samples share a stamp, the stream
    # has to be even there.
    fits = (room > 0.0) & (room <= GAP * usual)
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


def _shared(ticks: np.ndarray) -> np.ndarray:
    """Return which ticks equal those before them (n)."""
    return np.concatenate([np.zeros(min(len(ticks), 1), dtype=bool), np.diff(ticks) == 0.0])


def _follow(stream: _Stream, rows: np.ndarray, tick: float, counter: bool) -> np.ndarray:
    """Go through the blocks of a stream without jumps: undo overflows, add restarts.

    Returns:
        The samples with damaged stamps.
    """
    ticks, period = stream.ticks, stream.period
    near = NEAR * period
    steps = np.diff(ticks[rows])
    edges = np.flatnonzero((steps <= 0.0) | (steps > near)) + 1
    blocks = [rows[a:b] for a, b in pairwise([0, *edges.tolist(), len(rows)])]
    counters = [_COUNTER, *(_COUNTER * each / tick for each in _COUNTED)]
    damaged = [np.empty(0, dtype=int)]
    runs: list[list[np.ndarray]] = [[]]  # blocks between two restarts
    offset = 0.0
    for block, following in zip(blocks, [*blocks[1:], None], strict=True):
        while True:
            run = runs[-1]
            first = ticks[block[0]] + offset
            before = float(ticks[run[-1][-1]]) if run else -np.inf
            tail = np.concatenate([block[:0], *run[-SHORT - 1 :]])
            tail = tail[ticks[tail] >= first]
            few = len(block) <= max(SHORT, FEW * len(rows)) and not 0 < len(tail) < len(block)
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
            back, size = before - first, sum(map(len, run[: SHORT + 1]))
            alone = following is None and len(block) <= SHORT
            wraps = [each for each in counters if 0.0 < each - back <= WRAPPED * period]
            if counter and not alone and 0.0 < _COUNTER - back <= LONGEST_PAUSE / tick:
                wraps = [_COUNTER]
            if wraps:
                offset += wraps[0]
            elif len(tail) <= SHORT < size:
                stream.doubtful.append((int(run[-1][-1]), int(block[0]), tail))
                while ticks[run[-1][-1]] >= first:
                    last_block = run.pop()
                    earlier = last_block[ticks[last_block] < first]
                    run += [earlier] if len(earlier) else []
            elif size <= SHORT and stream.restarts:
                damaged += run
                runs.pop()
                stream.restarts.pop()
            elif size <= SHORT or alone:
                lost = np.concatenate(run) if size <= SHORT else block
                stream.doubtful.append((int(run[-1][-1]), int(block[0]), lost))
                runs.append([])
            elif len(stream.restarts) == MOST_RESTARTS:
                damaged.append(block)
                break
            else:
                stream.restarts.append((int(run[-1][-1]), int(block[0])))
                runs.append([])
    return np.sort(np.concatenate(damaged))


def _restarts(
    streams: Sequence[_Stream], faults: _Faults
) -> tuple[list[_Restart], list[tuple[_Stream, int, int]]]:
    """Return the restarts of the common clock, and those of single streams."""
    events = [(stream, *indices) for stream in streams for indices in stream.restarts]
    common: list[_Restart] = []
    own: list[tuple[_Stream, int, int]] = []
    for stream, before, index in sorted(events, key=lambda event: event[0].places[event[2]]):
        after, place = stream.places[[before, index]]
        if common and after < common[-1].place and stream not in dict(common[-1].seen):
            same = common[-1]
            common[-1] = _Restart(
                max(same.after, after), min(same.place, place), (*same.seen, (stream, index))
            )
        elif _is_common(streams, stream, before, index):
            common.append(_Restart(after, place, ((stream, index),)))
        else:
            own.append((stream, before, index))
    for stream in streams:
        for before, index, few in stream.doubtful:
            after, place = stream.places[[before, index]]
            if not any(each.place > after and each.after < place for each in common):
                stream.ticks[few] = np.nan
                faults.add(DAMAGED, stream.name, few)
    return common, own


def _is_common(streams: Sequence[_Stream], stream: _Stream, before: int, index: int) -> bool:
    """Return whether most streams that can show a step back of a stream step back, too."""
    back = stream.ticks[before] - stream.ticks[index]
    votes = 0
    for other in streams:
        if other is stream or back <= 2.0 * other.period:
            continue
        rows = other.rows
        earlier = rows[other.places[rows] <= stream.places[before]]
        later = rows[other.places[rows] >= stream.places[index]]
        if len(earlier) and len(later):
            votes += 1 if other.ticks[later[0]] < other.ticks[earlier[-1]] else -1
    return votes >= 0


def _put_behind(
    streams: Sequence[_Stream], number: int, restart: _Restart, pause: float
) -> tuple[float, float]:
    """Move the samples between a restart and the next one behind those before it, after a pause.

    Returns:
        The tick of the last sample before it, and the ticks by which the clock goes back.
    """
    earlier = [each.ticks[each.rows[each.part[each.rows] == number - 1]] for each in streams]
    ended = max(float(ticks.max()) for ticks in earlier if len(ticks))
    begun = min(float(stream.ticks[index]) for stream, index in restart.seen)
    for each in streams:
        each.ticks[each.part == number] += ended + pause - begun
    return ended, ended - begun


def _leave_out_isolated(streams: Sequence[_Stream], tick: float, faults: _Faults) -> None:
    """Leave out a few samples at an end of the log that are too far away from all others."""
    ticks = np.sort(np.concatenate([np.empty(0), *(each.ticks[each.rows] for each in streams)]))
    if len(ticks) <= 2 * SHORT:
        return
    low, high = ticks[0], ticks[-1]
    for count in range(1, SHORT + 1):
        for a, b, c, end in ((count - 1, count, -1, "low"), (-count, -count - 1, 0, "high")):
            pause = LONGEST_PAUSE / tick + ISOLATED * abs(ticks[c] - ticks[b])
            if abs(ticks[b] - ticks[a]) > pause:
                low, high = (ticks[b], high) if end == "low" else (low, ticks[b])
    for stream in streams:
        rows = stream.rows
        far = rows[(stream.ticks[rows] < low) | (stream.ticks[rows] > high)]
        stream.ticks[far] = np.nan
        faults.add(DAMAGED, stream.name, far)
