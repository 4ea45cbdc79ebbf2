import threading

import pytest

from workbench.link.drone_topics import drone_topics
from workbench.link.sample import MAX_QUEUE_AGE_S, MAX_QUEUED_SAMPLES, Sample, SampleQueue
from workbench.link.signal import TopicOptions

TOPICS = {
    topic.name.rsplit("/", 1)[1]: topic for topic in drone_topics(TopicOptions(4, 200.0, 10.0))
}
STATES = [TOPICS[name] for name in ("time_data", "position_data", "velocity_data", "rotors")]


class Clock:
    def __init__(self):
        self.now = 100.0

    def __call__(self):
        return self.now


def sample(topic, number):
    return Sample(topic, number, bytes(topic.packer.size))


def burst(number):
    return [sample(topic, number) for topic in STATES]


@pytest.fixture
def clock():
    return Clock()


def test_a_reader_who_keeps_up_gets_all_in_the_order_of_arrival(clock):
    queue = SampleQueue(clock)
    expected = []
    for number in range(200):
        queue.put(burst(number))
        expected += [(topic.name, number) for topic in STATES]
        clock.now += 0.005
        if number % 20 == 19:  # looks up ten times a second
            while taken := queue.take():
                assert (taken.topic, taken.t_ns) == expected.pop(0)
    assert not expected
    assert queue.dropped == 0


def test_a_slow_reader_gets_what_is_new_and_each_topic_as_often(clock):
    queue = SampleQueue(clock)
    seen = {topic.name: [] for topic in STATES}
    for number in range(4000):  # 20 s of bursts, 10 samples read a second of 800
        queue.put(burst(number))
        clock.now += 0.005
        if number % 20 == 19:
            taken = queue.take()
            seen[taken.topic].append(taken.t_ns)
            assert (number - taken.t_ns) * 0.005 <= MAX_QUEUE_AGE_S + 0.005
    assert {len(numbers) for numbers in seen.values()} == {50}
    assert all(numbers == sorted(numbers) for numbers in seen.values())
    waiting = 0
    while queue.take():
        waiting += 1
    assert queue.dropped == 4 * 4000 - 200 - waiting
    assert waiting <= 4 * (MAX_QUEUE_AGE_S / 0.005 + 2)


def test_the_newest_stays_however_old_it_is(clock):
    queue = SampleQueue(clock)
    queue.put(burst(1))
    clock.now += 3600.0
    assert queue.take().t_ns == 1
    assert queue.dropped == 0


def test_events_do_not_age_but_are_bounded(clock):
    queue = SampleQueue(clock)
    for number in range(10):
        queue.put([sample(TOPICS["events"], number)])
        clock.now += 1.0
    assert [queue.take().t_ns for _ in range(10)] == list(range(10))
    queue.put([sample(TOPICS["events"], number) for number in range(MAX_QUEUED_SAMPLES + 5)])
    assert queue.take().t_ns == 5
    assert queue.dropped == 5


def test_the_newest_of_a_topic_is_there_read_or_not(clock):
    queue = SampleQueue(clock)
    assert queue.newest(STATES[0].name) is None
    queue.put(burst(1) + burst(2))
    queue.take()
    assert queue.newest(STATES[0].name).t_ns == 2


def test_waiting_ends_with_a_sample_or_with_the_queue():
    queue = SampleQueue()
    taken = []

    def read():
        while (got := queue.wait()) is not None:
            taken.append(got.t_ns)

    reader = threading.Thread(target=read)
    reader.start()
    queue.put([sample(STATES[0], 7)])
    queue.put([sample(STATES[0], 8)])
    queue.close()
    reader.join(20.0)
    assert not reader.is_alive()
    assert taken == [7, 8]
