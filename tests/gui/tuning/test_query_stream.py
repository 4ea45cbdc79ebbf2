import pytest

from workbench.analysis.queries import FindRanges, Judge
from workbench.gui.analysis import QueryStream


@pytest.fixture
def stream(offline):
    analysis = offline.analysis
    made = QueryStream(analysis)
    made.set_seen(True)
    made.heard = []
    made.answered.connect(lambda question, _: made.heard.append(question))
    return made


def test_one_question_is_in_flight_and_the_newest_is_next(stream, offline, judge):
    for value in range(10):
        stream.ask(Judge({"kp_pitch": float(value)}))
    assert offline.analysis.asked == [Judge({"kp_pitch": 0.0})]
    offline.analysis.tell(*judge({"kp_pitch": 0.0}))
    assert offline.analysis.asked[1:] == [Judge({"kp_pitch": 9.0})]
    assert [dict(each.gains) for each in stream.heard] == [{"kp_pitch": 0.0}]


def test_nothing_is_asked_while_nobody_looks(stream, offline):
    stream.set_seen(False)
    stream.ask(Judge({"kp_pitch": 1.0}))
    assert offline.analysis.asked == []
    stream.set_seen(True)
    assert offline.analysis.asked == [Judge({"kp_pitch": 1.0})]


def test_what_is_known_is_not_asked_again(stream, offline, judge):
    stream.ask(Judge({"kp_pitch": 1.0}))
    offline.analysis.tell(*judge({"kp_pitch": 1.0}))
    stream.ask(Judge({"kp_pitch": 1.0}))
    assert len(offline.analysis.asked) == 1


def test_an_equal_question_of_somebody_else_is_answered_for_both_and_another_one_is_not(
    stream, offline, judge
):
    other = QueryStream(offline.analysis, seen=True)
    stream.ask(Judge({"kp_pitch": 1.0}))
    other.ask(Judge({"kp_pitch": 7.0}))
    first, second = offline.analysis.asked
    assert first.stream != second.stream  # none replaces the other
    offline.analysis.tell(*judge({"kp_pitch": 7.0}))
    assert stream.heard == [] and stream.is_waiting and not other.is_waiting
    other.ask(Judge({"kp_pitch": 1.0}))
    offline.analysis.tell(*judge({"kp_pitch": 1.0}))
    assert stream.heard == [Judge({"kp_pitch": 1.0})]
    assert not other.is_waiting


def test_it_waits_until_the_newest_is_answered(stream, offline, judge):
    waiting = []
    stream.answered.connect(lambda *_: waiting.append(stream.is_waiting))
    for value in (1.0, 2.0):
        stream.ask(Judge({"kp_pitch": value}))
    for value in (1.0, 2.0):
        offline.analysis.tell(*judge({"kp_pitch": value}))
    assert waiting == [True, False]
    stream.ask(Judge({"kp_pitch": 1.0}))  # known
    assert waiting == [True, False, False]
    assert len(stream.heard) == 3


def test_a_refusal_is_told_and_the_next_question_goes_out(stream, offline):
    told = []
    stream.refused.connect(told.append)
    question = Judge({"kp_pitch": 1.0})
    stream.ask(question)
    stream.ask(Judge({"kp_pitch": 2.0}))
    offline.analysis.refused.emit(FindRanges({}), "not mine")
    assert told == []
    offline.analysis.refused.emit(question, "no such vehicle")
    assert told == ["no such vehicle"]
    assert offline.analysis.asked[-1] == Judge({"kp_pitch": 2.0})
