"""Samples of several curves as one table in text."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, eq=False)
class Column:
    """A curve of a table.

    Attributes:
        label: its name.
        unit: SI.
        time: of its samples (n), rising [s].
        values: (n).
    """

    label: str
    unit: str
    time: np.ndarray
    values: np.ndarray


def table_text(columns: Sequence[Column], separator: str = "\t") -> str:
    """Return a line of names with units, then a line for each time at which there is a sample.

    A curve without a sample at that time has an empty cell.
    """
    heads = ["time [s]", *(f"{each.label} [{each.unit or '1'}]" for each in columns)]
    lines = [separator.join(heads)]
    if columns:
        time = columns[0].time
        if any(each.time.shape != time.shape or (each.time != time).any() for each in columns[1:]):
            time = np.unique(np.concatenate([each.time for each in columns]))
        table = np.full((len(time), 1 + len(columns)), np.nan)
        table[:, 0] = time
        for index, each in enumerate(columns, 1):
            table[np.searchsorted(time, each.time), index] = each.values
        row = separator.join(["%.9g"] * table.shape[1])
        filled = "\n".join([row] * len(time)) % tuple(table.ravel().tolist())
        lines.append(filled.replace("nan", ""))
    return "\n".join(line for line in lines if line) + "\n"
