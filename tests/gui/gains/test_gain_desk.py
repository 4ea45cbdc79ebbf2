"""Tuning as a transaction, with a flight and an analyst that answer when the test says so."""

import pytest

from workbench.analyst.questions import FindRanges, Judge
from workbench.analyst.replies import Judged
from workbench.errors import WorkbenchError
from workbench.gain_files import load_gains
from workbench.gui.gains.gain_desk import GainDesk
from workbench.gui.gains.gain_state import Mark

NAME = "kp_velocity_x"


def test_a_move_within_the_known_range_is_ordered_at_once(bench):
    bench.know(kp_velocity_x=(1.0, 8.0))
    bench.desk.propose(NAME, 7.9)
    assert bench.flight.given == [(NAME, 7.9)]
    assert not [each for each in bench.analysis.asked if isinstance(each, Judge)]
    assert bench.desk.flown[NAME] == 7.9


def test_a_move_beyond_the_known_range_is_judged_before_it_flies(bench):
    bench.know(kp_velocity_x=(1.0, 8.0))
    bench.desk.propose(NAME, 8.1)
    assert bench.flight.given == []
    assert bench.analysis.asked[-1].gains[NAME] == 8.1
    bench.analysis.judge(stable=True)
    assert bench.flight.given == [(NAME, 8.1)]


def test_without_any_knowledge_a_move_is_judged(bench):
    bench.desk.propose(NAME, 3.1)
    assert bench.flight.given == []
    bench.analysis.judge(stable=True)
    assert bench.flight.given == [(NAME, 3.1)]


def test_two_gains_halfway_each_are_known_and_further_are_judged(bench):
    bench.know(kp_velocity_x=(1.0, 5.0), kp_roll=(50.0, 250.0))
    bench.desk.propose(NAME, 4.0)
    bench.desk.propose("kp_roll", 200.0)
    assert bench.flight.given == [(NAME, 4.0), ("kp_roll", 200.0)]
    bench.desk.propose("kp_roll", 201.0)
    assert len(bench.flight.given) == 2
    assert isinstance(bench.analysis.asked[-1], Judge)


def test_what_is_unstable_is_named_and_not_flown_until_confirmed(bench, qtbot):
    with qtbot.waitSignal(bench.desk.doubt_raised) as doubt:
        bench.desk.propose("kp_roll", 900.0)
        bench.analysis.judge(stable=False, said="a swing grows through roll")
    assert doubt.args == ["a swing grows through roll"]
    assert bench.flight.given == []
    bench.desk.confirm()
    assert bench.flight.given == [("kp_roll", 900.0)]
    assert bench.desk.doubt == ""


def test_back_proposes_what_flies_again(bench):
    bench.desk.propose("kp_roll", 900.0)
    bench.analysis.judge(stable=False)
    bench.desk.back()
    assert bench.desk.proposed["kp_roll"] == 150.0
    assert bench.desk.doubt == ""
    bench.analysis.judged.emit(Judged({"kp_roll": 900.0}, (), None, True, ""))
    assert bench.flight.given == []


def test_confirm_without_a_doubt_flies_nothing(bench):
    bench.desk.propose(NAME, 4.0)
    bench.desk.confirm()
    assert bench.flight.given == []


def test_an_analyst_that_refuses_leaves_a_doubt_that_can_be_confirmed(bench):
    bench.desk.propose(NAME, 4.0)
    bench.analysis.refused.emit(bench.analysis.asked[-1], "its process has died")
    assert "could not be judged" in bench.desk.doubt
    assert "its process has died" in bench.desk.doubt
    count = len(bench.analysis.asked)
    bench.analysis.judged.emit(Judged({NAME: 11.0}, (), None, True, ""))
    assert len(bench.analysis.asked) == count  # nothing is waited for any more
    bench.desk.confirm()
    assert bench.flight.given == [(NAME, 4.0)]


