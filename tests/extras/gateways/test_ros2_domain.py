"""The domain of DDS that stays on this computer."""

import os
import socket
from pathlib import Path

import pytest

pytest.importorskip("cyclonedds", reason="install the extra `ros2` to try it")

from workbench.common.errors import WorkbenchError
from workbench.extras.gateways import ros2_dds
from workbench.extras.gateways.ros2_dds import DdsDomain, accept_only_interface, configuration_of

DOMAIN = 101 + os.getpid() % 100


@pytest.fixture
def pair():
    with (
        socket.socket(type=socket.SOCK_DGRAM) as receiver,
        socket.socket(type=socket.SOCK_DGRAM) as sender,
    ):
        receiver.bind(("127.0.0.1", 0))
        sender.connect(receiver.getsockname())
        yield receiver, sender


def test_a_socket_hears_by_the_interface_that_it_is_told(pair):
    receiver, sender = pair
    accept_only_interface(receiver.fileno(), socket.if_nametoindex("lo"))
    sender.send(b"here")
    receiver.settimeout(10.0)
    assert receiver.recv(10) == b"here"


def test_a_socket_hears_nothing_by_another_interface(pair):
    receiver, sender = pair
    accept_only_interface(receiver.fileno(), socket.if_nametoindex("lo") + 1)
    sender.send(b"from elsewhere")  # loopback delivers at once, or not at all
    receiver.setblocking(False)
    with pytest.raises(BlockingIOError):
        receiver.recv(10)


def test_all_sockets_of_the_domain_are_closed_in(monkeypatch):
    told = []
    monkeypatch.setattr(ros2_dds, "accept_only_interface", lambda *both: told.append(both))
    before = ros2_dds._sockets()
    with DdsDomain(DOMAIN):
        opened = ros2_dds._sockets() - before
    lo = socket.if_nametoindex("lo")
    assert opened
    assert sorted(told) == sorted((descriptor, lo) for descriptor in opened)


def test_what_a_network_is_to_hear_is_not_closed_in(monkeypatch):
    monkeypatch.setattr(ros2_dds, "accept_only_interface", lambda *both: pytest.fail("it was"))
    own = configuration_of("lo")  # in this test nothing leaves the computer either
    with DdsDomain(DOMAIN, configuration=own):
        pass


def test_nothing_is_left_behind():
    sockets, threads = ros2_dds._sockets(), len(list(Path("/proc/self/task").iterdir()))
    with DdsDomain(DOMAIN) as domain:
        assert domain.participant is not None
    assert ros2_dds._sockets() == sockets
    assert len(list(Path("/proc/self/task").iterdir())) <= threads


def test_a_filter_that_the_system_refuses_is_said(monkeypatch):
    def refuse(*_):
        raise OSError(92, "Protocol not available")

    monkeypatch.setattr(ros2_dds, "accept_only_interface", refuse)
    before = ros2_dds._sockets()
    with pytest.raises(WorkbenchError, match=r"cannot be kept to this computer.*not available"):
        DdsDomain(DOMAIN).__enter__()
    assert ros2_dds._sockets() == before


def test_an_interface_that_is_not_there_is_said(capfd):
    with pytest.raises(WorkbenchError, match=f"DDS domain {DOMAIN} cannot be joined"):
        DdsDomain(DOMAIN, interface="nothere9").__enter__()


def test_a_configuration_that_cyclone_refuses_is_said(capfd):
    with pytest.raises(WorkbenchError, match="refuses the configuration of --config: its reason"):
        DdsDomain(DOMAIN, configuration="<CycloneDDS><bad").__enter__()
    assert "unknown element" in capfd.readouterr().err


def test_an_interface_is_named_by_its_name_or_its_address():
    assert '<NetworkInterface address="10.1.2.3"/>' in configuration_of("10.1.2.3")
    names = [name for _, name in socket.if_nameindex() if name != "lo"]
    for name in names:
        assert f'<NetworkInterface name="{name}"/>' in configuration_of(name)


def test_what_stands_in_an_interface_cannot_change_the_configuration():
    assert "<Peers>" not in configuration_of('"/><Peers>')
