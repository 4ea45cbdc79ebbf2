"""Gains as a transaction, with a flight and an analyst that answer when the test says so."""

from dataclasses import replace

import pytest

from workbench.analysis.queries import FindRanges, Judge
from workbench.analysis.replies import Judged
from workbench.common.errors import WorkbenchError
from workbench.control.controller_file import load_controller
from workbench.gui.gains.gain_editor import GainEditor, GainMark

NAME = "kp_velocity_x"


def test_a_move_within_the_known_range_is_ordered_at_once(rig):
    rig.know(kp_velocity_x=(1.0, 8.0))
    rig.editor.propose(NAME, 7.9)
    assert rig.flight.given == [(NAME, 7.9)]
    assert not [each for each in rig.analysis.asked if isinstance(each, Judge)]
    assert rig.editor.flown[NAME] == 7.9


def test_a_move_beyond_the_known_range_is_judged_before_it_flies(rig):
    rig.know(kp_velocity_x=(1.0, 8.0))
    rig.editor.propose(NAME, 8.1)
    assert rig.flight.given == []
    assert rig.analysis.asked[-1].gains[NAME] == 8.1
    rig.analysis.judge(stable=True)
    assert rig.flight.given == [(NAME, 8.1)]


def test_without_any_knowledge_a_move_is_judged(rig):
    rig.editor.propose(NAME, 3.1)
    assert rig.flight.given == []
    rig.analysis.judge(stable=True)
    assert rig.flight.given == [(NAME, 3.1)]


def test_two_gains_halfway_each_are_known_and_further_are_judged(rig):
    rig.know(kp_velocity_x=(1.0, 5.0), kp_roll=(50.0, 250.0))
    rig.editor.propose(NAME, 4.0)
    rig.editor.propose("kp_roll", 200.0)
    assert rig.flight.given == [(NAME, 4.0), ("kp_roll", 200.0)]
    rig.editor.propose("kp_roll", 201.0)
    assert len(rig.flight.given) == 2
    assert isinstance(rig.analysis.asked[-1], Judge)


def test_what_is_unstable_is_named_and_not_flown_until_confirmed(rig, qtbot):
    with qtbot.waitSignal(rig.editor.warning_changed) as warned:
        rig.editor.propose("kp_roll", 900.0)
        rig.analysis.judge(stable=False, said="a mode grows through roll")
    assert warned.args == ["a mode grows through roll"]
    assert rig.flight.given == []
    rig.editor.confirm()
    assert rig.flight.given == [("kp_roll", 900.0)]
    assert rig.editor.warning == ""


def test_back_proposes_what_flies_again(rig):
    rig.editor.propose("kp_roll", 900.0)
    rig.analysis.judge(stable=False)
    rig.editor.discard()
    assert rig.editor.proposed["kp_roll"] == 150.0
    assert rig.editor.warning == ""
    rig.analysis.tell(Judge({"kp_roll": 900.0}), Judged((), None, True, ""))
    assert rig.flight.given == []


def test_confirm_without_a_doubt_flies_nothing(rig):
    rig.editor.propose(NAME, 4.0)
    rig.editor.confirm()
    assert rig.flight.given == []


def test_an_analyst_that_refuses_leaves_a_doubt_that_can_be_confirmed(rig):
    rig.editor.propose(NAME, 4.0)
    rig.analysis.refused.emit(rig.analysis.asked[-1], "its process has died")
    assert "could not be judged" in rig.editor.warning
    assert "its process has died" in rig.editor.warning
    count = len(rig.analysis.asked)
    rig.analysis.tell(Judge({NAME: 11.0}), Judged((), None, True, ""))
    assert len(rig.analysis.asked) == count  # nothing is waited for any more
    rig.editor.confirm()
    assert rig.flight.given == [(NAME, 4.0)]


def test_an_analyst_that_is_silent_leaves_a_doubt_and_may_still_answer(rig, qtbot):
    rig.editor.propose(NAME, 4.0)
    qtbot.waitUntil(lambda: rig.editor.warning != "", timeout=10000)
    assert "not known yet" in rig.editor.warning
    rig.analysis.judge(stable=True)
    assert rig.flight.given == [(NAME, 4.0)]
    assert rig.editor.warning == ""


def test_an_answer_about_earlier_gains_flies_nothing(rig):
    rig.editor.propose(NAME, 4.0)
    first = rig.analysis.asked[-1]
    rig.editor.propose(NAME, 29.0)
    rig.analysis.tell(first, Judged((), None, True, ""))
    assert rig.flight.given == []


