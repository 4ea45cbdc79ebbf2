"""Frames come out as they went in, however the bytes are cut, and nothing else comes out."""

import contextlib
import importlib.util
import itertools
import random
from pathlib import Path

import pytest

from workbench.link.wire import (
    FRAME_HEADER,
    MAX_PAYLOAD_BYTES,
    Decoder,
    FrameFlag,
    FrameKind,
    WireError,
    WireFrame,
)

ROOT = Path(__file__).resolve().parents[2]
FRAMES = [
    WireFrame(FrameKind.CONTROL, 0, 0, 1, 0, b'{"op":"ping"}'),
    WireFrame(FrameKind.DATA, 8, FrameFlag.ACKNOWLEDGE, 2, -5, bytes(range(24))),
    WireFrame(FrameKind.ACKNOWLEDGEMENT, 0, 0, 2, 0, b""),
]
STREAM = b"".join(frame.to_bytes() for frame in FRAMES)


def decoded(*pieces):
    decoder = Decoder()
    return [frame for piece in pieces for frame in decoder.feed(piece)]


@pytest.fixture(scope="module")
def fuzz():
    spec = importlib.util.spec_from_file_location("link_fuzz", ROOT / "benchmarks/link_fuzz.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module.fuzz


def test_the_header_is_24_bytes():
    assert FRAME_HEADER.size == 24
    assert len(STREAM) == 3 * 24 + 13 + 24


def test_every_two_cuts_of_three_frames():
    for one, two in itertools.combinations_with_replacement(range(len(STREAM) + 1), 2):
        assert decoded(STREAM[:one], STREAM[one:two], STREAM[two:]) == FRAMES


def test_one_byte_at_a_time():
    assert decoded(*(bytes([byte]) for byte in STREAM)) == FRAMES


def test_a_stream_cut_short_gives_the_frames_that_are_whole():
    ends = list(itertools.accumulate(len(frame.to_bytes()) for frame in FRAMES))
    for size in range(len(STREAM)):
        decoder = Decoder()
        whole = sum(end <= size for end in ends)
        assert list(decoder.feed(STREAM[:size])) == FRAMES[:whole]
        assert decoder.waiting == size - (ends[whole - 1] if whole else 0)


def test_frames_before_a_broken_one_arrive_at_every_cut():
    stream = STREAM + b"DH\x07" + bytes(21)
    for cut in range(len(stream) + 1):
        found, decoder = [], Decoder()
        with pytest.raises(WireError, match="version 7") as error:
            for piece in (stream[:cut], stream[cut:]):
                for frame in decoder.feed(piece):
                    found.append(frame)
        assert (found, error.value.code) == (FRAMES, "version")


def test_a_wrong_beginning_is_refused_before_the_header_is_whole():
    with pytest.raises(WireError, match=r"begins with b'GE'"):
        decoded(b"GET")
    with pytest.raises(WireError):
        decoded(STREAM, b"x")
    assert decoded(b"D") == []


def test_bytes_are_taken_even_if_nobody_asks_for_the_frames():
    decoder = Decoder()
    decoder.feed(STREAM[:30])
    assert list(decoder.feed(STREAM[30:])) == FRAMES


def test_frames_that_were_not_fetched_come_with_the_next_bytes():
    decoder = Decoder()
    first = decoder.feed(STREAM)
    assert next(first) == FRAMES[0]
    assert list(decoder.feed(b"")) == FRAMES[1:]
    assert list(first) == []
    del first
    assert list(decoder.feed(STREAM)) == FRAMES


def test_a_larger_limit_counts_from_the_next_frame_on():
    big = WireFrame(FrameKind.CONTROL, 0, 0, 1, 0, b" " * 5000)
    decoder, found = Decoder(largest=4096), []
    for frame in decoder.feed(FRAMES[0].to_bytes() + big.to_bytes()):
        found.append(frame)
        decoder.largest = MAX_PAYLOAD_BYTES
    assert found == [FRAMES[0], big]


def test_too_long_a_frame_is_not_waited_for():
    decoder = Decoder(largest=100)
    head = WireFrame(FrameKind.DATA, 1, 0, 1, 0, b"x" * 101).to_bytes()[:24]
    with pytest.raises(WireError) as error:
        list(decoder.feed(head))
    assert error.value.code == "length"
    assert decoder.waiting == 24


def test_an_operation_has_a_limit_of_its_own_that_data_do_not_have():
    sizes = {FrameKind.CONTROL: 0, FrameKind.DATA: 0}
    for kind in sizes:
        for size in (10, 11, 100):
            decoder = Decoder(largest=100, largest_operation=10)
            data = WireFrame(kind, 1, 0, 1, 0, b"x" * size).to_bytes()
            with contextlib.suppress(WireError):
                sizes[kind] = len(next(decoder.feed(data)).payload)
    assert sizes == {FrameKind.CONTROL: 10, FrameKind.DATA: 100}


def test_a_frame_that_nobody_would_take_is_not_made():
    with pytest.raises(WireError, match="65537 bytes after a header are too many"):
        WireFrame(FrameKind.DATA, 1, 0, 1, 0, b"x" * (MAX_PAYLOAD_BYTES + 1)).to_bytes()


@pytest.mark.parametrize("step", [1, 10])
def test_work_grows_with_the_bytes_and_not_with_their_square(step, monkeypatch):
    """Counted, not timed: header reads per feed, whatever waits."""
    looks = 0
    real = Decoder._next_end

    def counted(self):
        nonlocal looks
        looks += 1
        return real(self)

    monkeypatch.setattr(Decoder, "_next_end", counted)
    stream = WireFrame(FrameKind.DATA, 1, 0, 1, 0, b"x" * MAX_PAYLOAD_BYTES).to_bytes() * 4
    assert len(decoded(*(stream[i : i + step] for i in range(0, len(stream), step)))) == 4
    assert looks < 4 * 30
    looks = 0
    assert len(decoded(FRAMES[0].to_bytes() * 1000)) == 1000
    assert looks <= 1001


def test_a_thousand_random_cuts():
    chance = random.Random(3)
    stream = STREAM * 20
    for _ in range(1000):
        cuts = sorted(chance.randrange(len(stream)) for _ in range(chance.randrange(12)))
        pieces = [stream[i:j] for i, j in zip([0, *cuts], [*cuts, len(stream)], strict=True)]
        assert decoded(*pieces) == FRAMES * 20


def test_mutated_streams_are_refused_and_never_crash(fuzz):
    tally = fuzz(20_000, seed=11)
    assert tally.streams == 20_000
    assert {"magic", "version", "kind", "length", "json", "bad_value"} <= set(tally.refused)
    assert tally.refused["unknown_op"] and tally.refused["bad_size"]
    assert tally.understood > 1000
    assert tally.most_waiting < 24 + 4096
