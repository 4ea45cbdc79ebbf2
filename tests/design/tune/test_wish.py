"""Wishes as texts, and files of them."""

import math

import pytest

from workbench.common.errors import WorkbenchError
from workbench.design.tune.wish import Wishes, load_wishes, merged_wishes, parse_wish


def test_a_text_becomes_a_bound(case):
    for text, name, at_least, bound in [
        ("x.rise_time<=0.4", "x.rise_time", False, 0.4),
        (" x.rise_time <= 4e-1 s ", "x.rise_time", False, 0.4),
        ("z.settling_time<800ms", "z.settling_time", False, 0.8),
        ("x.rise_time>=0.2", "x.rise_time", True, 0.2),
        ("pitch.phase_margin>=45deg", "pitch.phase_margin", True, math.pi / 4),
        ("pitch.phase_margin>45deg", "pitch.phase_margin", True, math.pi / 4),
        ("x.rise_time ≤ 0.4", "x.rise_time", False, 0.4),
        ("pitch.phase_margin ≥ 45°", "pitch.phase_margin", True, math.pi / 4),
        ("position_x.disk_margin>=.8", "position_x.disk_margin", True, 0.8),
        ("rotors.noise_amplification<=2 N·s/rad", "rotors.noise_amplification", False, 2.0),
        ("yaw.overshoot<=5%", "yaw.overshoot", False, 5.0),
    ]:
        with case(text, name, at_least, bound):
            (wish,) = parse_wish(text)
            assert (wish.name, wish.at_least) == (name, at_least)
            assert wish.bound == pytest.approx(bound)


def test_a_group_stands_for_its_members():
    assert [wish.name for wish in parse_wish("level.overshoot<=5")] == [
        "x.overshoot",
        "y.overshoot",
    ]
    assert [wish.subject for wish in parse_wish("tilt.disk_margin>=0.6")] == ["roll", "pitch"]


def test_a_wish_reads_as_it_is_written():
    (wish,) = parse_wish("pitch.phase_margin>=45deg")
    assert str(wish) == "pitch.phase_margin >= 45 deg"
    assert parse_wish(str(wish))[0].bound == pytest.approx(wish.bound)


def test_what_is_no_wish_is_refused(case):
    for text, said in [
        ("x.rise_tim<=0.4", "unknown metric 'rise_tim': did you mean 'rise_time'"),
        ("w.rise_time<=0.4", "unknown axis 'w': known are level, pitch, roll, tilt, x, y, yaw, z"),
        ("pich.phase_margin>=45deg", "unknown loop 'pich': did you mean 'pitch'"),
        ("x.phase_margin>=45deg", "x has no phase_margin: that is of velocity_x"),
        ("pitch.peak_rotor_use<=1", "pitch has no peak_rotor_use: that is of x, y, z, yaw, level"),
        ("tilt.steady_state_error<=1", "tilt has no steady_state_error"),
        ("pitch_rate.phase_margin>=45deg", "no loop pitch_rate: it damps the rate in the loop"),
        ("x.noise_amplification<=1", "x has no noise_amplification: that is of rotors"),
        ("x.rise_time", "is not a wish: write SUBJECT.METRIC<=VALUE"),
        ("x.rise_time=0.4", "is not a wish"),
        ("rise_time<=0.4", "is not a wish"),
        ("x.rise_time<=nan", "is not a wish"),
        ("x.rise_time<=1.2.3", "1.2.3 is not a number"),
        ("", "is not a wish"),
    ]:
        with case(text, said), pytest.raises(WorkbenchError, match=said):
            parse_wish(text)


def test_the_later_of_two_counts():
    wishes = merged_wishes([*parse_wish("level.rise_time<=0.4"), *parse_wish("x.rise_time<=0.3")])
    assert {wish.name: wish.bound for wish in wishes} == {"x.rise_time": 0.3, "y.rise_time": 0.4}


def test_two_sides_may_be_bounded():
    wishes = merged_wishes([*parse_wish("x.rise_time<=0.4"), *parse_wish("x.rise_time>=0.3")])
    assert len(wishes) == 2


def test_a_contradiction_is_refused():
    wishes = [*parse_wish("x.rise_time<=0.3"), *parse_wish("x.rise_time>=0.4")]
    with pytest.raises(WorkbenchError, match="x.rise_time >= 0.4 s contradicts x.rise_time <= 0.3"):
        merged_wishes(wishes)


TEXT = """\
wishes:
  - x.rise_time <= 0.4 s
  - tilt.phase_margin >= 45 deg
steps: {x: 2}
robustness:
  mass: 0.1
  margin_share: 1
defaults: false
"""


@pytest.fixture
def load(tmp_path):
    def load_text(text):
        path = tmp_path / "wishes.yaml"
        path.write_text(text, encoding="utf-8")
        return load_wishes(path)

    return load_text


def test_all_of_it_is_read(load):
    wishes = load(TEXT)
    assert [str(wish) for wish in wishes.wishes] == [
        "x.rise_time <= 0.4 s",
        "roll.phase_margin >= 45 deg",
        "pitch.phase_margin >= 45 deg",
    ]
    assert dict(wishes.steps) == {"x": 2.0, "y": 1.0, "z": 1.0, "yaw": 0.2}
    assert (wishes.robustness.mass, wishes.robustness.inertia) == (0.1, 0.3)
    assert wishes.robustness.margin_share == 1.0
    assert not wishes.defaults
    assert wishes.wishes[0].origin.endswith("wishes.yaml:2")


def test_nothing_in_a_file_is_nothing_wished(load):
    assert load("defaults: true\n") == Wishes()


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("wishes:\n  - x.rise_time <= 1\n  - x.rise <= 1\n", "yaml:3: unknown metric 'rise'"),
        ("wishes:\n  - 4\n", "yaml:2: wishes.0 is 4, and should be text"),
        ("wish: []\n", "yaml:1: unknown key 'wish': did you mean 'wishes'"),
        ("\nsteps: {w: 1}\n", "yaml:2: unknown axis 'w'"),
        ("steps: {x: 0}\n", "yaml:1: the step along x is 0"),
        ("steps: {x: .inf}\n", "yaml:1: the step along x is inf"),
        ("robustness: {mass: 1.5}\n", "yaml:1: mass is 1.5: keep it within 0 .. 0.9"),
        ("robustness: {overshoot_factor: 0.5}\n", "keep it within 1 .. 100"),
        (
            "wishes:\n  - x.rise_time <= 0.1\n  - x.rise_time >= 0.2\n",
            "yaml:1: x.rise_time >= 0.2 s contradicts",
        ),
    ],
)
def test_what_is_wrong_is_said_with_its_line(load, text, said):
    with pytest.raises(WorkbenchError, match=said):
        load(text)
