"""What the flight has, whoever changed it."""

NAME = "kp_velocity_x"


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
