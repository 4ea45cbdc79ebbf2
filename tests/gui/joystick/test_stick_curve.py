"""The curve of a stick against numbers worked by hand."""

import pytest

from workbench.gui.joystick.piloting import Handling, shaped_deflection


def test_a_stick_asks_for_what_was_worked_by_hand(case):
    for curve, raw, shaped in [
        (Handling(), 0.3, 0.3),
        (Handling(), -0.7, -0.7),
        (Handling(expo=1.0), 0.5, 0.125),  # 0.5 cubed
        (Handling(expo=0.5), 0.5, 0.3125),  # half of 0.5 and half of 0.125
        (Handling(dead_band=0.2), 0.2, 0.0),
        (Handling(dead_band=0.2), 0.6, 0.5),  # half of the way that is left
        (Handling(expo=0.5, dead_band=0.2), -0.6, -0.3125),
        (Handling(sensitivity=0.4, expo=0.5, dead_band=0.2), 0.6, 0.125),
    ]:
        with case(curve, raw, shaped):
            assert curve.shaped(raw) == pytest.approx(shaped, abs=1e-12)


def test_full_stick_stays_full(case):
    for dead_band in [0.0, 0.05, 0.5]:
        for expo in [0.0, 0.3, 1.0]:
            with case(dead_band, expo):
                for raw, full in ((1.0, 1.0), (-1.0, -1.0), (7.0, 1.0)):
                    assert shaped_deflection(raw, expo, dead_band) == full


def test_nothing_jumps_at_the_edge_of_the_dead_band():
    assert shaped_deflection(0.1001, 0.3, 0.1) == pytest.approx(0.0, abs=1e-3)


def test_more_stick_never_asks_for_less():
    curve = Handling(sensitivity=0.8, expo=0.7, dead_band=0.1)
    shaped = [curve.shaped(step / 200) for step in range(-200, 201)]
    assert shaped == sorted(shaped)
