"""The whole story by mouse and keyboard, on the real window with real processes around it.

Take off, steer to 2 m/s, tune a gain with a step, undo, search gains, pin them, serve, let a client
command, take over, land, save, close; then nothing is left, and the pinned regression is green.
"""

import contextlib
import os
import subprocess
import sys
import threading
from dataclasses import dataclass
from pathlib import Path

import pytest
from PyQt6.QtCore import QPoint, QSettings, Qt
from PyQt6.QtWidgets import QApplication, QFileDialog, QLineEdit, QWidget

from workbench.control.mode import FlightMode
from workbench.gains.gains import load_gains
from workbench.gui.main_window import MainWindow
from workbench.gui.preferences import Preferences
from workbench.gui.workspace import make_workspace
from workbench.link import Client
from workbench.link.messages import ControlOwner
from workbench.live.choice import Choice
from workbench.live.orders import NetworkOrder
from workbench.logs.record import read_log

pytestmark = pytest.mark.slow

LIMIT = 600_000
"""Any single thing happens within this time, however slow the machine is [ms]."""
LEFT = Qt.MouseButton.LeftButton
CONTROL = Qt.KeyboardModifier.ControlModifier


def children() -> set[int]:
    """Return the processes that this one has started and that live."""
    found = set()
    for status in Path("/proc").glob("[0-9]*/stat"):
        try:
            state, parent = status.read_text().rpartition(")")[2].split()[:2]
        except OSError:  # it has ended meanwhile
            continue
        if int(parent) == os.getpid() and state != "Z":
            found.add(int(status.parent.name))
    return found


def sockets() -> set[str]:
    """Return the sockets that this process has open."""
    found = set()
    for link in Path("/proc/self/fd").iterdir():
        with contextlib.suppress(OSError):  # it was closed meanwhile
            found.add(str(link.readlink()))
    return {each for each in found if each.startswith("socket:")}


class Pilot:
    """Who sits in front of the window."""

    def __init__(self, qtbot, window: MainWindow) -> None:
        self.qtbot, self.window = qtbot, window
        self.flight = window.workspace.flight

    def until(self, so) -> None:
        """Wait until something is so."""
        self.qtbot.waitUntil(lambda: bool(so()), timeout=LIMIT)

    def press(self, keys: Qt.Key, modifier=Qt.KeyboardModifier.NoModifier) -> None:
        """Press a key, wherever the focus is."""
        self.qtbot.keyClick(QApplication.focusWidget() or self.window, keys, modifier)

    def go_to(self, number: int) -> QWidget:
        """Go to a screen by its key, and return it."""
        self.press(Qt.Key(Qt.Key.Key_0.value + number), CONTROL)
        screen = self.window.stack.current
        assert screen is not None and screen.isVisible()
        return screen

    def click(self, button: QWidget) -> None:
        """Click on what can be clicked."""
        self.until(button.isEnabled)
        self.qtbot.mouseClick(button, LEFT)

    def type(self, field: QLineEdit, text: str) -> None:
        """Type a text in place of what stands there."""
        field.setFocus()
        field.selectAll()
        self.qtbot.keyClicks(field, text)

    @property
    def snapshot(self):
        return self.flight.view.snapshot

    @property
    def mode(self) -> FlightMode:
        return self.snapshot.mode


@dataclass(frozen=True)
class Belongings:
    """What this process has: processes, sockets and threads."""

    children: set[int]
    sockets: set[str]
    threads: set[threading.Thread]


def belongings() -> Belongings:
    return Belongings(children(), sockets(), set(threading.enumerate()))


@pytest.fixture
def before(qapp) -> Belongings:
    """Return what there was before the window."""
    return belongings()


@pytest.fixture
def window(before, qtbot, style, tmp_path):
    store = QSettings(str(tmp_path / "kept.ini"), QSettings.Format.IniFormat)
    preferences = Preferences(store)
    preferences.set("log_folder", str(tmp_path))
    made = MainWindow(make_workspace(preferences), first="home", view3d=False)
    qtbot.addWidget(made)
    made.control.fly(Choice("network"))
    style(made.workspace.look)
    made.show()
    made.activateWindow()
    yield made
    made.close()


def test_from_take_off_to_a_green_regression(before, window, qtbot, tmp_path):
    pilot = Pilot(qtbot, window)
    failures = []
    window.workspace.notices.told.connect(
        lambda notice: failures.append(notice) if notice.severity.value == "failure" else None
    )
    pilot.until(lambda: pilot.flight.is_flying)
    pilot.press(
        Qt.Key.Key_R, Qt.KeyboardModifier.ControlModifier | Qt.KeyboardModifier.ShiftModifier
    )
    pilot.until(lambda: bool(pilot.flight.view.network.log))

    pilot.press(Qt.Key.Key_F6)
    pilot.until(lambda: pilot.mode is FlightMode.HOVERING)

    steer(pilot)
    tuning = tune_a_gain(pilot)
    found = search_gains(pilot, tuning)
    assert found
    spec = pin(pilot, tuning, tmp_path)
    serve_and_take_over(pilot)

    pilot.press(Qt.Key.Key_F8)
    pilot.until(lambda: pilot.mode in (FlightMode.OFF, FlightMode.ARMED))
    gains = save_gains(pilot, tmp_path)
    log = Path(pilot.flight.view.network.log)

    window.close()
    after = belongings()
    assert after.children <= before.children
    assert after.sockets <= before.sockets
    assert after.threads <= before.threads
    assert failures == []

    saved = load_gains(gains)
    assert {name: saved.gains[name] for name in found} == pytest.approx(found, rel=1e-5)
    record = read_log(log)
    flown = {name for done in record.done for name in done.action.set}
    assert flown >= set(found)
    command = [sys.executable, "-m", "workbench", "regress", str(spec)]
    done = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path)
    assert done.returncode == 0, done.stdout + done.stderr


