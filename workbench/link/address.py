"""Addresses of servers as entered by users: HOST:PORT."""

import ipaddress
from typing import NamedTuple

from workbench.common.errors import WorkbenchError

DEFAULT_PORT = 7733
LOOPBACK_HOST = "127.0.0.1"
IPV6_PREFIX_BITS = 64
"""Prefix length of the IPv6 network of a single machine, with 2^64 addresses [bits]."""


class Address(NamedTuple):
    """The address of a server.

    Attributes:
        host: a name or an IP address; IPv6 without brackets.
        port: 1 to 65535.
    """

    host: str
    port: int

    def __str__(self) -> str:
        return f"[{self.host}]:{self.port}" if ":" in self.host else f"{self.host}:{self.port}"


def parse_address(text: str, port: int = DEFAULT_PORT) -> Address:
    """Return the address for `HOST:PORT`, `HOST`, `:PORT` or `[IPv6]:PORT`; here without a host.

    Args:
        text: the text.
        port: default if the text has none.

    Raises:
        WorkbenchError: if it is invalid.
    """
    written = text.strip()
    if written.startswith("["):
        named, bracket, rest = written[1:].partition("]")
        digits = rest[1:]
        understood = bool(bracket) and (not rest or rest.startswith(":"))
    elif written.count(":") > 1:  # IPv6 without brackets cannot have a port
        named, digits, understood = written, "", True
    else:
        named, colon, digits = written.partition(":")
        understood = not colon or bool(digits)
    if not understood or any(sign.isspace() or sign == "/" for sign in named):
        raise WorkbenchError(
            f"'{text}' is not an address: write HOST:PORT, as {LOOPBACK_HOST}:{port}"
        )
    if digits and not (digits.isascii() and digits.isdigit() and 0 < int(digits[:6]) < 65536):
        raise WorkbenchError(f"'{text}': the port '{digits}' is not a number from 1 to 65535")
    return Address(named or LOOPBACK_HOST, int(digits) if digits else port)


def is_loopback(host: str) -> bool:
    """Return whether an address is a loopback address, or the name localhost."""
    try:
        address = ipaddress.ip_address(host.partition("%")[0])
    except ValueError:
        return host.lower() == "localhost"
    if isinstance(address, ipaddress.IPv6Address) and address.ipv4_mapped:
        return address.ipv4_mapped.is_loopback
    return address.is_loopback


def host_of(address: str) -> str:
    """Return the host of "HOST:PORT", IPv6 without brackets."""
    return address.rpartition(":")[0].strip("[]")


def network_of(host: str) -> str:
    """Return the network of all addresses that the machine with this address may use."""
    try:
        address = ipaddress.ip_address(host.partition("%")[0])
    except ValueError:
        return host
    if isinstance(address, ipaddress.IPv4Address):
        return host
    if address.ipv4_mapped:
        return str(address.ipv4_mapped)
    return str(ipaddress.ip_network((int(address), IPV6_PREFIX_BITS), strict=False))
