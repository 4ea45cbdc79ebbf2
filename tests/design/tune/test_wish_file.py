"""Files of wishes."""

import pytest

from workbench.common.errors import WorkbenchError
from workbench.design.tune.wish_file import Wishes, load_wishes

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
