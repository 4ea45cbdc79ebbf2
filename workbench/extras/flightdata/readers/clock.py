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
from typing import NamedTuple

import numpy as np

from workbench.common.flight import MAX_LOG_TIME_S, LogRemark
from workbench.common.series import Span
from workbench.extras.flightdata.readers.stamped_stream import (
    DAMAGED_TIME_REMARK,
    ISOLATION_DURATIONS,
    MAX_DAMAGED_SAMPLES,
    MIN_ISOLATION_S,
    ClockFaults,
    StampedStream,
    Stamps,
    unwrapped_stream,
)

RESTART_GAP_S = 1.0
"""Gap at a restart of the clock, whose length the log does not state [s]."""


class SampleClock(NamedTuple):
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
    remarks: tuple[LogRemark, ...]


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


class _Restart(NamedTuple):
    """A restart of the clock of all streams.

    Attributes:
        after: it is behind this place in the file.
        place: first place of the new clock.
        seen: the streams that step back, and their first samples behind it.
    """

    after: float
    place: float
    seen: tuple[tuple[StampedStream, int], ...]


def read_clock(
    streams: Mapping[str, Stamps],
    tick: float,
    *,
    counter: bool = False,
    begin: float | None = None,
    noun: str = "sample",
    numbers: np.ndarray | None = None,
) -> SampleClock:
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
    faults = ClockFaults(noun, numbers, {name: stamps.places for name, stamps in streams.items()})
    found = [
        unwrapped_stream(name, stamps, tick, counter, faults)
        for name, stamps in streams.items()
        if len(stamps.ticks)
    ]
    restarts, own = _restarts(found, faults)
    places = [restart.place for restart in restarts]
    for stream in found:
        stream.part = np.searchsorted(places, stream.places, side="right")
    breaks: list[Span] = []
    stepped: list[tuple[StampedStream, int, int, float, str]] = []
    for number, restart in enumerate(restarts, start=1):
        ended, back = _put_behind(found, number, restart, RESTART_GAP_S / tick)
        breaks.append((ended, ended + RESTART_GAP_S / tick))
        rest = faults.count(
            [(each.name, each.rows[each.part[each.rows] >= number]) for each in found]
        )
        what = f"a gap of unknown length that counts as {RESTART_GAP_S:g} s"
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
        beyond = np.flatnonzero(time > MAX_LOG_TIME_S)
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
        told.append(LogRemark(text, rest, place))
    ends = [float(np.nanmax(each)) for each in times.values() if np.isfinite(each).any()]
    return SampleClock(
        times=times,
        breaks=tuple(((a - zero) * tick, (b - zero) * tick) for a, b in sorted(breaks)),
        begin=zero,
        end=max(ends, default=0.0),
        remarks=(*told, *faults.remarks(times)),
    )


def _restarts(
    streams: Sequence[StampedStream], faults: ClockFaults
) -> tuple[list[_Restart], list[tuple[StampedStream, int, int]]]:
    """Return the restarts of the common clock, and those of single streams."""
    events = [(stream, *indices) for stream in streams for indices in stream.restarts]
    common: list[_Restart] = []
    own: list[tuple[StampedStream, int, int]] = []
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
                faults.add(DAMAGED_TIME_REMARK, stream.name, few)
    return common, own


def _is_common(
    streams: Sequence[StampedStream], stream: StampedStream, before: int, index: int
) -> bool:
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
    streams: Sequence[StampedStream], number: int, restart: _Restart, pause: float
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


def _leave_out_isolated(streams: Sequence[StampedStream], tick: float, faults: ClockFaults) -> None:
    """Leave out a few samples at an end of the log that are too far away from all others."""
    ticks = np.sort(np.concatenate([np.empty(0), *(each.ticks[each.rows] for each in streams)]))
    if len(ticks) <= 2 * MAX_DAMAGED_SAMPLES:
        return
    low, high = ticks[0], ticks[-1]
    for count in range(1, MAX_DAMAGED_SAMPLES + 1):
        for a, b, c, end in ((count - 1, count, -1, "low"), (-count, -count - 1, 0, "high")):
            pause = MIN_ISOLATION_S / tick + ISOLATION_DURATIONS * abs(ticks[c] - ticks[b])
            if abs(ticks[b] - ticks[a]) > pause:
                low, high = (ticks[b], high) if end == "low" else (low, ticks[b])
    for stream in streams:
        rows = stream.rows
        far = rows[(stream.ticks[rows] < low) | (stream.ticks[rows] > high)]
        stream.ticks[far] = np.nan
        faults.add(DAMAGED_TIME_REMARK, stream.name, far)
