"""The samples of a chart as a table of text: columns with names, units, times and values."""

import csv
import io
from collections.abc import Sequence

import numpy as np

from workbench.common.series import Series


def table_text(columns: Sequence[Series], over: str, separator: str = "\t") -> str:
    """Return a line of names with units, then a line for each time with a sample.

    A curve without a sample at that time has an empty cell.

    Args:
        columns: columns of the table.
        over: name and unit of the first column, as time [s].
        separator: text between cells.
    """
    heads = [over, *(f"{each.name} [{each.unit or '1'}]" for each in columns)]
    head = io.StringIO()
    csv.writer(head, delimiter=separator, lineterminator="").writerow(heads)  # quotes commas
    lines = [head.getvalue()]
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
