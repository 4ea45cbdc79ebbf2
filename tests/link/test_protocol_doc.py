"""docs/protocol.md is the specification: its examples run, and its tables are what we do."""

import hashlib
import hmac
import itertools
import json
import re
import struct
import subprocess
import sys
import time
from dataclasses import fields
from pathlib import Path

import pytest

from workbench.link import authority
from workbench.link.codes import DeniedError, ErrorCode, NackCode
from workbench.link.drone_topics import ALL_COMMAND_AXES, COMMAND_SIGNAL, drone_topics
from workbench.link.hello import Hello, ServerLimits
from workbench.link.message_json import (
    MAX_TOPIC_RATE_HZ,
    MIN_TOPIC_RATE_HZ,
    TAKE_OFF_HEIGHT_M,
    read_message,
    read_operation,
    write_message,
)
from workbench.link.server import rate_limiter
from workbench.link.server.client_session import LOGIN_TIMEOUT_S
from workbench.link.signal import TopicOptions
from workbench.link.wire import (
    FRAME_HEADER,
    MAX_BYTES_BEFORE_LOGIN,
    MAX_PAYLOAD_BYTES,
    Decoder,
    FrameKind,
)

PAGE = (Path(__file__).resolve().parents[2] / "docs" / "protocol.md").read_text(encoding="utf-8")
VECTORS = (Path(__file__).parent / "vectors" / "README.md").read_text(encoding="utf-8")
"""What a client of version 0.1.0 proves in place of sending a token."""


def section(title):
    found = re.search(
        rf"^(#+) {re.escape(title)}\n(.*?)(?=^#+ |\Z)", PAGE, re.DOTALL | re.MULTILINE
    )
    assert found, title
    return found[2]


def blocks(language, text=PAGE):
    return re.findall(rf"^```{language}\n(.*?)^```", text, re.DOTALL | re.MULTILINE)


def rows(text):
    cells = [line.strip("|").split(" | ") for line in text.splitlines() if line.startswith("| ")]
    return [[cell.strip() for cell in row] for row in cells if not set(row[0]) <= set("- |")]


def codes(text):
    return [code for row in rows(text) for code in row[0].split(", ") if code != "code"]


def test_the_small_client_runs(server, fakes):
    [program] = blocks("python")
    lines = [line for line in program.splitlines() if line.strip()]
    assert len(lines) <= 30
    assert set(re.findall(r"^import (\w+)", program, re.MULTILINE)) == {"json", "socket", "struct"}
    with subprocess.Popen(
        [sys.executable, "-I", "-u", "-c", program.replace("7733", str(server.port))],
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    ) as process:
        try:
            end = time.monotonic() + 60
            while not server.peers or server.peers[0].acknowledged < 3:
                if server.peers and server.peers[0].topics:
                    server.publish(
                        server.t_ns + 50_000_000,
                        velocity_data=(0.5, 0, 0, 0, 0, 0),
                        events=(1, "gust"),
                    )
                time.sleep(0.002)
                assert process.poll() is None and time.monotonic() < end
            # what it still had to say would come back to it as a broken connection
            fakes.wait_until(lambda: server.peers[0].acknowledged == server.peers[0].seq)
            server.close()
            assert process.wait(60) == 0, "it ends by itself when the server does"
        finally:
            process.kill()
        said = process.stdout.read()
    assert "/dh_drone/velocity_data (0.5, 0.0, 0.0, 0.0, 0.0, 0.0)" in said
    assert "/dh_drone/events (1, b'gust" in said


def test_the_picture_and_the_ping_are_those_of_the_header():
    assert [int(n) for n in re.search(r"^ 0 .*", PAGE, re.MULTILINE)[0].split()] == [
        0, 2, 3, 4, 6, 8, 12, 16, 24,
    ]  # fmt: skip
    assert FRAME_HEADER.format == "<2sBBHHIIq"
    assert [struct.calcsize(f"<{'2sBBHHIIq'[:end]}") for end in (2, 3, 4, 5, 6, 7, 8, 9)] == [
        2, 3, 4, 6, 8, 12, 16, 24,
    ]  # fmt: skip
    line = re.search(r"^44 48 .*", PAGE, re.MULTILINE)[0]
    digits, _, payload = line.replace(" ", "").replace("|", "").partition("{")
    [frame] = Decoder().feed(bytes.fromhex(digits) + b"{" + payload.encode())
    assert (frame.kind, frame.seq, frame.payload) == (FrameKind.CONTROL, 1, b'{"op":"ping"}')


