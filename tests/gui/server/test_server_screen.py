"""The server screen by mouse and keys, with a flight that is served to real clients."""

import socket
import threading

import pytest
from PyQt6.QtCore import QPoint, Qt
from PyQt6.QtGui import QGuiApplication
from PyQt6.QtTest import QTest

from tests.gui.conftest import noted, workspace_in
from workbench.common.errors import WorkbenchError
from workbench.gui.server.refusals_panel import RefusalsPanel
from workbench.gui.server.server_control import ListeningState
from workbench.gui.server.server_screen import ServerScreen
from workbench.link import Client
from workbench.link.authentication import read_tokens
from workbench.link.messages import ControlOwner
from workbench.live.choice import Choice

LONG = 30_000
"""Limit of a wait [ms]; nothing here takes so long."""


class Bench:
    """The screen over a flight of its own."""

    def __init__(self, folder):
        self.workspace = workspace_in(folder)
        self.folder, self.told = folder, noted(self.workspace)
        self.flight = self.workspace.flight
        self.screen = ServerScreen(self.workspace)
        self.screen.resize(760, 600)
        self.flight.begun.connect(self.screen.begin)
        self.flight.viewed.connect(self.screen.show_view)

    @property
    def running(self):
        return self.screen.control.state[0]

    def write(self, name, text):
        line = self.screen.form.lines[name]
        line.setFocus()
        line.selectAll()
        QTest.keyClicks(line, text)

    def press(self, button):
        QTest.mouseClick(button, Qt.MouseButton.LeftButton)

    def close(self):
        self.screen.close_screen()
        self.screen.close()
        self.workspace.close()


@pytest.fixture(scope="module")
def flown(qapp, tmp_path_factory):
    """A drone without sensors; one test after another serves it."""
    bench = Bench(tmp_path_factory.mktemp("server"))
    bench.flight.fly(Choice("hover"), draw=False)
    bench.flight.live.wait()
    yield bench
    bench.close()


@pytest.fixture
def bench(flown, qtbot):
    """The flight, not served, and a form that is right."""
    flown.screen.show()
    flown.screen.activateWindow()
    qtbot.waitUntil(flown.screen.isActiveWindow, timeout=LONG)
    qtbot.waitUntil(lambda: flown.flight.is_flying, timeout=LONG)
    form = flown.screen.form
    for name, text in (("host", "127.0.0.1"), ("port", "0"), ("token_file", "")):
        form.lines[name].setText(text)
    form.web.setChecked(False)
    yield flown
    flown.screen.control.stop()
    qtbot.waitUntil(lambda: flown.running is ListeningState.STOPPED, timeout=LONG)


def test_without_a_flight_it_says_so_and_cannot_start(workspace, qtbot):
    screen = ServerScreen(workspace)
    qtbot.addWidget(screen)
    assert screen.state.text() == "○ No flight"
    assert "open a scenario" in screen.said.text()
    assert not screen.start_button.isEnabled()
    assert not screen.stop_button.isEnabled()


def test_bad_input_is_said_beside_its_field_as_it_is_typed(workspace, qtbot):
    screen = ServerScreen(workspace)
    qtbot.addWidget(screen)
    form = screen.form
    form.lines["port"].selectAll()
    QTest.keyClicks(form.lines["port"], "77330")
    assert form.fault("port") == "✕ the port 77330 is not a number from 0 to 65535"
    QTest.keyClick(form.lines["port"], Qt.Key.Key_Backspace)
    assert form.fault("port") == ""
    form.lines["host"].selectAll()
    QTest.keyClicks(form.lines["host"], "0.0.0.0")
    assert "give a token file" in form.fault("token_file")
    assert "give a certificate" in form.fault("tls_cert")
    screen.show()
    line = form._faults["tls_cert"]  # its command can be copied
    QTest.mouseDClick(line, Qt.MouseButton.LeftButton, pos=line.rect().topLeft() + QPoint(30, 8))
    assert line.selectedText() == "others"
    assert not form.is_right
    again = ServerScreen(workspace)  # as after a new start
    qtbot.addWidget(again)
    assert again.form.config.host == "0.0.0.0"
    assert again.form.config.port == 7733


def test_new_tokens_are_written_for_their_owner_only_and_never_shown(workspace, qtbot, tmp_path):
    screen = ServerScreen(workspace)
    qtbot.addWidget(screen)
    path = tmp_path / "new.tokens"
    screen.form.make_tokens(path)
    assert path.stat().st_mode & 0o777 == 0o600
    assert screen.form.config.token_file == str(path)
    assert screen.form.fault("token_file") == ""
    screen.form.make_tokens(path)
    assert "exists already" in screen.form.fault("token_file")
    kept = {
        key: workspace.preferences.store.value(key) for key in workspace.preferences.store.allKeys()
    }
    assert read_tokens(path).view not in str(kept)


def test_start_listens_and_stop_ends_it(bench, qtbot):
    screen = bench.screen
    assert screen.state.text() == "○ Stopped"
    bench.press(screen.start_button)
    qtbot.waitUntil(lambda: screen.state.text() == "● Listening", timeout=LONG)
    address = bench.flight.view.network.server.address
    assert screen.said.text() == f"at {address}; nobody is connected."
    assert screen.connect_panel.texts["command"].text() == f"workbench gateway foxglove {address}"
    assert screen.form.lines["port"].isReadOnly()
    bench.press(screen.copy_button)
    assert QGuiApplication.clipboard().text() == address
    bench.press(screen.connect_panel.copies["command"])
    assert QGuiApplication.clipboard().text() == f"workbench gateway foxglove {address}"
    bench.press(screen.stop_button)
    qtbot.waitUntil(lambda: screen.state.text() == "○ Stopped", timeout=LONG)
    assert screen.connect_panel.texts["command"].text() == ""
    assert not screen.form.lines["port"].isReadOnly()


