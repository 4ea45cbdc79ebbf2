"""The gateway beside a program against Fast DDS, whose library nothing of ours is made of.

The drone's server is scripted, and a flight in the last test. The program (fastdds/peer.cpp) has
its own messages, by hand.
"""

import ctypes.util
import os
import shutil
import signal
import subprocess
import sys
import threading
import time
from contextlib import contextmanager
from pathlib import Path

import pytest

pytest.importorskip("cyclonedds", reason="install the extra `ros2` to try it")

from workbench.link.drone_topics import drone_topics
from workbench.link.messages import FlightOperation, ReleaseControl
from workbench.link.signal import TopicOptions

HERE = Path(__file__).parent
SOURCE = HERE / "fastdds"
DOMAIN = 101 + os.getpid() % 100
LIMIT = 300.0
POSITION = (1.0, -2.0, 3.5, 0.0, 0.0, 1.5707963267948966, 0.25, 0.5, 0.75)
VELOCITY = (0.0, 2.0, 0.0, 0.0, 0.0, 0.3)
FRAMES = (("world", "base_link"), ("base_link", "lidar_link"))
POSES = (1.0, -2.0, 3.5, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.125, 1.0, 0.0, 0.0, 0.0)

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(shutil.which("g++") is None, reason="install g++ to try it"),
    pytest.mark.skipif(
        ctypes.util.find_library("fastrtps") is None
        or not Path("/usr/include/fastdds/dds/domain/DomainParticipant.hpp").is_file(),
        reason="install Fast DDS to try it: apt-get install libfastrtps-dev libfastcdr-dev",
    ),
]