def test_a_limit_needs_no_judgement(rig):
    rig.editor.propose("max_tilt", 0.5)
    assert rig.flight.given == [("max_tilt", 0.5)]


@pytest.mark.parametrize("value", [float("nan"), float("inf"), -1.0, 30.5])
def test_what_the_table_refuses_never_reaches_the_flight(rig, qtbot, value):
    rig.know()
    with qtbot.waitSignal(rig.editor.value_refused) as refusal:
        rig.editor.propose(NAME, value)
    assert refusal.args[0] == NAME
    assert refusal.args[1].startswith("kp_velocity_x is ")
    assert rig.flight.given == []
    assert rig.editor.proposed[NAME] == 3.0
    with qtbot.waitSignal(rig.editor.value_refused) as refusal:
        rig.editor.propose(NAME, 4.0)
    assert refusal.args == [NAME, ""]


def test_a_set_with_one_bad_value_is_refused_whole(rig):
    rig.know()
    with pytest.raises(WorkbenchError, match="kp_roll"):
        rig.editor.adopt({NAME: 4.0, "kp_roll": float("nan")}, "a search")
    assert rig.flight.given == []
    assert rig.editor.proposed[NAME] == 3.0


def test_on_enter_nothing_flies_before_apply(rig, workspace):
    workspace.preferences.set("apply_gains", "on Enter")
    rig.know()
    rig.editor.propose(NAME, 4.0)
    assert rig.flight.given == []
    assert rig.editor.mark(NAME) is GainMark.PROPOSED
    assert rig.editor.summary() == "kept · 1 gain proposed, not flown"
    rig.editor.apply()
    assert rig.flight.given == [(NAME, 4.0)]
    assert rig.editor.summary() == "1 gain not kept"


def test_an_answer_flies_nothing_that_was_proposed_after_it_was_entered(rig, workspace):
    workspace.preferences.set("apply_gains", "on Enter")
    rig.editor.propose(NAME, 4.0)
    rig.editor.apply()
    entered = rig.analysis.asked[-1]
    rig.editor.propose(NAME, 30.0)
    rig.analysis.tell(entered, Judged((), None, True, ""))
    assert rig.flight.given == []
    assert rig.editor.unflown == (NAME,)


def test_a_doubt_about_other_gains_cannot_be_confirmed(rig, workspace):
    workspace.preferences.set("apply_gains", "on Enter")
    rig.editor.propose("kp_roll", 900.0)
    rig.editor.apply()
    rig.analysis.judge(stable=False)
    rig.editor.propose("kp_roll", 2000.0)
    assert rig.editor.warning == ""
    rig.editor.confirm()
    assert rig.flight.given == []


def test_what_is_left_of_doubted_gains_is_judged_anew(rig):
    rig.editor.adopt({NAME: 4.0, "kp_roll": 900.0}, "a search")
    rig.analysis.judge(stable=False)
    rig.editor.discard(["kp_roll"])
    assert rig.analysis.asked[-1].gains["kp_roll"] == 150.0
    rig.analysis.judge(stable=True)
    assert rig.flight.given == [(NAME, 4.0)]
    assert rig.editor.warning == ""


def test_undo_takes_a_doubt_about_what_was_entered_back(rig, workspace):
    workspace.preferences.set("apply_gains", "on Enter")
    rig.editor.propose(NAME, 4.0)
    rig.editor.propose("kp_roll", 900.0)
    rig.editor.apply()
    rig.analysis.judge(stable=False)
    rig.editor.undo()
    assert rig.editor.warning == ""
    rig.editor.confirm()
    assert rig.flight.given == []


def test_a_change_by_a_client_lets_doubted_gains_be_judged_anew(rig):
    rig.editor.propose(NAME, 4.0)
    rig.analysis.judge(stable=False)
    rig.flight.publish(2.0, kp_roll=140.0)
    assert rig.analysis.asked[-1].gains["kp_roll"] == 140.0
    assert rig.analysis.asked[-1].gains[NAME] == 4.0


def test_wind_that_a_script_sets_is_shown_and_is_no_step_of_undo(rig):
    rig.editor.propose(NAME, 3.1)
    done = rig.editor.next_undo
    rig.flight.publish(2.0, wind_x=4.0)
    assert rig.editor.proposed["wind_x"] == 4.0
    assert rig.editor.next_undo == done
    rig.editor.undo()
    assert not rig.editor.next_undo
    assert rig.editor.proposed["wind_x"] == 4.0
    rig.flight.publish(3.0, kp_roll=140.0)
    assert rig.editor.next_undo  # a gain that a client sets can be undone


