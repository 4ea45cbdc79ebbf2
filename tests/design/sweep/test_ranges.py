"""Oracle: values by hand, and numpy's geomspace."""

import numpy as np
import pytest

from workbench.common.errors import WorkbenchError
from workbench.design.sweep.ranges import SweepRange, parse_range


def test_a_text_is_a_range(case):
    for text, expected in [
        ("kp_roll=100..400:9", SweepRange("kp_roll", 100.0, 400.0, 9)),
        ("kp_roll=100..400", SweepRange("kp_roll", 100.0, 400.0, 9)),
        ("kp_roll=100..400:log", SweepRange("kp_roll", 100.0, 400.0, 9, log=True)),
        ("kp_roll=1e2..400:3:log", SweepRange("kp_roll", 100.0, 400.0, 3, log=True)),
        (" kp_roll = 100 .. 400 : 5 ", SweepRange("kp_roll", 100.0, 400.0, 5)),
        ("wind_x=-5..5:3", SweepRange("wind_x", -5.0, 5.0, 3)),
        ("vary.mass=.8..1.2:2", SweepRange("vary.mass", 0.8, 1.2, 2)),
        ("rotor_1=0..1:2", SweepRange("rotor_1", 0.0, 1.0, 2)),
        ("payload_mass=0..0.5:2", SweepRange("payload_mass", 0.0, 0.5, 2)),
        ("kp_roll=1.5..2.5", SweepRange("kp_roll", 1.5, 2.5)),
    ]:
        with case(text, expected):
            assert parse_range(text) == expected


def test_what_is_no_range_is_a_sentence(case):
    for text, said in [
        ("kp_roll", "is not a range: write NAME=LOW..HIGH:POINTS"),
        ("kp_roll=100", "is not a range"),
        ("kp_roll=100..b", "is not a range"),
        ("kp_roll=100..400:9:8", "is not a range"),
        ("kp_roll=100..400:few", "is not a range"),
        ("kp_roll=100..400:2.5", "is not a range"),
        ("kp_roll=100..400:linear", "is not a range"),
        ("kp_rol=100..400", "did you mean 'kp_roll'"),
        ("mass=1..2", "vary.mass"),
        ("vary.control_delay=0..2", "known are"),
        ("battery_duration=10..20", "is not something that a sweep can vary"),
        ("imu_fault=0..1", "is not something that a sweep can vary"),
        ("kp_roll=400..100", "give the smaller first"),
        ("kp_roll=4..4", "give the smaller first"),
        ("kp_roll=-1..100", "keep it within 0 .. 2500 1/s^2"),
        ("kp_roll=1..9999", "keep it within 0 .. 2500 1/s^2"),
        ("kp_roll=nan..100", "give it a number"),
        ("vary.mass=0.01..1", "0.1 .. 10"),
        ("vary.mass=nan..1", "0.1 .. 10"),
        ("kp_roll=100..400:1", "give 2 .. 10000"),
        ("kp_roll=100..400:10001", "give 2 .. 10000"),
        ("kp_roll=0..400:log", "begin above 0"),
    ]:
        with case(text, said):
            with pytest.raises(WorkbenchError) as caught:
                parse_range(text)
            assert said in str(caught.value)
            assert "\n" not in str(caught.value)


def test_a_grid_has_both_ends():
    assert parse_range("kp_roll=100..400:4").grid.tolist() == [100.0, 200.0, 300.0, 400.0]


def test_a_logarithmic_grid_has_equal_ratios_and_stays_within():
    span = parse_range("kp_roll=0.3..2500:7:log")
    np.testing.assert_allclose(span.grid, np.geomspace(0.3, 2500.0, 7), rtol=1e-14)
    assert span.grid.min() >= 0.3
    assert span.grid.max() <= 2500.0


def test_units_are_those_of_the_table():
    assert parse_range("kp_roll=1..2").unit == "1/s^2"
    assert parse_range("vary.mass=1..2").unit == "1"
