"""Which addresses are one machine's, as far as counting goes."""

import ipaddress

IPV6_PREFIX = 64
"""Bits: a machine has all the addresses of such a network to itself, 2^64 of them."""


def host_of(address: str) -> str:
    """Return the host of "HOST:PORT", IPv6 without brackets."""
    return address.rpartition(":")[0].strip("[]")


def network_of(host: str) -> str:
    """Return what stands for all addresses that whoever has this one can have as well."""
    try:
        address = ipaddress.ip_address(host.partition("%")[0])
    except ValueError:
        return host
    if isinstance(address, ipaddress.IPv4Address):
        return host
    if address.ipv4_mapped:
        return str(address.ipv4_mapped)
    return str(ipaddress.ip_network((int(address), IPV6_PREFIX), strict=False))