def test_an_analyst_that_is_silent_leaves_a_doubt_and_may_still_answer(bench, qtbot):
    bench.desk.propose(NAME, 4.0)
    qtbot.waitUntil(lambda: bench.desk.doubt != "", timeout=10000)
    assert "not known yet" in bench.desk.doubt
    bench.analysis.judge(stable=True)
    assert bench.flight.given == [(NAME, 4.0)]
    assert bench.desk.doubt == ""


def test_an_answer_about_earlier_gains_flies_nothing(bench):
    bench.desk.propose(NAME, 4.0)
    first = bench.analysis.asked[-1]
    bench.desk.propose(NAME, 29.0)
    bench.analysis.judged.emit(Judged(first.gains, (), None, True, ""))
    assert bench.flight.given == []


def test_an_answer_to_somebody_else_lets_the_question_be_asked_again(bench):
    bench.desk.propose(NAME, 4.0)
    count = len(bench.analysis.asked)
    bench.analysis.judged.emit(Judged({NAME: 11.0}, (), None, True, ""))
    assert len(bench.analysis.asked) == count + 1
    assert bench.analysis.asked[-1].gains[NAME] == 4.0


def test_a_limit_needs_no_judgement(bench):
    bench.desk.propose("max_tilt", 0.5)
    assert bench.flight.given == [("max_tilt", 0.5)]


@pytest.mark.parametrize("value", [float("nan"), float("inf"), -1.0, 30.5])
def test_what_the_table_refuses_never_reaches_the_flight(bench, qtbot, value):
    bench.know()
    with qtbot.waitSignal(bench.desk.complained) as complaint:
        bench.desk.propose(NAME, value)
    assert complaint.args[0] == NAME
    assert complaint.args[1].startswith("kp_velocity_x is ")
    assert bench.flight.given == []
    assert bench.desk.proposed[NAME] == 3.0
    with qtbot.waitSignal(bench.desk.complained) as complaint:
        bench.desk.propose(NAME, 4.0)
    assert complaint.args == [NAME, ""]


def test_a_set_with_one_bad_value_is_refused_whole(bench):
    bench.know()
    with pytest.raises(WorkbenchError, match="kp_roll"):
        bench.desk.adopt({NAME: 4.0, "kp_roll": float("nan")}, "a search")
    assert bench.flight.given == []
    assert bench.desk.proposed[NAME] == 3.0


def test_on_enter_nothing_flies_before_apply(bench, workspace):
    workspace.preferences.set("apply_gains", "on Enter")
    bench.know()
    bench.desk.propose(NAME, 4.0)
    assert bench.flight.given == []
    assert bench.desk.mark(NAME) is Mark.PROPOSED
    assert bench.desk.said() == "1 gain proposed, not flown"
    bench.desk.apply()
    assert bench.flight.given == [(NAME, 4.0)]
    assert bench.desk.said() == "1 gain tried, not kept"


def test_an_answer_flies_nothing_that_was_proposed_after_it_was_entered(bench, workspace):
    workspace.preferences.set("apply_gains", "on Enter")
    bench.desk.propose(NAME, 4.0)
    bench.desk.apply()
    entered = bench.analysis.asked[-1]
    bench.desk.propose(NAME, 30.0)
    bench.analysis.judged.emit(Judged(entered.gains, (), None, True, ""))
    assert bench.flight.given == []
    assert bench.desk.unflown == (NAME,)


def test_a_doubt_about_other_gains_cannot_be_confirmed(bench, workspace):
    workspace.preferences.set("apply_gains", "on Enter")
    bench.desk.propose("kp_roll", 900.0)
    bench.desk.apply()
    bench.analysis.judge(stable=False)
    bench.desk.propose("kp_roll", 2000.0)
    assert bench.desk.doubt == ""
    bench.desk.confirm()
    assert bench.flight.given == []


def test_what_is_left_of_doubted_gains_is_judged_anew(bench):
    bench.desk.adopt({NAME: 4.0, "kp_roll": 900.0}, "a search")
    bench.analysis.judge(stable=False)
    bench.desk.back(["kp_roll"])
    assert bench.analysis.asked[-1].gains["kp_roll"] == 150.0
    bench.analysis.judge(stable=True)
    assert bench.flight.given == [(NAME, 4.0)]
    assert bench.desk.doubt == ""


