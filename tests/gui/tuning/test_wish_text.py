"""Oracle: the tables and the parser that the search itself uses."""

import pytest

from workbench.design.metrics import LOOP, ROTORS, STEP, WISHED
from workbench.design.tune.wish import GROUPS, SUBJECTS, parse_wish, subjects_of
from workbench.gui.tuning import wish_text
from workbench.gui.tuning.autotune_card import DEFAULT
from workbench.gui.tuning.wish_text import completions, what_is_wrong, wishes_in


def test_every_beginning_that_is_offered_makes_a_wish():
    values = {"phase_margin": "45 deg", "gain_margin": "6 dB", "peak_sensitivity": "2"}
    for each in completions():
        metric = each.split(".")[1].split()[0]
        assert parse_wish(each + values.get(metric, "0.5"))


def test_every_subject_of_the_search_is_known():
    for kind in (STEP, LOOP, ROTORS):
        groups = [name for name, members in GROUPS.items() if set(members) <= set(SUBJECTS[kind])]
        for metric in (each for each in WISHED if each.kind == kind):
            known = subjects_of(metric)
            there = [name for name, members in GROUPS.items() if set(members) <= set(known)]
            assert set(wish_text.subjects_of(kind, metric.name)) == {*known, *there}
        assert set(wish_text.SUBJECTS[kind]) == {*SUBJECTS[kind], *groups}


def test_every_metric_of_the_search_is_known():
    for kind in (STEP, LOOP, ROTORS):
        of_kind = {metric.name for metric in WISHED if metric.kind == kind}
        assert set(wish_text.METRICS[kind]) == of_kind


@pytest.mark.parametrize("wish", [*DEFAULT, "x.rise_time<=.4", "pitch.phase_margin ≥ 45deg"])
def test_a_good_wish_is_good(wish):
    assert what_is_wrong(wish) == ""


@pytest.mark.parametrize(
    ("wish", "said"),
    [
        ("faster", "Write SUBJECT.METRIC"),
        ("x.speed <= 3", "There is no metric speed"),
        ("pitch.peak_rotor_use <= 0.3", "pitch has no peak_rotor_use: that is of x, y, z, yaw"),
        ("x.rise_time <= soon", "Write SUBJECT.METRIC"),
    ],
)
def test_a_bad_wish_is_told_in_a_sentence(wish, said):
    assert what_is_wrong(wish).startswith(said)


def test_wishes_are_lines():
    assert wishes_in("a.b <= 1\n\n  c.d >= 2 \n") == ("a.b <= 1", "c.d >= 2")
