"""An event loop in its own thread, for programs without asyncio."""

import asyncio
import contextlib
import threading
from collections.abc import Callable, Coroutine, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, wait
from typing import Any, TypeVar

from workbench.common.errors import WorkbenchError

CLIENT_NOT_OPEN = "the client is not open: write `with Client(...) as client:`"
CLIENT_THREAD_ENDED = "the client's thread has ended: open a new client"

T = TypeVar("T")


class BackgroundLoop:
    """Runs an event loop in a thread, in which a program runs coroutines and waits for results.

    Args:
        ended: called in the thread at its end, for any reason.
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
            WorkbenchError: if it was started before, or cannot start.
        """
        if self._thread is not None:
            raise WorkbenchError("a client can be opened once: make a new one")
        self._thread = threading.Thread(target=self._run, name="link client", daemon=True)
        self._thread.start()
        self._wait(self._loop)
        if not self._loop.done():
            self._thread.join()
            raise WorkbenchError(f"the client cannot begin: {self._ended.exception()}")

    def stop(self) -> None:
        """Stop the thread, and wait for its end."""
        if self._thread is None:
            return
        if self._loop.done():
            with contextlib.suppress(RuntimeError):  # closed, if the thread has ended by itself
                self._loop.result().call_soon_threadsafe(self._stopping.set)
        self._thread.join()

    def call(self, work: Coroutine[Any, Any, T]) -> T:
        """Run a coroutine in the thread, and return its result.

        Raises:
            WorkbenchError: if the thread is not running.
        """
        try:
            with self._running() as loop:
                future = asyncio.run_coroutine_threadsafe(work, loop)
        except BaseException:
            work.close()
            raise
        try:
            self._wait(future)
        except BaseException:  # Ctrl-C ends the wait, and also the work
            future.cancel()
            raise
        if future.cancelled() or not future.done():
            work.close()  # it may not have started
            raise WorkbenchError(CLIENT_THREAD_ENDED)
        return future.result()

    def post(self, act: Callable[[], None]) -> None:
        """Call a function in the thread, without waiting.

        Raises:
            WorkbenchError: if the thread is not running.
        """
        with self._running() as loop:
            loop.call_soon_threadsafe(act)

    @contextlib.contextmanager
    def _running(self) -> Iterator[asyncio.AbstractEventLoop]:
        """Return the running loop."""
        if not self._loop.done() or self._stopping.is_set():
            raise WorkbenchError(CLIENT_NOT_OPEN)
        try:
            yield self._loop.result()
        except RuntimeError as error:  # raised by asyncio for a closed loop
            raise WorkbenchError(CLIENT_THREAD_ENDED) from error

    def _wait(self, future: Future[Any]) -> None:
        """Wait for a result of the thread, as long as it runs."""
        wait((future, self._ended), return_when=FIRST_COMPLETED)

    def _run(self) -> None:
        """Run the loop, and release all waiting callers at its end."""
        until_stopped = self._run_until_stopped()
        try:
            asyncio.run(until_stopped)
        except BaseException as error:
            self._ended.set_exception(error)
        else:
            self._ended.set_result(None)
        finally:
            until_stopped.close()  # without a loop it has not started
            self._when_ended()

    async def _run_until_stopped(self) -> None:
        self._loop.set_result(asyncio.get_running_loop())
        await self._stopping.wait()
