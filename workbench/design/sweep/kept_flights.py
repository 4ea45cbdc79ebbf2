"""A file that keeps the flights of a sweep, so that a sweep that is ended goes on from there.

Its first line says what the flights depend on; each other line has the number of a candidate, its
metrics and the time of its loss, as hexadecimal numbers, which are exact. Lines are only added,
many in one write, so that at most the last one is incomplete.
"""

import fcntl
import json
import logging
import os
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Self

import numpy as np

from workbench.common.errors import WorkbenchError
from workbench.common.plain_files import read_plain
from workbench.design.sweep.case import empty_results

UNFINISHED_SUFFIX = ".unfinished"
"""Added to the name of the table."""
FIRST_WRITE_DELAY_S, WRITE_PERIOD_S = 5.0, 1.0
"""Time before anything is kept, and between writes [s]."""
MAX_KEPT_FLIGHTS_BYTES = 1_000_000_000
"""Size limit of the file."""


class KeptFlights:
    """The flights of a sweep in a file; use it in a `with` statement.

    Args:
        path: of the file; it need not exist.
        setup: returns what the flights depend on, by its description. It is called once, and only
            if there is such a file, or the sweep takes longer than `FIRST_WRITE_DELAY_S`.
        count: number of candidates.

    Attributes:
        flown: the flights in the file.

    Raises:
        WorkbenchError: if the file is of another sweep, or another process writes it.
    """

    def __init__(self, path: Path, setup: Callable[[], Mapping[str, str]], count: int) -> None:
        self._path = path
        self._setup = setup
        self._file: int | None = None
        self._lines: list[str] = []
        self._due = time.monotonic() + FIRST_WRITE_DELAY_S
        self._works = True
        self.flown = empty_results(count)
        if path.exists():
            self._read()
        if self.flown.done.any():
            logging.getLogger("workbench").warning(
                "%d of %d flights are kept from the sweep that was ended: flying the others",
                self.flown.done.sum(),
                count,
            )

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        if self._file is not None:
            self._write()
            os.close(self._file)
            self._file = None

    def keep(self, indices: np.ndarray, values: np.ndarray, diverged_at: np.ndarray) -> None:
        """Keep the flights of some candidates, see `FlownPart`."""
        if not self._works:
            return
        rows = np.column_stack([values, diverged_at]).tolist()
        for index, row in zip(indices.tolist(), rows, strict=True):
            self._lines.append(f"{index} {' '.join(map(float.hex, row))}\n")
        if time.monotonic() >= self._due:
            self._write()
            self._due = time.monotonic() + WRITE_PERIOD_S

    def _read(self) -> None:
        """Read the flights, and cut off an incomplete line.

        Raises:
            WorkbenchError: see `KeptFlights`.
        """
        head, *lines = read_plain(self._path, MAX_KEPT_FLIGHTS_BYTES).split(b"\n")
        self._check(head)
        whole = len(head) + 1
        for line in lines[:-1]:
            number, *numbers = line.decode("ascii", "replace").split(" ")
            try:
                index, row = int(number), [float.fromhex(each) for each in numbers]
                self.flown.values[index] = row[:-1]
            except (ValueError, IndexError, OverflowError):
                break
            self.flown.diverged_at[index] = row[-1]
            self.flown.done[index] = True
            whole += len(line) + 1
        self._open(whole)

    def _check(self, head: bytes) -> None:
        """Check that the flights are those of this sweep.

        Raises:
            WorkbenchError: if they are not.
        """
        instead = "delete it to fly all again, or name another table with --table"
        try:
            there = json.loads(head)
            assert isinstance(there, dict)
        except (ValueError, AssertionError):
            raise WorkbenchError(f"{self._path}: keeps no flights of a sweep: {instead}") from None
        own = self._setup()
        if there != own:
            other = [name for name in own if there.get(name) != own[name]]
            raise WorkbenchError(
                f"{self._path}: keeps the flights of a sweep with other {' and '.join(other)}: "
                f"{instead}"
            )

    def _write(self) -> None:
        """Add the lines to the file; if that fails, the sweep goes on without it."""
        if not self._works:
            return
        lines, self._lines = "".join(self._lines).encode(), []
        try:
            if self._file is None:
                lines = json.dumps(dict(self._setup())).encode() + b"\n" + lines
            file = self._open(0) if self._file is None else self._file
            if os.write(file, lines) < len(lines):
                raise WorkbenchError(f"{self._path}: the device is full")
            os.fsync(file)
        except (OSError, WorkbenchError) as error:
            self._works = False
            logging.getLogger("workbench").warning("further flights are not kept: %s", error)

    def _open(self, size: int) -> int:
        """Open the file for additions behind its first bytes.

        Raises:
            WorkbenchError: if another process has it.
        """
        file = os.open(self._path, os.O_WRONLY | os.O_CREAT | os.O_APPEND, 0o666)
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            os.close(file)
            raise WorkbenchError(f"{self._path}: another sweep writes it: wait for that") from None
        os.truncate(file, size)
        self._file = file
        return file
