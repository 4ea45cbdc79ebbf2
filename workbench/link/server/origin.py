"""Whether a browser asks for this page, and from it: all else may be another's page at work.

A page of anybody can make a browser connect to a WebSocket of this machine; its Origin tells. A
name that an attacker points to this machine makes the attacker's page look like ours; the Host
tells.
"""

import ipaddress

from workbench.link.address import is_loopback


def is_own_host(asked: str, local: str, named: str) -> bool:
    """Return whether a request is addressed to this machine as it listens.

    Args:
        asked: the Host of the request, with or without a port.
        local: address of this machine that the connection came to.
        named: the host that the server was told to listen at.
    """
    host = host_of(asked).lower()
    if not host:
        return False
    try:
        return _plain(host) == _plain(local)
    except ValueError:
        return host == named.lower() or (host == "localhost" and is_loopback(local))


def is_own_origin(origin: str, asked: str, scheme: str) -> bool:
    """Return whether a WebSocket is asked for by the page that this server gave.

    Args:
        origin: of the request, as the browser says; only browsers cannot lie here.
        asked: the Host of the request.
        scheme: http or https, of the connection.
    """
    return origin.lower() == f"{scheme}://{asked.lower()}"


def host_of(asked: str) -> str:
    """Return the name or address in a Host, without port and brackets; "" if it is none."""
    if asked.startswith("["):
        name, bracket, rest = asked[1:].partition("]")
        understood = bool(bracket) and (not rest or rest.startswith(":"))
        port = rest[1:]
    else:
        name, colon, port = asked.partition(":")
        understood = not colon or bool(port)
    if not understood or (port and not (port.isascii() and port.isdigit())):
        return ""
    return name


def _plain(text: str) -> ipaddress.IPv4Address | ipaddress.IPv6Address:
    """Return an address; of IPv4 within IPv6, that of IPv4.

    Raises:
        ValueError: if it is a name.
    """
    address = ipaddress.ip_address(text.partition("%")[0])
    return getattr(address, "ipv4_mapped", None) or address
