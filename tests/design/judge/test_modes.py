"""Modes, against python-control's damp."""

import control
import numpy as np
import pytest

from workbench.design.judge.modes import least_damping, modes


@pytest.mark.parametrize("period", [0.0, 0.01])
def test_modes_are_in_the_words_of_damp(closed, period):
    loop = control.tf([40.0], [1.0, 12.0, 20.0, 0.0])
    system = control.sample_system(control.ss(loop), period, "zoh") if period else loop
    model = closed(system)
    found = modes(model)
    frequency, damping, poles = control.damp(
        control.ss(model.A, model.b[:, None], model.c[None], 0, period), doprint=False
    )
    expected = sorted({(round(w, 9), round(z, 9)) for w, z in zip(frequency, damping, strict=True)})
    assert [(m.frequency, m.damping) for m in found] == pytest.approx(
        [pytest.approx(pair, rel=1e-6) for pair in expected]
    )
    slowest = found[0]
    pole = poles[np.argmin(frequency)]
    s = np.log(pole) / period if period else pole
    assert slowest.time_constant == pytest.approx(-1.0 / s.real, rel=1e-9)
    assert abs(slowest.imaginary) == pytest.approx(abs(s.imag), rel=1e-9)


def test_what_grows_has_negative_damping(closed):
    found = modes(closed(control.tf([7.0], [1.0, 3.0, 2.0, 0.0])))
    assert found[0].damping < 0.0
    assert found[0].time_constant < 0.0
    assert least_damping(found) == found[0].damping


def test_place_and_heading_are_no_modes(steering, holding):
    assert min(mode.frequency for mode in modes(steering)) > 1.0
    assert min(mode.frequency for mode in modes(holding)) == pytest.approx(1.43, rel=0.02)
    count = sum(2 if mode.imaginary else 1 for mode in modes(steering))
    assert count <= len(steering.A) - 4
