"""`workbench monitor` as people run it: in a terminal, in a pipe, once."""

import fcntl
import json
import os
import pty
import re
import signal
import struct
import subprocess
import sys
import termios
import threading

import pytest

from workbench.commands.cli import main
from workbench.link.authentication import Tokens
from workbench.link.messages import FlightOperation, Login, ReleaseControl, RequestControl

POSITION = (1.25, 2.0, 3.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
COMMAND = [sys.executable, "-m", "workbench", "monitor"]


class Terminal:
    """A pseudo-terminal with a program in it."""

    def __init__(self, words, rows=40, columns=100, **environment):
        self.main, other = pty.openpty()
        fcntl.ioctl(other, termios.TIOCSWINSZ, struct.pack("HHHH", rows, columns, 0, 0))
        self.shown = ""
        self.process = subprocess.Popen(
            [*COMMAND, *words],
            stdin=other,
            stdout=other,
            stderr=other,
            start_new_session=True,
            env={**os.environ, "TERM": "xterm", "LC_ALL": "C.UTF-8", **environment},
        )
        os.close(other)
        self.reader = threading.Thread(target=self.read)
        self.reader.start()

    def read(self):
        while True:
            try:
                self.shown += os.read(self.main, 65536).decode("utf-8", "replace")
            except OSError:  # its end
                return

    @property
    def text(self):
        """What was written, without the terminal's own signs."""
        return re.sub(r"\x1b(\[[0-9;?]*[A-Za-z]|[()][A-Z0-9]|[=>78])", " ", self.shown)

    def press(self, keys):
        os.write(self.main, keys.encode())

    def close(self):
        self.process.kill()
        self.process.wait()
        self.reader.join(20.0)
        os.close(self.main)


@pytest.fixture
def terminal():
    """Return a function that starts a monitor in a terminal."""
    opened = []

    def start(words, **options):
        opened.append(Terminal(words, **options))
        return opened[-1]

    yield start
    for each in opened:
        each.close()


@pytest.fixture
def flight(server):
    """Publish states until the end of the test."""
    done = threading.Event()

    def publish():
        t_ns = 5_000_000_000
        while not done.wait(0.02):
            t_ns += 20_000_000
            server.publish(
                t_ns, position_data=POSITION, drone_state=(3, "hovering", 0.5, float("inf"))
            )

    publisher = threading.Thread(target=publish)
    publisher.start()
    yield server
    done.set()
    publisher.join()


def said_of(kind, server):
    return [each for each in server.operations if isinstance(each, kind)]


def test_the_screen_shows_the_flight_and_q_quits(flight, fakes, terminal):
    screen = terminal([flight.address])
    fakes.wait_until(lambda: "hovering" in screen.text and "1.25" in screen.text)
    fakes.wait_until(lambda: "? help" in screen.text)  # it is drawn last
    screen.press("?")
    fakes.wait_until(lambda: "counts for 0.3 s" in screen.text)
    screen.press("q")
    assert screen.process.wait(20.0) == 0
    assert said_of(RequestControl, flight) == []


def test_keys_fly(flight, fakes, terminal):
    screen = terminal([flight.address])
    fakes.wait_until(lambda: "C take control" in screen.text)
    screen.press("c")
    fakes.wait_until(lambda: flight.commands)
    screen.press("w")
    fakes.wait_until(lambda: any(values[2] == 1.0 for _, values in flight.commands))
    fakes.wait_until(lambda: flight.commands[-1][1][2] == 0.0)  # by itself
    screen.press("\x1bOA")  # up, as xterm sends it
    fakes.wait_until(lambda: any(values[4] == 1.0 for _, values in flight.commands))
    screen.press("t")
    fakes.wait_until(lambda: said_of(FlightOperation, flight))
    screen.press("Q")
    assert screen.process.wait(20.0) == 0
    assert said_of(FlightOperation, flight)[0].what == "take_off"
    assert len(said_of(ReleaseControl, flight)) == 1


def test_fly_takes_control_at_the_start_and_ctrl_c_gives_it_back(flight, fakes, terminal):
    screen = terminal([flight.address, "--fly"])
    fakes.wait_until(lambda: "you fly" in screen.text and flight.commands)
    screen.process.send_signal(signal.SIGINT)
    assert screen.process.wait(20.0) == 0
    assert len(said_of(ReleaseControl, flight)) == 1


def test_fly_that_is_refused_is_a_sentence(server, fakes, terminal):
    server.refuse(RequestControl, "held", "Ada flies")
    screen = terminal([server.address, "--fly"])
    assert screen.process.wait(20.0) == 2
    fakes.wait_until(lambda: "workbench: refused: Ada flies" in screen.text)


@pytest.mark.parametrize(("rows", "columns"), [(5, 20), (2, 8)])
def test_any_size_of_terminal_does(flight, fakes, terminal, rows, columns):
    screen = terminal([flight.address], rows=rows, columns=columns)
    fakes.wait_until(lambda: len(screen.shown) > 10)
    screen.press("?q")
    assert screen.process.wait(20.0) == 0


def test_a_terminal_that_cannot_place_text_gets_lines(flight, fakes, terminal):
    screen = terminal([flight.address], TERM="dumb")
    fakes.wait_until(lambda: screen.text.count("hovering, charge 50 %") >= 2)
    screen.process.send_signal(signal.SIGINT)
    assert screen.process.wait(20.0) == 0


def test_a_pipe_gets_lines_until_ctrl_c(flight, fakes):
    with subprocess.Popen([*COMMAND, flight.address], stdout=subprocess.PIPE, text=True) as process:
        try:
            lines = [process.stdout.readline() for _ in range(2)]
            process.send_signal(signal.SIGINT)
            assert process.wait(20.0) == 0
        finally:
            process.kill()
    assert all("position x 1.25 y 2.00 z 3.00 m" in line for line in lines)


def test_once_prints_once(flight, capsys):
    assert main(["monitor", flight.address, "--once"]) == 0
    text = capsys.readouterr().out
    assert "mode      hovering, charge 50 %" in text
    assert "\x1b" not in text


def test_once_as_json_is_one_object(flight, capsys):
    assert main(["monitor", flight.address, "--once", "--json"]) == 0
    said = json.loads(capsys.readouterr().out)
    assert said["topics"]["drone_state"]["condition"] == "hovering"
    assert said["topics"]["drone_state"]["clearance"] is None


def test_a_flight_that_stands_is_said(server, monkeypatch, capsys):
    monkeypatch.setattr("workbench.commands.gateway.PATIENCE", 0.05)
    assert main(["monitor", server.address, "--once"]) == 0
    assert "is the flight paused?" in capsys.readouterr().err


def test_whoever_watches_shows_the_token_to_view(fakes, tmp_path, capsys, monkeypatch):
    monkeypatch.setattr("workbench.commands.gateway.PATIENCE", 0.05)
    server = fakes.FakeServer(Tokens("v" * 16, "c" * 16))
    file = tmp_path / "tokens"
    file.write_text(f"view: {'v' * 16}\n")  # whoever only watches has no more
    file.chmod(0o600)
    try:
        assert main(["monitor", server.address, "--once", "--token-file", str(file)]) == 0
    finally:
        server.close()
    assert said_of(Login, server)[0].role.value == "view"


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["127.0.0.1:1", "--fly", "--json"], "--fly needs a terminal"),
        (["127.0.0.1:1", "--once"], "nobody listens at 127.0.0.1:1"),
        (["127.0.0.1:x"], "the port 'x'"),
        (["--token-file", "missing"], "missing: cannot be read"),
        (["--tls", "missing.pem"], "missing.pem: no such file"),
        (["--rate", "fast"], "the rate 'fast'"),
    ],
)
def test_bad_input_is_a_sentence(tmp_path, monkeypatch, capsys, words, said):
    monkeypatch.chdir(tmp_path)
    assert main(["monitor", *words]) == 2
    assert said in capsys.readouterr().err
