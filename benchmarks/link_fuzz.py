"""Mutated streams through all that reads the network's bytes: `python benchmarks/link_fuzz.py`.

Half of the streams have valid framing around a broken payload, so that the readers behind the
decoder are reached; the others are broken anywhere. Only the refusals that the readers promise are
caught: anything else ends the run with the stream that did it. A million take some minutes.
"""

import random
import resource
import sys
import time
from collections import Counter
from dataclasses import dataclass, field, replace

from workbench.link.codes import DeniedError
from workbench.link.drone_topics import drone_topics
from workbench.link.hello import Hello, ServerLimits
from workbench.link.message_json import read_message, read_operation, write_message, write_operation
from workbench.link.messages import (
    Bye,
    Error,
    FlightOperation,
    GetParameters,
    Login,
    Nack,
    Ping,
    Pong,
    ReleaseControl,
    RequestControl,
    Role,
    SetParameters,
    Subscribe,
)
from workbench.link.signal import TopicOptions
from workbench.link.topics import Topic
from workbench.link.wire import FRAME_HEADER, Decoder, FrameFlag, FrameKind, WireError, WireFrame

STREAMS = 1_000_000
WARM_UP = 2_000
"""Streams after which memory is first looked at."""
LARGEST = 4096
SPITE = (
    b"NaN",
    b"-Infinity",
    b"1e999",
    b"9" * 40,
    b"[" * 300,
    b'{"a":' * 300,
    b'"\\ud800"',
    b'"' + b"x" * 300 + b'"',
    b"true",
    b"null",
    b"-0.0",
    b"{}",
    b"[[]]",
    b"\xff\xfe",
    b'"op":"ping",',
    b"\\",
    b'"',
    b"5e-324",
)
"""What stands in place of a piece of JSON."""


@dataclass
class Tally:
    """What became of the streams.

    Attributes:
        streams: how many.
        frames: that the decoder let through.
        understood: by the readers of operations, answers and topics.
        refused: how often, by code.
        most_waiting: bytes that a decoder held back at most.
    """

    streams: int = 0
    frames: int = 0
    understood: int = 0
    refused: Counter[str] = field(default_factory=Counter)
    most_waiting: int = 0


class Readers:
    """All that reads what the network brings."""

    def __init__(self, topics: tuple[Topic, ...]) -> None:
        self.tally = Tally()
        self._topics = {topic.id: topic for topic in topics}

    def read(self, stream: bytes, chance: random.Random) -> None:
        """Feed a stream in pieces, and read each frame in it."""
        decoder = Decoder(LARGEST)
        self.tally.streams += 1
        cuts = sorted(chance.randrange(len(stream) + 1) for _ in range(chance.randrange(4)))
        try:
            for begin, end in zip([0, *cuts], [*cuts, len(stream)], strict=True):
                for frame in decoder.feed(stream[begin:end]):
                    self.tally.frames += 1
                    self._read_frame(frame)
                self.tally.most_waiting = max(self.tally.most_waiting, decoder.waiting)
        except WireError as error:
            self.tally.refused[error.code] += 1

    def _read_frame(self, frame: WireFrame) -> None:
        if frame.kind == FrameKind.CONTROL:
            for read in (read_operation, read_message):
                try:
                    self.tally.understood += read(frame.payload) is not None
                except DeniedError as error:
                    self.tally.refused[error.code] += 1
        elif frame.kind == FrameKind.DATA and frame.topic in self._topics:
            try:
                self._topics[frame.topic].unpack(frame.payload)
                self.tally.understood += 1
            except ValueError:
                self.tally.refused["bad_size"] += 1


def fuzz(streams: int, seed: int) -> Tally:
    """Read so many mutated streams.

    Args:
        streams: how many.
        seed: of the random numbers; the same seed, the same streams.
    """
    chance = random.Random(seed)
    topics = drone_topics(
        TopicOptions(
            4,
            200.0,
            8.0,
            rates={"imu": 200.0, "gps": 10.0, "lidar": 10.0},
            rays=16,
            scan={},
            frames=[("W", "B")],
        )
    )
    frames, readers = _seeds(topics), Readers(topics)
    for number in range(streams):
        if number % 2:
            chosen = [_broken_inside(chance.choice(frames), chance) for _ in range(2)]
            stream = b"".join(chosen)
        else:
            stream = b"".join(chance.choice(frames).to_bytes() for _ in range(2))
            stream = _mutated(stream, chance)
        try:
            readers.read(stream, chance)
        except Exception as error:
            error.add_note(f"stream {number} of seed {seed}: {stream.hex()}")
            raise
    return readers.tally


