"""Oracle: the parser that the search itself uses."""

import pytest

from workbench.control.controller import load_controller
from workbench.design.tune.wish import parse_wish
from workbench.gui.tuning.autotune_card import DEFAULT
from workbench.gui.tuning.wish_text import completions, what_is_wrong, with_point

PD = load_controller()


@pytest.mark.parametrize("law", [load_controller(name) for name in ("pd", "pid", "geometric")])
def test_every_beginning_that_is_offered_makes_a_wish(law):
    values = {"phase_margin": "45 deg", "gain_margin": "6 dB", "peak_sensitivity": "2"}
    offered = completions(law)
    for each in offered:
        metric = each.split(".")[1].split()[0]
        assert parse_wish(each + values.get(metric, "0.5"), law=law)
    beginnings = {each.split(" ")[0] for each in offered}
    assert beginnings > {"level.overshoot", "tilt.phase_margin", "rotors.noise_amplification"}
    assert beginnings > {f"{loop.name}.disk_margin" for loop in law.loops}


@pytest.mark.parametrize("wish", [*DEFAULT, "x.rise_time<=,4", "pitch.phase_margin ≥ 45deg"])
def test_a_good_wish_is_good(wish):
    assert what_is_wrong(wish, PD) == ""


@pytest.mark.parametrize(
    ("wish", "said"),
    [
        ("faster", "'faster' is no wish: write SUBJECT.METRIC"),
        ("x.speed <= 3", "unknown metric 'speed'"),
        ("pitch.peak_rotor_use <= 0.3", "pitch has no peak_rotor_use: that is of x, y, z, yaw"),
        ("x.rise_time <= soon", "'x.rise_time <= soon' is no wish"),
        ("x.rise_time <= 1,000.5", "'1,000.5' has more than one point or comma"),
        ("yaw_rate.overshoot <= 5", "yaw_rate has no overshoot"),
    ],
)
def test_a_bad_wish_is_told_in_a_sentence(wish, said):
    assert what_is_wrong(wish, PD).startswith(said)


def test_a_comma_before_decimals_is_a_point_for_the_search():
    assert with_point(" x.rise_time <= 0,45 s ") == "x.rise_time <= 0.45 s"
