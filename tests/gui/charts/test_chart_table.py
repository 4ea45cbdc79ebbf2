"""The table of a chart's samples, as another program reads it."""

import csv
import io

import numpy as np

from workbench.common.series import make_series
from workbench.gui.charts.chart_table import table_text


def test_a_name_with_a_separator_stays_one_column():
    time = np.array([0.0, 1.0])
    columns = [
        make_series("height · one, two.csv", "m", time, np.array([2.0, 3.0])),
        make_series("speed\tover ground", "m/s", time, np.array([4.0, 5.0])),
    ]
    for separator in (",", "\t"):
        text = table_text(columns, "time [s]", separator)
        rows = list(csv.reader(io.StringIO(text), delimiter=separator))
        assert rows == [
            ["time [s]", "height · one, two.csv [m]", "speed\tover ground [m/s]"],
            ["0", "2", "4"],
            ["1", "3", "5"],
        ]
