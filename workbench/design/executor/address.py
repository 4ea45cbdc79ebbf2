"""The address of a Dask scheduler: what it may be, and whether one answers there."""

import asyncio
import importlib.util
import socket
from concurrent.futures import ThreadPoolExecutor
from typing import Any
from urllib.parse import urlsplit

from workbench.common.errors import WorkbenchError

ANSWER_WITHIN = 2.0
"""Time for a connection to be made, and once more for a scheduler to say that it is one [s]."""
EXAMPLE = "tcp://localhost:8786"
_SCHEMES = ("tcp", "tls")


def check_address(address: str) -> tuple[str, int]:
    """Return host and port of an address like tcp://HOST:PORT or tls://HOST:PORT.

    Raises:
        WorkbenchError: if it is none, or the package that it needs is not installed.
    """
    if importlib.util.find_spec("distributed") is None:
        raise WorkbenchError(
            "a Dask cluster needs the package distributed: `pip install distributed`"
        )
    try:
        parts = urlsplit(address)
        if parts.scheme not in _SCHEMES or not parts.hostname or not parts.port or parts.path:
            raise ValueError
    except ValueError:
        raise WorkbenchError(
            f"'{address}' is no address of a scheduler: write tcp://HOST:PORT, as {EXAMPLE}"
        ) from None
    return parts.hostname, parts.port


def check_scheduler(address: str, within: float = ANSWER_WITHIN) -> None:
    """Refuse an address where no Dask scheduler answers.

    Dask's own client tries a closed port again and again, and waits for ever for an answer of what
    is no scheduler.

    Args:
        address: tcp://HOST:PORT or tls://HOST:PORT.
        within: time for a connection to be made, and once more for an answer [s].

    Raises:
        WorkbenchError: if none does.
    """
    try:
        socket.create_connection(check_address(address), timeout=within).close()
    except OSError as error:
        reason = "it does not answer" if isinstance(error, TimeoutError) else error.strerror
        raise _unreachable(address, reason or str(error)) from error
    with ThreadPoolExecutor(1) as pool:  # a notebook has an event loop of its own in this thread
        try:
            who = pool.submit(asyncio.run, _identity(address, within)).result()
        except TimeoutError as error:
            raise _unreachable(address, "what listens there does not answer as one") from error
        except Exception as error:  # another protocol's answer is read as Dask's: anything follows
            reason = f"what answers there is no Dask scheduler, or wants TLS otherwise ({error})"
            raise _unreachable(address, reason) from error
    if who.get("type") != "Scheduler":
        raise _unreachable(address, f"what answers there is a Dask {who.get('type', '?')}")


async def _identity(address: str, within: float) -> dict[str, Any]:
    """Return what a scheduler says of itself."""
    from distributed.core import rpc
    from distributed.security import Security

    async def ask() -> dict[str, Any]:
        arguments = Security().get_connection_args("client")
        async with rpc(address, connection_args=arguments) as scheduler:
            answer: dict[str, Any] = await scheduler.identity()
            return answer

    return await asyncio.wait_for(ask(), within)


def _unreachable(address: str, reason: str) -> WorkbenchError:
    return WorkbenchError(
        f"no scheduler can be reached at {address} ({reason}): start one with `dask scheduler`, "
        "and give the address that it prints"
    )