def test_a_port_in_use_is_a_sentence_and_another_one_starts(bench, qtbot):
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        bench.write("port", str(port))
        QTest.keyClick(bench.screen.form.lines["port"], Qt.Key.Key_Return)
        qtbot.waitUntil(lambda: bench.running is ListeningState.FAILED, timeout=LONG)
    assert bench.screen.state.text() == "✕ Failed"
    said = bench.screen.said.text()
    assert said.startswith(f"Port {port} at 127.0.0.1 is in use")
    assert said.endswith("choose another port.")
    bench.write("port", "0")
    bench.press(bench.screen.start_button)
    qtbot.waitUntil(lambda: bench.running is ListeningState.LISTENING, timeout=LONG)
    assert bench.told == []


def test_a_page_for_phones_has_its_address_and_code(bench, qtbot):
    bench.screen.form.web.setChecked(True)
    bench.press(bench.screen.start_button)
    panel = bench.screen.connect_panel
    qtbot.waitUntil(lambda: panel.texts["page"].text().startswith("http://"), timeout=LONG)
    assert panel.code.isVisible()
    assert panel.texts["page"].text() in panel.code.accessibleName()
    assert "Only this machine" in panel.hint.text()


def test_clients_are_listed_taken_over_from_and_sent_away(bench, qtbot):
    screen = bench.screen
    path = bench.folder / "link.tokens"
    screen.form.make_tokens(path)
    bench.press(screen.start_button)
    qtbot.waitUntil(lambda: bench.running is ListeningState.LISTENING, timeout=LONG)
    assert "--token-file FILE" in screen.connect_panel.texts["command"].text()
    address = bench.flight.view.network.server.address
    client = RealClient(address, read_tokens(path).command)
    try:
        panel = screen.clients
        qtbot.waitUntil(lambda: panel.control.text() == "tuner has control.", timeout=LONG)
        qtbot.waitUntil(lambda: panel.table.model().index(0, 4).data() == "flies", timeout=LONG)
        qtbot.waitUntil(lambda: panel.table.item(0, 0).text() == "tuner", timeout=LONG)
        assert panel.table.model().index(0, 3).data() == "fly"
        bench.press(panel.take_over)
        operator = ControlOwner.OPERATOR
        qtbot.waitUntil(lambda: bench.flight.view.network.control.hand is operator, timeout=LONG)
        qtbot.waitUntil(lambda: "You have control" in panel.control.text(), timeout=LONG)
        bench.press(panel.give_back)
        qtbot.waitUntil(panel.take_over.isEnabled, timeout=LONG)
        assert wrong_login(address)
        qtbot.waitUntil(lambda: "bad login" in screen.refusals.counts.text(), timeout=LONG)
        assert "role command" in screen.refusals.list.toPlainText()
        panel.table.setFocus()
        panel.table.selectRow(0)
        QTest.keyClick(panel.table, Qt.Key.Key_Delete)
        qtbot.waitUntil(client.ended.is_set, timeout=LONG)
        assert "the operator ended it" in client.said
        qtbot.waitUntil(lambda: panel.table.rowCount() == 0, timeout=LONG)
    finally:
        client.leave()
    assert bench.told == []


def test_the_list_of_refusals_has_four_lines_in_a_low_window(workspace, style, qtbot):
    """The wheel scrolls the page around it."""
    style(workspace.look)
    panel = RefusalsPanel()
    qtbot.addWidget(panel)
    panel.resize(400, 1)
    panel.show()
    lines = panel.list
    assert lines.viewport().height() >= 4 * lines.fontMetrics().lineSpacing()


class RealClient:
    """A client in a thread of its own, which asks for control and then watches."""

    def __init__(self, address, token):
        self._address, self._token = address, token
        self._leave, self.ended, self.said = threading.Event(), threading.Event(), ""
        self._thread = threading.Thread(target=self._run)
        self._thread.start()

    def leave(self):
        self._leave.set()
        self._thread.join()

    def _run(self):
        try:
            with (
                Client(self._address, name="tuner", token=self._token) as client,
                client.control(),
            ):
                for _ in client:
                    if self._leave.is_set():
                        return
        except WorkbenchError as error:
            self.said = str(error)
        finally:
            self.ended.set()


def wrong_login(address):
    """Return whether a client with a wrong token is refused."""
    try:
        with Client(address, name="stranger", token="not the right one at all"):
            return False
    except WorkbenchError:
        return True


@pytest.fixture
def own(qapp, tmp_path):
    """A flight of the test's own."""
    made = Bench(tmp_path)
    made.flight.fly(Choice("hover"), draw=False)
    yield made
    made.close()


@pytest.mark.slow
def test_a_server_that_another_flight_ends_says_so(own, qtbot):
    own.screen.show()
    own.screen.form.lines["port"].setText("0")
    own.press(own.screen.start_button)
    qtbot.waitUntil(lambda: own.running is ListeningState.LISTENING, timeout=LONG)
    own.flight.fly(Choice("hover"), draw=False)
    ended = "The server has ended with its flight: start it again."
    qtbot.waitUntil(lambda: own.screen.said.text() == ended, timeout=LONG)
    qtbot.waitUntil(lambda: own.flight.is_flying, timeout=LONG)
    assert own.running is ListeningState.FAILED
    own.press(own.screen.start_button)
    qtbot.waitUntil(lambda: own.running is ListeningState.LISTENING, timeout=LONG)
