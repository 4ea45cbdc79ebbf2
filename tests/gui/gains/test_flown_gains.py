"""Which value is said to fly: of answers and of what is published, the later one."""

import pytest
from PyQt6.QtCore import QObject, pyqtSignal

from workbench.gui.gains.flown_gains import FlownGains
from workbench.link.backplane import Published
from workbench.link.drone_topics import PARAMETERS_SIGNAL, fixed_topic
from workbench.live.view import LiveView


class Flight(QObject):
    """A flight whose answers a test gives."""

    streamed = pyqtSignal(object)

    def __init__(self):
        super().__init__()
        self.orders = []

    def do(self, order, done, refused):
        self.orders.append((dict(order.set), done, refused))

    def publish(self, time, **values):
        pack = fixed_topic(PARAMETERS_SIGNAL.id).pack
        payloads = ((PARAMETERS_SIGNAL.id, pack(each)) for each in values.items())
        self.streamed.emit([Published(round(time * 1e9), 0, tuple(payloads))])


@pytest.fixture
def flight(qapp):
    return Flight()


@pytest.fixture
def flown(flight):
    found = FlownGains(flight, flight)
    found.begin(LiveView(values={"a": 1.0, "b": 2.0}))
    return found


def test_an_answer_counts_unless_something_later_was_published(flight, flown):
    """Somebody else has changed the gain since; the answer comes after that is published."""
    flown.order({"a": 3.0})
    flight.publish(1.5, a=7.0)
    flight.orders[0][1](1.0)
    assert flown.values == {"a": 7.0, "b": 2.0} and not flown.is_ordered("a")
    flown.order({"a": 4.0})
    flight.orders[1][1](2.0)
    assert flown.values == {"a": 4.0, "b": 2.0}


def test_an_answer_of_an_earlier_flight_says_nothing_of_this_one(flight, flown):
    told = []
    flown.refused.connect(lambda values, said: told.append(said))
    flown.order({"a": 3.0})
    flown.order({"b": 3.0})
    flown.begin(LiveView(values={"a": 1.0, "b": 2.0}))
    flight.orders[0][1](1.0)
    flight.orders[1][2]("it is over")
    assert flown.values == {"a": 1.0, "b": 2.0} and told == []
    flown.order({"a": 5.0})
    flight.orders[2][1](0.5)
    assert flown.values["a"] == 5.0
