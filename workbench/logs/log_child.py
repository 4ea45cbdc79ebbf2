"""The process that reads one log: run by `read_in_process` through `run_limited`.

Logs and the libraries that read them are foreign. Arrays go to files, and the rest is JSON.
"""

import hashlib
from pathlib import Path
from typing import Any

import numpy as np

from workbench.common.flight import Flight
from workbench.ipc.limited import serve_one_request
from workbench.logs.array_files import ArrayWriter
from workbench.logs.log_process import ARRAYS_FOLDER, PROGRESS_FILE
from workbench.logs.readers.any_log import read_any, read_workbench_log
from workbench.logs.readers.log_reader import LogFile
from workbench.logs.record import LogRecord


def read_to_arrays(request: dict[str, Any]) -> dict[str, Any]:
    """Read a log, write its arrays, and return the rest."""
    path, folder = Path(request["path"]), Path(request["folder"])
    arrays = folder / ARRAYS_FOLDER
    arrays.mkdir()
    with (folder / PROGRESS_FILE).open("ab", buffering=0) as told:

        def tell(share: float) -> None:
            told.write(bytes(max(0, int(100.0 * share) - told.tell())))

        if request["own"]:
            found: LogRecord | Flight = read_workbench_log(path, folder, tell)
        else:
            mapping = request["mapping"] and Path(request["mapping"])
            found = read_any(LogFile(path, mapping, request["log_number"]), folder, tell)
    writer = ArrayWriter(arrays)
    if isinstance(found, LogRecord):
        return {"log": found.described(writer)}
    return {"flight": found.described(), "samples": _written_signals(found, writer)}


def _written_signals(flight: Flight, arrays: ArrayWriter) -> list[Any]:
    """Write the samples of the signals, and times that several of them share once."""
    known: dict[bytes, np.ndarray] = {}
    places = []
    for signal in flight.signals.values():
        digest = hashlib.blake2b(np.ascontiguousarray(signal.time).data).digest()
        time = known.setdefault(digest, signal.time)
        places.append([arrays.add(time), arrays.add(signal.values)])
    return places


if __name__ == "__main__":
    serve_one_request(read_to_arrays)
