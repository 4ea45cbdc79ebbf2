"""The newest rows of numbers over time, in one block of memory."""

import numpy as np


class RowRingBuffer:
    """The newest rows of a table whose first column is time.

    A block of at least twice the needed length is filled from its start; when it is full, its newer
    half moves to the front. So rows are always contiguous, and a view of them costs nothing.

    Args:
        rows: least number of kept rows.
        columns: numbers per row, including time.
    """

    def __init__(self, rows: int, columns: int) -> None:
        self._kept = max(1, rows)
        self._block = np.empty((2 * self._kept, columns))
        self._end = 0

    def append(self, rows: np.ndarray) -> None:
        """Append rows (N, columns) with non-decreasing times."""
        rows = rows[-self._kept :]
        if self._end + len(rows) > len(self._block):
            left = self._block[max(0, self._end - self._kept) : self._end]
            self._block[: len(left)] = left.copy()
            self._end = len(left)
        self._block[self._end : self._end + len(rows)] = rows
        self._end += len(rows)

    def rows(self, since: float = -np.inf) -> np.ndarray:
        """Return the rows from a time on (N, columns): a view, valid until the next `append`."""
        filled = self._block[: self._end]
        return filled[np.searchsorted(filled[:, 0], since) :]
