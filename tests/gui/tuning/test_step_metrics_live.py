"""Oracle: python-control's step_info."""

import control
import numpy as np
import pytest

from workbench.gui.tuning.number_table import State
from workbench.gui.tuning.response_card import (
    StepPart,
    Trace,
    measure_step,
    metric_rows,
    step_parts,
)
from workbench.scenario.excitation import Excitation, Shape

TIME = np.arange(0.0, 4.0, 1.0 / 128.0)


def trace_of(response):
    return Trace(
        TIME[: len(response)], response, np.zeros(len(response)), np.full(len(response), 0.7)
    )


def swinging(duration: float) -> np.ndarray:
    system = control.tf([36.0], [1.0, 4.0, 36.0])
    return control.step_response(system, TIME[duration >= TIME]).outputs


@pytest.mark.parametrize(("before", "level"), [(0.0, 2.0), (-2.0, 2.0), (0.0, -0.3)])
def test_numbers_of_a_flown_step_are_those_of_python_control(before, level):
    part = StepPart(0.5, 3.0, before, level)
    rise = (level - before) * swinging(2.5)
    flown = np.full(len(TIME), before)
    flown[TIME >= 0.5] = level
    flown[64 : 64 + len(rise)] = before + rise
    numbers = measure_step(trace_of(flown), part)
    info = control.step_info(rise, T=TIME[: len(rise)])
    assert numbers.rise_time == pytest.approx(info["RiseTime"])
    assert numbers.settling_time == pytest.approx(info["SettlingTime"])
    assert numbers.overshoot == pytest.approx(info["Overshoot"])
    off = abs(rise[-1] - (level - before)) / abs(level - before) * 100.0
    assert numbers.steady_state_error == pytest.approx(off)
    assert numbers.peak_rotor_use == 0.7


def test_numbers_that_mean_nothing_are_withheld_with_the_reason():
    """Too short to settle, begun while it still moved, and with gains that changed."""
    moving = np.full(len(TIME), -1.6)
    moving[TIME >= 0.5] = -1.6 + 3.6 * swinging(3.5)[: int((TIME >= 0.5).sum())]
    cases = [
        (trace_of(swinging(0.6)), StepPart(0.0, 0.59, 0.0, 1.0), False, "not settled within 0.586"),
        (trace_of(moving), StepPart(0.5, 3.5, -2.0, 2.0), False, "did not begin at rest"),
        (trace_of(swinging(3.5)), StepPart(0.0, 3.0, 0.0, 1.0), True, "parameters changed"),
    ]
    for trace, part, changed, why in cases:
        numbers = measure_step(trace, part, changed=changed)
        assert why in numbers.withheld
        assert np.isnan([numbers.rise_time, numbers.settling_time, numbers.overshoot]).all(), why
        assert numbers.peak_rotor_use == 0.7
        rows = metric_rows(numbers, None, lambda name: 1.0)
        assert rows[0].cells[0].text == "–"
        assert rows[0].cells[0].help == numbers.withheld
        assert rows[0].state is State.NONE
    assert measure_step(trace_of(swinging(3.5)), StepPart(0.0, 3.0, 0.0, 1.0)).withheld == ""


def test_a_step_that_is_not_over_has_no_numbers():
    part = StepPart(0.0, 3.0, 0.0, 1.0)
    assert measure_step(trace_of(swinging(2.9)), part) is None
    assert measure_step(trace_of(swinging(3.0)), part) is not None


def test_what_comes_after_a_step_does_not_count():
    part = StepPart(0.0, 3.0, 0.0, 1.0)
    flown = np.concatenate([swinging(3.0), np.zeros(100)])
    assert measure_step(trace_of(flown), part) == measure_step(trace_of(swinging(3.0)), part)


def test_the_first_half_of_a_square_wave_goes_all_the_way_once_it_repeats():
    wave = Excitation("x", Shape.SQUARE, 1.5, 2.0, repeats=True)
    assert step_parts(wave)[0] == StepPart(0.0, 1.0, 0.0, 1.5)
    assert step_parts(wave, again=True)[0] == StepPart(0.0, 1.0, -1.5, 1.5)
    assert step_parts(wave)[1] == StepPart(1.0, 2.0, 1.5, -1.5)


def test_a_chirp_has_no_steps():
    assert step_parts(Excitation("x", Shape.CHIRP, 1.0, 5.0)) == ()


@pytest.mark.parametrize("shape", [Shape.STEP, Shape.DOUBLET, Shape.SQUARE])
def test_steps_begin_where_the_command_jumps(shape):
    excitation = Excitation("x", shape, 1.0, 2.0)
    for part in step_parts(excitation):
        assert part.begin in excitation.edges
        assert excitation.command(part.begin + 0.01) == part.level
        assert excitation.command(part.end - 0.01) == part.level


def test_a_step_that_lacks_a_sample_is_not_measured_yet():
    part = StepPart(0.0, 2.0, 0.0, 1.0)
    whole = trace_of(swinging(2.0))
    assert whole.time[-1] == 2.0
    assert measure_step(whole.between(0, len(whole) - 1), part) is None
    assert measure_step(whole, part) is not None
