"""The map of the code, docs/architecture.md, and CONTRIBUTING.md, held to the code."""

import asyncio
import re
import sys
from contextlib import closing
from multiprocessing import Pipe
from pathlib import Path
from types import SimpleNamespace

import pytest

from tests.drawn_ways import GAIN, PAGE, WAYS, drawn_functions, drawn_parts, present_way
from workbench.commands.cli import main
from workbench.ipc import child_process
from workbench.ipc.channel import RecordChannel
from workbench.ipc.send_queue import SendQueue
from workbench.ipc.worker_process import WorkerRequest
from workbench.link.server.admission import Admission
from workbench.link.server.hub import Hub
from workbench.link.server.policy import Policy
from workbench.link.server.process import FlightConnection
from workbench.link.server.tcp import TcpConnection
from workbench.link.wire import FrameKind, WireFrame
from workbench.live.flying import FlightLoop
from workbench.live.messages import CLOSE_MESSAGE
from workbench.scenario.scenario import Action
from workbench.session.session import Session
from workbench.systems.bridge import Bridge
from workbench.systems.flight_computer import FlightComputer
from workbench.systems.pilot import PilotSystem

ROOT = Path(__file__).resolve().parents[2]
STEP = "commands/cli.py"

XACRO = "workbench.plant.formats.xacro_child"
"""It reads a description in its own process, once until a file changes."""


def test_ways_are_drawn_by_functions_that_there_are(case):
    assert set(WAYS) == {STEP, "link/server/tcp.py", GAIN}
    for begin, (count, files, drawn) in WAYS.items():
        functions = drawn_functions(drawn)
        with case(begin):
            assert (len(functions), len({file for file, _ in functions})) == (count, files)
        for file, name in functions:
            source = (ROOT / "workbench" / file).read_text(encoding="utf-8")
            for part in name.split("."):
                assert re.search(rf"^ *(class|def) {part}\b", source, re.MULTILINE), (file, name)


def source_of(name: str) -> str:
    """Return the text of a file that a page names, by its path or the end of its path."""
    found = [path for path in (ROOT / "workbench").rglob(Path(name).name) if path.is_file()]
    found += [ROOT / name] if (ROOT / name).is_file() else []
    return "".join(each.read_text("utf-8") for each in found if str(each).endswith(f"/{name}"))


def test_what_the_map_names_is_there(case):
    files, names = [], []
    for page in (PAGE, (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")):
        files += re.findall(r"`([\w/]+\.(?:py|js))`", page)
        names += re.findall(r"`([A-Za-z_][\w.]*)` (?:\(|of |in )`([\w/]+\.py)`", page)
    assert len(files) > 60 and len(names) > 20
    for file in files:
        with case(file):
            assert source_of(file)
    for name, file in names:
        with case(name, file):
            source = source_of(file)
            assert all(
                re.search(rf"^ *(class |def )?{part}\b", source, re.M) for part in name.split(".")
            )


@pytest.mark.skipif(sys.version_info < (3, 12), reason="sys.monitoring came with Python 3.12")
def test_a_step_goes_the_drawn_way_in_one_process(tmp_path, monkeypatch):
    """It calls the drawn functions in that order; another process draws the picture alone."""
    monkeypatch.chdir(tmp_path)
    start, started = child_process.start_module, []
    monkeypatch.setattr(
        child_process, "start_module", lambda *a, **o: started.append(a) or start(*a, **o)
    )
    called: list[tuple[str, str]] = []  # each function once, as it is called first

    def note(code, offset):
        path = code.co_filename.partition("/workbench/")[2]
        if path:
            called.append((path, code.co_qualname.removesuffix(".__init__")))
        return sys.monitoring.DISABLE

    tool, starts = sys.monitoring.PROFILER_ID, sys.monitoring.events.PY_START
    sys.monitoring.use_tool_id(tool, "way")
    sys.monitoring.register_callback(tool, starts, note)
    sys.monitoring.set_events(tool, starts)
    try:
        assert main(["step", "--axis", "x", "--amplitude", "1"]) == 0
    finally:
        sys.monitoring.free_tool_id(tool)
    rest = iter(called)
    for each in drawn_functions(WAYS[STEP][2]):
        assert each in rest, each
    assert {module for module, *_ in started} - {XACRO} == {"workbench.commands.drawer"}
    assert (tmp_path / "out" / "step-x.png").is_file()


def test_a_gain_goes_the_drawn_way_in_the_flight_process(monkeypatch):
    """No function comes between the drawn ones. The window's part: tests/gui/gains."""
    bridge = Bridge()
    session = Session(bridge=bridge)
    ways, put = [], FlightComputer.set_parameters
    monkeypatch.setattr(
        FlightComputer, "set_parameters", lambda *a: ways.append(present_way()) or put(*a)
    )
    window, flight = Pipe()
    window.send(WorkerRequest(1, Action(set={"kp_roll": 77.0})))
    window.send(CLOSE_MESSAGE)
    answers = SendQueue(flight)
    FlightLoop(session, bridge, {}, answers, lambda: 0.0).run(flight, lambda: True)
    answers.close(60.0)
    assert ways == [drawn_parts(GAIN)[1][:-1]]
    assert session.get("kp_roll") == 77.0


class Unserved(RecordChannel):
    """The flight's end of its server, which says nothing."""

    def publish(self, published: object) -> None:
        """Say nothing."""

    tell = publish


class Taken:
    """A transport of asyncio that takes all bytes."""

    def get_write_buffer_size(self) -> int:
        return 0

    def write(self, data: bytes) -> None:
        """Take bytes."""

    close = abort = pause_reading = resume_reading = lambda self: None


def test_a_velocity_goes_the_drawn_way_in_the_server_and_into_the_mailbox(monkeypatch):
    """Of the drawn functions, those that take bytes in or out return before the next one."""
    bridge = Bridge()
    session = Session(bridge=bridge)
    flying = FlightLoop(session, bridge, {}, SimpleNamespace(post=print), lambda: 0.0)
    lease = bridge.authority.request(1, "one", 0.0)
    ways = {}

    def note(owner: type, name: str) -> None:
        call = getattr(owner, name)

        def noted(*arguments):
            ways.setdefault(name, present_way())
            return call(*arguments)

        monkeypatch.setattr(owner, name, noted)

    for owner, name in ((RecordChannel, "flush"), (Bridge, "command"), (PilotSystem, "write")):
        note(owner, name)
    near, far = Pipe()
    heard = Unserved(far)
    monkeypatch.setattr(flying._network._server, "_process", heard)

    async def serve() -> None:
        flight = FlightConnection(near)
        hub = Hub(Policy(flying._network._flight()), Admission(1, 1), flight.tell)
        flight.start(hub.hear, lambda: None)
        client = TcpConnection(hub, "here:1", "tcp")
        client.connection_made(Taken())
        hub.hear([bridge.authority.state(0.0)])  # the client has control
        payload = hub.policy.command.packer.pack(lease, 15, 0.0, 0.0, 0.0, 0.0)
        client.data_received(WireFrame(FrameKind.DATA, 8, 0, 1, 0, payload).to_bytes())
        await flight.close()

    asyncio.run(serve())
    with far, closing(heard):
        flying._network.hear()
    session.tick(session.scenario.rates.control_period)
    server, mailbox, update = drawn_parts("link/server/tcp.py")
    returns = ("Decoder.next", "RecordChannel.received")
    assert ways["flush"] == [each for each in server if each[1] not in returns][:-1]
    assert ways["command"] == [each for each in mailbox if each[1] not in returns][:-1]
    assert ways["write"][-1] == update[0]
