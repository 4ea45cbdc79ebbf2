"""An event loop in a thread of its own, for plain programs."""

import asyncio
import contextlib
import threading
from collections.abc import Callable, Coroutine, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, wait
from typing import Any, TypeVar

from workbench.common.errors import WorkbenchError

NOT_OPEN = "the client is not open: write `with Client(...) as client:`"
ENDED = "the client's thread has ended: open a new client"

T = TypeVar("T")


class BackgroundLoop:
    """Runs an event loop in a thread; a program calls coroutines there and waits for results.

    Args:
        ended: is called in the thread at its end, whatever ends it.
    """

    def __init__(self, ended: Callable[[], None]) -> None:
        self._when_ended = ended
        self._stopping = asyncio.Event()
        self._thread: threading.Thread | None = None
        self._loop: Future[asyncio.AbstractEventLoop] = Future()
        self._ended: Future[None] = Future()

    def start(self) -> None:
        """Start the thread, once.

        Raises:
            WorkbenchError: if it was started before, or cannot begin.
        """
        if self._thread is not None:
            raise WorkbenchError("a client is opened once: make a new one")
        self._thread = threading.Thread(target=self._run, name="link client", daemon=True)
        self._thread.start()
        self._wait(self._loop)
        if not self._loop.done():
            self._thread.join()
            raise WorkbenchError(f"the client cannot begin: {self._ended.exception()}")

    def stop(self) -> None:
        """End the thread, and wait for its end."""
        if self._thread is None:
            return
        if self._loop.done():
            with contextlib.suppress(RuntimeError):  # closed, if the thread has ended by itself
                self._loop.result().call_soon_threadsafe(self._stopping.set)
        self._thread.join()

    def call(self, work: Coroutine[Any, Any, T]) -> T:
        """Run a coroutine in the thread, and return its result.

        Raises:
            WorkbenchError: if the thread does not run.
        """
        try:
            with self._running() as loop:
                future = asyncio.run_coroutine_threadsafe(work, loop)
        except BaseException:
            work.close()
            raise
        try:
            self._wait(future)
        except BaseException:  # Ctrl-C, which ends the waiting, ends the work too
            future.cancel()
            raise
        if future.cancelled() or not future.done():
            work.close()  # it may not have begun
            raise WorkbenchError(ENDED)
        return future.result()

    def post(self, act: Callable[[], None]) -> None:
        """Call a function in the thread, without waiting.

        Raises:
            WorkbenchError: if the thread does not run.
        """
        with self._running() as loop:
            loop.call_soon_threadsafe(act)

    @contextlib.contextmanager
    def _running(self) -> Iterator[asyncio.AbstractEventLoop]:
        """Give the loop to schedule something in."""
        if not self._loop.done() or self._stopping.is_set():
            raise WorkbenchError(NOT_OPEN)
        try:
            yield self._loop.result()
        except RuntimeError as error:  # asyncio's word for a loop that is closed
            raise WorkbenchError(ENDED) from error

    def _wait(self, future: Future[Any]) -> None:
        """Wait for something that comes of the thread, as long as there is one."""
        wait((future, self._ended), return_when=FIRST_COMPLETED)

    def _run(self) -> None:
        """Let the loop run; whatever ends it, nobody waits for it any longer."""
        until_stopped = self._run_until_stopped()
        try:
            asyncio.run(until_stopped)
        except BaseException as error:
            self._ended.set_exception(error)
        else:
            self._ended.set_result(None)
        finally:
            until_stopped.close()  # where there is no loop it has not begun
            self._when_ended()

    async def _run_until_stopped(self) -> None:
        self._loop.set_result(asyncio.get_running_loop())
        await self._stopping.wait()
