"""The small clients in examples/link watch and fly, each in its own language."""

import importlib.util
import io
import json
import os
import shutil
import struct
import subprocess
import sys
import time
from pathlib import Path

import pytest

from workbench.link.authentication import Tokens
from workbench.link.drone_topics import drone_topics
from workbench.link.messages import (
    Bye,
    Error,
    FlightOperation,
    Nack,
    ReleaseControl,
    RequestControl,
    Subscribe,
)
from workbench.link.signal import TopicOptions
from workbench.link.wire import WireFrame

EXAMPLES = Path(__file__).resolve().parents[2] / "examples" / "link"
LANGUAGES = ["c", "js", "python"]
TOKENS = Tokens("v" * 20, "c" * 20)
STEP = 50_000_000
"""Between two states of the fake flight [ns]."""


@pytest.fixture(scope="module")
def c_client(tmp_path_factory):
    if shutil.which("gcc") is None:
        pytest.skip("there is no C compiler: run `sudo apt-get install gcc`")
    program = tmp_path_factory.mktemp("c") / "client"
    flags = ["-std=c99", "-Wall", "-Wextra", "-Werror", "-O1", "-fsanitize=address,undefined"]
    source = EXAMPLES / "client.c"
    subprocess.run(["gcc", *flags, "-o", program, source], check=True, timeout=120)
    return program


@pytest.fixture(params=LANGUAGES)
def words(request):
    """Return how a client is started, but for the address."""
    if request.param == "c":
        return [str(request.getfixturevalue("c_client"))]
    if request.param == "python":
        return [sys.executable, "-I", str(EXAMPLES / "client.py")]
    node = shutil.which("node")
    if node is None:
        pytest.skip("there is no Node: run `sudo apt-get install nodejs`")
    return [node, str(EXAMPLES / "client.mjs")]


def run(server, words, *more, token=""):
    """Run a client beside a flight that publishes, and return its exit code and what it said."""
    apart = server.address.split(":") if words[0].endswith("client") else [server.address]
    environment = {"PATH": os.environ["PATH"], "LINK_TOKEN": token}
    with subprocess.Popen(
        [*words, *apart, *more],
        env=environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    ) as process:
        try:
            t_ns, end = server.t_ns, time.monotonic() + 60
            while process.poll() is None and time.monotonic() < end:
                if any(peer.topics for peer in server.peers):
                    t_ns += STEP
                    server.publish(t_ns, velocity_data=(0.5, -0.25, 1e-9 * t_ns, 0, 0, 0))
                time.sleep(0.002)
            assert process.poll() is not None, "the client did not end"
        finally:
            process.kill()
        return process.returncode, process.stdout.read()


def heard(server, kind):
    return [each for each in server.operations if isinstance(each, kind)]


def test_watching_prints_velocities_and_acknowledges(server, fakes, words):
    code, said = run(server, words, "watch", "5")
    lines = [line.split() for line in said.splitlines() if line.endswith("m/s")]
    assert code == 0, said
    assert len(lines) == 5
    for line in lines:
        assert line[1:4] == ["s", "0.500", "-0.250"]
        assert line[0] == line[4], "the fake flight's v_z is its time"
    assert heard(server, Subscribe)[0].topics == ("/dh_drone/velocity_data",)
    fakes.wait_until(lambda: heard(server, Bye))
    assert server.peers[0].acknowledged >= 5
    assert server.commands == []


def test_flying_begins_at_rest_and_gives_control_back(fakes, words):
    check_flight(fakes, words, token="")


@pytest.mark.parametrize("words", ["js", "python"], indirect=True)
def test_a_token_is_shown_where_the_server_has_tokens(fakes, words):
    check_flight(fakes, words, token=TOKENS.command)


def check_flight(fakes, words, token):
    server = fakes.FakeServer(tokens=TOKENS if token else None)
    try:
        code, said = run(server, words, "fly", "1.5", "-0.5", "0.25", "0.125", "1", token=token)
    finally:
        server.close()
    assert code == 0, said
    assert {lease for _, (lease, *_) in server.commands} == {fakes.LEASE}
    assert {axes for _, (_, axes, *_) in server.commands} == {15}
    asked = [tuple(velocity) for _, (_, _, *velocity) in server.commands]
    moving = [velocity for velocity in asked if any(velocity)]
    assert not any(asked[0])
    assert not any(asked[-1])
    assert set(moving) == {(1.5, -0.5, 0.25, 0.125)}
    assert len(moving) == pytest.approx(1e9 / STEP, abs=1)
    times = [t_ns for t_ns, _ in server.commands]
    assert heard(server, FlightOperation) == []
    assert times == sorted(set(times)), "each state is answered once"
    fakes.wait_until(lambda: heard(server, Bye))
    assert len(heard(server, RequestControl)) == 1
    assert [each.lease for each in heard(server, ReleaseControl)] == [fakes.LEASE]


def test_a_take_off_comes_after_the_neutral_command(server, fakes, words):
    code, said = run(server, words, "fly", "1", "0", "0", "0", "0.5", "2.5")
    assert code == 0, said
    [take_off] = heard(server, FlightOperation)
    assert (take_off.what, take_off.height, take_off.lease) == ("take_off", 2.5, fakes.LEASE)
    first = next(t_ns for t_ns, (_, _, *velocity) in server.commands if any(velocity))
    assert first - server.commands[0][0] == pytest.approx(4e9, abs=STEP)


