"""The connection of a client: opening it, reasons for failure, and the protocol over streams.

With TLS a client trusts its server by the certificate authorities of the system, a file of them, or
a hash.
"""

import asyncio
import contextlib
import errno
import hashlib
import hmac
import socket
import ssl
import time
from dataclasses import dataclass

from workbench.common.errors import WorkbenchError
from workbench.common.plain_files import read_plain
from workbench.link.address import Address, is_loopback
from workbench.link.client_protocol import ClientOptions, ClientProtocol
from workbench.link.message_json import Operation
from workbench.link.messages import Bye, Error, Ping

FINGERPRINT_PREFIX = "sha256:"
MAX_TRUST_FILE_BYTES = 4_000_000
"""Size limit of a file of certificates."""


@dataclass(frozen=True)
class Trust:
    """The server certificates that a client accepts.

    Attributes:
        context: for the connection; None without TLS.
        fingerprint: SHA-256 of the only certificate accepted; empty if authorities decide.
    """

    context: ssl.SSLContext | None = None
    fingerprint: bytes = b""

    def check(self, certificate: bytes | None) -> None:
        """Compare the certificate of the server with the accepted one.

        Args:
            certificate: in DER.

        Raises:
            WorkbenchError: if they differ.
        """
        if not self.fingerprint:
            return
        shown = hashlib.sha256(certificate or b"").digest()
        if not hmac.compare_digest(shown, self.fingerprint):
            raise WorkbenchError(
                f"the server's certificate has the fingerprint {FINGERPRINT_PREFIX}{shown.hex()}, "
                "which "
                "is not the one that was given: connect only if its owner tells you that one"
            )


def make_trust(tls: str | bool | None) -> Trust:
    """Return the certificates that a client accepts.

    Args:
        tls: None or False for no TLS, True for the authorities of the system, the path of a file of
            certificates (PEM) to trust, or `sha256:` and the fingerprint of the server certificate.

    Raises:
        WorkbenchError: if the file cannot be read, or the fingerprint is invalid.
    """
    if not tls:
        return Trust()
    if tls is True:
        return Trust(ssl.create_default_context())
    if tls.startswith(FINGERPRINT_PREFIX):
        return _by_fingerprint(tls)
    what = f"name a file of certificates (PEM), or {FINGERPRINT_PREFIX}FINGERPRINT"
    try:
        read_plain(tls, MAX_TRUST_FILE_BYTES)  # the library would wait for the writer of a pipe
        return Trust(ssl.create_default_context(cafile=tls))
    except WorkbenchError as error:
        raise WorkbenchError(f"{error}: {what}") from None
    except OSError as error:  # ssl.SSLError is one
        raise WorkbenchError(f"{tls}: holds no certificates ({error}): {what}") from None


def _by_fingerprint(tls: str) -> Trust:
    digits = tls.removeprefix(FINGERPRINT_PREFIX).replace(":", "")
    try:
        fingerprint = bytes.fromhex(digits)
    except ValueError:
        fingerprint = b""
    if len(fingerprint) != hashlib.sha256().digest_size:
        raise WorkbenchError(
            f"'{tls}' is not a fingerprint: write {FINGERPRINT_PREFIX} and 64 hexadecimal digits, "
            "as "
            "`openssl x509 -fingerprint -sha256 -noout -in CERTIFICATE` prints them"
        )
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
    context.check_hostname = False  # the certificate is known, whatever name it states
    context.verify_mode = ssl.CERT_NONE
    return Trust(context, fingerprint)


CONNECT_TIMEOUT_S = 5.0
"""Time limit to connect [s]."""
GREETING_TIMEOUT_S = 5.0
"""Time limit for the greeting [s]."""
CROWD_RETRY_S = 1.0
"""Time for which to try again if the server ends a connection before its login: it may have to make
room, as strangers take all of its connections [s]."""
CROWD_PAUSE_S = 0.02
READ_CHUNK_BYTES = 256 * 1024
PING_AFTER_S = 2.0
"""Silence after which a client pings the server [s]; after another such time it disconnects."""
MAX_STATE_SILENCE_S = 0.2
"""Time without a state after which a client in control asks for the simulated time [s]."""
MAX_UNSENT_BYTES = 64 * 1024
"""Largest number of bytes waiting to be sent; a further command would be late, and is not sent."""

