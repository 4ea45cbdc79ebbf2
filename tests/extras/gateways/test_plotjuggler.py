import json
import signal
import socket
import subprocess
import sys

import pytest

from workbench.common.errors import WorkbenchError
from workbench.extras.gateways.plotjuggler import MAX_DATAGRAM_BYTES, PlotJuggler, datagram
from workbench.link.address import Address
from workbench.link.drone_topics import drone_topics
from workbench.link.sample import Sample
from workbench.link.signal import TopicOptions

TOPICS = {
    topic.name.rsplit("/", 1)[1]: topic
    for topic in drone_topics(TopicOptions(4, 200.0, 10.0, rates={"lidar": 10.0}, rays=40_000))
}
VELOCITY = (1.0, 2.0, -3.0, 0.5, 0.25, 0.125)


def sample(name, *values, t_ns=1_250_000_000):
    return Sample(TOPICS[name], t_ns, TOPICS[name].pack(values))


@pytest.fixture
def listener():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as listener:
        listener.bind(("127.0.0.1", 0))
        listener.settimeout(300.0)
        yield listener


def test_a_sample_is_nested_by_its_topic_with_a_timestamp_in_seconds():
    assert json.loads(datagram(sample("velocity_data", *VELOCITY))) == {
        "timestamp": 1.25,
        "dh_drone": {
            "velocity_data": {
                "v_x": 1.0,
                "v_y": 2.0,
                "v_z": -3.0,
                "w_x": 0.5,
                "w_y": 0.25,
                "w_z": 0.125,
            }
        },
    }


def test_lists_and_texts_stay_what_they_are():
    said = json.loads(datagram(sample("rotors", (1.0, 2.0, 3.0, 4.0), (0.5,) * 4)))
    assert said["dh_drone"]["rotors"] == {"speed": [1.0, 2.0, 3.0, 4.0], "thrust": [0.5] * 4}
    said = json.loads(datagram(sample("drone_state", 3, "hovering", 1.0, 2.0)))
    assert said["dh_drone"]["drone_state"]["condition"] == "hovering"


def test_what_is_not_finite_is_null():
    numbers = (float("nan"), float("inf"), -float("inf"), 1.0, 2.0, 3.0)
    said = json.loads(datagram(sample("velocity_data", *numbers)))["dh_drone"]["velocity_data"]
    assert [said["v_x"], said["v_y"], said["v_z"]] == [None] * 3


def test_samples_arrive_as_datagrams(listener):
    outlet = PlotJuggler(Address(*listener.getsockname()), print)
    outlet.deliver(sample("velocity_data", *VELOCITY))
    outlet.deliver(sample("velocity_data", *VELOCITY, t_ns=2_000_000_000))
    outlet.close()
    assert [json.loads(listener.recv(65536))["timestamp"] for _ in range(2)] == [1.25, 2.0]


def test_what_is_too_large_is_said_once(listener):
    said = []
    outlet = PlotJuggler(Address(*listener.getsockname()), said.append)
    for _ in range(2):
        outlet.deliver(sample("lidar_cloud", 0, (1.5,) * 40_000))
    outlet.deliver(sample("velocity_data", *VELOCITY))
    outlet.close()
    assert len(listener.recv(65536)) < MAX_DATAGRAM_BYTES
    assert len(said) == 1 and "/dh_drone/lidar_cloud is left out" in said[0]


def test_nobody_listening_is_no_failure():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as gone:
        gone.bind(("127.0.0.1", 0))
        address = Address(*gone.getsockname())
    outlet = PlotJuggler(address, print)
    for _ in range(10):
        outlet.deliver(sample("velocity_data", *VELOCITY))
    outlet.close()


def test_an_unknown_host_is_a_sentence():
    with pytest.raises(WorkbenchError, match="the host 'no.such.invalid' is unknown"):
        PlotJuggler(Address("no.such.invalid", 9870), print)


def test_the_command_passes_on_until_ctrl_c(listener, server, fakes):
    to = "{}:{}".format(*listener.getsockname())
    words = ["gateway", "plotjuggler", server.address, "--to", to, "--topics", "velocity_data"]
    process = subprocess.Popen(
        [sys.executable, "-m", "workbench", *words, "--json"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    try:
        assert f"dh_drone: sending to {to}" in process.stderr.readline()
        assert json.loads(process.stdout.readline()) == {"vehicle": "dh_drone", "address": to}
        fakes.wait_until(lambda: server.peers and server.peers[0].topics)
        assert server.peers[0].topics == ("/dh_drone/velocity_data",)
        server.publish(3_000_000_000, velocity_data=VELOCITY)
        said = json.loads(listener.recv(65536))
        assert said["timestamp"] == 3.0 and said["dh_drone"]["velocity_data"]["v_z"] == -3.0
        process.send_signal(signal.SIGINT)
        assert process.wait(300.0) == 0
    finally:
        process.kill()
        process.wait()
        process.stdout.close()
        process.stderr.close()