def test_before_any_flight_a_value_is_refused_in_a_sentence(rig, workspace, qtbot):
    editor = GainEditor(rig.flight, rig.analysis, workspace.preferences, workspace.notices)
    with qtbot.waitSignal(editor.value_refused) as refusal:
        editor.propose(NAME, 4.0)
    assert refusal.args[0] == NAME
    assert "start a flight" in refusal.args[1]


def test_ranges_are_looked_for_once_gains_have_rested(rig, qtbot):
    rig.know()
    for value in (3.1, 3.2, 3.3):
        rig.editor.propose(NAME, value)
    assert not rig.editor.has_fresh_ranges

    def asked():
        return [each for each in rig.analysis.asked if isinstance(each, FindRanges)]

    qtbot.waitUntil(lambda: len(asked()) > 0, timeout=10000)
    assert [each.gains[NAME] for each in asked()] == [3.3]
    rig.know()
    assert rig.editor.has_fresh_ranges


def test_while_an_order_is_not_answered_only_the_newest_waits(rig):
    rig.know()
    rig.flight.at_once = False
    for value in (3.1, 3.2, 3.3, 3.4):
        rig.editor.propose(NAME, value)
    assert rig.flight.given == [(NAME, 3.1)]
    rig.flight.answer()
    assert rig.flight.given == [(NAME, 3.1), (NAME, 3.4)]
    assert rig.editor.flown[NAME] == 3.1
    assert rig.editor.proposed[NAME] == 3.4
    rig.flight.answer()
    assert rig.editor.flown[NAME] == 3.4


def test_a_set_is_one_order_so_that_no_mixture_is_flown(rig):
    rig.know()
    rig.flight.at_once = False
    rig.editor.adopt({NAME: 4.0, "kp_roll": 200.0}, "a gain file")
    rig.editor.adopt({NAME: 5.0, "kp_pitch": 210.0}, "another")
    rig.editor.adopt({"kp_pitch": 220.0, "kd_roll": 21.0}, "a third")
    assert [order.values for order in rig.flight.waiting] == [{NAME: 4.0, "kp_roll": 200.0}]
    rig.flight.answer()
    rest = {NAME: 5.0, "kp_pitch": 220.0, "kd_roll": 21.0}
    assert [order.values for order in rig.flight.waiting] == [rest]
    assert rig.editor.unflown == ()
    rig.flight.answer()
    assert rest.items() <= dict(rig.editor.flown).items()


def test_a_drag_that_comes_back_to_its_start_ends_there(rig):
    rig.know()
    rig.flight.at_once = False
    rig.editor.propose(NAME, 3.1)
    rig.editor.propose(NAME, 3.0)
    rig.flight.answer()
    assert rig.editor.proposed[NAME] == 3.0
    rig.flight.answer()
    assert rig.editor.flown[NAME] == 3.0


def test_a_refused_order_is_told_once_and_stays_proposed(rig):
    rig.know()
    rig.flight.at_once = False
    rig.editor.adopt({NAME: 4.0, "kp_velocity_y": 4.0}, "a search")
    rig.flight.refuse("the flight broke off")
    assert rig.editor.flown[NAME] == 3.0
    assert rig.editor.unflown == (NAME, "kp_velocity_y")
    assert [notice.what for notice in rig.told] == [
        "kp_velocity_x stays at 3, and 1 more as they are: the flight broke off."
    ]


def test_a_change_by_a_client_is_followed(rig, qtbot):
    with qtbot.waitSignal(rig.editor.flown_changed) as changed:
        rig.flight.publish(5.0, kp_velocity_x=7.0, kp_roll=170.0)
    assert changed.args[0] == {NAME: 7.0, "kp_roll": 170.0}
    assert rig.editor.proposed[NAME] == 7.0
    assert rig.editor.summary() == "2 gains not kept"
    assert rig.flight.given == []


def test_a_change_by_a_client_leaves_what_is_being_tried(rig, workspace):
    workspace.preferences.set("apply_gains", "on Enter")
    rig.editor.propose(NAME, 4.0)
    rig.flight.publish(5.0, kp_velocity_x=7.0)
    assert (rig.editor.proposed[NAME], rig.editor.flown[NAME]) == (4.0, 7.0)


