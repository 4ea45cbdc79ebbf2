"""Gains of a loop for a bandwidth and a phase margin, as a screen asks for them."""

import math

import pytest

from workbench.analysis.questions import Judge, ShapeLoop
from workbench.analysis.subject import Subject
from workbench.scenario.scenario import Scenario


def of(judged, name):
    """Return a judged loop."""
    return next(each for each in judged.loops if each.name == name)


def test_the_loop_that_is_judged_has_what_was_asked(answer):
    asked = ShapeLoop({}, "pitch", 40.0, math.radians(45.0), {"kp_pitch": "kp_roll"})
    shaped = answer(asked)
    assert shaped.reached and shaped.asked == asked
    assert set(shaped.gains) == {"kp_pitch", "kd_pitch", "kp_roll"}
    pitch = of(answer(Judge(shaped.gains)), "pitch")
    assert pitch.bandwidth == pytest.approx(40.0, rel=1e-3)
    assert math.degrees(pitch.phase_margin) == pytest.approx(45.0, abs=0.05)
    low, high = shaped.bandwidths
    assert low < 40.0 < high
    low, high = map(math.degrees, shaped.phase_margins)
    assert low < 45.0 < high


def test_nothing_asked_is_what_is(answer):
    shaped, pitch = answer(ShapeLoop({}, "pitch")), of(answer(Judge({})), "pitch")
    assert shaped.reached
    assert shaped.bandwidth == pytest.approx(pitch.bandwidth)
    assert shaped.phase_margin == pytest.approx(pitch.phase_margin)


def test_what_takes_the_phase_is_named(answer):
    """By the phase budget; of the slower loops it is the loop inside them."""
    pitch = answer(ShapeLoop({}, "pitch"))
    turned = dict(of(answer(Judge({})), "pitch").turned)
    assert f"rotor lag {-math.degrees(turned['rotors']):.0f}°" in pitch.said
    assert "the pitch loop inside" in answer(ShapeLoop({}, "velocity_x", 10.0)).said
    wide = answer(ShapeLoop({}, "velocity_x", 60.0))
    assert not wide.reached
    assert "more kd_velocity_x than its largest value" in wide.said


def test_a_set_of_scheduled_gains_keeps_its_names(answer):
    subject = Subject(Scenario(controller="pd@speed=0,4"), {})
    asked = {f"{name}_at_4": subject.own[name] for name in ("kp_pitch", "kd_pitch")}
    linked = {"kp_pitch_at_4": "kp_roll_at_4"}
    shaped = answer(ShapeLoop(asked, "pitch", 40.0, linked=linked), subject)
    assert set(shaped.gains) >= {"kp_pitch_at_4", "kd_pitch_at_4"}
