"""What wishes ask of a vehicle and of its corners."""

import math

import numpy as np
import pytest

from workbench.design.tune.case import NOMINAL, Case, Robustness, corners
from workbench.design.tune.requirement import HOPELESS, requirements
from workbench.design.tune.wish import parse_wish

CORNER = Case(0.8, 0.7, 1.5)


def required(text, case=NOMINAL):
    (found,) = requirements(parse_wish(text), [case], Robustness())
    return found


def test_a_reserve_is_a_share_of_the_bound(case):
    for text, value, reserve in [
        ("x.rise_time<=0.4", 0.3, 0.25),
        ("x.rise_time<=0.4", 0.4, 0.0),
        ("x.rise_time<=0.4", 0.6, -0.5),
        ("x.rise_time<=0.4", 0.8, -1.0),
        ("x.rise_time<=0.4", 0.4 + 0.4 * math.e, -2.0),
        ("x.rise_time>=0.4", 0.3, -0.25),
        ("x.overshoot<=0", 0.5, -0.5),
        ("pitch.disk_margin>=0.6", 0.9, 0.5),
        ("pitch.disk_margin>=0.6", math.inf, -HOPELESS),
        ("x.rise_time<=0.4", math.inf, HOPELESS),
        ("x.rise_time<=0.4", math.nan, HOPELESS),
    ]:
        with case(text, value, reserve):
            found = required(text)
            assert found.reserves(np.array([value]))[0] == pytest.approx(reserve)
            assert found.met(value) == (reserve >= 0.0)


def test_a_corner_is_asked_for_less():
    assert required("pitch.phase_margin>=50deg", CORNER).bound == pytest.approx(math.radians(30))
    assert required("pitch.gain_margin>=4", CORNER).bound == pytest.approx(4**0.6)
    assert required("x.overshoot<=5", CORNER).bound == 10.0
    assert required("x.overshoot<=0", CORNER).bound == 2.0


@pytest.mark.parametrize(
    "text",
    ["x.rise_time<=1", "x.peak_rotor_use<=0.9", "rotors.noise_amplification<=1", "x.overshoot>=1"],
)
def test_what_a_corner_is_not_asked_for(text):
    assert requirements(parse_wish(text), [CORNER], Robustness()) == ()


def test_it_says_where_it_is_asked():
    assert str(required("x.overshoot<=5")) == "x.overshoot <= 5 %"
    assert str(required("x.overshoot<=5", CORNER)) == (
        "x.overshoot <= 10 % with mass x 0.8, inertia x 0.7, rotor lag x 1.5"
    )


def test_corners_are_all_ends_of_what_is_unsure():
    found = corners(Robustness())
    assert len(set(found)) == 8
    assert CORNER in found
    assert {case.mass for case in found} == {0.8, 1.2}
    assert corners(Robustness(inertia=0.0, rotor_lag=0.0)) == [Case(0.8), Case(1.2)]
    assert corners(Robustness(mass=0.0, inertia=0.0, rotor_lag=0.0)) == []
    assert CORNER.variation.rotor_lag == 1.5
