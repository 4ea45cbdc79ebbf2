"""The times of the messages of a component in a telemetry log, on the component's own clock.

The stamps of a log are those of the program that wrote it: a radio link makes them late by any
time. Most messages have a time since boot, whose steps are exact.
"""

from collections.abc import Mapping, Sequence

import numpy as np

BOOT_FIELD, SAMPLE_FIELD = "time_boot_ms", "time_usec"
"""Fields with a time since boot: milliseconds in 32 bits, and microseconds in 32 or 64 bits."""
BOOT_RANGE_S = 2.0**32 * 1e-3
"""Time after which a counter of milliseconds in 32 bits overflows [s]."""
SAMPLE_RANGE_S = 2.0**32 * 1e-6
"""Time after which a counter of microseconds in 32 bits overflows [s]."""
MAX_DISORDER_S = 1.0
"""Largest step back between messages that is no restart [s]."""
MAX_SAMPLE_AGE_S = 10.0
"""Largest difference of the two times since boot in neighbouring messages [s]; others are on
another clock, as microseconds since 1970."""


def message_times(
    stamps: Sequence[np.ndarray],
    places: Sequence[np.ndarray],
    fields: Sequence[Mapping[str, np.ndarray]],
) -> list[np.ndarray]:
    """Return the times of the messages of a component [us since 1970], by kind.

    Between restarts of the component they have the steps of its clock, and the earliest arrival
    after the clock's time sets when it began. A message without a time of its own counts from the
    message with a time before it. Without any such message, the times are the stamps.

    Args:
        stamps: of the messages of each kind [us since 1970].
        places: of the messages in the file.
        fields: of the messages.
    """
    order = np.argsort(np.concatenate(places), kind="stable")
    arrival = 1e-6 * np.concatenate(stamps)[order]
    boot, sample, is_short = (np.concatenate(each)[order] for each in _own_times(stamps, fields))
    timed = np.flatnonzero(boot > 0.0)
    if len(timed) == 0:
        return [np.asarray(each, dtype=float) for each in stamps]
    clock = np.unwrap(boot[timed], period=BOOT_RANGE_S)
    part = np.cumsum(np.diff(clock, prepend=clock[0]) < -MAX_DISORDER_S)
    begin = np.full(part[-1] + 1, np.inf)
    np.minimum.at(begin, part, arrival[timed] - clock)
    before = np.maximum(np.searchsorted(timed, np.arange(len(order)), side="right") - 1, 0)
    since = np.maximum(arrival - arrival[timed[before]], 0.0)
    since[: timed[0]] = arrival[: timed[0]] - arrival[timed[0]]
    time = clock[before] + since
    age = sample - clock[before]
    age = np.where(is_short, age - SAMPLE_RANGE_S * np.round(age / SAMPLE_RANGE_S), age)
    known = np.isnan(boot) & (sample > 0.0) & (np.abs(age) <= MAX_SAMPLE_AGE_S)
    time = np.where(known, clock[before] + age, time)
    found = np.empty(len(order))
    found[order] = 1e6 * (time + begin[part[before]])
    return np.split(found, np.cumsum([len(each) for each in stamps])[:-1])


def _own_times(
    stamps: Sequence[np.ndarray], fields: Sequence[Mapping[str, np.ndarray]]
) -> tuple[list[np.ndarray], list[np.ndarray], list[np.ndarray]]:
    """Return boot and sample times of all messages [s], NaN without one, and whether the latter
    are of 32 bits.
    """
    boot, sample, is_short = [], [], []
    for each, kind in zip(stamps, fields, strict=True):
        unknown = np.full(len(each), np.nan)
        boot.append(1e-3 * kind[BOOT_FIELD] if BOOT_FIELD in kind else unknown)
        sample.append(1e-6 * kind[SAMPLE_FIELD] if SAMPLE_FIELD in kind else unknown)
        width = kind[SAMPLE_FIELD].dtype.itemsize if SAMPLE_FIELD in kind else 0
        is_short.append(np.full(len(each), width == 4))
    return boot, sample, is_short
