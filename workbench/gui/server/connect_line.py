"""What a colleague types to connect."""

import hashlib
import ssl
from pathlib import Path

from workbench.link.address import Address, parse_address
from workbench.link.client_tls import FINGERPRINT
from workbench.link.page_address import is_wildcard, lan_address
from workbench.link.server.config import ServerConfig


def reachable_address(listening: str) -> str:
    """Return where others reach a server; this asks the system, and nothing is sent.

    Args:
        listening: HOST:PORT, whose host may mean all addresses of this machine.
    """
    address = parse_address(listening)
    if not is_wildcard(address.host):
        return listening
    by_ipv6 = ":" in address.host
    own = lan_address(by_ipv6) or ("::1" if by_ipv6 else "127.0.0.1")
    return str(Address(own, address.port))


def connect_line(address: str, config: ServerConfig) -> str:
    """Return the command that watches a served flight.

    Args:
        address: where the server is reached.
        config: what it was started with.
    """
    words = ["workbench monitor", address]
    if config.token_file:
        words.append("--token-file FILE")
    if config.tls_cert:
        words.append(f"--tls {fingerprint(config.tls_cert)}")
    return " ".join(words)


def fingerprint(certificate: str) -> str:
    """Return by what a client knows a server's certificate, the first one of a file (PEM)."""
    begin, end = ssl.PEM_HEADER, ssl.PEM_FOOTER
    try:
        text = Path(certificate).read_text(encoding="ascii", errors="replace")
        first = text[text.index(begin) : text.index(end) + len(end)]
        digits = hashlib.sha256(ssl.PEM_cert_to_DER_cert(first)).hexdigest()
    except (OSError, ValueError):  # the server has read it before it was taken away
        digits = "FINGERPRINT"
    return FINGERPRINT + digits
