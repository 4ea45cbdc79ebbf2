"""Reads a log with a library that was not written for strangers' files, in a process of its own.

The process has bounds of time and memory; arrays come back as files, all else as JSON.
"""

import tempfile
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

from workbench.common.errors import WorkbenchError
from workbench.ipc.limited import LimitedError, run_limited, serve
from workbench.logs.flight_record import FlightRecord, Signal
from workbench.logs.readers import blackbox, dataflash, ulog

READERS = {
    ulog.FORMAT: (ulog.NEEDS, ulog.read_ulog),
    dataflash.FORMAT: (dataflash.NEEDS, dataflash.read_dataflash),
    blackbox.FORMAT: (blackbox.NEEDS, blackbox.read_blackbox),
}
"""By the format: the package that it needs, and the reader."""
SECONDS, SECONDS_A_MEGABYTE = 15.0, 4.0
MEGABYTES, MEGABYTES_A_MEGABYTE = 1500, 40
MOST_SECONDS, MOST_MEGABYTES = 900.0, 12_000
"""Bounds, by the size of the file: blackbox logs take some 2 s and 20 MB a megabyte."""


def read_limited(path: Path, format_: str) -> FlightRecord:
    """Read a log of one of the `READERS`.

    Raises:
        WorkbenchError: if its package is not there, or the log cannot be read within bounds.
    """
    needs, _ = READERS[format_]
    if find_spec(needs) is None:
        raise WorkbenchError(
            f"{path}: a {format_} needs the package {needs}: `pip install {needs}`"
        )
    size = path.stat().st_size / 1e6
    with tempfile.TemporaryDirectory() as folder:
        request = {"path": str(path), "format": format_, "folder": folder}
        try:
            said = run_limited(
                __name__,
                request,
                seconds=min(SECONDS + SECONDS_A_MEGABYTE * size, MOST_SECONDS),
                megabytes=round(min(MEGABYTES + MEGABYTES_A_MEGABYTE * size, MOST_MEGABYTES)),
            )
        except LimitedError as error:
            raise WorkbenchError(f"{path}: cannot be read as a {format_}: {error}") from error
        times = [_load(folder, f"t{i}") for i in range(said["times"])]
        signals = {}
        for i, each in enumerate(said["signals"]):
            gaps = tuple((begin, end) for begin, end in each["gaps"])
            signals[each["name"]] = Signal(
                each["name"],
                each["unit"],
                times[each["time"]],
                _load(folder, f"v{i}"),
                each["rate"],
                each["delay"],
                gaps,
            )
    return FlightRecord(
        name=said["name"],
        source=path,
        format=format_,
        signals=signals,
        firmware=said["firmware"],
        parameters=said["parameters"],
        remarks=tuple(said["remarks"]),
        end=said["end"],
    )


def _load(folder: str, name: str) -> np.ndarray:
    array: np.ndarray = np.load(Path(folder) / f"{name}.npy", allow_pickle=False)
    return array


def _read(request: dict[str, Any]) -> dict[str, Any]:
    """Read a log here, and return all but the arrays, which become files."""
    folder = Path(request["folder"])
    _, read = READERS[request["format"]]
    flight = read(Path(request["path"]))
    times: list[np.ndarray] = []
    places: dict[bytes, int] = {}
    signals = []
    for i, signal in enumerate(flight.signals.values()):
        key = signal.time.tobytes()
        if key not in places:
            places[key] = len(times)
            np.save(folder / f"t{len(times)}.npy", signal.time)
            times.append(signal.time)
        np.save(folder / f"v{i}.npy", signal.values)
        signals.append(
            {
                "name": signal.name,
                "unit": signal.unit,
                "time": places[key],
                "rate": signal.rate,
                "delay": signal.delay,
                "gaps": signal.gaps,
            }
        )
    return {
        "name": flight.name,
        "firmware": flight.firmware,
        "parameters": dict(flight.parameters),
        "remarks": list(flight.remarks),
        "end": flight.end,
        "times": len(times),
        "signals": signals,
    }


if __name__ == "__main__":
    serve(_read)
