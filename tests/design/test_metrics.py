"""Values with units."""

import math

import pytest

from workbench.common.errors import WorkbenchError
from workbench.design.metrics import find_metric, si_value


def test_a_value_comes_in_the_metrics_own_unit(case):
    for name, number, unit, value in [
        ("rise_time", 0.4, "", 0.4),
        ("rise_time", 400.0, "ms", 0.4),
        ("phase_margin", 45.0, "deg", math.pi / 4),
        ("phase_margin", 0.5, "", 0.5),
        ("gain_margin", 6.0, "dB", 10 ** (6 / 20)),
        ("peak_rotor_use", 80.0, "%", 0.8),
        ("bandwidth", 1.0, "Hz", 2 * math.pi),
        ("overshoot", 5.0, "%", 5.0),
    ]:
        with case(name, number, unit, value):
            assert si_value(find_metric(name), number, unit) == pytest.approx(value)


def test_what_cannot_be_is_refused(case):
    for name, number, unit, said in [
        ("phase_margin", 45.0, "", "phase_margin of 45 rad is not possible.*or say deg"),
        ("phase_margin", 200.0, "deg", "keep it within 0 deg .. 180 deg"),
        ("disk_margin", 2.5, "", "disk_margin of 2.5 is not possible: keep it within 0 .. 2"),
        ("rise_time", -1.0, "s", "rise_time of -1 s"),
        ("overshoot", math.nan, "%", "not possible"),
        ("gain_margin", 1e9, "dB", "not possible"),
        ("rise_time", 1.0, "deg", "rise_time is not in 'deg': its units are s, ms"),
        ("disk_margin", 1.0, "s", "its units are %"),
    ]:
        with case(name, number, unit, said), pytest.raises(WorkbenchError, match=said):
            si_value(find_metric(name), number, unit)


def test_people_read_degrees():
    assert find_metric("phase_margin").text(math.pi / 4) == "45 deg"
    assert find_metric("rise_time").text(0.123456) == "0.123 s"
    assert find_metric("disk_margin").text(math.inf) == "inf"
    assert find_metric("disk_margin").text(math.nan) == "—"
