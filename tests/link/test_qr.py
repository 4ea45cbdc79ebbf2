"""The page's address, and its QR code."""

import io
import ipaddress
import socket
import sys

import pytest
from PIL import Image

from workbench.link import page_address as module
from workbench.link.page_address import is_page_reachable, lan_address, page_address
from workbench.link.qr import QUIET_ZONE_MODULES, png_code, terminal_code

URL = "http://192.168.1.7:8080/"
FINDER = ["1111111", "1000001", "1011101", "1011101", "1011101", "1000001", "1111111"]
"""The pattern in three corners of each code, by its standard."""


def of_picture(scale=3):
    """Return the modules of the PNG, its border too."""
    image = Image.open(io.BytesIO(png_code(URL, scale))).convert("L")
    size = image.width // scale
    return [
        "".join(
            "1" if image.getpixel((x * scale + 1, y * scale + 1)) < 128 else "0"
            for x in range(size)
        )
        for y in range(size)
    ]


def of_terminal():
    rows = []
    for line in terminal_code(URL).splitlines():
        assert line.startswith("\x1b[38;5;16;48;5;231m") and line.endswith("\x1b[0m")
        text = line.removeprefix("\x1b[38;5;16;48;5;231m").removesuffix("\x1b[0m")
        rows.append("".join("1" if sign in "▀█" else "0" for sign in text))
        rows.append("".join("1" if sign in "▄█" else "0" for sign in text))
    return rows


def test_the_picture_is_a_code_with_its_quiet_border():
    rows = of_picture()
    size = len(rows)
    assert (size - 2 * QUIET_ZONE_MODULES) % 4 == 1  # 21, 25, 29 ... by the standard
    assert all("1" not in row for row in rows[:QUIET_ZONE_MODULES] + rows[-QUIET_ZONE_MODULES:])
    for top, left in (
        (QUIET_ZONE_MODULES, QUIET_ZONE_MODULES),
        (QUIET_ZONE_MODULES, size - QUIET_ZONE_MODULES - 7),
        (size - QUIET_ZONE_MODULES - 7, QUIET_ZONE_MODULES),
    ):
        assert [row[left : left + 7] for row in rows[top : top + 7]] == FINDER


def test_the_terminal_shows_the_picture():
    rows, picture = of_terminal(), of_picture()
    assert rows[: len(picture)] == picture
    assert all("1" not in row for row in rows[len(picture) :])


def test_a_code_of_another_address_is_another():
    assert terminal_code(URL) != terminal_code(URL + "x")


@pytest.mark.parametrize(
    "host, scheme, url, reachable",
    [
        ("127.0.0.1", "http", "http://127.0.0.1:80/", False),
        ("localhost", "http", "http://localhost:80/", False),
        ("::1", "http", "http://[::1]:80/", False),
        ("192.168.1.7", "https", "https://192.168.1.7:80/", True),
        ("fd00::7", "http", "http://[fd00::7]:80/", True),
        ("drone.local", "http", "http://drone.local:80/", True),
    ],
)
def test_the_address_is_where_the_page_listens(host, scheme, url, reachable):
    found = page_address(host, 80, scheme)
    assert (found, is_page_reachable(found)) == (url, reachable)


@pytest.mark.parametrize(
    ("host", "in_network", "alone"),
    [
        ("0.0.0.0", "http://192.168.1.7:80/", "http://127.0.0.1:80/"),
        ("::", "http://[fd00::7]:80/", "http://[::1]:80/"),
    ],
)
def test_listening_everywhere_is_told_by_the_address_in_the_network(
    host, in_network, alone, monkeypatch
):
    addresses = {False: "192.168.1.7", True: "fd00::7"}
    monkeypatch.setattr(module, "lan_address", addresses.get)
    assert page_address(host, 80) == in_network
    monkeypatch.setattr(module, "lan_address", lambda by_ipv6: None)
    found = page_address(host, 80)
    assert (found, is_page_reachable(found)) == (alone, False)


@pytest.mark.parametrize("by_ipv6", [False, True])
def test_the_address_in_the_network_is_one_of_this_machine(by_ipv6):
    found = lan_address(by_ipv6)
    if found is None:
        pytest.skip("this machine is in no such network")
    family = socket.AF_INET6 if by_ipv6 else socket.AF_INET
    with socket.create_server((found, 0), family=family) as server:
        assert server.getsockname()[0] == found
    assert not ipaddress.ip_address(found).is_loopback


@pytest.mark.parametrize("by_ipv6", [False, True])
def test_a_machine_without_network_has_no_such_address(by_ipv6, monkeypatch):
    class Unplugged(socket.socket):
        def connect(self, address):
            raise OSError("Network is unreachable")

    monkeypatch.setattr(module.socket, "socket", Unplugged)
    assert lan_address(by_ipv6) is None


def test_the_code_needs_segno_only_when_it_is_drawn():
    assert "segno" not in vars(sys.modules["workbench.link.page_address"])
