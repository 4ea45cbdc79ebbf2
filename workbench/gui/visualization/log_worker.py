"""The process that reads a log or a spec for a responsive window: `python -m MODULE FD`."""

import contextlib
import math
import re
import signal
import sys
import threading
from collections.abc import Callable, Container
from itertools import chain, count
from multiprocessing.connection import Connection
from pathlib import Path

import numpy as np

from workbench.common.errors import WorkbenchError
from workbench.common.plain_text import plain_name
from workbench.gui.visualization.log_messages import (
    CaseLimits,
    LogContents,
    SpecContents,
)
from workbench.ipc.worker_process import Answer, Refusal, Request
from workbench.logs.flight_reader import open_log

_AXES = {"x": 0, "y": 1, "z": 2}
_QUATERNION = {"w": 0, "x": 1, "y": 2, "z": 3}
_UNWANTED = re.compile(
    r"covariance|^actions\.|^lidar_cloud\.|^tf|\.fields\.|^pose\.|^twist\.|^estimated_odometry\.|^gps\.status|"
    r"^command_velocity\.(lease|axes)$|twist\.angular"
)

SPECS = (".yaml", ".yml")
"""Endings of spec files; all other files are logs."""
LONGEST_SERIES = 200
"""Largest number of characters in the name of a series."""
READING = 0.7
"""Share of the time for reading; the rest is for decoding."""
STEP = 0.01
"""Step of reported progress."""


def live_name(name: str) -> str | None:
    """Return a flight's name for a series of a log; None if it is not worth a curve."""
    if _UNWANTED.search(name):
        return None
    patterns = (
        (r"^imu\.linear_acceleration\.([xyz])$", "imu.specific_force.{}", _AXES),
        (r"^imu\.angular_velocity\.([xyz])$", "imu.angular_velocity.{}", _AXES),
        (r"^imu\.orientation\.([wxyz])$", "imu.q_WS.{}", _QUATERNION),
        (
            r"^magnetometer\.magnetic_field\.([xyz])$",
            "magnetometer.magnetic_field.{}",
            _AXES,
        ),
        (r"^gps_velocity\.twist\.linear\.([xyz])$", "gps.velocity.{}", _AXES),
    )
    for pattern, wanted, places in patterns:
        found = re.match(pattern, name)
        if found:
            return wanted.format(places[found.group(1)])
    return name


def short_name(name: str, taken: Container[str]) -> str:
    """Return the name of a series for the window, which searches all names many times.

    Args:
        name: the name in the log.
        taken: names of other series.
    """
    if len(name) <= LONGEST_SERIES:
        return name
    short = plain_name(name, LONGEST_SERIES)
    others = (f"{short} {number}" for number in count(2))
    return next(each for each in chain([short], others) if each not in taken)


def si_unit(unit: str) -> tuple[str, float]:
    """Return the SI unit that a flight uses for a quantity of a log, and the factor to it."""
    if unit in ("deg", "degree", "degrees"):
        return "rad", math.pi / 180.0
    return unit or "1", 1.0


def contents_of(path: Path, progress: Callable[[float], None]) -> LogContents:
    """Return the content of a log that can be drawn.

    Args:
        path: path of the log.
        progress: called with the share done, 0 .. 1.

    Raises:
        WorkbenchError: if it cannot be read, or its format is unknown.
    """
    record = open_log(path, progress=lambda share: progress(READING * share))
    units: dict[str, str] = {}
    times: dict[str, np.ndarray] = {}
    values: dict[str, np.ndarray] = {}
    topic_of: dict[str, str] = {}
    for number, (topic, logged) in enumerate(record.topics.items()):
        for series in logged.columns.values():
            name = live_name(series.name)
            if name is None or series.values.dtype.kind not in "fiub":
                continue
            name = short_name(name, units)
            unit, factor = si_unit(series.unit)
            flown = np.asarray(series.values, dtype=float)
            units[name], values[name] = unit, flown * factor if factor != 1.0 else flown
            # A topic of an imported log may contain streams of several rates.
            shared = np.array_equal(times.get(topic, series.time), series.time)
            whose = topic if shared else name
            times.setdefault(whose, series.time)
            topic_of[name] = whose
        progress(READING + (1.0 - READING) * (number + 1) / len(record.topics))
    begin = min((float(time[0]) for time in times.values() if len(time)), default=0.0)
    end = max((float(time[-1]) for time in times.values() if len(time)), default=0.0)
    return LogContents(
        path, record.vehicle, begin, end, record.remark, units, times, values, topic_of
    )


def limits_of(path: Path) -> SpecContents:
    """Return the limits in a spec.

    Raises:
        WorkbenchError: names file and line of an error.
    """
    # these load Drake, which reading logs does not need
    from workbench.design.regress.baseline import curves_file, read_curves
    from workbench.design.regress.loading import load_spec
    from workbench.design.regress.signals import AXIS_SIGNALS
    from workbench.design.regress.verdict import band

    spec = load_spec(path)
    cases = []
    for case in spec.content.cases:
        curves = read_curves(curves_file(spec.path, case.name))
        bands = {
            signal: (curve.time, *band(curve, tolerance, curve.time))
            for signal, tolerance in case.baseline.items()
            if (curve := curves.get(signal)) is not None
        }
        command = case.amplitude if case.axis else case.command
        limits = {name: (each.min, each.max) for name, each in case.limits.items()}
        signal = case.signal or AXIS_SIGNALS.get(case.axis or case.load, "")
        wanted = math.nan if command is None else command
        cases.append(CaseLimits(case.name, signal, wanted, limits, bands))
    return SpecContents(path, tuple(cases))


def main(connection: Connection) -> None:
    """Read the requested file, send its content, and exit; also exit when the app wants no more."""
    # Ctrl-C, by which the process that reads the log ends, too, and its files are removed.
    with contextlib.suppress(EOFError, OSError, KeyboardInterrupt):
        asked = connection.recv()
        threading.Thread(target=_end_with_app, args=(connection,), daemon=True).start()
        assert isinstance(asked, Request)
        path, told = asked.what, 0.0

        def tell(share: float) -> None:
            """Send progress, at a limited rate."""
            nonlocal told
            if share >= told + STEP:
                told = share
                with contextlib.suppress(OSError):  # the app is gone, and this process ends
                    connection.send(share)

        try:
            is_spec = path.suffix in SPECS
            found = limits_of(path) if is_spec else contents_of(path, tell)
            connection.send(Answer(asked.number, found))
        except WorkbenchError as error:
            connection.send(Refusal(asked.number, str(error)))
        except MemoryError:
            said = f"{path}: there is not enough memory for this log"
            connection.send(Refusal(asked.number, said))


def _end_with_app(connection: Connection) -> None:
    """Interrupt the main thread when the app says that it wants no more, or is gone."""
    with contextlib.suppress(EOFError, OSError):
        connection.recv()
    main_thread = threading.main_thread().ident
    assert main_thread is not None
    signal.pthread_kill(main_thread, signal.SIGINT)


if __name__ == "__main__":
    main(Connection(int(sys.argv[1])))
