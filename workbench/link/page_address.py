"""The address of the page, to type or as a code for phones."""

import ipaddress
import socket
from urllib.parse import urlsplit

from workbench.link.address import Address, is_loopback

# A UDP socket connected to any remote address knows the local address of the route; nothing is
# sent. These addresses are reserved for documentation.
_REMOTE_IPV4 = "192.0.2.1"
_REMOTE_IPV6 = "2001:db8::1"


def page_address(host: str, port: int, scheme: str = "http") -> str:
    """Return the address of the page, to type or to scan, for a host and port.

    Args:
        host: name or address that the server listens at; 0.0.0.0 is all IPv4 addresses of this
            machine, :: all IPv6 addresses.
        port: that it listens at.
        scheme: http or https.
    """
    reached = host
    if is_wildcard(host):
        by_ipv6 = ":" in host
        reached = lan_address(by_ipv6) or ("::1" if by_ipv6 else "127.0.0.1")
    return f"{scheme}://{Address(reached, port)}/"


def is_page_reachable(url: str) -> bool:
    """Return whether other machines and phones can reach the page at an address."""
    return not is_loopback(urlsplit(url).hostname or "")


def is_wildcard(host: str) -> bool:
    """Return whether a host means all addresses of this machine."""
    try:
        return ipaddress.ip_address(host).is_unspecified
    except ValueError:
        return False


def lan_address(by_ipv6: bool = False) -> str | None:
    """Return the address of this machine in its network, None without a network.

    Args:
        by_ipv6: whether to return an IPv6 address instead of IPv4.
    """
    family, far = (socket.AF_INET6, _REMOTE_IPV6) if by_ipv6 else (socket.AF_INET, _REMOTE_IPV4)
    try:
        with socket.socket(family, socket.SOCK_DGRAM) as asking:
            asking.connect((far, 9))
            found = str(asking.getsockname()[0])
    except OSError:  # no route
        return None
    return None if ipaddress.ip_address(found).is_link_local else found
