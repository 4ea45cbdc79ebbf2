"""Gains of one law as those of another: the core's laws, and forms of all that are installed."""

from functools import cache

import pytest

from workbench.common.errors import WorkbenchError
from workbench.control.controller_file import load_controller
from workbench.control.installed_laws import installed_laws
from workbench.design.linear.study import LinearStudy
from workbench.design.translate.forms import form_of
from workbench.design.translate.loop_difference import gains_alone, loop_differences
from workbench.design.translate.translation import translate
from workbench.scenario.scenario import Scenario


@cache
def study(law: str) -> LinearStudy:
    return LinearStudy(Scenario(controller=law))


def test_gains_come_back_and_loops_are_the_same_where_nothing_is_lost():
    one, other = study("pd"), study("pid")
    values = dict(one.gains) | dict.fromkeys((f"kd_velocity_{axis}" for axis in "xyz"), 0.0)
    there = translate(one, other, values, dict(other.gains))
    loops = [
        each
        for each in gains_alone(one, other, values, there.values)
        if there.exact and not there.lost_in(each.channel)
    ]
    assert loops and max(each.largest for each in loops) < 0.01
    back = translate(other, one, there.values, dict(one.gains))
    lost = {each.axis for each in there.lost} | {each.axis for each in back.lost}
    kept = [row.name for row in form_of(one.controller).rows if row.axis not in lost]
    assert kept
    for name in kept:
        assert back.values[name] == pytest.approx(values[name], rel=6e-3), name


def test_a_gain_beyond_its_limit_is_at_it_and_its_axes_lose_something():
    """PID's tilt gain is kp over kd of PD, by the cascade of both."""
    values = dict(study("pd").gains) | dict.fromkeys(("kp_roll", "kp_pitch"), 2500.0)
    there = translate(study("pd"), study("pid"), values, dict(study("pid").gains))
    (tilt,) = (each for each in there.gains if each.name == "kp_tilt")
    wanted = 2500.0 / values["kd_pitch"]
    most = study("pid").controller.table.find("kp_tilt").maximum
    assert tilt.value == there.values["kp_tilt"] == most < wanted
    assert f"{wanted:.4g} is wanted, and {most:g} is the largest allowed" in tilt.said
    for channel in ("roll", "pitch"):
        assert "kp_tilt is at its limit" in there.lost_in(channel)


def test_axes_that_share_a_gain_get_the_mean_of_both():
    values = {**study("pd").gains, "kp_roll": 200.0, "kp_pitch": 300.0}
    there = translate(study("pd"), study("pid"), values, dict(study("pid").gains))
    mean = 0.5 * (200.0 / values["kd_roll"] + 300.0 / values["kd_pitch"])
    assert there.values["kp_tilt"] == pytest.approx(mean, rel=1e-6)
    for channel in ("roll", "pitch"):
        assert "shares kp_tilt with another axis" in there.lost_in(channel)


def test_what_cannot_be_is_said(case):
    for old, new in (("pd", "lqi"), ("lqi", "pid")):
        with case(old, new), pytest.raises(WorkbenchError, match="lqi has weights"):
            translate(study(old), study(new), dict(study(old).gains), dict(study(new).gains))


def test_every_shipped_law_has_a_form_or_says_why_not(case):
    for law in installed_laws():
        with case(law):
            if law == "lqi":
                continue
            rows = form_of(load_controller(law)).rows
            own = {row.name for row in load_controller(law).parameters}
            assert {row.name for row in rows} <= own


def test_two_laws_differ_by_what_the_second_has_less_than_the_first():
    """Half the gains of roll halve its open loop: |L2 / L1 - 1| = 1/2; others stay as they are."""
    one = study("pd")
    values = dict(one.gains)
    halved = values | {name: 0.5 * values[name] for name in ("kp_roll", "kd_roll")}
    found = {each.channel: each for each in loop_differences(one, one, values, halved)}
    assert found["roll"].largest == pytest.approx(0.5, rel=1e-4)
    assert found["roll"].other < 0.7 * found["roll"].crossover
    for channel in ("z", "pitch", "yaw"):
        assert found[channel].largest < 1e-3
        assert found[channel].other == pytest.approx(found[channel].crossover, rel=1e-3)