def test_an_answer_does_not_hide_a_later_change_by_a_client(rig):
    rig.know()
    rig.flight.at_once = False
    rig.editor.propose(NAME, 4.0)
    rig.flight.publish(5.0, kp_velocity_x=4.0)
    rig.flight.publish(5.1, kp_velocity_x=7.0)
    rig.flight.time = 5.0 - 0.01
    rig.flight.answer()
    assert rig.editor.flown[NAME] == 7.0


def test_a_reset_brings_the_start_values_and_leaves_the_kept_set(rig):
    rig.know()
    rig.editor.propose(NAME, 4.0)
    rig.editor.keep()
    rig.editor.begin(rig.view)
    assert (rig.editor.flown[NAME], rig.editor.proposed[NAME]) == (3.0, 3.0)
    assert rig.editor.kept[NAME] == 4.0
    rig.editor.revert()
    assert rig.editor.flown[NAME] == 4.0


def test_a_change_told_right_after_a_reset_is_not_lost(rig):
    rig.flight.publish(5.0, kp_velocity_x=7.0)
    rig.flight.publish(0.0, kp_velocity_x=3.0)
    rig.flight.publish(0.2, kp_velocity_x=4.0)
    rig.editor.begin(rig.view)
    assert rig.editor.flown[NAME] == 4.0


def test_what_was_told_before_a_reset_does_not_outlive_it(rig):
    rig.flight.publish(5.0, kp_roll=170.0)
    rig.flight.publish(0.2, kp_velocity_x=4.0)
    rig.editor.begin(rig.view)
    assert (rig.editor.flown[NAME], rig.editor.flown["kp_roll"]) == (4.0, 150.0)


def test_another_vehicle_begins_with_its_own_values(rig, new_view):
    rig.know()
    rig.editor.propose(NAME, 4.0)
    rig.editor.store("A")
    rig.editor.begin(new_view(kp_velocity_x=2.0))
    assert rig.editor.kept[NAME] == 2.0
    assert rig.editor.slots == {}
    assert rig.editor.next_undo == ""
    assert rig.editor.stable_range(NAME) is None


def test_revert_orders_the_whole_kept_set_without_asking_anybody(rig):
    rig.know()
    rig.editor.propose(NAME, 4.0)
    rig.editor.propose("kp_roll", 160.0)
    rig.flight.given.clear()
    asked = len(rig.analysis.asked)
    rig.editor.revert()
    assert dict(rig.flight.given) == dict(rig.editor.kept)
    assert dict(rig.flight.given)[NAME] == 3.0
    assert len(rig.analysis.asked) == asked
    assert rig.editor.summary() == "kept"


def test_revert_overtakes_an_order_that_is_never_answered(rig):
    rig.know()
    rig.flight.at_once = False
    rig.editor.propose(NAME, 4.0)
    rig.editor.propose(NAME, 5.0)
    rig.editor.revert()
    assert rig.flight.given[0] == (NAME, 4.0)
    assert (NAME, 3.0) in rig.flight.given
    assert (NAME, 5.0) not in rig.flight.given


def test_revert_brings_back_what_was_kept_last(rig):
    rig.know()
    rig.editor.propose(NAME, 4.0)
    rig.editor.keep()
    rig.editor.propose(NAME, 5.0)
    rig.editor.revert()
    assert rig.editor.flown[NAME] == 4.0


def test_revert_leaves_the_weather_alone(rig):
    rig.editor.propose("wind_x", 5.0)
    rig.editor.revert()
    assert rig.editor.flown["wind_x"] == 5.0


def test_a_drag_is_one_step_of_undo(rig):
    rig.know()
    rig.editor.begin_edit()
    for value in (3.1, 3.2, 3.3):
        rig.editor.propose(NAME, value)
    rig.editor.end_edit()
    rig.editor.propose(NAME, 4.0)
    rig.editor.undo()
    assert rig.editor.flown[NAME] == 3.3
    rig.editor.undo()
    assert rig.editor.flown[NAME] == 3.0
    assert rig.editor.next_undo == ""
    rig.editor.redo()
    rig.editor.redo()
    assert rig.editor.flown[NAME] == 4.0


def test_two_drags_of_one_slider_are_two_steps_of_undo(rig):
    rig.know()
    for value in (3.3, 3.6):
        rig.editor.begin_edit()
        rig.editor.propose(NAME, value)
        rig.editor.end_edit()
    rig.editor.undo()
    assert rig.editor.flown[NAME] == 3.3