def test_undo_takes_a_doubt_about_what_was_entered_back(bench, workspace):
    workspace.preferences.set("apply_gains", "on Enter")
    bench.desk.propose(NAME, 4.0)
    bench.desk.propose("kp_roll", 900.0)
    bench.desk.apply()
    bench.analysis.judge(stable=False)
    bench.desk.undo()
    assert bench.desk.doubt == ""
    bench.desk.confirm()
    assert bench.flight.given == []


def test_a_change_by_a_client_lets_doubted_gains_be_judged_anew(bench):
    bench.desk.propose(NAME, 4.0)
    bench.analysis.judge(stable=False)
    bench.flight.publish(2.0, kp_roll=140.0)
    assert bench.analysis.asked[-1].gains["kp_roll"] == 140.0
    assert bench.analysis.asked[-1].gains[NAME] == 4.0


def test_before_any_flight_a_value_is_refused_in_a_sentence(bench, workspace, qtbot):
    desk = GainDesk(bench.flight, bench.analysis, workspace.preferences, workspace.notices)
    with qtbot.waitSignal(desk.complained) as complaint:
        desk.propose(NAME, 4.0)
    assert complaint.args[0] == NAME
    assert "begin a flight" in complaint.args[1]
    desk.close()


def test_revert_orders_the_whole_kept_set_without_asking_anybody(bench):
    bench.know()
    bench.desk.propose(NAME, 4.0)
    bench.desk.propose("kp_roll", 160.0)
    bench.flight.given.clear()
    asked = len(bench.analysis.asked)
    bench.desk.revert()
    assert dict(bench.flight.given) == dict(bench.desk.kept)
    assert dict(bench.flight.given)[NAME] == 3.0
    assert len(bench.analysis.asked) == asked
    assert bench.desk.said() == "Flown = kept"


def test_revert_overtakes_an_order_that_is_never_answered(bench):
    bench.know()
    bench.flight.at_once = False
    bench.desk.propose(NAME, 4.0)
    bench.desk.propose(NAME, 5.0)
    bench.desk.revert()
    assert bench.flight.given[0] == (NAME, 4.0)
    assert (NAME, 3.0) in bench.flight.given
    assert (NAME, 5.0) not in bench.flight.given


def test_revert_brings_back_what_was_kept_last(bench):
    bench.know()
    bench.desk.propose(NAME, 4.0)
    bench.desk.keep()
    bench.desk.propose(NAME, 5.0)
    bench.desk.revert()
    assert bench.desk.flown[NAME] == 4.0


def test_revert_leaves_the_weather_alone(bench):
    bench.desk.propose("wind_x", 5.0)
    bench.desk.revert()
    assert bench.desk.flown["wind_x"] == 5.0


def test_while_an_order_is_not_answered_only_the_newest_waits(bench):
    bench.know()
    bench.flight.at_once = False
    for value in (3.1, 3.2, 3.3, 3.4):
        bench.desk.propose(NAME, value)
    assert bench.flight.given == [(NAME, 3.1)]
    bench.flight.answer()
    assert bench.flight.given == [(NAME, 3.1), (NAME, 3.4)]
    assert bench.desk.flown[NAME] == 3.1
    assert bench.desk.proposed[NAME] == 3.4
    bench.flight.answer()
    assert bench.desk.flown[NAME] == 3.4


def test_a_set_is_one_order_so_that_no_mixture_is_flown(bench):
    bench.know()
    bench.flight.at_once = False
    bench.desk.adopt({NAME: 4.0, "kp_roll": 200.0}, "a profile")
    bench.desk.adopt({NAME: 5.0, "kp_pitch": 210.0}, "another")
    bench.desk.adopt({"kp_pitch": 220.0, "kd_roll": 21.0}, "a third")
    assert [order.values for order in bench.flight.waiting] == [{NAME: 4.0, "kp_roll": 200.0}]
    bench.flight.answer()
    rest = {NAME: 5.0, "kp_pitch": 220.0, "kd_roll": 21.0}
    assert [order.values for order in bench.flight.waiting] == [rest]
    assert bench.desk.unflown == ()
    bench.flight.answer()
    assert rest.items() <= dict(bench.desk.flown).items()


