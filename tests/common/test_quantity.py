"""A quantity's limits and texts, and the rows of all tables of quantities."""

import math

import pytest

from workbench.common.errors import WorkbenchError
from workbench.common.quantity import DisplayUnit, Quantity, display_unit, number_text
from workbench.design.metrics import WISHED_METRICS
from workbench.gui.preferences import PREFERENCES
from workbench.gui.tuning.limits import NUMBER_LIMITS
from workbench.parameters.parameter_table import flight_table


@pytest.mark.parametrize(
    ("value", "said"),
    [
        (math.nan, "here: height is 'nan': give it a number"),
        (True, "here: height is 'True': give it a number"),
        ("2", "here: height is '2': give it a number"),
        (2.5, "here: height is 2.5 m: keep it within -1 .. 2 m"),
        (-math.inf, "here: height is -inf m: keep it within -1 .. 2 m"),
    ],
)
def test_what_is_no_number_or_out_of_range_is_refused(value, said):
    height = Quantity("height", "m", "above the ground", -1.0, 2.0)
    assert [height.check(each) for each in (-1, 0.5, 2.0)] == [-1.0, 0.5, 2.0]
    with pytest.raises(WorkbenchError) as refused:
        height.check(value, "here: ")
    assert str(refused.value) == said


def test_a_number_is_shown_in_one_way_everywhere():
    """A quarter turn is 90 deg; a velocity of 1 m/s is 3.6 km/h."""
    assert Quantity("turn", "rad", "").text(math.pi / 2.0) == "90 deg"
    assert Quantity("share", "1", "").text(0.12345) == "0.123"
    assert Quantity("time", "s", "").text(math.nan) == "—"
    assert display_unit("rad").read(90.0) == pytest.approx(math.pi / 2.0)
    fast = DisplayUnit("km/h", 3.6, 1)
    assert fast.text(-1.0) == "\N{MINUS SIGN}3.6\N{NO-BREAK SPACE}km/h"
    assert fast.text(math.inf) == "–"
    assert DisplayUnit("°", decimals=0).text(12.0) == "12°"
    assert [number_text(each, 1) for each in (-0.04, -1e7)] == ["0.0", "\N{MINUS SIGN}1e+07"]


def test_limits_of_all_tables_are_finite_and_have_their_default():
    numbers = [row for row in PREFERENCES if isinstance(row.default, float)]
    for row in (*flight_table(), *numbers, *NUMBER_LIMITS):
        assert row.check(row.default) == row.default, row.name
    for row in (*flight_table(), *numbers, *NUMBER_LIMITS, *WISHED_METRICS):
        assert -math.inf < row.minimum < row.maximum < math.inf, row.name
        assert row.help, row.name
