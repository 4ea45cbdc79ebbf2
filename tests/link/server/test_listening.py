"""The socket that listens."""

import socket

import pytest

from workbench.link.server import acceptor
from workbench.link.server.acceptor import listen


def test_an_address_of_a_link_is_listened_at_with_its_number(monkeypatch):
    found = ("fe80::1", 7733, 0, 3)
    family = socket.AF_INET6
    bound = []
    monkeypatch.setattr(
        acceptor.socket, "getaddrinfo", lambda *_, **__: [(family, 1, 6, "", found)]
    )

    def create(address, **_):
        bound.append(address)
        return socket.socket()

    monkeypatch.setattr(acceptor.socket, "create_server", create)
    listen("fe80::1%eth0", 7733).close()
    assert bound == [found]


@pytest.mark.skipif(not socket.has_ipv6, reason="needs IPv6")
def test_all_of_ipv6_is_none_of_ipv4():
    try:
        listener = listen("::", 0)
    except Exception:
        pytest.skip("this machine has no IPv6")
    with listener:
        assert listener.getsockopt(socket.IPPROTO_IPV6, socket.IPV6_V6ONLY) == 1