def test_a_refused_request_is_said(server, words):
    server.refuse(RequestControl, "held", "Ada flies: ask again")
    code, said = run(server, words, "fly", "1", "0", "0", "0")
    assert code == 1
    assert "Ada flies: ask again" in said
    assert server.commands == []


def test_a_refused_command_is_said_and_the_flight_goes_on(server, words):
    def answer(peer, operation):
        if isinstance(operation, WireFrame):
            return Nack("scaled", "the level speed is 9 m/s, its limit 8 m/s", seq=operation.seq)
        return None

    server.answer = answer
    code, said = run(server, words, "fly", "9", "0", "0", "0", "0.5")
    assert code == 0, said
    assert "its limit 8 m/s" in said
    assert heard(server, ReleaseControl)


def test_who_has_lost_control_ends(server, words):
    def answer(peer, operation):
        if isinstance(operation, WireFrame):
            return Nack("not_holder", "control was silent for 0.5 s", seq=operation.seq)
        return None

    server.answer = answer
    code, said = run(server, words, "fly", "1", "0", "0", "0")
    assert code == 1
    assert "control was silent" in said


def test_a_server_that_takes_no_more_is_understood(server, words):
    server.greet = lambda peer: peer.say(Error("too_many", "all 16 places are taken"))
    code, said = run(server, words, "watch", "1")
    assert code == 1
    assert "all 16 places are taken" in said


def test_a_token_is_asked_for(fakes, words):
    server = fakes.FakeServer(tokens=TOKENS)
    try:
        code, said = run(server, words, "watch", "1", token="wrong")
        assert code == 1
        proves = not words[0].endswith("client")  # the one in C knows no tokens
        assert ("the token is wrong" if proves else "token") in said
        if proves:
            code, said = run(server, words, "watch", "1", token=TOKENS.view)
            assert code == 0, said
    finally:
        server.close()


def test_what_is_no_link_is_refused(server, words):
    server.greet = lambda peer: peer.stream.sendall(b"HTTP/1.1 400 Bad Request\r\n\r\n" + b" " * 99)
    code, said = run(server, words, "watch", "1")
    assert code != 0
    assert "this is not a link of version 1" in said


def test_the_javascript_client_unpacks_every_topic():
    node = shutil.which("node")
    if node is None:
        pytest.skip("there is no Node: run `sudo apt-get install nodejs`")
    outfit = TopicOptions(
        4, 200, 8, rates={"imu": 200, "gps": 5, "lidar": 10}, rays=4, frames=[("W", "B")]
    )
    fields = {topic.id: topic.definition()["fields"] for topic in drone_topics(outfit)}
    vectors = json.loads((Path(__file__).parent / "vectors/topics.json").read_text("utf-8"))
    program = f"""
        import {{ unpack }} from {json.dumps((EXAMPLES / "client.mjs").as_uri())};
        import {{ readFileSync }} from "node:fs";
        const shown = (key, value) =>
            typeof value === "bigint" || (typeof value === "number" && !Number.isFinite(value))
                ? String(value) : value;
        const found = JSON.parse(readFileSync(0)).map(({{ fields, hex }}) =>
            unpack(fields, new Uint8Array(Buffer.from(hex, "hex"))));
        console.log(JSON.stringify(found, shown));
    """
    asked = [
        {"fields": fields[each["id"]], "hex": "".join(word for word in each["hex"].split())}
        for each in vectors
        if "*" not in each["hex"]
    ]
    said = subprocess.run(
        [node, "--input-type=module", "-e", program],
        input=json.dumps(asked),
        capture_output=True,
        text=True,
        timeout=60,
    )
    assert said.returncode == 0, said.stderr
    spelled = {"NaN": "nan", "Infinity": "inf", "-Infinity": "-inf"}

    def plain(value):
        if isinstance(value, list):
            return [plain(each) for each in value]
        return spelled.get(value, value) if isinstance(value, str) else value

    found = [{k: plain(v) for k, v in each.items()} for each in json.loads(said.stdout)]
    expected = [each["values"] for each in vectors if "*" not in each["hex"]]
    assert len(found) > 20
    for one, other in zip(found, expected, strict=True):
        assert one.keys() == other.keys()
        for name, value in one.items():
            wanted = other[name]
            assert value == (str(wanted) if name in ("stamp", "wall_ns") else wanted), name


def test_the_square_takes_the_newest_time_of_topics_that_come_in_any_order():
    """Topics of a batch are in any order, and a command with an old time is stale."""
    spec = importlib.util.spec_from_file_location("square", EXAMPLES / "square.py")
    square = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(square)
    link = square.Link.__new__(square.Link)  # without a connection
    link.position_data = link.on_off_state = {"id": 0}
    link.newest_ns = 0
    times = (100, 300, 200)
    frames = [struct.pack("<2sBBHHIIq", b"DH", 1, 1, 9, 0, 1, 0, t_ns) for t_ns in times]
    link.incoming = io.BytesIO(b"".join(frames))
    seen = []
    for _ in times:
        link.receive()
        seen.append(link.newest_ns)
    assert seen == [100, 300, 300]
