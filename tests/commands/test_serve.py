"""`workbench serve` and `workbench tokens`, as processes of their own and their clients."""

import os
import re
import signal
import socket
import stat
import subprocess
import sys
from contextlib import contextmanager
from pathlib import Path

import pytest

from workbench.link import Client

ENOUGH = 300.0
"""No test waits so long unless it fails [s]."""


@contextmanager
def serving(folder, *options, env=None):
    """Run `workbench serve` at a free port; yield the process and where it listens."""
    process = subprocess.Popen(
        [sys.executable, "-m", "workbench", "serve", "--port", "0", *options],
        cwd=folder,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env={**os.environ, "PYTHONPATH": str(Path(__file__).resolve().parents[2])},
    )
    try:
        line = process.stdout.readline()
        found = re.fullmatch(r"serving (\S+) at (127\.0\.0\.1:\d+)\n", line)
        assert found, (line, process.communicate(timeout=ENOUGH))
        yield process, found[2]
    finally:
        process.kill()
        process.communicate()


def children(pid: int) -> list[int]:
    """Return the processes below one, their own too."""
    found = []
    for path in Path(f"/proc/{pid}/task").glob("*/children"):
        for child in path.read_text().split():
            found += [int(child), *children(int(child))]
    return found


def gone(pid: int) -> bool:
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] == "Z"
    except (FileNotFoundError, ProcessLookupError):
        return True


@pytest.mark.parametrize(
    "number", [pytest.param(signal.SIGINT, marks=pytest.mark.slow), signal.SIGTERM]
)
def test_it_serves_until_told_to_stop_and_leaves_nothing_behind(tmp_path, number):
    with serving(tmp_path) as (process, address):
        with Client(address, topics=["/dh_drone/drone_state", "/dh_drone/imu"]) as client:
            seen = {sample.topic for sample, _ in zip(client, range(50), strict=False)}
            assert seen == {"/dh_drone/drone_state", "/dh_drone/imu"}
            assert client.latest("/dh_drone/drone_state").values["condition"] == "off"
        below = children(process.pid)
        assert len(below) == 2  # the flight and its server
        process.send_signal(number)
        said = process.communicate(timeout=ENOUGH)
        assert process.returncode == 0, said
        assert "Traceback" not in said[1]
        assert all(map(gone, below))


@pytest.mark.slow
def test_a_server_that_is_killed_is_started_again_and_the_flight_goes_on(tmp_path):
    with serving(tmp_path, "--log", "flight.mcap") as (process, address):
        with Client(address, topics=["drone_state"]) as client:
            before = next(iter(client)).time
            server = children(process.pid)[-1]
            assert b"link.server" in Path(f"/proc/{server}/cmdline").read_bytes()
            os.kill(server, signal.SIGKILL)
            while "serving again" not in (line := process.stderr.readline()):
                assert line, "it has ended"
            assert line == f"workbench: serving again at {address}\n"
            latest = client.latest("drone_state").time
            assert latest >= before
            for sample in client:  # it comes back by itself, to the same flight
                if sample.time > latest + 0.5:
                    break
        process.send_signal(signal.SIGINT)
        process.communicate(timeout=ENOUGH)
        assert process.returncode == 0
    log = (tmp_path / "flight.mcap").read_bytes()
    assert log.startswith(b"\x89MCAP") and log.endswith(b"\x89MCAP0\r\n")


@pytest.mark.slow
def test_a_client_takes_off_and_the_log_flies_it_again(tmp_path, run):
    with serving(tmp_path, "--log", "logs/flight.mcap") as (process, address):
        with Client(address, name="tester") as client, client.control() as control:
            control.take_off(1.0)
            for sample in client:
                if sample.topic == "/dh_drone/position_data" and sample.values["z"] > 0.9:
                    break
            control.velocity(0.5, 0.0, 0.0)
            for sample in client:
                if sample.topic == "/dh_drone/velocity_data" and sample.values["v_x"] > 0.4:
                    break
        process.send_signal(signal.SIGINT)
        out, said = process.communicate(timeout=ENOUGH)
        assert "tester" in said
    replayed = run("replay", tmp_path / "logs/flight.mcap", "--json")
    assert replayed.code == 0, replayed.err
    assert replayed.json["equal"]


@pytest.mark.slow
def test_a_duration_ends_it(tmp_path):
    with serving(tmp_path, "--duration", "0.5") as (process, _):
        process.communicate(timeout=ENOUGH)
        assert process.returncode == 0


@pytest.mark.slow
def test_a_port_in_use_is_a_sentence(run):
    with socket.create_server(("127.0.0.1", 0)) as taken:
        said = run("serve", "--port", taken.getsockname()[1])
    assert said.code == 2
    assert f"port {taken.getsockname()[1] if taken.fileno() > 0 else ''}".strip() in said.err
    assert "in use" in said.err


def test_what_cannot_be_served_is_refused_in_a_sentence(case, run):
    for options, words in [
        (["--host", "0.0.0.0"], "token"),
        (["--port", "70000"], "70000"),
        (["--token-file", "none.txt"], "none.txt"),
        (["--tls-cert", "none.pem"], "a certificate and its key"),
        (["--scenario", "netwrk"], "network"),
        (["--duration", "-1"], "-1"),
        (["--sensors", "imo"], "imu"),
        (["--log", "/proc/no/flight.mcap"], "/proc/no"),
    ]:
        with case(options, words):
            said = run("serve", *options)
            assert said.code == 2
            assert words in said.err
            assert "Traceback" not in said.err
            assert said.out == ""


def test_tokens_are_for_their_owner_alone(run, tmp_path):
    path = tmp_path / "tokens.txt"
    assert run("tokens", path).code == 0
    assert stat.S_IMODE(path.stat().st_mode) == 0o600
    view, command = (line.split(": ")[1] for line in path.read_text().splitlines())
    assert view != command
    assert min(len(view), len(command)) >= 16
    before = path.read_text()
    again = run("tokens", path)
    assert again.code == 2
    assert path.read_text() == before
