import pytest

from workbench.common.errors import WorkbenchError
from workbench.link.address import parse_address


def test_an_address_is_understood(case):
    for text, host, port in [
        ("127.0.0.1:7733", "127.0.0.1", 7733),
        ("drone.local", "drone.local", 7733),
        (":9000", "127.0.0.1", 9000),
        ("", "127.0.0.1", 7733),
        ("[::1]:80", "::1", 80),
        ("[::1]", "::1", 7733),
        ("fe80::1", "fe80::1", 7733),
        (" localhost:1 ", "localhost", 1),
        ("localhost:65535", "localhost", 65535),
    ]:
        with case(text, host, port):
            assert parse_address(text) == (host, port)


def test_what_is_no_address_is_a_sentence(case):
    for text in [
        "h:",
        "h:x",
        "h:0",
        "h:65536",
        "h:-1",
        "h:٣",
        "a b:1",
        "[::1",
        "[::1]x:1",
        "http://h:1",
        "h:1/",
    ]:
        with (
            case(text),
            pytest.raises(
                WorkbenchError, match=r"is not an address: write HOST:PORT|is not a number from"
            ),
        ):
            parse_address(text)


def test_ipv6_is_written_in_brackets():
    assert str(parse_address("[::1]:80")) == "[::1]:80"
    assert str(parse_address("h")) == "h:7733"
