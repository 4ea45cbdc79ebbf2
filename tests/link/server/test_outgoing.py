import struct

import pytest

from workbench.link.backplane import Published
from workbench.link.drone_topics import EVENTS_SIGNAL, drone_topics
from workbench.link.server.outgoing import MAX_QUEUED_ANSWERS, Outgoing, SampleBuffer, data_frames
from workbench.link.signal import TopicOptions
from workbench.link.wire import FRAME_HEADER, FrameFlag, FrameKind

PERIOD = 1.0 / 204.8
EIGHT = (1, 2, 3, 4, 5, 6, 7, 8)


def topics(numbers):
    found = {
        topic.id: topic
        for topic in drone_topics(TopicOptions(4, 204.8, 204.8, rates={"imu": 204.8, "gps": 204.8}))
    }
    return [found[number] for number in numbers]


def split(data):
    """Return (kind, topic, flags, seq, t_ns) of frames, decoded by hand."""
    found = []
    while data:
        _, _, kind, topic, flags, seq, length, t_ns = FRAME_HEADER.unpack_from(data)
        assert len(data) >= 24 + length
        found.append((kind, topic, flags, seq, t_ns))
        data = data[24 + length :]
    return found


class Reader:
    """A client that reads so many frames a second, told the time."""

    def __init__(self, rate):
        self.period = 1.0 / rate
        self.waiting = []
        self.free = 0.0
        self.ages = []
        self.got = []

    def read(self, now):
        """Return the frames to acknowledge that it has read until now."""
        acknowledged = []
        while self.waiting and self.free <= now:
            arrived, (_, topic, flags, seq, t_ns) = self.waiting[0]
            begun = max(self.free, arrived)
            if begun > now:
                break
            self.waiting.pop(0)
            self.free = begun + self.period
            self.ages.append((begun, begun - 1e-9 * t_ns))
            self.got.append((topic, t_ns))
            if flags & FrameFlag.ACKNOWLEDGE:
                acknowledged.append(seq)
        return acknowledged


def publish(out, published):
    out.publish(published.t_ns, data_frames(published))


def run(parts, reader, seconds, numbers=EIGHT, burst=1, rate=None, paused=(0.0, 0.0)):
    """Fly so long for one reader; return what went to it."""
    out = Outgoing()
    out.subscribe(topics(numbers), rate)
    step, now = 0, 0.0
    tick = min(0.1 * reader.period, 1e-3) * 4
    while now < seconds:
        now += tick
        while (step + burst) * PERIOD < now:
            for _ in range(burst):
                step += 1
                publish(out, parts.published(step, numbers))
        if not paused[0] < now < paused[1]:
            for seq in reader.read(now):
                out.acknowledge(seq, now)
        while data := out.take(now):
            reader.waiting += [(now, frame) for frame in split(data) if frame[0] == FrameKind.DATA]
    return out


@pytest.mark.parametrize("numbers", [EIGHT, (1, 2), (*EIGHT, 9, 10, 14, 15)])
@pytest.mark.parametrize("burst", [1, 4])
@pytest.mark.parametrize("rate", [20.0, 30.0, 100.0])
def test_no_slow_client_reads_anything_older_than_a_second(parts, rate, numbers, burst):
    reader = Reader(rate)
    run(parts, reader, 30.0, numbers, burst)
    assert len(reader.ages) > 27.5 * rate
    assert max(age for _, age in reader.ages) <= 1.0


def test_a_slow_client_gets_all_topics_in_turn(parts):
    reader = Reader(20.0)
    numbers = (*EIGHT, 9, 10, 14, 15)
    run(parts, reader, 30.0, numbers)
    counts = [sum(topic == each for topic, _ in reader.got) for each in numbers]
    assert max(counts) - min(counts) <= 3


@pytest.mark.parametrize("burst", [1, 3, 7])
def test_a_fast_client_gets_every_sample_in_order(parts, burst):
    reader = Reader(20_000.0)
    out = run(parts, reader, 5.0, EIGHT, burst)
    assert out.dropped == 8 * (burst - 1), "of the first burst, as its pace is unknown then"
    assert len(reader.got) > 1000 * 8
    for topic in EIGHT:
        times = [t_ns for each, t_ns in reader.got if each == topic]
        steps = {round(1e-9 * (b - a) / PERIOD) for a, b in zip(times, times[1:], strict=False)}
        assert steps == {1}


def test_a_fast_client_that_pauses_for_a_fifth_of_a_second_misses_nothing(parts):
    reader = Reader(20_000.0)
    out = run(parts, reader, 4.0, paused=(2.0, 2.2))
    assert out.dropped == 0
    assert len(reader.got) > 815 * 8


def test_no_more_than_two_batches_are_on_their_way(parts):
    out = Outgoing()
    out.subscribe(topics(EIGHT), None)
    sent = []
    for step in range(1, 50):
        publish(out, parts.published(step, EIGHT))
        sent += split(out.take(step * PERIOD))
    assert sum(bool(flags & FrameFlag.ACKNOWLEDGE) for _, _, flags, _, _ in sent) == 2
    assert len(sent) == 16


