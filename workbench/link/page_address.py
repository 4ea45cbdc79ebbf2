"""The address of the page, to type or as a code for phones."""

import ipaddress
import socket
from dataclasses import dataclass
from urllib.parse import urlencode, urlsplit

from workbench.link.address import Address, is_loopback

# A UDP socket connected to any remote address knows the local address of the route; nothing is
# sent. These addresses are reserved for documentation.
_REMOTE_IPV4 = "192.0.2.1"
_REMOTE_IPV6 = "2001:db8::1"


@dataclass(frozen=True)
class PageAddress:
    """The address of the page.

    Attributes:
        url: to type or to scan.
    """

    url: str

    @property
    def is_reachable(self) -> bool:
        """Whether other machines and phones can reach it."""
        return not is_loopback(urlsplit(self.url).hostname or "")

    @property
    def said(self) -> str:
        """The address, and who can use it, in words."""
        if self.is_reachable:
            return f"{self.url} (a phone in the same network can open it)"
        return (
            f"{self.url} (only this machine can open it: for a phone, listen at 0.0.0.0 with a "
            "token file and a certificate)"
        )

    def with_token(self, token: str, role: str) -> str:
        """Return an address that logs in automatically; it and its code contain the token.

        The token follows a #, so browsers do not send it, and servers do not log it.

        Args:
            token: of the role.
            role: view or command.
        """
        return f"{self.url}#{urlencode({'token': token, 'role': role})}"


def page_address(host: str, port: int, scheme: str = "http") -> PageAddress:
    """Return the address of the page for a host and port.

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
    return PageAddress(f"{scheme}://{Address(reached, port)}/")


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
