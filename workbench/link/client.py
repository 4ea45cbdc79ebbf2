"""Watch and fly a drone over the link, from a plain program."""

import asyncio
import threading
from collections.abc import Coroutine, Sequence
from typing import Any, TypeVar

from workbench.errors import WorkbenchError
from workbench.link.answers import ControlStateSaid
from workbench.link.async_client import AsyncClient
from workbench.link.backplane import Role
from workbench.link.client_control import Control
from workbench.link.control import AsyncControl
from workbench.link.hello import Hello
from workbench.link.sample import Sample

T = TypeVar("T")


class Client:
    """A client of a drone's server, as a context manager that yields samples.

    The network is attended to in a thread of its own, so nothing is lost while the program does
    something else. For arguments and behaviour see `AsyncClient`.
    """

    def __init__(
        self,
        address: str = "127.0.0.1:7733",
        *,
        name: str = "",
        token: str = "",
        role: Role | str | None = None,
        tls: str | bool | None = None,
        topics: Sequence[str] = ("*",),
        rate: float | None = None,
        reconnect: bool = True,
    ) -> None:
        self._client = AsyncClient(
            address,
            name=name,
            token=token,
            role=role,
            tls=tls,
            topics=topics,
            rate=rate,
            reconnect=reconnect,
        )
        self._loop: asyncio.AbstractEventLoop | None = None
        self._leave = asyncio.Event()
        self._thread: threading.Thread | None = None

    def __enter__(self) -> "Client":
        if self._thread is not None:
            raise WorkbenchError("a client is opened once: make a new one")
        started = threading.Event()
        self._thread = threading.Thread(
            target=lambda: asyncio.run(self._live(started)), name="link client", daemon=True
        )
        self._thread.start()
        started.wait()
        try:
            self.call(self._client.__aenter__())
        except BaseException:
            self._end_thread()
            raise
        return self

    def __exit__(self, *_: object) -> None:
        try:
            self.call(self._client.__aexit__())
        finally:
            self._end_thread()

    def __iter__(self) -> "Client":
        return self

    def __next__(self) -> Sample:
        sample = self._client.inbox.wait()
        if sample is None:
            self._client.raise_failure()
            raise StopIteration
        return sample

    @property
    def hello(self) -> Hello:
        """What the server said of itself, its topics, limits and parameters."""
        return self._client.hello

    @property
    def control_state(self) -> ControlStateSaid | None:
        """Who flies, None until the server said so."""
        return self._client.control_state

    @property
    def connected(self) -> bool:
        """Whether there is a connection at present."""
        return self._client.connected

    @property
    def trouble(self) -> str:
        """Why there is no connection at present, "" while there is one."""
        return self._client.trouble

    @property
    def received(self) -> int:
        """Samples that have arrived."""
        return self._client.received

    @property
    def dropped(self) -> int:
        """Samples that this program was too slow for."""
        return self._client.dropped

    def latest(self, topic: str) -> Sample | None:
        """Return a topic's newest sample, None before the first."""
        return self._client.latest(topic)

    def control(self) -> Control:
        """Return the controls: `with client.control() as c:` asks for them.

        Raises:
            WorkbenchError: on entering, if somebody else flies or the server takes no commands.
        """
        return Control(self, self._client.control())

    def parameters(self, *names: str) -> dict[str, float]:
        """Return live parameters by name; all if none is named.

        Raises:
            WorkbenchError: if one is unknown.
        """
        return self.call(self._client.parameters(*names))

    def ping(self) -> float:
        """Ask whether the server is there, and return its simulated time [s]."""
        return self.call(self._client.ping())

    def raise_failure(self) -> None:
        """Raise what ended the client by itself, if anything did; as iterating does."""
        self._client.raise_failure()

    def call(self, work: Coroutine[Any, Any, T]) -> T:
        """Do something in the client's thread, and return what comes of it."""
        loop = self._loop
        if loop is None or self._leave.is_set():
            work.close()
            raise WorkbenchError("the client is not open: write `with Client(...) as client:`")
        future = asyncio.run_coroutine_threadsafe(work, loop)
        try:
            return future.result()
        except BaseException:  # Ctrl-C, which ends the waiting, ends the work too
            future.cancel()
            raise

    def post(self, control: AsyncControl, asked: tuple[float, float, float, float]) -> None:
        """Send a velocity, without waiting."""
        if self._loop is not None:
            self._loop.call_soon_threadsafe(control.steer, asked)

    async def _live(self, started: threading.Event) -> None:
        """Let the loop run until the client is left."""
        self._loop = asyncio.get_running_loop()
        started.set()
        await self._leave.wait()

    def _end_thread(self) -> None:
        if self._loop is not None and self._thread is not None:
            self._loop.call_soon_threadsafe(self._leave.set)
            self._thread.join()
            self._loop = None
