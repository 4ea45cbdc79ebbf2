"""Arrays in the files of a folder, which a process leaves for the one that asked for them.

The reader takes what it gets for hostile: no pickles, types from a list, and no more numbers than
the files have.
"""

from pathlib import Path
from typing import Any

import numpy as np

MAX_ARRAY_FILE_BYTES = 1 << 26
"""Size limit of a file [bytes], as the processes that write them may write no larger ones."""
ARRAY_TYPE_CODES = ("|b1", "|i1", "|u1", "<i2", "<u2", "<i4", "<u4", "<f4", "<i8", "<u8", "<f8")
"""Types of the elements of arrays, by numpy's codes."""


class ArrayWriter:
    """Writes arrays one after the other.

    Args:
        folder: an empty one, for the files.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._at = 0
        self._places: dict[int, list[Any]] = {}
        self._kept: list[np.ndarray] = []  # so that no other array gets the identity of one

    def add(self, values: np.ndarray) -> Any:
        """Write an array (n) of numbers or texts, and return where it is, for `ArrayReader`.

        An array that is added again is not written again.

        Raises:
            OSError: if it cannot be written.
        """
        if id(values) not in self._places:
            self._kept.append(values)
            self._places[id(values)] = self._add(values)
        return self._places[id(values)]

    def _add(self, values: np.ndarray) -> list[Any]:
        if values.dtype.kind == "O":
            numbers: dict[str, int] = {}
            each = [numbers.setdefault(str(value), len(numbers)) for value in values]
            return [*self._add(np.array(each, dtype=np.uint32)), list(numbers)]
        plain = np.ascontiguousarray(values, dtype=values.dtype.newbyteorder("<"))
        place = [plain.dtype.str, len(plain), self._at]
        rest = plain.data.cast("B") if len(plain) else memoryview(b"")
        while rest:
            number, begin = divmod(self._at, MAX_ARRAY_FILE_BYTES)
            part = rest[: MAX_ARRAY_FILE_BYTES - begin]
            with (self._folder / str(number)).open("ab") as file:
                file.write(part)
            rest, self._at = rest[len(part) :], self._at + len(part)
        return place


class ArrayReader:
    """Reads the arrays of an `ArrayWriter`.

    Args:
        folder: the one with the files.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._size = sum(file.stat().st_size for file in folder.iterdir())
        self._found: dict[int, np.ndarray] = {}

    def get(self, place: Any) -> np.ndarray:
        """Return an array (n).

        Raises:
            ValueError, TypeError, OSError: if there is none.
        """
        code, count, at, *texts = place
        if code not in ARRAY_TYPE_CODES or not 0 <= count <= self._size // np.dtype(code).itemsize:
            raise ValueError(f"{code} and {count} are no array")
        values = self._found.get(at)
        if values is None or values.dtype.str != code or len(values) != count:
            values = self._found[at] = self._read(np.empty(count, code), at)
        if not texts:
            return values
        known = np.array([*map(str, texts[0]), ""], dtype=object)
        return np.asarray(known[np.minimum(values, len(known) - 1)])

    def _read(self, values: np.ndarray, at: int) -> np.ndarray:
        rest = values.data.cast("B") if len(values) else memoryview(b"")
        while rest:
            number, begin = divmod(at, MAX_ARRAY_FILE_BYTES)
            with (self._folder / str(number)).open("rb") as file:
                file.seek(begin)
                count = file.readinto(rest[: MAX_ARRAY_FILE_BYTES - begin])
            if not count:
                raise ValueError("an array ends beyond its file")
            rest, at = rest[count:], at + count
        return values