RETRIED_ENDS = {"lost", "bye", "slow", "overflow", "too_many", "back_off", "internal"}
"""Ends after which to reconnect; others would only occur again."""


class Connection:
    """An open connection to the server.

    Attributes:
        protocol: its state.
    """

    def __init__(
        self, options: ClientOptions, reader: asyncio.StreamReader, writer: asyncio.StreamWriter
    ) -> None:
        self.protocol = ClientProtocol(options)
        self._reader = reader
        self._writer = writer
        self._end: Error | None = None
        self._pinged = False
        self._told = -MAX_STATE_SILENCE_S

    @property
    def fresh(self) -> bool:
        """Whether the known simulated time is current."""
        return time.monotonic() - self._told < MAX_STATE_SILENCE_S

    @property
    def end(self) -> Error | None:
        """Why the connection ended, None before."""
        return self.protocol.end or self._end

    async def read(self) -> None:
        """Receive data, or detect that no more will come."""
        try:
            async with asyncio.timeout(PING_AFTER_S):
                data = await self._reader.read(READ_CHUNK_BYTES)
        except TimeoutError:
            self._on_silence()
            return
        except OSError as error:
            self._end = Error("lost", f"the connection broke: {error.strerror or error}")
            return
        self._pinged = False
        if data:
            known = self.protocol.newest_ns
            self.protocol.receive(data)
            if self.protocol.newest_ns != known:
                self._told = time.monotonic()
            self._flush()
        else:
            self._end = Error("lost", "the server closed the connection")

    def send(self, operation: Operation) -> None:
        """Send an operation."""
        self.protocol.send(operation)
        self._flush()

    def command(self, payload: bytes) -> None:
        """Send a command, unless earlier ones are still waiting to be sent."""
        if self._writer.transport.get_write_buffer_size() < MAX_UNSENT_BYTES:
            self.protocol.command(payload)
            self._flush()

    async def close(self) -> None:
        """Take leave if the connection is open, and end."""
        if self.end is None:
            self.send(Bye())
            self._end = Error("closed", "the client was closed")
            self._writer.close()
        else:
            self.abort()
        # It no longer matters whether the other side closed properly.
        with contextlib.suppress(OSError, TimeoutError):
            async with asyncio.timeout(1.0):
                await self._writer.wait_closed()
        self.abort()

    def abort(self) -> None:
        """End at once, without taking leave."""
        self._writer.transport.abort()

    def _on_silence(self) -> None:
        if self._pinged:
            self._end = Error("lost", f"the server was silent for {2.0 * PING_AFTER_S:g} s")
            return
        self._pinged = True
        self.send(Ping())

    def _flush(self) -> None:
        data = self.protocol.take_outgoing()
        if data and not self._writer.is_closing():
            self._writer.write(data)


async def open_connection(address: Address, trust: Trust, options: ClientOptions) -> Connection:
    """Return a connection after its greeting.

    Raises:
        RefusedError: if the connection fails, or the server rejects it.
    """
    give_up = time.monotonic() + CROWD_RETRY_S
    while True:
        try:
            reader, writer = await connect(address, trust)
        except WorkbenchError as error:
            raise RefusedError("lost", str(error)) from None
        if options.token and not trust.context and _is_elsewhere(writer):
            writer.transport.abort()
            raise RefusedError(
                "tls",
                f"{address} is another machine, and without TLS anybody between could read the "
                "token: give the server's certificate (PEM), or "
                f"{FINGERPRINT_PREFIX}FINGERPRINT, as tls",
            )
        connection = Connection(options, reader, writer)
        await _greet(connection, address)
        if connection.end is None:
            return connection
        await connection.close()
        if connection.end.code != "lost" or time.monotonic() > give_up:
            said = f"{address}: {connection.end.said}{_hint(connection.end, trust, options)}"
            raise RefusedError(connection.end.code, said)
        await asyncio.sleep(CROWD_PAUSE_S)