def test_a_drag_that_comes_back_to_its_start_ends_there(bench):
    bench.know()
    bench.flight.at_once = False
    bench.desk.propose(NAME, 3.1)
    bench.desk.propose(NAME, 3.0)
    bench.flight.answer()
    assert bench.desk.proposed[NAME] == 3.0
    bench.flight.answer()
    assert bench.desk.flown[NAME] == 3.0


def test_a_refused_order_is_told_once_and_stays_proposed(bench):
    bench.know()
    bench.flight.at_once = False
    bench.desk.adopt({NAME: 4.0, "kp_velocity_y": 4.0}, "a search")
    bench.flight.refuse("the flight broke off")
    assert bench.desk.flown[NAME] == 3.0
    assert bench.desk.unflown == (NAME, "kp_velocity_y")
    assert [notice.what for notice in bench.told] == [
        "kp_velocity_x stays at 3, and 1 more as they are: the flight broke off."
    ]


def test_a_drag_is_one_step_of_undo(bench):
    bench.know()
    bench.desk.grasp()
    for value in (3.1, 3.2, 3.3):
        bench.desk.propose(NAME, value)
    bench.desk.settle()
    bench.desk.propose(NAME, 4.0)
    bench.desk.undo()
    assert bench.desk.flown[NAME] == 3.3
    bench.desk.undo()
    assert bench.desk.flown[NAME] == 3.0
    assert bench.desk.next_undo == ""
    bench.desk.redo()
    bench.desk.redo()
    assert bench.desk.flown[NAME] == 4.0


def test_undo_takes_back_reverts_and_what_a_search_found(bench):
    bench.know()
    bench.desk.adopt({NAME: 4.0, "kp_roll": 151.0}, "auto-tune")
    bench.desk.revert()
    assert bench.desk.next_undo == "revert"
    bench.desk.undo()
    assert (bench.desk.flown[NAME], bench.desk.flown["kp_roll"]) == (4.0, 151.0)
    bench.desk.undo()
    assert (bench.desk.flown[NAME], bench.desk.flown["kp_roll"]) == (3.0, 150.0)


def test_on_enter_undo_flies_only_what_had_flown(bench, workspace):
    workspace.preferences.set("apply_gains", "on Enter")
    bench.know()
    bench.desk.propose(NAME, 4.0)
    bench.desk.apply()
    bench.desk.propose(NAME, 5.0)
    bench.desk.undo()
    assert bench.flight.given == [(NAME, 4.0)]
    bench.desk.undo()
    assert bench.flight.given == [(NAME, 4.0), (NAME, 3.0)]


def test_linking_moves_nothing_until_one_moves(bench):
    bench.know()
    bench.desk.propose(NAME, 4.0)
    bench.desk.set_linked(True)
    assert bench.desk.proposed["kp_velocity_y"] == 3.0
    bench.desk.propose("kp_velocity_y", 5.0)
    assert (bench.desk.flown[NAME], bench.desk.flown["kp_velocity_y"]) == (5.0, 5.0)
    bench.desk.set_linked(False)
    bench.desk.propose(NAME, 6.0)
    assert bench.desk.flown["kp_velocity_y"] == 5.0
    bench.desk.undo()
    bench.desk.undo()
    assert (bench.desk.flown[NAME], bench.desk.flown["kp_velocity_y"]) == (4.0, 3.0)


def test_a_slot_and_the_present_change_places_by_one_key(bench):
    bench.know()
    bench.desk.propose(NAME, 4.0)
    bench.desk.store("A")
    bench.desk.propose(NAME, 5.0)
    bench.desk.recall("A")
    assert bench.desk.flown[NAME] == 4.0
    bench.desk.recall("A")
    assert bench.desk.flown[NAME] == 5.0
    bench.desk.undo()
    assert bench.desk.flown[NAME] == 4.0