def _seeds(topics: tuple[Topic, ...]) -> list[WireFrame]:
    """Return a frame of each sort that may come."""
    hello = Hello(
        "s",
        "0f",
        1,
        "drone",
        "0" * 32,
        True,
        ServerLimits(8.0, 3.0, 0.4),
        (topics[7],),
        parameters=(),
    )
    said = [Pong(1, 2), Nack("held", "no", 3), Error("slow", "too slow"), hello]
    operations = [
        Login(1, "zoë", Role.COMMAND, "0f" * 16),
        Login(1, "older", Role.COMMAND, nonce="0f" * 16, proof="a5" * 32),
        Subscribe(2, ("*",), 20.0),
        RequestControl(3),
        ReleaseControl(4, 99),
        FlightOperation(5, "take_off", 2.0, 99),
        GetParameters(6, ("a", "b")),
        SetParameters(7, {"a": 1.5}, 99),
        Ping(8),
        Bye(9),
    ]
    payloads = [write_message(each) for each in said] + [
        write_operation(each) for each in operations
    ]
    frames = [WireFrame(FrameKind.CONTROL, 0, 0, 1, 0, payload) for payload in payloads]
    frames += [WireFrame(FrameKind.DATA, t.id, 2, 1, 5, bytes(t.packer.size)) for t in topics]
    frames += [
        WireFrame(FrameKind.DATA, 8, FrameFlag.PROOF, 1, 5, bytes(24 + 16)),
        WireFrame(FrameKind.ACKNOWLEDGEMENT, 0, 0, 7, 0, b""),
        WireFrame(200, 0, 0, 7, 0, b"later"),
    ]
    return frames


def _broken_inside(frame: WireFrame, chance: random.Random) -> bytes:
    """Return a frame with a broken payload, and a header that tells its length."""
    payload = frame.payload
    if frame.kind == FrameKind.CONTROL and chance.random() < 0.5:
        begin = chance.randrange(len(payload))
        end = min(len(payload), begin + chance.randrange(12))
        payload = payload[:begin] + chance.choice(SPITE) + payload[end:]
    else:
        payload = _mutated(payload, chance)
    return replace(frame, payload=payload[:LARGEST]).to_bytes()


def _mutated(data: bytes, chance: random.Random) -> bytes:
    """Return bytes with one to four faults."""
    found = bytearray(data)
    for _ in range(chance.randrange(1, 5)):
        where = chance.randrange(len(found) + 1)
        match chance.randrange(6):
            case 0 if where < len(found):
                found[where] ^= 1 << chance.randrange(8)
            case 1 if where < len(found):
                found[where] = chance.choice((0, 1, 127, 128, 255))
            case 2:
                del found[where : where + chance.randrange(1, 40)]
            case 3:
                found[where:where] = chance.randbytes(chance.randrange(1, 9))
            case 4:
                found[where:where] = found[where : where + chance.randrange(1, 60)]
            case 5 if len(found) >= FRAME_HEADER.size:  # a number of the header, of any size
                place = chance.choice((2, 3, 4, 6, 8, 12, 16))
                size = {2: 1, 3: 1, 4: 2, 6: 2, 16: 8}.get(place, 4)
                found[place : place + size] = chance.randbytes(size)
    return bytes(found)


def main() -> None:
    """Read the streams, and print what became of them."""
    streams = int(sys.argv[1]) if len(sys.argv) > 1 else STREAMS
    fuzz(WARM_UP, seed=1)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    begin = time.perf_counter()
    tally = fuzz(streams, seed=2)
    took = time.perf_counter() - begin
    grown = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before
    print(f"{tally.streams:,} streams in {took:.0f} s, {took / streams * 1e6:.0f} us each")
    print(f"{tally.frames:,} frames, understood {tally.understood:,} times")
    for code, count in tally.refused.most_common():
        print(f"  refused as {code}: {count:,}")
    print(f"most bytes held back: {tally.most_waiting:,}; peak memory grew by {grown:,} kB")


if __name__ == "__main__":
    main()
