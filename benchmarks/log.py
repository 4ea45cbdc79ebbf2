"""The cost of a log: processor time to write and read a second of flight, and its size on disk.

Samples are flown first and written afterwards, in turns, so that only the log is measured. Times
are processor times of one thread, except the longest write, which is wall-clock time and includes
the compression of a chunk. The last row's messages are those of the first, without the exact
states, written by the packages mcap and mcap-ros2-support alone.
"""

import time
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

from mcap.reader import make_reader
from mcap.records import Schema
from mcap_ros2.decoder import DecoderFactory
from mcap_ros2.writer import Writer
from spread import Spread, number, spread, text

from workbench.link.backplane import Sampled
from workbench.link.ros_messages.conversion import Conversion, conversion
from workbench.link.ros_messages.library import schema_text
from workbench.link.topics import Topic
from workbench.logs.flight_log import FlightLog
from workbench.logs.mcap_writer import MCAP_CHUNK_BYTES
from workbench.logs.readers.mcap_log import read_mcap
from workbench.scenario.scenario import Action, Scenario, SensorsConfig
from workbench.session.session import Session
from workbench.systems.bridge import Bridge

FLIGHT = 4.0
"""Flown for each row [s]."""
TURNS = 9
KINDS = {
    "no sensors": [],
    "imu, gps": ["imu", "gps"],
    "imu, gps, lidar": ["imu", "gps", "lidar"],
}


@dataclass(frozen=True)
class LogRow:
    """A log of a drone with some sensors.

    Attributes:
        sensors: sensors of the flight.
        messages: messages a simulated second.
        writing: share of a core in real time [%].
        longest: longest time to write a sample [ms].
        reading: time to read a second of flight [ms].
        size: size on disk [kB/s].
    """

    sensors: str
    messages: float
    writing: Spread
    longest: Spread
    reading: Spread
    size: float


@dataclass(frozen=True)
class Flown:
    """What a log is written of."""

    scenario: Scenario
    vehicle: str
    topics: tuple[Topic, ...]
    samples: list[Sampled]


def measure(turns: int = TURNS) -> list[LogRow]:
    """Return a row for each kind of drone, and one for the packages."""
    with TemporaryDirectory() as folder:
        path = Path(folder) / "flight.mcap"
        rows = [_row(name, use, path, turns) for name, use in KINDS.items()]
        return [*rows, _row_of_packages(path, turns)]


def show(rows: list[LogRow]) -> None:
    """Print the table."""
    print("log of            messages/s   % of a core              longest write [ms]")
    for row in rows:
        print(
            f"{row.sensors:17} {row.messages:10,.0f}   {text(row.writing):24} {text(row.longest)}"
        )
    print("\nlog of            kB/s   reading a second of flight [ms]")
    for row in rows:
        print(f"{row.sensors:17} {number(row.size):>5}  {text(row.reading)}")


def _row(name: str, use: list[str], path: Path, turns: int) -> LogRow:
    flown = _fly(use)
    writing, longest, reading = [], [], []
    for turn in range(turns + 1):
        spent, slowest = _write(flown, path)
        begun = time.process_time()
        record = read_mcap(path)
        if turn:  # the first one warms up
            writing.append(100.0 * spent / FLIGHT)
            longest.append(1e3 * slowest)
            reading.append(1e3 * (time.process_time() - begun) / FLIGHT)
    count = sum(len(topic.t_ns) for topic in record.topics.values())
    size = path.stat().st_size / 1e3 / FLIGHT
    spreads = map(spread, (writing, longest, reading))
    return LogRow(name, count / FLIGHT, *spreads, size)


def _row_of_packages(path: Path, turns: int) -> LogRow:
    flown = _fly([])
    writing, longest, reading = [], [], []
    for turn in range(turns + 1):
        spent, slowest = _write_by_packages(flown, path)
        begun = time.process_time()
        with path.open("rb") as file:
            count = sum(
                1
                for _ in make_reader(
                    file, decoder_factories=[DecoderFactory()]
                ).iter_decoded_messages()
            )
        if turn:
            writing.append(100.0 * spent / FLIGHT)
            longest.append(1e3 * slowest)
            reading.append(1e3 * (time.process_time() - begun) / FLIGHT)
    spreads = map(spread, (writing, longest, reading))
    return LogRow("by packages", count / FLIGHT, *spreads, path.stat().st_size / 1e3 / FLIGHT)


def _fly(use: list[str]) -> Flown:
    scenario = Scenario(
        world="obstacle_field",
        sensors=SensorsConfig(use=use),
        duration=FLIGHT,
        script=[Action(0.5, velocity=[1.0, 0.5, 0.2], yaw_rate=0.2)],
    )
    session = Session(scenario, bridge=Bridge())
    session.run()
    return Flown(scenario, session.vehicle.name, session.topics, session.drain())


def _write(flown: Flown, path: Path) -> tuple[float, float]:
    """Write a log; return the processor time of all and the wall time of the longest sample [s]."""
    log = FlightLog(path, flown.topics, flown.scenario, {}, {}, flown.vehicle)
    slowest, begun = 0.0, time.process_time()
    for sampled in flown.samples:
        before = time.perf_counter()
        log.write(sampled)
        slowest = max(slowest, time.perf_counter() - before)
    log.close()
    return time.process_time() - begun, slowest


def _write_by_packages(flown: Flown, path: Path) -> tuple[float, float]:
    """Write the messages by mcap and mcap-ros2-support alone; return the same as `_write`."""
    slowest, begun = 0.0, time.process_time()
    with path.open("wb") as file:
        writer = Writer(file, chunk_size=MCAP_CHUNK_BYTES)
        topics = {
            topic.id: (becomes := conversion(topic), _schemas(writer, becomes))
            for topic in flown.topics
        }
        for sampled in flown.samples:
            before = time.perf_counter()
            t_ns, wall_ns = sampled.published.t_ns, sampled.published.wall_ns
            for number, payload in sampled.published.payloads:
                becomes, schemas = topics[number]
                values = becomes.read(payload)
                for (channel, make), schema in zip(becomes.made, schemas, strict=True):
                    message = make(t_ns, values)
                    writer.write_message(channel.topic, schema, message, t_ns, wall_ns)
            slowest = max(slowest, time.perf_counter() - before)
        writer.finish()
    return time.process_time() - begun, slowest


def _schemas(writer: Writer, becomes: Conversion) -> list[Schema]:
    types = [channel.type for channel, _ in becomes.made]
    return [writer.register_msgdef(each, schema_text(each)) for each in types]


if __name__ == "__main__":
    show(measure())