@pytest.fixture(scope="module")
def program(tmp_path_factory):
    made = tmp_path_factory.mktemp("fastdds") / "peer"
    words = ["g++", "-std=c++17", "-O0", str(SOURCE / "peer.cpp"), "-o", str(made)]
    done = subprocess.run([*words, "-lfastrtps", "-lfastcdr"], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return made


@pytest.fixture
def server(fakes, monkeypatch):
    options = TopicOptions(4, 200.0, 10.0, frames=FRAMES, moving=("base_link",))
    topics = drone_topics(options)
    monkeypatch.setattr(fakes, "TOPICS", topics)
    by_name = {topic.name.rsplit("/", 1)[1]: topic for topic in topics}
    monkeypatch.setattr(fakes, "BY_NAME", by_name)
    server = fakes.FakeServer()
    yield server
    server.close()


class Started:
    """A program that runs; its lines are gathered."""

    def __init__(self, words, **pipes):
        self.lines = []
        self.process = subprocess.Popen(
            words, stdin=subprocess.PIPE, text=True, stdout=subprocess.PIPE, **pipes
        )
        self.reader = threading.Thread(target=self.read)
        self.reader.start()

    def read(self):
        self.lines.extend(iter(self.process.stdout.readline, ""))

    def write(self, line):
        self.process.stdin.write(f"{line}\n")
        self.process.stdin.flush()

    def last(self, topic):
        """Return the words of the newest line of a topic, None before the first."""
        found = [line.split()[1:] for line in list(self.lines) if line.split()[0] == topic]
        return found[-1] if found else None

    def end(self):
        self.process.stdin.close()
        try:
            return self.process.wait(LIMIT)
        except subprocess.TimeoutExpired:
            self.process.kill()
            raise
        finally:
            self.reader.join()
            self.process.stdout.close()


@contextmanager
def workbench(*words):
    """Let a command run, and end it by Ctrl-C."""
    whole = [sys.executable, "-m", "workbench", *words]
    started = Started(whole, stderr=subprocess.STDOUT)
    try:
        yield started
    finally:
        if started.process.poll() is None:
            started.process.send_signal(signal.SIGINT)
        code = started.end()
    assert code == 0, started.lines


def passing_on(address):
    return workbench("gateway", "ros2", address, "--allow-commands", "--domain", str(DOMAIN))


@pytest.fixture
def gateway(server):
    with passing_on(server.address) as started:
        yield started


@pytest.fixture
def peer(program):
    started = Started([program, str(DOMAIN)])
    yield started
    assert started.end() == 0


def comes(condition, again=lambda: None):
    """Wait for something that comes soon; do `again` what a slow machine may have undone."""
    begin = time.monotonic()
    due = begin
    while not condition():
        now = time.monotonic()
        assert now < begin + LIMIT, "it did not come"
        if now >= due:
            again()
            due = now + 4.0
        time.sleep(0.01)


def until(condition, server):
    """Let the drone tell its state until something holds."""
    values = {
        "time_data": (0, 0, 0),
        "position_data": POSITION,
        "velocity_data": VELOCITY,
        "frames": (POSES,),
    }
    end = time.monotonic() + LIMIT
    while not condition():
        assert time.monotonic() < end, "it did not come"
        if all(each.topics for each in server.peers):  # who did not greet yet hears nothing
            server.publish(server.t_ns + 5_000_000, **values)
        time.sleep(0.005)


def numbers(words):
    return [float(word) for word in words]


def test_a_stranger_hears_where_the_drone_is(server, gateway, peer):
    topics = ("odometry", "position_data")
    until(lambda: all(peer.last(f"/dh_drone/{name}") for name in topics), server)
    others = ("/clock", "/tf", "/tf_static", "/dh_drone/robot_description")
    until(lambda: all(map(peer.last, others)), server)

    seconds, rest, *frames = peer.last("/dh_drone/odometry")[:4]
    time_told = float(seconds) + 1e-9 * float(rest)
    assert 5.0 < time_told <= server.t_ns * 1e-9
    assert frames == ["odom", "base_link"]
    place, turn, speed = (
        numbers(peer.last("/dh_drone/odometry")[a:b]) for a, b in ((4, 7), (7, 9), (9, 12))
    )
    assert place == [1.0, -2.0, 3.5]
    assert turn == pytest.approx([0.5**0.5, 0.5**0.5], abs=1e-5)  # z, w: a quarter turn
    assert speed == pytest.approx([2.0, 0.0, 0.3], abs=1e-5)  # north is forward then

    frame, *told = peer.last("/dh_drone/position_data")
    assert frame == "world"
    assert numbers(told) == pytest.approx(POSITION, abs=1e-5)
    assert peer.last("/tf") == ["odom", "base_link", "3.5", "1"]
    assert peer.last("/tf_static") == [
        *("world", "map", "0", "1"),
        *("map", "odom", "0", "1"),
        *("base_link", "lidar_link", "0.125", "1"),
    ]
    assert peer.last("/dh_drone/robot_description") == ["<robot", 'name="fake"/>']
    assert len(peer.last("/clock")) == 2


def test_a_stranger_calls_a_service(server, gateway, peer):
    until(lambda: peer.last("/dh_drone/odometry"), server)
    peer.write("call")
    until(lambda: peer.last("/dh_drone/armReply"), server)
    assert peer.last("/dh_drone/armReply")[:6] == ["4711", "1", "1", "arm", "has", "started"]
    # rmw_fastrtps_cpp, unlike this client, does not write its number into the request
    until(lambda: any("with Fast DDS calls a service" in line for line in gateway.lines), server)


def test_a_stranger_flies_by_stamped_velocities_of_the_world(server, gateway, program):
    stamped = Started([program, str(DOMAIN), "map"])
    try:
        until(lambda: stamped.last("/dh_drone/odometry"), server)
        stamped.write("fly 0 0 0 0")
        until(lambda: server.commands, server)
        stamped.write("fly 1.5 0.5 -0.25 0.125")
        until(lambda: any(server.commands[-1][1][2:]), server)
        # East is east, although the drone faces north.
        assert server.commands[-1][1][2:] == pytest.approx((1.5, 0.5, -0.25, 0.125), abs=1e-6)
    finally:
        assert stamped.end() == 0


def test_a_stranger_flies_and_falls_silent(server, gateway, peer):
    until(lambda: peer.last("/dh_drone/odometry"), server)
    peer.write("fly 0 0 0 0")
    until(lambda: server.commands, server)
    peer.write("fly 1.5 0.5 -0.25 0.125")
    until(lambda: any(server.commands[-1][1][2:]), server)
    lease, axes, *first = server.commands[0][1]
    assert (lease, axes, first) == (4711, 15, [0.0, 0.0, 0.0, 0.0])
    # The drone faces north, so forward is y and left is -x.
    assert server.commands[-1][1][2:] == pytest.approx((-0.5, 1.5, -0.25, 0.125), abs=1e-6)

    peer.write("silent")
    peer.write("do take_off 2.5")  # what was said before it is there when it is
    until(lambda: any(isinstance(each, FlightOperation) for each in server.operations), server)
    count = len(server.commands)
    peer.write("do land")
    until(lambda: sum(isinstance(each, FlightOperation) for each in server.operations) == 2, server)
    assert [each.what for each in server.operations if isinstance(each, FlightOperation)] == [
        "take_off",
        "land",
    ]
    assert len(server.commands) <= count + 1  # two topics may overtake each other
    assert not any(isinstance(each, ReleaseControl) for each in server.operations)

    gateway.process.send_signal(signal.SIGINT)
    gateway.process.wait(LIMIT)
    until(lambda: any(isinstance(each, ReleaseControl) for each in server.operations), server)


def test_a_stranger_flies_a_real_flight_which_lands_when_it_falls_silent(peer):
    def speed_and_height():
        words = peer.last("/dh_drone/odometry")
        return (float(words[9]), float(words[6])) if words else (0.0, 0.0)

    with workbench("serve", "--port", "0", "--sensors", "none") as flight:
        comes(lambda: any("127.0.0.1:" in line for line in flight.lines))
        address = next(line for line in flight.lines if "127.0.0.1:" in line).split()[-1]
        with passing_on(address) as gateway:
            comes(lambda: peer.last("/dh_drone/odometry"))
            peer.write("fly 0 0 0 0")
            comes(lambda: any("control was granted" in line for line in gateway.lines))
            comes(lambda: speed_and_height()[1] > 0.9, lambda: peer.write("do take_off 1.0"))
            comes(lambda: speed_and_height()[0] > 1.2, lambda: forward(peer))
            peer.write("silent")
            comes(lambda: any("silent for 0.5 s" in line for line in gateway.lines))
            comes(lambda: any("the drone lands" in line for line in flight.lines))


def forward(peer):
    """Let it fly forward, from neutral, as whoever lost control has to begin."""
    peer.write("fly 0 0 0 0")
    time.sleep(0.3)
    peer.write("fly 1.5 0 0 0")
