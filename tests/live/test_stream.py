"""Everything that is published arrives, or is counted as missing."""

import numpy as np
import pytest

from workbench.link.backplane import Published
from workbench.live.flight import LiveFlight
from workbench.live.messages import StreamedRecords
from workbench.live.stream import RecordStream

ENOUGH = 300.0
"""No test waits so long unless it fails [s]."""


class SendQueue:
    """Takes messages while it is open."""

    def __init__(self):
        self.open, self.sent = True, []

    def offer(self, message):
        if self.open:
            self.sent.append(message)
        return self.open


def at(t_ns):
    return Published(t_ns, 0, ())


def test_a_reader_that_is_too_slow_is_told_how_much_is_left_out():
    send_queue = SendQueue()
    stream = RecordStream(send_queue)
    stream.flush()
    assert send_queue.sent == []
    stream.add(at(1))
    stream.flush()
    send_queue.open = False
    for time in (2, 3, 4):
        stream.add(at(time))
    stream.flush()
    send_queue.open = True
    stream.add(at(5))
    stream.flush()
    assert send_queue.sent == [StreamedRecords((at(1),), 0), StreamedRecords((at(5),), 3)]


@pytest.fixture
def flight():
    with LiveFlight(stream=True) as flight:
        flight.wait(ENOUGH)
        flight.pause().result(ENOUGH)
        yield flight


def test_every_sample_comes_once_and_in_order(flight):
    before = flight.streamed()
    flight.fly_on(2.0).result(ENOUGH)
    flight.reset().result(ENOUGH)  # what was published before its answer is there
    times = np.array([each.t_ns for each in (*before, *flight.streamed())])
    flown = times[: int(np.argmax(np.diff(times, append=-1) < 0)) + 1]
    assert np.all(np.diff(flown) > 0)
    assert flown[-1] - flown[0] >= 1.99e9
    assert np.ptp(np.diff(flown)) <= 2  # rounded to whole nanoseconds
    assert flight.missed == 0


def test_what_nobody_takes_is_counted(monkeypatch):
    monkeypatch.setattr("workbench.live.flight.MAX_STREAMED_SAMPLES", 200)
    with LiveFlight(stream=True) as flight:
        flight.wait(ENOUGH)
        flight.pause().result(ENOUGH)
        flight.fly_on(2.0).result(ENOUGH)
        taken = flight.streamed()
        assert len(taken) == 200
        assert flight.missed > 0
        missed = flight.missed
        flight.fly_on(1.0).result(ENOUGH)
        assert flight.missed == missed