def test_every_operation_of_a_client_has_an_example():
    said = section("What a client sends")
    shown = [read_operation(line.encode()) for line in blocks("json", said)[0].splitlines()]
    with pytest.raises(DeniedError) as unknown:
        read_operation(b'{"op":"dance"}')
    known = unknown.value.said.split("known are ")[1].split(", ")
    ops = {json.loads(line)["op"] for line in blocks("json", said)[0].splitlines()}
    assert ops == set(known) == {row[0] for row in rows(said)} - {"op"}
    assert len(shown) == 11


def test_every_operation_of_the_server_has_an_example():
    hello, others = blocks("json", section("What the server sends"))
    shown = [read_message(text.encode()) for text in (hello, *others.splitlines())]
    assert all(each is not None for each in shown)
    assert {each.op for each in shown} == {
        "hello", "login", "subscribe", "request_control", "release_control", "parameters", "flight",
        "control_state", "pong", "nack", "error", "bye", "description",
    }  # fmt: skip
    for said, text in zip(shown, (hello, *others.splitlines()), strict=True):
        written, example = json.loads(write_message(said)), json.loads(text)
        if isinstance(said, Hello):
            written["topics"][0].pop("hash"), example["topics"][0].pop("hash")
        assert written == example


def test_the_limits_that_hello_shows_are_the_usual_ones():
    shown = read_message(blocks("json", section("What the server sends"))[0].encode())
    usual = ServerLimits(8.0, 3.0, 0.4)
    for each in fields(ServerLimits):
        assert getattr(shown.limits, each.name) == getattr(usual, each.name)
    assert (usual.largest, usual.largest_before_login) == (
        MAX_PAYLOAD_BYTES,
        MAX_BYTES_BEFORE_LOGIN,
    )
    assert (usual.hold_after, usual.lost_after, usual.land_after, usual.oldest_state) == (
        authority.HOLD_AFTER_S,
        authority.LOST_AFTER_S,
        authority.LAND_AFTER_S,
        authority.MAX_STATE_AGE_S,
    )
    assert authority.MAX_SPEED_EXCESS == 2.0


@pytest.mark.parametrize(("which", "known"), [(0, NackCode), (1, ErrorCode)])
def test_every_code_says_what_to_do(which, known):
    nack, error = section("Refusals").split("An error is")
    table = (nack, error)[which]
    assert codes(table) == [code.value for code in known]
    assert all(len(row) == 3 and all(row) for row in rows(table))


def name(field):
    return (
        field.name if field.count == 1 or field.type == "char" else f"{field.name}[{field.count}]"
    )


def unit_and_frame(field):
    shown = [each for each in (field.unit.removeprefix("1"), field.frame) if each]
    return f" ({', '.join(shown)})" if shown else ""


def test_the_table_of_topics_is_that_of_the_drone():
    frames = [("W", "B"), ("B", "S")]
    outfit = TopicOptions(
        4,
        204.8,
        204.8 / 6,
        rates={"imu": 100.0, "gps": 5.0, "lidar": 10.0, "magnetometer": 50.0, "estimate": 204.8},
        rays=360,
        scan={},
        frames=frames,
    )
    rates = {outfit.fast: "fast", outfit.slow: "slow", 0.0: "event"}
    expected = [
        [
            str(topic.id),
            topic.name.removeprefix("/dh_drone/"),
            rates.get(topic.rate, "sensor"),
            f"`{topic.packer.format}`",
            "; ".join(
                ", ".join(map(name, group)) + shown
                for shown, group in itertools.groupby(topic.fields, unit_and_frame)
            ),
        ]
        for topic in drone_topics(outfit)
    ]
    assert rows(section("Topics"))[1:] == expected


def test_the_command_is_described():
    [command] = [t for t in drone_topics(TopicOptions(4, 200, 8)) if t.id == COMMAND_SIGNAL.id]
    described = ", ".join(row[0] for row in rows(section("Flying")))
    assert described == "field, lease, axes, v_x, v_y, v_z, yaw_rate, t_ns, in the header"
    told = " ".join(section("Flying").split())
    assert f"data frame of topic {COMMAND_SIGNAL.id}, `{command.name}`" in told
    assert ALL_COMMAND_AXES == 0b1111


