"""The small clients fly the real drone over the real server."""

import contextlib
import shutil
import socket
import subprocess
import sys
import threading
from pathlib import Path

import pytest

from workbench.link.drone_topics import COMMAND_SIGNAL, VELOCITY_SIGNAL
from workbench.link.hello import Hello
from workbench.link.message_json import read_message, write_operation
from workbench.link.messages import Subscribe
from workbench.link.wire import Decoder, FrameFlag, FrameKind, WireFrame

EXAMPLES = Path(__file__).resolve().parents[2] / "examples" / "link"
LIMIT = 300.0
"""For anything to happen [s]."""
ATTEMPTS = 5
"""A machine that stands still for half a second loses control, as it should."""


@pytest.fixture(scope="module")
def address(served):
    return served("hover")


class Watcher:
    """Sees what is flown, and how fast the drone is."""

    def __init__(self, address):
        host, _, port = address.rpartition(":")
        self.stream = socket.create_connection((host, int(port)), timeout=LIMIT)
        self.commands, self.fastest = set(), 0.0
        self.thread = threading.Thread(target=self.read)
        self.thread.start()

    def read(self):
        decoder, topics = Decoder(), {}
        while data := self.stream.recv(65536):
            for frame in decoder.feed(data):
                if frame.kind == FrameKind.DATA:
                    values = topics[frame.topic].unpack(frame.payload)
                    if frame.topic == VELOCITY_SIGNAL.id:
                        self.fastest = max(self.fastest, values["v_x"])
                    else:
                        self.commands.add((round(values["v_x"], 4), round(values["v_z"], 4)))
                elif isinstance(said := read_message(frame.payload), Hello):
                    topics = {topic.id: topic for topic in said.topics}
                    names = tuple(
                        topics[number].name for number in (VELOCITY_SIGNAL.id, COMMAND_SIGNAL.id)
                    )
                    self.send(
                        WireFrame(
                            FrameKind.CONTROL, 0, 0, 1, 0, write_operation(Subscribe(1, names))
                        )
                    )
                if frame.flags & FrameFlag.ACKNOWLEDGE:
                    self.send(WireFrame(FrameKind.ACKNOWLEDGEMENT, 0, 0, frame.seq, 0, b""))

    def send(self, frame):
        with contextlib.suppress(OSError):  # once we have said that we go
            self.stream.sendall(frame.to_bytes())

    def close(self):
        self.stream.shutdown(socket.SHUT_WR)
        self.thread.join(LIMIT)
        self.stream.close()


@pytest.fixture(params=["c", "js", "python"])
def words(request, address, tmp_path):
    if request.param == "python":
        return [sys.executable, "-I", str(EXAMPLES / "client.py"), address]
    if request.param == "js":
        if shutil.which("node") is None:
            pytest.skip("there is no Node: run `sudo apt-get install nodejs`")
        return ["node", str(EXAMPLES / "client.mjs"), address]
    if shutil.which("gcc") is None:
        pytest.skip("there is no C compiler: run `sudo apt-get install gcc`")
    command = ["gcc", "-std=c99", "-o", tmp_path / "client", EXAMPLES / "client.c"]
    subprocess.run(command, check=True, timeout=LIMIT)
    return [str(tmp_path / "client"), *address.rsplit(":", 1)]


@pytest.mark.slow
def test_it_flies(words, address):
    watcher = Watcher(address)
    try:
        for _ in range(ATTEMPTS):
            flown = subprocess.run(
                [*words, "fly", "0.75", "0", "0.125", "0", "0.5"],
                capture_output=True,
                text=True,
                timeout=LIMIT,
            )
            if flown.returncode == 0:
                break
            assert "not_holder" in flown.stdout or "held" in flown.stdout
    finally:
        watcher.close()
    assert flown.returncode == 0, flown.stdout + flown.stderr
    assert "nack" not in flown.stdout
    assert "take_off" not in flown.stdout
    assert (0.75, 0.125) in watcher.commands
    assert watcher.fastest > 0.3