async def _greet(connection: Connection, address: Address) -> None:
    """Read until the greeting is done, or the connection has ended.

    Raises:
        RefusedError: if the server is silent.
    """
    try:
        async with asyncio.timeout(GREETING_TIMEOUT_S):
            while not connection.protocol.ready and connection.end is None:
                await connection.read()
    except TimeoutError:
        await connection.close()
        raise RefusedError(
            "lost",
            f"{address} sent no greeting within {GREETING_TIMEOUT_S:g} s: is it a drone's server, "
            "and does it want TLS?",
        ) from None
    except BaseException:
        await connection.close()
        raise


class RefusedError(WorkbenchError):
    """A connection could not be opened.

    Attributes:
        retried: whether a later attempt may succeed.
    """

    def __init__(self, code: str, said: str) -> None:
        super().__init__(said)
        self.retried = code in RETRIED_ENDS


def _hint(end: Error, trust: Trust, options: ClientOptions) -> str:
    """Return advice about an end, where the server cannot give it."""
    if end.code == "bad_login":
        return f": take it from the line '{options.role.value}:' of the server's token file"
    if end.code == "lost" and trust.context is None:
        return "; if it serves over TLS, give its certificate (PEM) or fingerprint as tls"
    return ""


async def connect(
    address: Address, trust: Trust
) -> tuple[asyncio.StreamReader, asyncio.StreamWriter]:
    """Return the streams of a new connection to a server.

    Args:
        address: of the server.
        trust: accepted certificates, None for no TLS.

    Raises:
        WorkbenchError: if there is no server, the name is unknown, or TLS fails.
    """
    try:
        async with asyncio.timeout(CONNECT_TIMEOUT_S):
            reader, writer = await asyncio.open_connection(
                address.host,
                address.port,
                ssl=trust.context,
                server_hostname=address.host if trust.context else None,
            )
    except TimeoutError:
        raise WorkbenchError(
            f"{address} did not answer within {CONNECT_TIMEOUT_S:g} s: is the host right, is a "
            "firewall in "
            "between, and does the server use TLS as requested?"
        ) from None
    except OSError as error:
        raise WorkbenchError(_why_not(address, error)) from None
    try:
        if trust.context:
            trust.check(writer.get_extra_info("ssl_object").getpeercert(binary_form=True))
        disable_send_delay(writer)
    except BaseException:
        writer.transport.abort()
        raise
    return reader, writer


def _is_elsewhere(writer: asyncio.StreamWriter) -> bool:
    """Return whether the other side of a connection is not this machine itself, by loopback."""
    peer = writer.get_extra_info("peername")  # None if it was reset: nothing can be sent any more
    return peer is not None and not is_loopback(peer[0])


def disable_send_delay(writer: asyncio.StreamWriter) -> None:
    """Disable buffering of small packets (Nagle's algorithm), which would delay commands."""
    writer.get_extra_info("socket").setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)


def _why_not(address: Address, error: OSError) -> str:
    """Return the sentence for an error from the system or from TLS."""
    if isinstance(error, ssl.SSLCertVerificationError):
        return (
            f"{address}: the server's certificate is not trusted ({error.verify_message}): give "
            "the file of its authority, or its fingerprint"
        )
    if isinstance(error, ssl.SSLError):
        return f"{address} does not speak TLS ({error.reason}): leave TLS out, or check the port"
    if isinstance(error, socket.gaierror):
        return f"the host '{address.host}' is unknown: check its name, or write its address"
    # If a name has several addresses, asyncio merges their errors without an error number.
    if error.errno == errno.ECONNREFUSED or "Connect call failed" in str(error):
        return (
            f"nobody listens at {address}: start a server there with `workbench serve`, or check "
            "host and port"
        )
    return f"{address} cannot be reached: {error.strerror or error}"
