"""Series and flights, against hand calculations."""

from pathlib import Path

import numpy as np
import pytest

from workbench.common.errors import WorkbenchError
from workbench.common.flight import Flight
from workbench.common.series import Series, interpolated_on_grid, make_series
from workbench.logs import flight_record, logged_signal

TORN = make_series("a.x", "m", np.array([0.0, 1.0, 2.0, 6.0, 7.0]), np.arange(5.0), end=9.5)
"""A sample a second, with gaps from 2 to 6 s, and from 7 s to the end."""


def test_a_part_keeps_its_ends_and_the_gaps_that_reach_into_it():
    assert TORN.gaps == ((2.0, 6.0), (7.0, 9.5))
    part = TORN.between(1.0, 6.0)
    assert (part.time.tolist(), part.values.tolist()) == ([1.0, 2.0, 6.0], [1.0, 2.0, 3.0])
    assert part.gaps == ((2.0, 6.0),) and part.rate == TORN.rate
    assert TORN.between(6.0, 7.0).gaps == ()
    moved = part.since(1.0)
    assert moved.time.tolist() == [0.0, 1.0, 5.0] and moved.gaps == ((1.0, 5.0),)
    assert TORN.between(3.0, 5.0).time.tolist() == []


def test_no_curve_is_drawn_across_a_gap():
    drawn = TORN.with_gaps()
    assert drawn.time.tolist() == [0.0, 1.0, 2.0, 4.0, 6.0, 7.0, 8.25]
    assert np.isnan(drawn.values).nonzero()[0].tolist() == [3, 6]
    whole = Series("a.y", "m", TORN.time, TORN.values)
    assert whole.with_gaps() is whole


def test_the_known_share_is_the_time_outside_of_gaps():
    assert TORN.known_share(0.0, 7.0) == pytest.approx(3.0 / 7.0)
    assert TORN.known_share(-1.0, 3.0) == pytest.approx(2.0 / 4.0)
    assert TORN.known_share(6.0, 9.5) == pytest.approx(1.0 / 3.5)
    assert TORN.known_share(3.0, 5.0) == TORN.known_share(1.0, 1.0) == 0.0


def test_rows_lie_on_lines_between_samples():
    values = np.arange(12.0).reshape(3, 2, 2) ** 2
    found = interpolated_on_grid(np.array([0.0, 1.0, 3.0]), values, np.array([-1.0, 0.5, 2.0]))
    assert found[0].tolist() == values[0].tolist()
    assert found[1].tolist() == (0.5 * (values[0] + values[1])).tolist()
    assert found[2].tolist() == (0.5 * (values[1] + values[2])).tolist()


def test_signals_of_a_flight_are_found_by_topic_field_and_component(case):
    names = ("p.x", "p.x_max", "rotors.thrust.0", "rotors.thrust.1", "rotors.thrusts")
    signals = {name: Series(name, "1", TORN.time, TORN.values) for name in names}
    flight = Flight("quad", Path("a.csv"), "made", signals, parameters={"vehicle": "x500"}, end=9.5)
    assert (flight.vehicle, flight.begin, flight.units["p.x"]) == ("x500", 0.0, "1")
    for name, found in (
        ("p", ["p.x", "p.x_max"]),
        ("p.x", ["p.x"]),
        ("rotors.thrust", ["rotors.thrust.0", "rotors.thrust.1"]),
    ):
        with case(name):
            assert [each.name for each in flight.several(name)] == found
    for name, said in (("q.x", "unknown topic 'q'"), ("p.z", "unknown field of p, 'z'")):
        with case(name), pytest.raises(WorkbenchError, match=said):
            flight.several(name)
    part = flight.between(1.0, 6.0)
    assert (part.begin, part.end) == (1.0, 6.0)
    time, values = part.series("p.x", since=1.5)
    assert (time.tolist(), values.tolist()) == ([2.0, 6.0], [2.0, 3.0])
    with pytest.raises(WorkbenchError, match=r"a.csv: has nothing between 20 and 30 s"):
        flight.between(20.0, 30.0)


def test_readers_of_version_1_0_work(case):
    for module, name, now in (
        (flight_record, "FlightRecord", Flight),
        (logged_signal, "make_signal", make_series),
    ):
        with case(name):
            with pytest.warns(DeprecationWarning, match=f"{name} is now workbench.{now.__name__}"):
                assert getattr(module, name) is now
            with pytest.raises(AttributeError, match="has no attribute 'other'"):
                _ = module.other