def test_the_worked_login_is_right():
    """With the standard library alone, as a reader would check it."""
    told = {key: value.strip("`") for key, value in rows(VECTORS.split("## The login")[1])}
    token = told["token"].encode()
    nonces = bytes.fromhex(told["server_nonce"] + told["client_nonce"])

    def sha(key, *parts):
        return hmac.new(key, b"".join(parts), hashlib.sha256).digest()

    for role in ("view", "command"):
        assert told[f"proof, role {role}"] == sha(token, b"DH1 login", role.encode(), nonces).hex()
    example = read_operation(
        blocks("json", section("What a client sends"))[0].splitlines()[0].encode()
    )
    assert example.token == told["token"]


def test_a_search_in_the_text_of_hello_finds_numbers_of_topics():
    """Small devices search instead of parsing; the page promises them this order."""
    topics = drone_topics(TopicOptions(4, 200, 8))
    hello = Hello("s", "0", 1, "v", "0" * 32, False, ServerLimits(8, 3, 1), topics, parameters=())
    written = write_message(hello).decode()
    for topic in topics:
        assert f'{{"id":{topic.id},"name":"{topic.name}",' in written


def test_links_within_the_page_lead_somewhere():
    anchors = {
        re.sub(r"[^\w -]", "", title.lower()).replace(" ", "-")
        for title in re.findall(r"^#+ (.*)$", PAGE, re.MULTILINE)
    }
    assert set(re.findall(r"\]\(#([^)]*)\)", PAGE)) <= anchors


def test_the_files_that_the_page_names_are_there():
    root = Path(__file__).resolve().parents[2]
    for path in ("examples/link/", "tests/link/vectors/"):
        assert f"`{path}`" in PAGE
        assert (root / path).is_dir()


def test_the_figures_of_the_server_are_told():
    from workbench.link.authority import FIRST_HOLD_AFTER_S
    from workbench.link.server import acceptor, admission, outgoing, web
    from workbench.link.server import client_session as session

    told = " ".join(PAGE.split())
    for sentence in (
        f"within {LOGIN_TIMEOUT_S:g} s",
        f"no login for {LOGIN_TIMEOUT_S:g} s",
        f"acknowledged for {session.ACKNOWLEDGE_TIMEOUT_S:g} s, or written for "
        f"{session.SEND_TIMEOUT_S:g} s",
        f"{outgoing.MAX_QUEUED_ANSWERS} may wait",
        f"read in {outgoing.BATCH_TIME_S:g} s, but at least {outgoing.MIN_BATCH_FRAMES} frames",
        f"{session.MAX_OPEN_REQUESTS} requests wait for an answer",
        f"More than {rate_limiter.FRAMES_PER_S:,.0f} frames or "
        f"{rate_limiter.RECEIVED_BYTES_PER_S / 1e6:g} MB a second",
        f"Up to {rate_limiter.FRAME_BURST_COUNT:g} frames may come at once",
        f"{MIN_TOPIC_RATE_HZ:g} to {MAX_TOPIC_RATE_HZ:.0f}; events come all the same",
        f"[m], {TAKE_OFF_HEIGHT_M:g} if left out",
        f"of at most {FRAME_HEADER.size + MAX_PAYLOAD_BYTES} bytes",
        f"It holds for {FIRST_HOLD_AFTER_S:g} s",
        f"A request has {web.WEB_IDLE_TIMEOUT_S:g} s, {web.MAX_WEB_REQUEST_BYTES // 1024} kB, "
        f"{web.MAX_REQUEST_HEADERS} "
        f"headers and {web.MAX_REQUEST_READS} reads",
        f"A port has {acceptor.MAX_BEGUN_CONNECTIONS} connections at once, and "
        f"{acceptor.MAX_PENDING_CONNECTIONS} more wait",
        f"At most {acceptor.BEGIN_RATE_HZ:,.0f} connections begin in a second",
    ):
        assert sentence in told, sentence
    assert outgoing.MAX_OPEN_BATCHES == 2 and "at most two unacknowledged batches" in told
    assert admission.MAX_LOGIN_WAIT_S == 60.0 and "up to a minute" in told
