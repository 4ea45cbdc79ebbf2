"""The other side is a real Connection, or one end of its socket where bytes are to be cut."""

import pickle
import socket
import struct
from multiprocessing import Pipe

import pytest

from workbench.ipc.channel import RecordChannel

MOST = 1_000_000


@pytest.fixture
def pipe():
    here, there = Pipe()
    yield here, there
    here.close()
    there.close()


@pytest.fixture
def channel(pipe):
    channel = RecordChannel(pipe[0])
    yield channel
    channel.close()


def framed(record) -> bytes:
    data = pickle.dumps(record)
    return struct.pack("!i", len(data)) + data


def test_records_arrive_in_their_order(pipe, channel):
    for number in range(100):
        assert channel.offer(number, MOST)
    assert [pipe[1].recv() for _ in range(100)] == list(range(100))
    for number in range(100):
        pipe[1].send(number)
    assert list(channel.received(60)) == list(range(60))
    assert channel.has_more
    assert list(channel.received(60)) == list(range(60, 100))
    assert list(channel.received(60)) == []
    assert not channel.has_more


def test_what_nobody_reads_is_bounded_and_never_waits(pipe, channel):
    """The system's buffer takes some, the channel its bound, and no more."""
    taken = sum(channel.offer(bytes(10_000), MOST) for _ in range(1000))
    assert MOST // 10_000 <= taken < 1000
    assert 0 < channel.unsent <= MOST
    first = 0
    while first < taken:
        assert pipe[1].recv() == bytes(10_000)
        channel.flush()
        first += 1
    assert channel.offer("and on it goes", MOST)
    assert pipe[1].recv() == "and on it goes"


def test_nothing_waits_for_a_process_that_is_gone(pipe, channel):
    """Whoever ends it waits until all is sent, and would wait for ever."""
    while not channel.unsent:
        channel.offer(bytes(10_000), MOST)
    pipe[1].close()
    channel.flush()
    assert channel.unsent == 0
    assert channel.offer(bytes(10_000), MOST)
    assert channel.unsent == 0


def test_a_record_in_pieces_is_seen_when_it_is_whole(pipe, channel):
    """A process that is stopped in the middle of a record stops nobody else."""
    there = socket.socket(fileno=socket.dup(pipe[1].fileno()))
    data = framed("one") + framed({"two": 2})
    for index in range(len(data) - 1):
        there.sendall(data[index : index + 1])
        seen = list(channel.received(10))
        assert seen == (["one"] if index == len(framed("one")) - 1 else [])
    there.sendall(data[-1:])
    assert list(channel.received(10)) == [{"two": 2}]
    there.close()


def test_the_last_words_are_heard_before_the_end(pipe, channel):
    pipe[1].send("farewell")
    pipe[1].close()
    heard = channel.received(10)
    assert next(heard) == "farewell"
    with pytest.raises(EOFError):
        list(channel.received(10))
    channel.offer("to nobody", MOST)  # and no harm is done


def test_a_large_record_comes_in_several_reads(pipe, channel):
    """Half a megabyte fits into no buffer: who sends it waits, who reads does not."""
    import threading

    sender = threading.Thread(target=pipe[1].send, args=(bytes(500_000),))
    sender.start()
    found: list[object] = []
    while not found:
        found = list(channel.received(10))
    sender.join()
    assert found == [bytes(500_000)]
