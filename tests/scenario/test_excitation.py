"""Excitations against closed forms by hand."""

import dataclasses
import itertools
import math

import numpy as np
import pytest

from workbench.common.errors import WorkbenchError
from workbench.scenario.excitation import ActiveExcitation, Excitation, Shape

STEP = Excitation("x", Shape.STEP, 1.5, 2.0)
DOUBLET = Excitation("y", Shape.DOUBLET, -1.0, 3.0)
SQUARE = Excitation("yaw", Shape.SQUARE, 0.4, 1.0)
CHIRP = Excitation("z", Shape.CHIRP, 0.5, 20.0)


def values(excitation: Excitation, *times: float) -> list[float]:
    return [excitation.command(t) for t in times]


def test_a_step_lasts_a_period_and_rests_for_one():
    assert values(STEP, -0.1, 0.0, 1.999, 2.0, 3.999, 4.0, 9.0) == [0, 1.5, 1.5, 0, 0, 0, 0]
    assert STEP.edges == (0.0, 2.0)
    assert STEP.round_time == 4.0


def test_a_doublet_goes_there_and_back_and_rests():
    assert values(DOUBLET, 0.0, 1.499, 1.5, 2.999, 3.0, 5.9, 6.0) == [-1, -1, 1, 1, 0, 0, 0]
    assert DOUBLET.edges == (0.0, 1.5, 3.0)
    assert DOUBLET.round_time == 6.0


def test_a_square_wave_goes_to_and_fro():
    assert values(SQUARE, 0.0, 0.499, 0.5, 0.999, 1.0) == [0.4, 0.4, -0.4, -0.4, 0]
    assert SQUARE.edges == (0.0, 0.5)
    assert SQUARE.round_time == 1.0


@pytest.mark.parametrize("once", [STEP, DOUBLET, SQUARE, CHIRP], ids=lambda each: each.shape.name)
def test_what_repeats_begins_again_for_ever(once):
    again = dataclasses.replace(once, repeats=True)
    times = np.linspace(0.0, once.round_time, 97, endpoint=False)
    for rounds in (1, 2, 1000):
        later = [again.command(t + rounds * once.round_time) for t in times]
        assert later == pytest.approx([once.command(t) for t in times], abs=1e-6)
    assert again.command(-1e-3) == 0.0


def test_edges_of_periods_that_are_not_exact_in_binary_are_met():
    tenths = Excitation("x", Shape.SQUARE, 1.0, 0.2, repeats=True)
    steps = [tenths.command(0.1 * k) for k in range(60)]
    assert steps == [1.0, -1.0] * 30


def test_a_chirp_is_a_sine_from_a_tenth_of_a_hertz_to_one_in_whole_waves():
    """20 s from 0.1 Hz to 1 Hz: 0.1 t + 0.0225 t² waves, eleven in all."""
    times = np.linspace(0.0, 19.999, 500)
    waves = 0.1 * times + 0.0225 * times**2
    expected = 0.5 * np.sin(2.0 * math.pi * waves)
    assert values(CHIRP, *times) == pytest.approx(expected, abs=1e-7)
    assert CHIRP.edges == ()
    assert values(CHIRP, 20.0, 20.5) == [0.0, 0.0]


@pytest.mark.parametrize("period", [0.1, 0.37, 1.0, 3.3, 7.0, 60.0])
def test_a_chirp_of_any_period_ends_as_it_began_and_rises_tenfold(period):
    chirp = Excitation("x", Shape.CHIRP, 1.0, period)
    end = np.linspace(period - 1e-4 * period, period - 1e-6, 50)
    tail = values(chirp, *end)
    assert tail[-1] == pytest.approx(0.0, abs=2e-3)
    slope = (tail[-1] - tail[0]) / (end[-1] - end[0])
    assert slope > 2.0 * math.pi * 0.999  # it crosses zero upwards, at 1 Hz or more
    assert values(chirp, 1e-5) == pytest.approx([2.0 * math.pi * 0.1e-5], rel=2e-2)


def test_what_cannot_be_flown_is_refused(case):
    for change, said in [
        ({"axis": "rol"}, "axis is 'rol': give one of x, y, z, yaw, roll"),
        ({"axis": 3}, "axis is 3"),
        (
            {"shape": "step"},
            "shape is 'step': give one of step, doublet, square wave, chirp, pulse",
        ),
        ({"amplitude": 0.0}, "amplitude is 0 m/s: give a value other than 0, within ±8 m/s"),
        ({"amplitude": -8.5}, r"amplitude is -8.5 m/s"),
        ({"amplitude": math.nan}, "amplitude is nan: give it a finite number of m/s"),
        ({"amplitude": "1"}, "amplitude is '1'"),
        ({"axis": "yaw", "amplitude": math.inf}, "amplitude is inf: .* rad/s"),
        ({"period": 0.05}, "period is 0.05 s: give it one from 0.1 to 60 s"),
        ({"period": 61.0}, "period is 61 s"),
        ({"period": math.nan}, "period is nan"),
        ({"period": None}, "period is None"),
    ]:
        with case(change, said), pytest.raises(WorkbenchError, match=said):
            dataclasses.replace(STEP, **change).check(8.0)


def test_what_can_be_flown_passes():
    for each in (STEP, DOUBLET, SQUARE, CHIRP):
        each.check(1.5)


def test_the_longest_level_is_the_longest_time_of_one_sign(case):
    """Of a chirp, whose frequency rises, half a wave at the beginning's is a bound."""
    for shape in Shape:
        for period in (0.5, 20.0):
            excitation = Excitation("x", shape, -0.4, period)
            step = excitation.round_time / 1000.0
            signs = [np.sign(excitation.command(k * step)) for k in range(1000)]
            longest = (
                max(len(list(run)) for sign, run in itertools.groupby(signs) if sign != 0.0) * step
            )
            with case(shape, period):
                if shape is Shape.CHIRP:
                    assert longest <= excitation.longest_level + 2.0 * step
                else:
                    assert excitation.longest_level == pytest.approx(longest, abs=2.0 * step)


def test_rounds_count_once_they_are_over():
    flown = ActiveExcitation(Excitation("x", Shape.STEP, 1.0, 1.0, repeats=True), 0.0, 0)
    counts = []
    for number, returning in ((0, False), (1, False), (1, True), (2, False), (2, True)):
        now = dataclasses.replace(flown, round=number, returning=returning)
        counts.append(now.rounds_flown)
    assert counts == [0, 0, 1, 1, 2]
