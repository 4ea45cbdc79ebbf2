"""Orders to the flight: one at a time for each gain, a set at once."""

NAME = "kp_velocity_x"


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
