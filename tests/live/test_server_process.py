"""What waits for a server that reads nothing: topics of a second at most, and answers."""

from multiprocessing import Pipe

import pytest

from workbench.ipc.channel import RecordChannel
from workbench.link.backplane import Published, ServedFlight
from workbench.link.server.config import ServerConfig
from workbench.live import server_process
from workbench.live.server_process import ServerProcess

FLIGHT = ServedFlight("x500", (), (), (8.0, 8.0, 0.4))
KILOBYTE = b"x" * 1000


@pytest.fixture
def server(monkeypatch):
    """A server whose process stands still."""
    ours, theirs = Pipe()

    class StandingStill:
        def __init__(self, module: str, what: str) -> None:
            self.connection = ours

    monkeypatch.setattr(server_process, "ChildProcess", StandingStill)
    server = ServerProcess(ServerConfig(), FLIGHT)
    yield server
    RecordChannel.close(server)  # its own waits for the process
    ours.close()
    theirs.close()


def test_topics_beyond_a_megabyte_are_left_out_and_answers_beyond_eight_end_it(server):
    for step in range(3000):
        server.publish(Published(step, step, ((1, KILOBYTE),)))
    assert 900_000 < server.unsent <= 1_000_000
    for _ in range(6500):
        server.tell(KILOBYTE)
    assert server.unsent > 7_000_000
    with pytest.raises(EOFError):
        for _ in range(3000):
            server.tell(KILOBYTE)
    assert server.unsent <= 8_000_000
