"""A TCP proxy that may stop forwarding without closing anything: a connection half open."""

import selectors
import socket
import threading
from itertools import chain

PIECE = 65536


class Proxy:
    """Forwards one TCP connection, until it stops without closing anything.

    Args:
        address: where to, "HOST:PORT".
    """

    def __init__(self, address: str) -> None:
        host, _, port = address.rpartition(":")
        self._target = host, int(port)
        self._door = socket.create_server(("127.0.0.1", 0))
        self._stopped = threading.Event()
        self._pairs: list[tuple[socket.socket, socket.socket]] = []
        self._bell, self._button = socket.socketpair()
        self.address = f"127.0.0.1:{self._door.getsockname()[1]}"
        self._thread = threading.Thread(target=self._run, name="proxy")
        self._thread.start()

    def stop(self) -> None:
        """Forward nothing for now; both connections stay open."""
        self._stopped.set()
        self._button.send(b"!")
        self._thread.join()
        self._bell.recv(1)

    def go_on(self) -> None:
        """Forward again, from what has come meanwhile on."""
        self._stopped.clear()
        self._thread = threading.Thread(target=self._run, name="proxy")
        self._thread.start()

    def close(self) -> None:
        """Close all."""
        if self._thread.is_alive():
            self.stop()
        for each in (*chain.from_iterable(self._pairs), self._door, self._bell, self._button):
            each.close()

    def _run(self) -> None:
        with selectors.DefaultSelector() as selector:
            for each in (self._door, self._bell):
                selector.register(each, selectors.EVENT_READ, None)
            for near, far in self._pairs:
                selector.register(near, selectors.EVENT_READ, far)
                selector.register(far, selectors.EVENT_READ, near)
            while not self._stopped.is_set():
                for key, _ in selector.select():
                    if key.fileobj is self._door:
                        near, _ = self._door.accept()
                        far = socket.create_connection(self._target)
                        self._pairs.append((near, far))
                        selector.register(near, selectors.EVENT_READ, far)
                        selector.register(far, selectors.EVENT_READ, near)
                    elif isinstance(key.fileobj, socket.socket) and not _passed(key):
                        selector.unregister(key.fileobj)


def _passed(key: selectors.SelectorKey) -> bool:
    """Pass on what has come at one end; return whether there may be more."""
    assert isinstance(key.fileobj, socket.socket)
    if key.data is None:  # the bell
        return True
    try:
        data = key.fileobj.recv(PIECE)
        key.data.sendall(data)
    except OSError:
        return False
    return bool(data)
