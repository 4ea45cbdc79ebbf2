"""What stands between a page and its server, or beside them."""

import asyncio
import contextlib
import functools
import threading
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer


class Proxy:
    """Passes bytes on between a page and its server, until it is frozen or cut.

    Attributes:
        url: of the page through it.
    """

    def __init__(self, url):
        host, _, port = url.removeprefix("http://").rstrip("/").partition(":")
        self._target = host, int(port)
        self._loop = asyncio.new_event_loop()
        self._writers, self._server = set(), None
        self._thread = threading.Thread(target=self._loop.run_forever)
        self._thread.start()
        self.port = self._call(self._listen(0))
        self.url = f"http://127.0.0.1:{self.port}/"

    def cut(self):
        """Take the network away: all connections end, and none can be made."""
        self._call(self._end())

    def mend(self):
        """Bring the network back."""
        self._call(self._listen(self.port))

    def close(self):
        self.cut()
        self._call(self._loop.shutdown_default_executor())
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join(10)
        self._loop.close()

    def _call(self, coroutine):
        return asyncio.run_coroutine_threadsafe(coroutine, self._loop).result(10)

    async def _listen(self, port):
        self._server = await asyncio.start_server(self._pass, "127.0.0.1", port)
        return self._server.sockets[0].getsockname()[1]

    async def _end(self):
        if self._server is not None:
            self._server.close()
        for writer in list(self._writers):
            writer.transport.abort()
        while self._writers:
            await asyncio.sleep(0.01)

    async def _pass(self, reader, writer):
        self._writers.add(writer)
        try:
            to_reader, to_writer = await asyncio.open_connection(*self._target)
            ways = [_copy(reader, to_writer), _copy(to_reader, writer)]
            await asyncio.gather(*ways)
            to_writer.transport.abort()
        except OSError:
            writer.transport.abort()
        finally:
            self._writers.discard(writer)


async def _copy(reader, writer):
    with contextlib.suppress(OSError):
        while data := await reader.read(65536):
            writer.write(data)
            await writer.drain()
    writer.close()


class FilesElsewhere:
    """A page of somebody else, served from another port of this machine.

    Args:
        folder: for its files.

    Attributes:
        url: of the page.
    """

    def __init__(self, folder):
        (folder / "index.html").write_text("<!doctype html><title>elsewhere</title>")
        handler = functools.partial(_Quiet, directory=str(folder))
        self._server = ThreadingHTTPServer(("127.0.0.1", 0), handler)
        self.url = f"http://127.0.0.1:{self._server.server_port}/"
        self._thread = threading.Thread(target=self._server.serve_forever, args=(0.05,))
        self._thread.start()

    def close(self):
        self._server.shutdown()
        self._server.server_close()
        self._thread.join(10)


class _Quiet(SimpleHTTPRequestHandler):
    def log_message(self, *args):
        pass
