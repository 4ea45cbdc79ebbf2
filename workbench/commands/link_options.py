"""Options of commands that connect to a drone's server."""

import argparse
from typing import NamedTuple

from workbench.common.errors import WorkbenchError

SYSTEM = "system"


class LinkOptions(NamedTuple):
    """How to connect.

    Attributes:
        address: HOST:PORT.
        token: of the role; "" where none is needed.
        tls: as for `workbench.link.Client`.
    """

    address: str
    token: str
    tls: str | bool | None


def add_link_options(parser: argparse.ArgumentParser) -> None:
    """Add the server's address and how it is trusted."""
    parser.add_argument(
        "address",
        nargs="?",
        default="127.0.0.1:7733",
        metavar="HOST:PORT",
        help="of the server (default: 127.0.0.1:7733)",
    )
    parser.add_argument(
        "--token-file",
        default="",
        metavar="FILE",
        help="the server's token file, or its line `view: TOKEN` or `command: TOKEN`; mode 0600",
    )
    parser.add_argument(
        "--tls",
        default="",
        metavar="system|FILE|sha256:HEX",
        help="connect by TLS, and trust the system's authorities, those in a file (PEM), or the "
        "one certificate with this fingerprint",
    )


def link_options(args: argparse.Namespace, flies: bool) -> LinkOptions:
    """Return how to connect.

    Args:
        args: with what `add_link_options` adds.
        flies: whether the token to command is wanted, or that to view.

    Raises:
        WorkbenchError: if the token file is no good, or the address is none.
    """
    from workbench.link.address import parse_address
    from workbench.link.authentication import read_token
    from workbench.link.messages import Role

    address = parse_address(args.address)
    role = Role.COMMAND if flies else Role.VIEW
    token = read_token(args.token_file, role) if args.token_file else ""
    return LinkOptions(str(address), token, args.tls == SYSTEM or args.tls or None)


def parse_rate(text: str) -> float:
    """Return a number of samples a second.

    Raises:
        WorkbenchError: if it is none.
    """
    try:
        return float(text)
    except ValueError:
        raise WorkbenchError(f"the rate '{text}' is no number of samples a second") from None
