"""Logs of a height sensor: a line HEIGHT, then lines with time [s] and height [m]."""

import numpy as np

from workbench import Flight, make_series
from workbench.logs.readers.log_reader import LogReader


def recognises(path, head):
    """Return whether a file is such a log, from its first bytes."""
    return head.startswith(b"HEIGHT\n")


def read(file):
    """Return the flight."""
    time, height = np.loadtxt(file.path, skiprows=1, unpack=True)
    signal = make_series("position_data.z", "m", time, height)
    signals = {signal.name: signal}
    return Flight(file.path.stem, file.path, "height log", signals, end=float(time[-1]))


READER = LogReader(
    "height log",
    "a height sensor's .hgt",
    recognises,
    read,
    place=100,
    endings=(".hgt",),
    needs_plain=True,
)