def test_an_empty_slot_says_so(bench):
    bench.desk.recall("B")
    assert "empty" in bench.told[-1].what
    assert bench.flight.given == []


def test_a_change_by_a_client_is_followed(bench, qtbot):
    with qtbot.waitSignal(bench.desk.flown_changed) as changed:
        bench.flight.publish(5.0, kp_velocity_x=7.0, kp_roll=170.0)
    assert changed.args[0] == {NAME: 7.0, "kp_roll": 170.0}
    assert bench.desk.proposed[NAME] == 7.0
    assert bench.desk.said() == "2 gains tried, not kept"
    assert bench.flight.given == []


def test_a_change_by_a_client_leaves_what_is_being_tried(bench, workspace):
    workspace.preferences.set("apply_gains", "on Enter")
    bench.desk.propose(NAME, 4.0)
    bench.flight.publish(5.0, kp_velocity_x=7.0)
    assert (bench.desk.proposed[NAME], bench.desk.flown[NAME]) == (4.0, 7.0)


def test_an_answer_does_not_hide_a_later_change_by_a_client(bench):
    bench.know()
    bench.flight.at_once = False
    bench.desk.propose(NAME, 4.0)
    bench.flight.publish(5.0, kp_velocity_x=4.0)
    bench.flight.publish(5.1, kp_velocity_x=7.0)
    bench.flight.time = 5.0 - 0.01
    bench.flight.answer()
    assert bench.desk.flown[NAME] == 7.0


def test_a_reset_brings_the_start_values_and_leaves_the_kept_set(bench):
    bench.know()
    bench.desk.propose(NAME, 4.0)
    bench.desk.keep()
    bench.desk.begin(bench.view)
    assert (bench.desk.flown[NAME], bench.desk.proposed[NAME]) == (3.0, 3.0)
    assert bench.desk.kept[NAME] == 4.0
    bench.desk.revert()
    assert bench.desk.flown[NAME] == 4.0


def test_a_change_told_right_after_a_reset_is_not_lost(bench):
    bench.flight.publish(5.0, kp_velocity_x=7.0)
    bench.flight.publish(0.0, kp_velocity_x=3.0)
    bench.flight.publish(0.2, kp_velocity_x=4.0)
    bench.desk.begin(bench.view)
    assert bench.desk.flown[NAME] == 4.0


def test_what_was_told_before_a_reset_does_not_outlive_it(bench):
    bench.flight.publish(5.0, kp_roll=170.0)
    bench.flight.publish(0.2, kp_velocity_x=4.0)
    bench.desk.begin(bench.view)
    assert (bench.desk.flown[NAME], bench.desk.flown["kp_roll"]) == (4.0, 150.0)


def test_another_vehicle_begins_with_its_own_values(bench, new_view):
    bench.know()
    bench.desk.propose(NAME, 4.0)
    bench.desk.store("A")
    bench.desk.begin(new_view(kp_velocity_x=2.0))
    assert bench.desk.kept[NAME] == 2.0
    assert bench.desk.slots == {}
    assert bench.desk.next_undo == ""
    assert bench.desk.stable_range(NAME) is None


def test_ranges_are_looked_for_once_gains_have_rested(bench, qtbot):
    bench.know()
    for value in (3.1, 3.2, 3.3):
        bench.desk.propose(NAME, value)
    assert not bench.desk.ranges_fresh

    def asked():
        return [each for each in bench.analysis.asked if isinstance(each, FindRanges)]

    qtbot.waitUntil(lambda: len(asked()) > 0, timeout=10000)
    assert [each.gains[NAME] for each in asked()] == [3.3]
    bench.know()
    assert bench.desk.ranges_fresh


