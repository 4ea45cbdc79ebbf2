"""What takes changes back: revert, undo, slots; and linked gains."""

NAME = "kp_velocity_x"


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


def test_the_difference_is_of_the_proposed_to_the_kept(bench):
    bench.know()
    bench.desk.propose(NAME, 4.5)
    (change,) = bench.desk.difference()
    assert (change.name, change.a, change.b, change.percent) == (NAME, 3.0, 4.5, 50.0)


def test_revert_lets_go_of_what_was_refused(bench, qtbot):
    bench.desk.propose(NAME, 99.0)
    with qtbot.waitSignal(bench.desk.complained) as complaint:
        bench.desk.revert()
    assert complaint.args == [NAME, ""]