def test_a_drag_that_leads_back_to_its_start_is_no_step_of_undo(rig):
    rig.know()
    rig.editor.begin_edit()
    for value in (3.1, 3.2, 3.0):
        rig.editor.propose(NAME, value)
    rig.editor.end_edit()
    assert rig.editor.next_undo == ""


def test_undo_takes_back_reverts_and_what_a_search_found(rig):
    rig.know()
    rig.editor.adopt({NAME: 4.0, "kp_roll": 151.0}, "auto-tune")
    rig.editor.revert()
    assert rig.editor.next_undo == "revert"
    rig.editor.undo()
    assert (rig.editor.flown[NAME], rig.editor.flown["kp_roll"]) == (4.0, 151.0)
    rig.editor.undo()
    assert (rig.editor.flown[NAME], rig.editor.flown["kp_roll"]) == (3.0, 150.0)


def test_on_enter_undo_flies_only_what_had_flown(rig, workspace):
    workspace.preferences.set("apply_gains", "on Enter")
    rig.know()
    rig.editor.propose(NAME, 4.0)
    rig.editor.apply()
    rig.editor.propose(NAME, 5.0)
    rig.editor.undo()
    assert rig.flight.given == [(NAME, 4.0)]
    rig.editor.undo()
    assert rig.flight.given == [(NAME, 4.0), (NAME, 3.0)]


def test_linking_moves_nothing_until_one_moves(rig):
    rig.know()
    rig.editor.propose(NAME, 4.0)
    rig.editor.set_linked(True)
    assert rig.editor.proposed["kp_velocity_y"] == 3.0
    rig.editor.propose("kp_velocity_y", 5.0)
    assert (rig.editor.flown[NAME], rig.editor.flown["kp_velocity_y"]) == (5.0, 5.0)
    rig.editor.set_linked(False)
    rig.editor.propose(NAME, 6.0)
    assert rig.editor.flown["kp_velocity_y"] == 5.0
    rig.editor.undo()
    rig.editor.undo()
    assert (rig.editor.flown[NAME], rig.editor.flown["kp_velocity_y"]) == (4.0, 3.0)


def test_a_slot_and_the_present_change_places_by_one_key(rig):
    rig.know()
    rig.editor.propose(NAME, 4.0)
    rig.editor.store("A")
    rig.editor.propose(NAME, 5.0)
    rig.editor.compare("A")
    assert rig.editor.flown[NAME] == 4.0
    rig.editor.compare("A")
    assert rig.editor.flown[NAME] == 5.0
    rig.editor.undo()
    assert rig.editor.flown[NAME] == 4.0


def test_from_slot_to_slot_the_gains_before_the_first_come_back(rig):
    rig.know()
    for slot, value in (("A", 4.0), ("B", 4.5)):
        rig.editor.propose(NAME, value)
        rig.editor.store(slot)
    rig.editor.propose(NAME, 5.0)  # stored nowhere
    for slot, flies in (("A", 4.0), ("B", 4.5), ("A", 4.0), ("A", 5.0)):
        rig.editor.compare(slot)
        assert rig.editor.flown[NAME] == flies


def test_revert_lets_go_of_what_was_refused(rig, qtbot):
    rig.editor.propose(NAME, 99.0)
    with qtbot.waitSignal(rig.editor.value_refused) as refusal:
        rig.editor.revert()
    assert refusal.args == [NAME, ""]


def test_an_edit_of_the_law_keeps_proposals_and_undo_and_a_new_row_is_shown(rig, qtbot, tmp_path):
    law = load_controller()
    rig.editor.propose(NAME, 4.0)
    before = rig.editor.rows
    same = replace(law, text=law.text + "# edited")
    rig.editor.take_over(replace(rig.view, controller=same))
    assert rig.editor.rows is before and rig.editor.proposed[NAME] == 4.0
    rig.editor.undo()
    assert rig.editor.proposed[NAME] != 4.0

    rig.editor.propose(NAME, 4.0)
    row = replace(law.parameters[0], name="k_new", help="of no use")
    other = replace(same, parameters=(row, *law.parameters))
    values = {**rig.view.values, NAME: 4.0, "k_new": 0.5}
    with qtbot.waitSignal(rig.editor.begun):
        rig.editor.take_over(replace(rig.view, controller=other, values=values))
    assert "k_new" in [row.name for row in rig.editor.rows]
    assert (rig.editor.proposed["k_new"], rig.editor.flown[NAME]) == (0.5, 4.0)
    assert not rig.editor.next_undo