def steer(pilot) -> None:
    """Fly 2 m/s ahead by the right stick, and let go."""
    screen = pilot.go_to(3)
    pad = screen.right_pad
    middle = pad.rect().center()
    pilot.qtbot.mousePress(pad, LEFT, pos=middle)
    for way in range(0, pad.height(), 4):
        pilot.qtbot.mouseMove(pad, middle - QPoint(0, way))
        pilot.qtbot.wait(20)
        if pilot.snapshot.reference[0] >= 2.0:
            break
    assert pilot.snapshot.reference[0] >= 2.0
    pilot.until(lambda: pilot.snapshot.v_WB[0] > 1.9)
    pilot.qtbot.mouseRelease(pad, LEFT, pos=middle)
    pilot.until(lambda: abs(pilot.snapshot.v_WB[0]) < 0.1)


def tune_a_gain(pilot):
    """Fly a step, move a gain by the keyboard, and take that back."""
    screen = pilot.go_to(5)
    gains = screen.gains
    pilot.until(lambda: bool(gains.flown))
    if screen.excitation.repeats.isChecked():
        pilot.qtbot.mouseClick(screen.excitation.repeats, LEFT)
    pilot.click(screen.excitation.button)
    pilot.until(lambda: pilot.flight.view.exciting is not None)
    pilot.until(lambda: pilot.flight.view.exciting is None)
    pilot.until(lambda: screen.response.history.numbers is not None)
    row = screen.panel.rows["kp_velocity_x"]
    start = gains.flown["kp_velocity_x"]
    row.slider.setFocus()
    pilot.qtbot.keyClick(row.slider, Qt.Key.Key_Right, Qt.KeyboardModifier.ShiftModifier)
    pilot.until(lambda: gains.flown["kp_velocity_x"] > start)
    pilot.press(Qt.Key.Key_Z, CONTROL)
    pilot.until(lambda: gains.flown["kp_velocity_x"] == start)
    return screen


def search_gains(pilot, screen) -> dict[str, float]:
    """Let gains be searched for a wish, and accept them."""
    card = screen.autotune
    screen.tabs.setCurrentWidget(card)
    for row in card.wishes.rows[1:]:
        pilot.click(row.remove)
    assert card.wishes.rows[0].text == "level.rise_time <= 0.4 s"
    pilot.type(card.wishes.rows[0].number, "0.5")
    pilot.click(card.start)
    pilot.until(lambda: not card.is_running)
    assert card.pages.currentIndex() == 2
    before = dict(screen.gains.flown)
    pilot.click(card.accept)
    pilot.until(lambda: dict(screen.gains.flown) != before)
    wanted = dict(screen.gains.proposed)
    pilot.until(lambda: dict(screen.gains.flown) == wanted)
    pilot.press(Qt.Key.Key_K, CONTROL)
    return {n: v for n, v in wanted.items() if v != before[n] and n in screen.gains.saved_names}


def pin(pilot, screen, folder: Path) -> Path:
    """Pin what flies as a regression."""
    card = screen.pin
    screen.tabs.setCurrentWidget(card)
    pilot.type(card.name, "story")
    pilot.type(card.folder, str(folder))
    pilot.click(card.button)
    pilot.until(lambda: bool(card.command.text()))
    spec = folder / "story.workbench.yaml"
    assert spec.is_file()
    return spec


def serve_and_take_over(pilot) -> None:
    """Serve, let a client fly, and take over from it."""
    screen = pilot.go_to(2)
    pilot.type(screen.form.lines["port"], "0")
    pilot.click(screen.start_button)
    pilot.until(lambda: pilot.flight.view.network.server is not None)
    address = pilot.flight.view.network.server.address
    if screen.clients.give_back.isEnabled():  # the stick has made the operator fly
        pilot.click(screen.clients.give_back)
    lost = threading.Event()

    def fly() -> None:
        with Client(address, name="somebody") as client, client.control() as control:
            for _ in client:
                if (
                    client.control_state is not None
                    and client.control_state.hand is ControlOwner.OPERATOR
                ):
                    lost.set()
                    return
                control.velocity(0.0, 0.5, 0.0)

    stranger = threading.Thread(target=fly, name="Dummy client")
    stranger.start()
    try:
        network = lambda: pilot.flight.view.network  # noqa: E731
        pilot.until(
            lambda: network().control is not None and network().control.hand is ControlOwner.CLIENT
        )
        pilot.until(lambda: pilot.snapshot.v_WB[1] > 0.3)
        assert screen.clients.table.rowCount() == 1
        pilot.click(screen.clients.take_over)
        pilot.until(lambda: network().control.hand is ControlOwner.OPERATOR)
        pilot.until(lost.is_set)
    finally:
        pilot.flight.do(NetworkOrder.TAKE_OVER)
        stranger.join(30.0)
    pilot.until(lambda: abs(pilot.snapshot.v_WB[1]) < 0.1)
    pilot.click(screen.stop_button)
    pilot.until(lambda: network().server is None)


def save_gains(pilot, folder: Path) -> Path:
    """Save what flies by the dialog that Ctrl+S shows."""
    pilot.go_to(5)
    pilot.press(Qt.Key.Key_S, CONTROL)
    dialogs = lambda: [d for d in pilot.window.findChildren(QFileDialog) if d.isVisible()]  # noqa: E731
    pilot.until(dialogs)
    path = folder / "story-gains.yaml"
    dialog = dialogs()[0]
    field = dialog.findChild(QLineEdit)
    field.setText(str(path))  # typed letter by letter, a list of files would stand above it
    pilot.qtbot.keyClick(field, Qt.Key.Key_Return)
    pilot.until(path.exists)
    return path
