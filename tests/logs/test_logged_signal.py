"""Names of signals that come from names of columns."""

import pytest

from workbench.logs.logged_signal import SIGNAL_NAME, signal_name_part
from workbench.logs.readers.table_head import own_signal


@pytest.mark.parametrize(
    ("column", "name"),
    [
        ("Temp ℃", "csv.temp_c"),
        ("№ 3", "csv.no_3"),
        ("Höhe [m]", "csv.höhe"),
        ("Ho\u0308he", "csv.höhe"),
        ("𝐀xis", "csv.axis"),
        ("²", "csv.n_2"),
    ],
)
def test_a_column_becomes_a_signal_in_small_letters(column, name):
    assert own_signal(column) == name


def test_whatever_sign_a_column_has_its_name_is_that_of_a_signal():
    signs = map(chr, (*range(0x3000), *range(0xF900, 0x10000), *range(0x1D400, 0x1D800)))
    names = [f"a.{signal_name_part(each)}" for each in signs]
    assert [name for name in names if not SIGNAL_NAME.fullmatch(name)] == []
