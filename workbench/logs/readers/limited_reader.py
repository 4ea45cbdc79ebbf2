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
from workbench.logs.flight_record import FlightRecord
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
        times = [_load(folder, f"t{place}") for place in range(said["times"])]
        samples = {
            each["name"]: (times[place], _load(folder, f"v{number}"))
            for number, (each, place) in enumerate(
                zip(said["signals"], said["places"], strict=True)
            )
        }
    return FlightRecord.from_description(said, path, samples)


def _load(folder: str, name: str) -> np.ndarray:
    array: np.ndarray = np.load(Path(folder) / f"{name}.npy", allow_pickle=False)
    return array


def _read(request: dict[str, Any]) -> dict[str, Any]:
    """Read a log here, and return all but the arrays, which become files."""
    folder = Path(request["folder"])
    _, read = READERS[request["format"]]
    flight = read(Path(request["path"]))
    known: dict[bytes, int] = {}
    places = []
    for number, signal in enumerate(flight.signals.values()):
        key = signal.time.tobytes()
        if key not in known:
            known[key] = len(known)
            np.save(folder / f"t{known[key]}.npy", signal.time)
        places.append(known[key])
        np.save(folder / f"v{number}.npy", signal.values)
    return {**flight.described(), "times": len(known), "places": places}


if __name__ == "__main__":
    serve(_read)
