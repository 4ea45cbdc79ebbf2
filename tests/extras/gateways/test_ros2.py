"""The gateway to ROS 2 as a program."""

import asyncio
import importlib.util
import os
import socket
import subprocess
import sys

import pytest

from tests.extras.gateways.conftest import until
from workbench.common.errors import WorkbenchError
from workbench.extras.gateways import ros2
from workbench.extras.gateways.ros2 import run_ros2, serve_ros2
from workbench.extras.gateways.ros2_options import Ros2Options
from workbench.extras.gateways.running import MESSAGE_REPEAT_S, LinkOptions, throttled
from workbench.link.messages import Role

DOMAIN = 101 + (os.getpid() + 25) % 100
needs_cyclone = pytest.mark.skipif(
    importlib.util.find_spec("cyclonedds") is None, reason="install the extra `ros2` to try it"
)


def test_a_sentence_is_not_said_again_and_again():
    said, now = [], [0.0]
    say = throttled(said.append, lambda: now[0])
    for sentence in ("a", "a", "b", "a"):
        say(sentence)
    assert said == ["a", "b"]
    now[0] = MESSAGE_REPEAT_S
    say("a")
    assert said == ["a", "b", "a"]


def test_without_the_extra_it_says_how_to_install_it(monkeypatch):
    monkeypatch.setattr(ros2, "find_spec", lambda name: None)
    with pytest.raises(WorkbenchError, match="`pip install cyclonedds`"):
        run_ros2(LinkOptions("127.0.0.1:1", "ros2"), Ros2Options())


def test_nothing_is_tried_where_an_option_is_wrong():
    with pytest.raises(WorkbenchError, match="on this computer only"):
        options = Ros2Options(interface="eth0", allow_commands=True)
        run_ros2(LinkOptions("127.0.0.1:1", "ros2"), options)


@needs_cyclone
def test_without_a_server_it_ends_with_a_sentence():
    with pytest.raises(WorkbenchError, match="nobody listens at 127.0.0.1:1"):
        run_ros2(LinkOptions("127.0.0.1:1", "ros2"), Ros2Options(domain=DOMAIN))


def beside(server, test, **options):
    """Run the gateway beside a test, and return what it said."""
    said = []

    async def inner():
        options_here = Ros2Options(domain=DOMAIN, **options)
        role = Role.COMMAND if options_here.allow_commands else Role.VIEW
        link = LinkOptions(server.address, "ros2", role=role)
        work = serve_ros2(link, options_here, said.append)
        gateway = asyncio.create_task(work, name="gateway")
        try:
            await until(lambda: said or gateway.done())
            await test(said)
        finally:
            gateway.cancel()
            await asyncio.gather(gateway, return_exceptions=True)

    asyncio.run(inner())
    return said


@needs_cyclone
def test_it_says_what_it_does(server):
    async def nothing(said):
        pass

    assert beside(server, nothing)[0] == (
        f"dh_drone: 22 ROS 2 topics under /dh_drone in domain {DOMAIN}, for this computer alone; "
        "it only watches; Ctrl-C ends it"
    )
    assert "commands are taken" in beside(server, nothing, allow_commands=True)[0]


@needs_cyclone
def test_who_wants_to_fly_hears_why_it_does_not(server):
    async def order(said):
        from cyclonedds.domain import DomainParticipant
        from cyclonedds.pub import DataWriter

        from workbench.extras.gateways.ros2_dds import dds_topic, endpoint_qos, message_type
        from workbench.extras.gateways.ros2_definitions import STRING_TYPE

        other = DomainParticipant(DOMAIN)
        kind = message_type(STRING_TYPE)
        topic = dds_topic(other, "/dh_drone/flight_operation", kind)
        writer = DataWriter(other, topic, qos=endpoint_qos())
        await until(writer.get_matched_subscriptions)
        writer.write(kind.sample({"data": "take_off"}))
        await until(lambda: len(said) > 1)

    said = beside(server, order)
    assert "only watches: start it with --allow-commands" in said[1]
    assert not any("take_off" in str(each) for each in server.operations)


@needs_cyclone
def test_a_lost_connection_is_said(server):
    async def stop_and_start(said):
        threads = server.threads
        server.listener.shutdown(socket.SHUT_RDWR)
        server.listener.close()
        server.cut()
        await until(lambda: "nobody listens" in said[-1])
        server.listen(server.port)
        server.threads += threads
        await until(lambda: "again" in said[-1] and "connected" in said[-1])

    said = beside(server, stop_and_start)
    assert said[-1] == "connected to dh_drone again"


@needs_cyclone
def test_a_server_that_is_another_one_now_ends_it(server):
    ended = []

    async def replace(said):
        server.greet = lambda peer: peer.stream.sendall(b"HTTP/1.1 200 OK\r\n\r\n" * 4)
        server.cut()
        (gateway,) = [each for each in asyncio.all_tasks() if each.get_name() == "gateway"]
        await until(gateway.done)
        ended.append(gateway.exception())

    beside(server, replace)
    assert isinstance(ended[0], WorkbenchError)
    assert "cannot be understood" in str(ended[0])


def test_the_command_writes_the_package_of_messages(tmp_path):
    words = [sys.executable, "-m", "workbench", "gateway", "ros2", "--write-messages", tmp_path]
    done = subprocess.run(words, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "dh_drone_msgs" / "msg" / "PositionData.msg").is_file()
