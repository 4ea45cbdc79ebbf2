"""Gains of a loop for a bandwidth and a phase margin, as a screen asks for them."""

import math
import re

import pytest

from workbench.analysis.queries import Judge, SampleReach, ShapeLoop
from workbench.analysis.subject import AnalysedVehicle
from workbench.design.judge.noise import noise_effects
from workbench.design.linear.operating_point import HOVER_POINT
from workbench.gui.tuning.limit_reach import held_range
from workbench.scenario.scenario import Scenario


def of(judged, name):
    """Return a judged loop."""
    return next(each for each in judged.loops if each.name == name)


def test_the_loop_that_is_judged_has_what_was_asked(answer):
    asked = ShapeLoop({}, "pitch", 40.0, math.radians(45.0), {"kp_pitch": "kp_roll"})
    shaped = answer(asked)
    assert shaped.reached
    assert set(shaped.gains) == {"kp_pitch", "kd_pitch", "kp_roll"}
    pitch = of(answer(Judge(shaped.gains)), "pitch")
    assert pitch.bandwidth == pytest.approx(40.0, rel=1e-3)
    assert math.degrees(pitch.phase_margin) == pytest.approx(45.0, abs=0.05)
    low, high = shaped.bandwidths
    assert low < 40.0 < high
    low, high = map(math.degrees, shaped.reach)
    assert low < 45.0 < high
    unlinked = answer(ShapeLoop({}, "pitch", 40.0, math.radians(45.0)))
    assert set(unlinked.gains) == {"kp_pitch", "kd_pitch"}  # the shaper is another one


def test_nothing_asked_is_what_is(answer):
    shaped, pitch = answer(ShapeLoop({}, "pitch")), of(answer(Judge({})), "pitch")
    assert shaped.reached
    assert shaped.bandwidth == pytest.approx(pitch.bandwidth)
    assert shaped.phase_margin == pytest.approx(pitch.phase_margin)


def test_what_takes_the_phase_is_named(answer):
    """By the phase budget; of the slower loops it is the loop inside them."""
    pitch = answer(ShapeLoop({}, "pitch", rests=True))
    turned = dict(of(answer(Judge({})), "pitch").turned)
    assert f"rotor lag {-math.degrees(turned['rotors']):.0f}°" in pitch.said
    assert "loop inside" not in pitch.said
    assert answer(ShapeLoop({}, "pitch")).said == ""  # while a slider moves, it is left out
    shaped = answer(ShapeLoop({}, "velocity_x", 10.0, rests=True))
    inside = int(re.search(r"the pitch loop inside (\d+)°", shaped.said)[1])
    outer = of(answer(Judge(shaped.gains)), "velocity_x")
    rest = sum(angle for part, angle in outer.turned if part != "law")
    # an integrator turns by 90 degrees, and 180 less all that turns is the margin
    assert 90.0 - inside + math.degrees(rest) == pytest.approx(
        math.degrees(outer.phase_margin), abs=0.6
    )
    wide = answer(ShapeLoop({}, "velocity_x", 60.0))
    assert not wide.reached
    assert "more kd_velocity_x than its largest value" in wide.said


def test_saturation_and_noise_are_named_where_they_are_near(answer):
    """The drone's thrust is 2.22 times its weight; kp times a step takes the rest of it.

    It does so after the rotors' lag, with a fall of the error in the meantime: as in the closed
    loop of lag and velocity, whose two poles are real.
    """
    calm = answer(ShapeLoop({}, "velocity_z", rests=True))
    assert "saturates" not in calm.said and "Noise" not in calm.said
    fast = answer(ShapeLoop({}, "velocity_z", 15.0, math.radians(50.0), rests=True))
    assert "along z" in fast.said and "saturates the rotors" in fast.said
    step = float(fast.said.split("along z of ")[1].split()[0])
    k, lag = fast.gains["kp_velocity_z"], 2.0 / (1.0 / 0.0125 + 1.0 / 0.025)  # up and down
    root = math.sqrt(1.0 - 4.0 * k * lag)
    quick, slow = (1.0 + root) / (2.0 * lag), (1.0 - root) / (2.0 * lag)
    peak = math.log(quick / slow) / (quick - slow)
    share = (math.exp(-slow * peak) - math.exp(-quick * peak)) / root
    assert step == pytest.approx(9.81 * 1.22 / (k * share), rel=0.05)


def test_noise_is_named_on_an_estimate_that_has_some(answer):
    subject = AnalysedVehicle(Scenario(estimator="ekf"), {})
    gains = {"kp_pitch": 1000.0, "kd_pitch": 70.0}
    said = answer(ShapeLoop(gains, "pitch", rests=True), subject).said
    noise = max(each.worst_command for each in noise_effects(subject.study, HOVER_POINT, gains))
    assert f"Noise moves the rotors' commands by {100.0 * noise:.2g} % rms." in said


def test_a_set_of_scheduled_gains_keeps_its_names(answer):
    subject = AnalysedVehicle(Scenario(controller="pd@speed=0,4"), {})
    asked = {f"{name}_at_4": subject.own[name] for name in ("kp_pitch", "kd_pitch")}
    linked = {"kp_pitch_at_4": "kp_roll_at_4"}
    shaped = answer(ShapeLoop(asked, "pitch", 40.0, linked=linked), subject)
    assert set(shaped.gains) >= {"kp_pitch_at_4", "kd_pitch_at_4"}


def test_over_its_reach_the_margins_of_all_loops_are_those_that_are_judged(answer):
    """For some bandwidths and margins, by the gains that a request for them gives."""
    margins = math.radians(40.0), math.radians(60.0)
    sampled = answer(SampleReach({}, "velocity_x", (3.0, 8.0), margins))
    assert [value for value, _ in sampled.bandwidths[::16]] == pytest.approx([3.0, 8.0])
    own = of(answer(Judge({})), "velocity_x")
    for samples, asked in (
        (sampled.bandwidths[4], lambda value: (value, own.phase_margin)),
        (sampled.margins[9], lambda value: (own.bandwidth, value)),
    ):
        value, loops = samples
        shaped = answer(ShapeLoop({}, "velocity_x", *asked(value)))
        judged = answer(Judge(shaped.gains))
        for loop, found in zip(judged.loops, loops, strict=True):
            assert found.phase_margin == pytest.approx(loop.phase_margin, rel=1e-6, nan_ok=True)
            assert found.disk_margin == pytest.approx(loop.disk_margin, rel=1e-6)
    nothing = answer(SampleReach({}, "velocity_x", (math.nan, math.nan), (1.0, 1.0)))
    assert nothing.bandwidths == nothing.margins == ()


def test_the_range_within_limits_is_the_connected_one_nearest_to_the_present():
    samples = [(float(value), value) for value in range(10)]
    good = {0, 1, 4, 5, 6, 9}
    spans = {0.5: (0.0, 1.0), 2.0: (0.0, 1.0), 3.5: (4.0, 6.0), 8.9: (9.0, 9.0)}
    for present, span in spans.items():
        assert held_range(samples, present, lambda value: value in good) == span
    # it is within a wide one, beside whose end another one is nearer than its middle
    assert held_range(samples, 7.0, lambda value: value != 8) == (0.0, 7.0)
    assert held_range(samples, 1.0, lambda value: False) is None
    assert held_range((), 1.0, lambda value: True) is None
