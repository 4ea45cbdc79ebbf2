"""Watch and fly a drone over the link, with or without asyncio."""

from functools import cached_property

from workbench.link.background_loop import BackgroundLoop
from workbench.link.client_core import ClientCore
from workbench.link.control import AsyncControl, Control
from workbench.link.sample import Sample


class AsyncClient(ClientCore):
    """A client of the server of a drone, as an asynchronous context manager that yields samples.

    See `ClientCore` for arguments, attributes and the handling of a lost connection.
    """

    async def __aenter__(self) -> "AsyncClient":
        await self.open()
        return self

    async def __aexit__(self, *_: object) -> None:
        await self.close()

    def __aiter__(self) -> "AsyncClient":
        return self

    async def __anext__(self) -> Sample:
        while (sample := self._samples.take()) is None:
            self.raise_failure()
            if self._task is None or self._task.done():
                raise StopAsyncIteration
            self._arrived.clear()
            await self._arrived.wait()
        return sample

    def control(self) -> AsyncControl:
        """Return the controls; `async with client.control() as c:` requests them.

        Raises:
            WorkbenchError: on entering, if somebody else flies or the server accepts no commands.
        """
        return AsyncControl(self, repeats=True)

    def direct_control(self) -> AsyncControl:
        """Return controls that do not repeat commands, for programs that forward a person's input.

        Raises:
            WorkbenchError: on entering, if somebody else flies or the server accepts no commands.
        """
        return AsyncControl(self, repeats=False)

    parameters = ClientCore.request_parameters
    description = ClientCore.request_description
    ping = ClientCore.request_time


class Client(ClientCore):
    """A client of the server of a drone, as a context manager that yields samples.

    It runs in its own thread, so nothing is lost while the program is busy. See `ClientCore` for
    arguments, attributes and the handling of a lost connection.
    """

    def __enter__(self) -> "Client":
        self.loop.start()
        try:
            self.loop.call(self.open())
        except BaseException:
            self.loop.stop()
            raise
        return self

    def __exit__(self, *_: object) -> None:
        try:
            self.loop.call(self.close())
        finally:
            self.loop.stop()

    def __iter__(self) -> "Client":
        return self

    def __next__(self) -> Sample:
        sample = self._samples.wait()
        if sample is None:
            self.raise_failure()
            raise StopIteration
        return sample

    @cached_property
    def loop(self) -> BackgroundLoop:
        """The thread for the network."""
        return BackgroundLoop(self._samples.close)

    def control(self) -> Control:
        """Return the controls; `with client.control() as c:` requests them.

        Raises:
            WorkbenchError: on entering, if somebody else flies or the server accepts no commands.
        """
        return Control(AsyncControl(self, repeats=True), self.loop)

    def direct_control(self) -> Control:
        """Return controls that do not repeat commands, for programs that forward a person's input.

        Raises:
            WorkbenchError: on entering, if somebody else flies or the server accepts no commands.
        """
        return Control(AsyncControl(self, repeats=False), self.loop)

    def parameters(self, *names: str) -> dict[str, float]:
        """Return live parameters by name, or all if none is named.

        Raises:
            WorkbenchError: if one is unknown.
        """
        return self.loop.call(self.request_parameters(*names))

    def description(self) -> str:
        """Return the description of the vehicle as URDF.

        Raises:
            WorkbenchError: if the server is older and does not know it, or it is too long.
        """
        return self.loop.call(self.request_description())

    def ping(self) -> float:
        """Ping the server, and return its simulated time [s]."""
        return self.loop.call(self.request_time())
