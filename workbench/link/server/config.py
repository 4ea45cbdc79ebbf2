"""The configuration of a server: where it listens, its clients, and their permissions."""

import ipaddress
import os
import ssl
from dataclasses import dataclass
from pathlib import Path

from workbench.common.errors import WorkbenchError
from workbench.common.optional_package import require_package
from workbench.common.plain_files import read_plain
from workbench.link.address import DEFAULT_PORT, LOOPBACK_HOST, is_loopback
from workbench.link.authentication import Tokens, read_tokens
from workbench.link.page_address import is_wildcard, lan_address

MAX_PORT = 65535
MAX_TLS_FILE_BYTES = 1_000_000
"""Size limit of a certificate with its chain, and of a key [bytes]."""
MAKE_CERTIFICATE = (
    "openssl req -x509 -newkey ec -pkeyopt ec_paramgen_curve:P-256 -nodes -days 365 "
    "-subj /CN=drone -addext subjectAltName={name} -out drone.pem -keyout drone.key"
)
"""A command that makes a certificate and its key for a name."""


@dataclass(frozen=True)
class ServerConfig:
    """The configuration of a server.

    Attributes:
        host: name or address to listen at.
        port: of TCP, 0 for a free one.
        token_file: two tokens, to view and to command; "" without login.
        tls_cert: certificate chain (PEM), "" without TLS; others than this machine need it, and
            tokens.
        tls_key: its private key (PEM).
        allow_commands: whether clients may send commands; otherwise all of them only watch.
        web: whether to serve the page for phones.
        web_port: port of the page, 0 for a free one.
        clients: largest number at once, of any kind.
        clients_an_address: largest number at once from one address of another machine.
    """

    host: str = LOOPBACK_HOST
    port: int = DEFAULT_PORT
    token_file: str = ""
    tls_cert: str = ""
    tls_key: str = ""
    allow_commands: bool = True
    web: bool = False
    web_port: int = 0
    clients: int = 16
    clients_an_address: int = 4

    def check(self) -> None:
        """Check that the configuration is valid.

        Raises:
            WorkbenchError: if it is not.
        """
        if not self.host or any(sign.isspace() or sign == "/" for sign in self.host):
            raise WorkbenchError(
                f"'{self.host}' is not a host: write {LOOPBACK_HOST}, or 0.0.0.0 for all"
            )
        for name, port in (("port", self.port), ("port of the page", self.web_port)):
            if isinstance(port, bool) or not isinstance(port, int) or not 0 <= port <= MAX_PORT:
                raise WorkbenchError(f"the {name} {port} is not a number from 0 to {MAX_PORT}")
        if self.web:
            require_package("websockets", "pages for phones and browsers")
        if self.web and self.port == self.web_port != 0:
            raise WorkbenchError(f"server and page cannot both have the port {self.port}")
        for name in ("clients", "clients_an_address"):
            if getattr(self, name) < 1:
                raise WorkbenchError(f"{name} is {getattr(self, name)}: allow 1 at least")
        if not self.is_local and not self.token_file:
            raise WorkbenchError(
                f"others can reach {self.host}, and without tokens anybody of them could fly: "
                f"give a token file, or listen at {LOOPBACK_HOST}"
            )
        if not self.is_local and not (self.tls_cert or self.tls_key):
            raise WorkbenchError(
                f"others can reach {self.host}, and without TLS anybody between could read the "
                "tokens and fly: give a certificate and its key, as this makes: "
                + MAKE_CERTIFICATE.format(name=_certified(self.host))
            )
        self.tokens()
        self.tls()

    @property
    def is_local(self) -> bool:
        """Whether only programs of this machine can connect."""
        return is_loopback(self.host)

    def tokens(self) -> Tokens | None:
        """Return the tokens, or None if no login is required.

        Raises:
            WorkbenchError: if the token file is invalid.
        """
        return read_tokens(Path(self.token_file)) if self.token_file else None

    def tls(self) -> ssl.SSLContext | None:
        """Return the context for TLS, or None without TLS.

        Raises:
            WorkbenchError: if certificate or key is invalid.
        """
        if not self.tls_cert and not self.tls_key:
            return None
        if not self.tls_cert or not self.tls_key:
            missing = "key" if self.tls_cert else "certificate"
            raise WorkbenchError(f"TLS needs a certificate and its key: give the {missing}, too")
        for path in (self.tls_cert, self.tls_key):
            read_plain(path, MAX_TLS_FILE_BYTES)
        context = ssl.create_default_context(ssl.Purpose.CLIENT_AUTH)
        try:
            # Never ask for a password: nobody is at the terminal of a server.
            context.load_cert_chain(self.tls_cert, self.tls_key, password=lambda: "")
        except (OSError, ValueError) as error:  # ssl.SSLError is an OSError
            raise WorkbenchError(
                f"{self.tls_cert} and {self.tls_key} are not a certificate (PEM) and its key "
                f"without a password: {getattr(error, 'reason', None) or error}"
            ) from error
        key = Path(self.tls_key).stat()
        # As in ssh, only the user's own key is checked; another owner may share a key.
        if key.st_uid == os.getuid() and key.st_mode & 0o077:
            raise WorkbenchError(
                f"{self.tls_key}: others may read this private key (mode "
                f"{key.st_mode & 0o777:04o}): run chmod 600 {self.tls_key}"
            )
        return context


def _certified(host: str) -> str:
    """Return the name for the certificate of a server that listens at a host."""
    own = (lan_address(":" in host) or host) if is_wildcard(host) else host
    try:
        ipaddress.ip_address(own)
    except ValueError:
        return f"DNS:{own}"
    return f"IP:{own}"
