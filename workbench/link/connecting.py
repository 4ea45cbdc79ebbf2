"""How a client's connection comes to be, and why it does not, in sentences."""

import asyncio
import errno
import socket
import ssl

from workbench.common.errors import WorkbenchError
from workbench.link.address import Address
from workbench.link.client_tls import Trust

LIMIT = 5.0
"""A connection that is not there by then does not come [s]."""

Streams = tuple[asyncio.StreamReader, asyncio.StreamWriter]


async def connect(address: Address, trust: Trust) -> Streams:
    """Return the streams of a connection to a server.

    Args:
        address: where it listens.
        trust: whether by TLS, and what is accepted.

    Raises:
        WorkbenchError: if nobody listens, the name is unknown, or TLS does not come about.
    """
    try:
        async with asyncio.timeout(LIMIT):
            reader, writer = await asyncio.open_connection(
                address.host,
                address.port,
                ssl=trust.context,
                server_hostname=address.host if trust.context else None,
            )
    except TimeoutError:
        raise WorkbenchError(
            f"{address} does not answer within {LIMIT:g} s: is the host right, does a firewall "
            "stand between, and does that server speak TLS as asked for?"
        ) from None
    except OSError as error:
        raise WorkbenchError(_why_not(address, error)) from None
    try:
        if trust.context:
            trust.check(writer.get_extra_info("ssl_object").getpeercert(binary_form=True))
        tune(writer)
    except BaseException:
        writer.transport.abort()
        raise
    return reader, writer


def tune(writer: asyncio.StreamWriter) -> None:
    """Send at once, however little it is: a command that waits for company is an old one."""
    writer.get_extra_info("socket").setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)


def _why_not(address: Address, error: OSError) -> str:
    """Return the sentence for an error of the system or of TLS."""
    if isinstance(error, ssl.SSLCertVerificationError):
        return (
            f"{address}: the server's certificate is not trusted ({error.verify_message}): give "
            "the file of its authority, or its fingerprint"
        )
    if isinstance(error, ssl.SSLError):
        return f"{address} does not speak TLS ({error.reason}): leave TLS out, or check the port"
    if isinstance(error, socket.gaierror):
        return f"the host '{address.host}' is unknown: check its name, or write its address"
    # Where a name has several addresses, asyncio sums their failures up without a number.
    if error.errno == errno.ECONNREFUSED or "Connect call failed" in str(error):
        return (
            f"nobody listens at {address}: start a server there with `workbench serve`, or check "
            "host and port"
        )
    return f"{address} cannot be reached: {error.strerror or error}"
