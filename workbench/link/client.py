"""Watch and fly a drone over the link, from a plain program."""

import asyncio
import contextlib
import threading
from collections.abc import Callable, Coroutine, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, wait
from typing import Any, TypeVar

from workbench.common.errors import WorkbenchError
from workbench.link.async_client import AsyncClient
from workbench.link.client_control import Control, DirectControl
from workbench.link.hello import Hello
from workbench.link.operations import Role
from workbench.link.sample import Sample
from workbench.link.server_messages import ControlState

NOT_OPEN = "the client is not open: write `with Client(...) as client:`"
ENDED = "the client's thread has ended: open a new client"

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
        self._leave = asyncio.Event()
        self._thread: threading.Thread | None = None
        self._loop: Future[asyncio.AbstractEventLoop] = Future()
        self._ended: Future[None] = Future()

    def __enter__(self) -> "Client":
        if self._thread is not None:
            raise WorkbenchError("a client is opened once: make a new one")
        self._thread = threading.Thread(target=self._attend, name="link client", daemon=True)
        self._thread.start()
        self._await(self._loop)
        try:
            if not self._loop.done():
                raise WorkbenchError(f"the client cannot begin: {self._ended.exception()}")
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
    def control_state(self) -> ControlState | None:
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

    def direct_control(self) -> DirectControl:
        """Return controls that repeat nothing, for who passes on what a person's hand does.

        Raises:
            WorkbenchError: on entering, if somebody else flies or the server takes no commands.
        """
        return DirectControl(self, self._client.direct_control())

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
        try:
            future = asyncio.run_coroutine_threadsafe(work, self._open_loop())
        except BaseException:
            work.close()
            raise
        try:
            self._await(future)
        except BaseException:  # Ctrl-C, which ends the waiting, ends the work too
            future.cancel()
            raise
        if future.cancelled() or not future.done():
            work.close()  # it may not have begun
            raise WorkbenchError(ENDED)
        return future.result()

    def post(self, act: Callable[[], None]) -> None:
        """Do something in the client's thread, without waiting."""
        self._open_loop().call_soon_threadsafe(act)

    def _open_loop(self) -> asyncio.AbstractEventLoop:
        """Return the loop of the client's thread.

        Raises:
            WorkbenchError: if there is none.
        """
        if not self._loop.done() or self._leave.is_set():
            raise WorkbenchError(NOT_OPEN)
        if self._ended.done():
            raise WorkbenchError(ENDED)
        return self._loop.result()

    def _await(self, future: Future[Any]) -> None:
        """Wait for something that comes of the client's thread, as long as there is one."""
        wait((future, self._ended), return_when=FIRST_COMPLETED)

    def _attend(self) -> None:
        """Let the loop run; whatever ends it, nobody waits for it any longer."""
        life = self._live()
        try:
            asyncio.run(life)
        except BaseException as error:
            self._ended.set_exception(error)
        else:
            self._ended.set_result(None)
        finally:
            life.close()  # where there is no loop it has not begun
            self._client.inbox.close()

    async def _live(self) -> None:
        self._loop.set_result(asyncio.get_running_loop())
        await self._leave.wait()

    def _end_thread(self) -> None:
        if self._thread is None:
            return
        if self._loop.done():
            with contextlib.suppress(RuntimeError):  # closed, if the thread has ended by itself
                self._loop.result().call_soon_threadsafe(self._leave.set)
        self._thread.join()
