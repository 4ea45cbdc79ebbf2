"""Whether a browser asks for this page, and from it."""

import pytest

from workbench.link.server.web import is_own_host, is_own_origin


def test_a_host_is_own_where_the_server_listens(case):
    for asked, local, named, own in [
        ("127.0.0.1:8080", "127.0.0.1", "127.0.0.1", True),
        ("127.0.0.1", "127.0.0.1", "127.0.0.1", True),
        ("localhost:8080", "127.0.0.1", "127.0.0.1", True),
        ("LOCALHOST", "::1", "localhost", True),
        ("[::1]:8080", "::1", "::1", True),
        ("192.168.1.7:8080", "192.168.1.7", "0.0.0.0", True),
        ("192.168.1.7:8080", "::ffff:192.168.1.7", "::", True),
        ("drone.local:8080", "192.168.1.7", "drone.local", True),
        ("localhost:8080", "192.168.1.7", "0.0.0.0", False),
        ("192.168.1.8:8080", "192.168.1.7", "0.0.0.0", False),
        ("evil.example:8080", "127.0.0.1", "127.0.0.1", False),
        ("evil.example", "192.168.1.7", "0.0.0.0", False),
        ("127.0.0.1.evil.example", "127.0.0.1", "127.0.0.1", False),
        ("127.0.0.1:80@evil.example", "127.0.0.1", "127.0.0.1", False),
        ("127.0.0.1 evil.example", "127.0.0.1", "127.0.0.1", False),
        ("[::1", "::1", "::1", False),
        ("[::1]8080", "::1", "::1", False),
        ("[127.0.0.1]:8080", "127.0.0.1", "127.0.0.1", False),
        ("127.0.0.1%00:8080", "127.0.0.1", "127.0.0.1", False),
        ("127.0.0.1%25lo", "127.0.0.1", "127.0.0.1", False),
        ("[::1%lo]:8080", "::1", "::1", False),
        ("[::ffff:127.0.0.1%lo]", "127.0.0.1", "127.0.0.1", False),
        ("[localhost]", "127.0.0.1", "localhost", False),
        ("localhost%00", "127.0.0.1", "localhost", False),
        ("[fe80::1]:8080", "fe80::1%eth0", "::", True),
        ("[fe80::2]:8080", "fe80::1%eth0", "::", False),
        ("", "127.0.0.1", "127.0.0.1", False),
        (":8080", "127.0.0.1", "", False),
    ]:
        with case(asked, local, named, own):
            assert is_own_host(asked, local, named) is own


@pytest.mark.parametrize(
    "origin, own",
    [
        ("http://127.0.0.1:80", True),
        ("https://127.0.0.1:80", False),
        ("http://127.0.0.1", False),
        ("http://127.0.0.1:81", False),
        ("http://evil.example", False),
        ("null", False),
        ("", False),
    ],
)
def test_an_origin_is_own_where_the_page_came_from(origin, own):
    assert is_own_origin(origin, "127.0.0.1:80", "http") is own
