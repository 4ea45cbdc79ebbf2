"""Oracles: a table filled by hand; Python's csv, and pyarrow where it is installed."""

import csv
import sys

import numpy as np
import pytest

from workbench.common.errors import WorkbenchError
from workbench.design.sweep.table import check_table_path, write_sweep_table

NAN = float("nan")
#        rise settle over under peak  at steady error use
ROWS = [
    [0.50, 0.90, 0.0, 0.0, 1.99, 3.0, 1.99, 0.5, 0.80],
    [0.40, 0.70, 0.0, 0.0, 2.00, 3.0, 2.00, 0.1, 0.90],
    [0.30, NAN, 9.0, 0.0, 2.30, 0.5, 2.10, 4.9, 0.70],
    [0.10, 0.20, 0.0, 0.0, 1.20, 3.0, 1.20, 40.0, 0.60],
    [NAN] * 9,
]
LOST = [NAN, NAN, NAN, NAN, 0.7]


@pytest.fixture
def table(make_table):
    return make_table(ROWS, LOST)


def test_columns_have_names_and_units(table):
    assert table.names[:3] == ("kp_roll", "rise_time", "settling_time")
    assert table.names[-2:] == ("peak_rotor_use", "diverged_at")
    assert dict(zip(table.names, table.units, strict=True)) == {
        "kp_roll": "1/s^2",
        "rise_time": "s",
        "settling_time": "s",
        "overshoot": "%",
        "undershoot": "%",
        "peak": "m/s",
        "peak_time": "s",
        "steady_state_value": "m/s",
        "steady_state_error": "%",
        "peak_rotor_use": "1",
        "diverged_at": "s",
    }
    assert table.rows.shape == (5, 11)
    np.testing.assert_array_equal(table.column("kp_roll"), np.linspace(100.0, 400.0, 5))
    np.testing.assert_array_equal(table.column("diverged_at"), LOST)


@pytest.mark.parametrize(
    ("metric", "order"),
    [
        ("rise_time", [1, 0, 3]),  # 3 is fastest, and does not get there
        ("settling_time", [1, 0, 3]),  # 2 never settles, and is ranked nowhere
        ("overshoot", [1, 0, 3]),  # equal ones: what settles first
        ("peak_rotor_use", [0, 1, 3]),
        ("peak", [1, 0, 3]),  # nearest to the command
    ],
)
def test_ranking_puts_the_best_first_and_the_lost_nowhere(table, metric, order):
    assert table.ranking(metric).tolist() == order


def test_a_candidate_has_the_values_of_its_row(table):
    assert table.candidate(4).settings == {"kp_roll": 400.0}
    assert table.candidate(4).variation.nominal


def test_what_is_not_there_is_a_sentence(table):
    with pytest.raises(WorkbenchError, match="did you mean 'overshoot'"):
        table.ranking("overshot")
    with pytest.raises(WorkbenchError, match="phase_margin was not measured: ask for margins"):
        table.ranking("phase_margin")
    with pytest.raises(WorkbenchError, match="unknown column"):
        table.column("kp_pitch")


def test_csv_has_units_in_its_head_and_nothing_where_nothing_is_known(lost_table, tmp_path):
    path = tmp_path / "a.csv"
    write_sweep_table(lost_table, path)
    head, *rows = csv.reader(path.read_text().splitlines())
    assert head[:3] == ["kp_pitch [1/s^2]", "kp_velocity_x [1/s]", "rise_time [s]"]
    assert head[-2:] == ["peak_rotor_use [1]", "diverged_at [s]"]
    found = [[float(cell) if cell else np.nan for cell in row] for row in rows]
    np.testing.assert_array_equal(found, lost_table.rows)
    assert "" in rows[0] and "nan" not in path.read_text()


@pytest.mark.slow
def test_parquet_has_names_units_and_gaps(lost_table, tmp_path):
    parquet = pytest.importorskip("pyarrow.parquet", reason="install the extra `parquet` to try it")
    path = tmp_path / "a.parquet"
    write_sweep_table(lost_table, path)
    table = parquet.read_table(path)
    assert tuple(table.column_names) == lost_table.names
    assert table.schema.field("kp_pitch").metadata[b"unit"] == b"1/s^2"
    assert table["diverged_at"].null_count == int(np.isnan(lost_table.diverged_at).sum())


def test_without_pyarrow_a_sentence_says_what_to_install(monkeypatch, tmp_path):
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    with pytest.raises(WorkbenchError, match="`pip install pyarrow`, or name a .csv"):
        check_table_path(tmp_path / "a.parquet")


@pytest.mark.parametrize("name", ["a.txt", "a", "a.csv.gz"])
def test_another_suffix_is_refused(tmp_path, name):
    with pytest.raises(WorkbenchError, match="ends in .csv or .parquet"):
        check_table_path(tmp_path / name)


def test_a_place_that_is_not_there_is_a_sentence(lost_table, tmp_path):
    with pytest.raises(WorkbenchError, match="cannot be written: No such file"):
        write_sweep_table(lost_table, tmp_path / "gone" / "a.csv")
