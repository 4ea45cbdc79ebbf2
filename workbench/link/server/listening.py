"""Opens the socket that listens."""

import errno
import socket

from workbench.common.errors import WorkbenchError

WAITING = 512
"""Connections that the system keeps until they are accepted."""


def listen(host: str, port: int) -> socket.socket:
    """Return a socket that listens and never waits: one, also where a name has several addresses.

    Raises:
        WorkbenchError: if it is not possible to listen there.
    """
    try:
        found = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE)
        family, *_, address = found[0]
        # All of the address: that of a link counts only with its number.
        listener = socket.create_server(address, family=family, backlog=WAITING)
    except socket.gaierror as error:
        raise WorkbenchError(f"'{host}' is no host of this machine: {error.strerror}") from error
    except (OSError, OverflowError, UnicodeError) as error:
        raise WorkbenchError(_reason(error, host, port)) from error
    listener.setblocking(False)
    return listener


def _reason(error: Exception, host: str, port: int) -> str:
    match getattr(error, "errno", None):
        case errno.EADDRINUSE:
            return f"port {port} at {host} is in use: end the program that has it, or take another"
        case errno.EADDRNOTAVAIL:
            return f"{host} is no address of this machine: listen at one that is, or at 0.0.0.0"
        case errno.EACCES:
            return f"port {port} at {host} is reserved: take one above 1023"
    return f"it is not possible to listen at {host}:{port}: {error}"
