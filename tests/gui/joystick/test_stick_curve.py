"""The curve of a stick against numbers worked by hand."""

import pytest

from workbench.gui.joystick.piloting import StickCurve


def test_a_stick_asks_for_what_was_worked_by_hand(case):
    for curve, raw, shaped in [
        (StickCurve(), 0.3, 0.3),
        (StickCurve(), -0.7, -0.7),
        (StickCurve(expo=1.0), 0.5, 0.125),  # 0.5 cubed
        (StickCurve(expo=0.5), 0.5, 0.3125),  # half of 0.5 and half of 0.125
        (StickCurve(dead_band=0.2), 0.2, 0.0),
        (StickCurve(dead_band=0.2), 0.6, 0.5),  # half of the way that is left
        (StickCurve(expo=0.5, dead_band=0.2), -0.6, -0.3125),
        (StickCurve(sensitivity=0.4, expo=0.5, dead_band=0.2), 0.6, 0.125),
    ]:
        with case(curve, raw, shaped):
            assert curve.shaped(raw) == pytest.approx(shaped, abs=1e-12)


def test_full_stick_stays_full(case):
    for dead_band in [0.0, 0.05, 0.5]:
        for expo in [0.0, 0.3, 1.0]:
            with case(dead_band, expo):
                curve = StickCurve(1.0, expo, dead_band)
                assert curve.shaped(1.0) == 1.0
                assert curve.shaped(-1.0) == -1.0
                assert curve.shaped(7.0) == 1.0


def test_nothing_jumps_at_the_edge_of_the_dead_band():
    assert StickCurve(1.0, 0.3, 0.1).shaped(0.1001) == pytest.approx(0.0, abs=1e-3)


def test_more_stick_never_asks_for_less():
    curve = StickCurve(0.8, 0.7, 0.1)
    shaped = [curve.shaped(step / 200) for step in range(-200, 201)]
    assert shaped == sorted(shaped)