def test_the_difference_is_of_the_proposed_to_the_kept(bench):
    bench.know()
    bench.desk.propose(NAME, 4.5)
    (change,) = bench.desk.difference()
    assert (change.name, change.a, change.b, change.percent) == (NAME, 3.0, 4.5, 50.0)


def test_what_is_copied_is_a_gain_file_of_what_flies(bench, tmp_path):
    bench.know()
    bench.desk.propose(NAME, 4.5)
    path = tmp_path / "copied.yaml"
    path.write_text(bench.desk.as_yaml())
    copied = load_gains(path)
    assert copied.vehicle == "dh_drone"
    assert copied.gains[NAME] == 4.5
    assert set(copied.gains) == set(bench.desk.profile_names)


def test_what_is_saved_is_what_flies(bench, workspace, qtbot, tmp_path):
    workspace.preferences.set("apply_gains", "on Enter")
    bench.know()
    bench.desk.propose(NAME, 4.5)
    bench.desk.apply()
    bench.desk.propose(NAME, 9.0)
    path = tmp_path / "brisk.yaml"
    with qtbot.waitSignal(bench.desk.profiles.named):
        bench.desk.save(path, "tuned in flight")
    saved = load_gains(path)
    assert (saved.gains[NAME], saved.origin) == (4.5, "tuned in flight")
    assert bench.desk.profiles.name == "brisk"


def test_a_file_that_cannot_be_written_is_told(bench, qtbot, tmp_path):
    bench.desk.save(tmp_path / "nowhere" / "brisk.yaml", "tuned in flight")
    qtbot.waitUntil(lambda: len(bench.told) > 0, timeout=10000)
    assert "cannot be written" in bench.told[-1].what


def test_a_loaded_profile_flies_only_what_is_taken(bench, gain_file, qtbot):
    bench.know()
    with qtbot.waitSignal(bench.desk.profiles.offered) as offered:
        bench.desk.load(gain_file)
    offer = offered.args[0]
    assert [change.name for change in offer.changes] == [NAME, "kp_roll"]
    assert bench.flight.given == []
    bench.desk.profiles.take(["kp_roll"])
    bench.analysis.judge(stable=True) if bench.desk.unflown else None
    assert bench.flight.given == [("kp_roll", 200.0)]
    bench.desk.undo()
    assert bench.desk.flown["kp_roll"] == 150.0


def test_a_wrong_file_is_told_with_its_line(bench, tmp_path, qtbot):
    path = tmp_path / "wrong.yaml"
    path.write_text("gains:\n  kp_velocity_x: 99\n")
    bench.desk.load(path)
    qtbot.waitUntil(lambda: len(bench.told) > 0, timeout=10000)
    assert "wrong.yaml:2" in bench.told[-1].what


def test_lines_of_the_clipboard_are_a_profile(bench, qtbot):
    with qtbot.waitSignal(bench.desk.profiles.offered) as offered:
        bench.desk.profiles.paste("kp_velocity_x: 4.5 1/s\nkp_roll: 150 1/s^2\n")
    assert [(change.name, change.b) for change in offered.args[0].changes] == [(NAME, 4.5)]


def test_what_the_clipboard_has_wrong_is_told(bench, qtbot):
    bench.desk.profiles.paste("gains:\n  kp_velocity_x: nonsense\n")
    qtbot.waitUntil(lambda: len(bench.told) > 0, timeout=10000)
    assert bench.told[-1].what.startswith("the clipboard:2")


def test_a_model_without_gains_offers_those_of_the_start(bench, qtbot):
    bench.know()
    bench.desk.propose(NAME, 4.0)
    with qtbot.waitSignal(bench.desk.profiles.offered) as offered:
        bench.desk.profiles.load_own()
    assert [(change.name, change.b) for change in offered.args[0].changes] == [(NAME, 3.0)]


def test_revert_lets_go_of_what_was_refused(bench, qtbot):
    bench.desk.propose(NAME, 99.0)
    with qtbot.waitSignal(bench.desk.complained) as complaint:
        bench.desk.revert()
    assert complaint.args == [NAME, ""]
