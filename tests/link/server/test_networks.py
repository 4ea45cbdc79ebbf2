"""Which addresses count as one."""

import pytest

from workbench.link.address import host_of, network_of


def test_a_network_of_ipv6_is_one(case):
    for one, other, same in [
        ("10.0.0.1", "10.0.0.2", False),
        ("127.0.0.1", "127.0.0.2", False),
        ("::ffff:10.0.0.1", "10.0.0.1", True),
        ("::ffff:10.0.0.1", "::ffff:10.0.0.2", False),
        ("2001:db8::1", "2001:db8::ffff:ffff:ffff:ffff", True),
        ("2001:db8::1", "2001:db8:0:1::1", False),
        ("fe80::1%eth0", "fe80::2", True),
        ("unknown", "unknown", True),
    ]:
        with case(one, other, same):
            assert (network_of(one) == network_of(other)) is same


@pytest.mark.parametrize(
    ("address", "host"),
    [("10.0.0.1:5", "10.0.0.1"), ("[::1]:5", "::1"), ("[fe80::1%eth0]:5", "fe80::1%eth0")],
)
def test_the_host_of_an_address(address, host):
    assert host_of(address) == host
