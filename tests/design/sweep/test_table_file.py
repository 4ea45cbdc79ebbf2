"""Oracle: Python's csv, and pyarrow where it is installed."""

import csv
import sys

import numpy as np
import pytest

from workbench.common.errors import WorkbenchError
from workbench.design.sweep.table_file import check_table_path, write_table


def test_csv_has_units_in_its_head_and_nothing_where_nothing_is_known(lost_table, tmp_path):
    path = tmp_path / "a.csv"
    write_table(lost_table, path)
    head, *rows = csv.reader(path.read_text().splitlines())
    assert head[:3] == ["kp_pitch [1/s^2]", "kp_velocity_x [1/s]", "rise_time [s]"]
    assert head[-2:] == ["peak_rotor_use [1]", "diverged_at [s]"]
    found = [[float(cell) if cell else np.nan for cell in row] for row in rows]
    np.testing.assert_array_equal(found, lost_table.rows)
    assert "" in rows[0] and "nan" not in path.read_text()


def test_parquet_has_names_units_and_gaps(lost_table, tmp_path):
    parquet = pytest.importorskip("pyarrow.parquet", reason="install the extra `parquet` to try it")
    path = tmp_path / "a.parquet"
    write_table(lost_table, path)
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
        write_table(lost_table, tmp_path / "gone" / "a.csv")
