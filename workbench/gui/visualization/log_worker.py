"""The process that reads a log or a spec for a responsive window: `python -m MODULE FD`."""

import contextlib
import math
import re
import signal
import sys
import threading
from collections.abc import Callable, Container
from dataclasses import replace
from itertools import chain, count
from multiprocessing.connection import Connection
from pathlib import Path

import numpy as np

from workbench.common.errors import WorkbenchError
from workbench.common.flight import Flight
from workbench.common.plain_text import plain_name
from workbench.common.series import Series
from workbench.gui.visualization.signal_catalog import vector_components
from workbench.gui.visualization.spec_limits import (
    CaseLimits,
    SpecContents,
)
from workbench.ipc.worker_process import WorkerRefusal, WorkerRequest, WorkerResult
from workbench.logs.flight_reader import open_log

_LIVE_NAMES = {
    "imu.linear_acceleration": "imu.specific_force",
    "imu.orientation": "imu.q_WS",
    "gps_velocity.twist.linear": "gps.velocity",
}
"""Fields of ROS 2 messages that have other names in the window."""
_UNWANTED_SERIES = re.compile(
    r"covariance|^actions\.|^lidar_cloud\.|^tf|\.fields\.|^pose\.|^twist\.|^estimated_odometry\.|^gps\.status|"
    r"^command_velocity\.(lease|axes)$|twist\.angular"
)

SPEC_ENDINGS = (".yaml", ".yml")
"""Endings of spec files; all other files are logs."""
MAX_SERIES_CHARACTERS = 200
"""Largest number of characters in the name of a series."""
LOG_PROGRESS_STEP = 0.01
"""Step of reported progress."""


def live_name(name: str) -> str | None:
    """Return a flight's name for a series of a log; None if it is not worth a curve."""
    if _UNWANTED_SERIES.search(name):
        return None
    of, _, part = name.rpartition(".")
    wanted = _LIVE_NAMES.get(of, of)
    components = [*vector_components().get(wanted, "")]
    return f"{wanted}.{components.index(part)}" if part in components else name


def short_series_name(name: str, taken: Container[str]) -> str:
    """Return the name of a series for the window, which searches all names many times.

    Args:
        name: the name in the log.
        taken: names of other series.
    """
    if len(name) <= MAX_SERIES_CHARACTERS:
        return name
    short = plain_name(name, MAX_SERIES_CHARACTERS)
    others = (f"{short} {number}" for number in count(2))
    return next(each for each in chain([short], others) if each not in taken)


def si_unit(unit: str) -> tuple[str, float]:
    """Return the SI unit that a flight uses for a quantity of a log, and the factor to it."""
    if unit in ("deg", "degree", "degrees"):
        return "rad", math.pi / 180.0
    return unit or "1", 1.0


def drawable_flight(path: Path, progress: Callable[[float], None]) -> Flight:
    """Return the flight of a log with the numbers that can be drawn, by the app's names.

    Args:
        path: path of the log.
        progress: called with the share done, 0 .. 1.

    Raises:
        WorkbenchError: if it cannot be read, or its format is unknown.
    """
    flight = open_log(path, progress=progress)
    signals: dict[str, Series] = {}
    for series in flight.signals.values():
        name = live_name(series.name)
        if name is None or series.values.dtype.kind not in "fiub":
            continue
        name = short_series_name(name, signals)
        unit, factor = si_unit(series.unit)
        values = np.asarray(series.values, dtype=float)
        scaled = values * factor if factor != 1.0 else values
        signals[name] = replace(series, name=name, unit=unit, values=scaled)
    lasts = (float(each.time[-1]) for each in signals.values() if len(each.time))
    return replace(flight, signals=signals, end=max(lasts, default=0.0))


def spec_limits(path: Path) -> SpecContents:
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
        assert isinstance(asked, WorkerRequest)
        path, told = asked.what, 0.0

        def tell(share: float) -> None:
            """Send progress, at a limited rate."""
            nonlocal told
            if share >= told + LOG_PROGRESS_STEP:
                told = share
                with contextlib.suppress(OSError):  # the app is gone, and this process ends
                    connection.send(share)

        try:
            is_spec = path.suffix in SPEC_ENDINGS
            found = spec_limits(path) if is_spec else drawable_flight(path, tell)
            connection.send(WorkerResult(asked.number, found))
        except WorkbenchError as error:
            connection.send(WorkerRefusal(asked.number, str(error)))
        except MemoryError:
            said = f"{path}: there is not enough memory for this log"
            connection.send(WorkerRefusal(asked.number, said))


def _end_with_app(connection: Connection) -> None:
    """Interrupt the main thread when the app says that it wants no more, or is gone."""
    with contextlib.suppress(EOFError, OSError):
        connection.recv()
    main_thread = threading.main_thread().ident
    assert main_thread is not None
    signal.pthread_kill(main_thread, signal.SIGINT)


if __name__ == "__main__":
    main(Connection(int(sys.argv[1])))