def test_after_an_acknowledgement_the_newest_samples_come(parts):
    out = Outgoing()
    out.subscribe(topics(EIGHT), None)
    sent = []
    for step in range(1, 50):
        publish(out, parts.published(step, EIGHT))
        sent += split(out.take(step * PERIOD))
    out.acknowledge(sent[7][3], 50 * PERIOD)
    batch = split(out.take(50 * PERIOD))
    assert sorted(topic for _, topic, _, _, _ in batch) == list(EIGHT)
    assert {t_ns for *_, t_ns in batch} == {round(49 * 1e9 / 204.8)}
    assert out.dropped == 8 * 46


def test_answers_come_though_nothing_is_acknowledged(parts):
    out = Outgoing()
    out.subscribe(topics(EIGHT), None)
    for step in range(1, 5):
        publish(out, parts.published(step, EIGHT))
        out.take(step * PERIOD)
    out.answer(b"{}")
    assert [kind for kind, *_ in split(out.take(1.0))] == [FrameKind.CONTROL]


@pytest.mark.parametrize("seq", [0, 17, 2**32 - 1])
def test_an_acknowledgement_of_what_was_not_sent_counts_for_nothing(parts, seq):
    out = Outgoing()
    out.subscribe(topics(EIGHT), None)
    publish(out, parts.published(1, EIGHT))
    out.take(0.0)
    assert not out.acknowledge(seq, 0.0)
    assert out.acknowledge(8, 0.0)
    assert not out.acknowledge(8, 0.0)


def test_silence_counts_from_the_oldest_batch_that_waits(parts):
    out = Outgoing()
    out.subscribe(topics(EIGHT), None)
    assert out.silence(1000.0) == 0.0
    publish(out, parts.published(1, EIGHT))
    out.take(10.0)
    publish(out, parts.published(2, EIGHT))
    out.take(11.0)
    assert out.silence(13.0) == 3.0
    out.acknowledge(8, 13.0)
    assert out.silence(14.0) == 1.0
    out.acknowledge(16, 14.0)
    assert out.silence(99.0) == 0.0


def test_events_are_never_dropped_but_the_64_that_wait_are_the_most(parts):
    out = Outgoing()
    out.subscribe(topics([EVENTS_SIGNAL.id]), None)
    sent = []
    for step in range(1, MAX_QUEUED_ANSWERS + 3):  # two go at once, in a batch each
        publish(out, parts.published(step, [EVENTS_SIGNAL.id]))
        sent += split(out.take(0.0))
    assert len(sent) == 2
    assert not out.overflowed
    publish(out, parts.published(99, [EVENTS_SIGNAL.id]))
    assert out.overflowed


def test_the_rate_that_a_client_asks_for_is_that_of_each_topic(parts):
    reader = Reader(20_000.0)
    out = run(parts, reader, 4.0, EIGHT, rate=20.0)
    for topic in EIGHT:
        assert 74 <= sum(each == topic for each, _ in reader.got) <= 81
    assert out.dropped == 0, "what nobody asked for is not lost"


def test_a_flight_that_begins_anew_goes_on_at_a_rate(parts):
    buffer = SampleBuffer(topics([1]), 20.0)
    for t_ns in (5_000_000_000, 5_010_000_000, 0, 10_000_000, 50_000_000):
        buffer.add(*data_frames(Published(t_ns, 0, ((1, b""),))))
    assert [sample.t_ns for sample in buffer.take(9)] == [5_000_000_000, 0, 50_000_000]


def test_in_a_long_batch_frames_between_ask_for_an_acknowledgement_too(parts):
    out = Outgoing()
    out.subscribe(topics([*EIGHT, EVENTS_SIGNAL.id]), None)
    for step in range(1, 61):
        publish(out, parts.published(step, [EVENTS_SIGNAL.id]))
    frames = split(out.take(0.0))
    assert [index for index, frame in enumerate(frames) if frame[2] & 2] == [27, 59]


def test_frames_are_numbered_one_after_the_other(parts):
    out = Outgoing()
    out.answer(b"{}")
    out.subscribe(topics(EIGHT), None)
    publish(out, parts.published(1, EIGHT))
    data = out.take(0.0) + out.last(b"{}")
    assert [frame[3] for frame in split(data)] == list(range(1, 11))
    assert struct.unpack_from("<2sB", data) == (b"DH", 1)


def test_the_age_is_that_of_the_newest_sample_that_was_acknowledged(parts):
    out = Outgoing()
    out.subscribe(topics(EIGHT), None)
    publish(out, parts.published(1, EIGHT, wall_ns=111))
    out.take(0.0)
    publish(out, parts.published(2, EIGHT, wall_ns=222))
    out.take(0.0)
    assert out.acknowledged_ns == 0
    out.acknowledge(8, 0.0)
    assert out.acknowledged_ns == 111
