"""What can break behind the real window: it says what and what to do, lives on, and flies again."""

import os
import signal
import socket
from pathlib import Path

import pytest
from PyQt6.QtCore import Qt

from workbench.gui import recorder
from workbench.gui.notices import Severity
from workbench.live.choice import Choice
from workbench.live.messages import Phase
from workbench.scenario.scenario import Action, Push

LIMIT = 60_000
CONTROL = Qt.KeyboardModifier.ControlModifier


@pytest.fixture
def window(shared_window, qtbot, workspace, tmp_path):
    """The window, and the flight that the test before began anew; or the first one."""
    workspace.preferences.set("log_folder", str(tmp_path))
    flight = workspace.flight
    if not flight.is_flying:
        shared_window.control.fly(Choice("hover"))
    qtbot.waitUntil(lambda: flight.is_flying, timeout=LIMIT)
    return shared_window


@pytest.fixture
def failure(told, qtbot):
    """Wait for a failure that is told, and return it."""

    def wait(words):
        def found():
            return [n for n in told if n.severity is not Severity.INFORMATION and words in n.what]

        qtbot.waitUntil(lambda: bool(found()), timeout=LIMIT)
        return found()[0]

    return wait


def fly_again(window, qtbot):
    """Press the key that resets, and wait until it flies."""
    flight = window.workspace.flight
    qtbot.keyClick(window, Qt.Key.Key_R, CONTROL)
    qtbot.waitUntil(lambda: flight.view.phase is Phase.FLYING, timeout=LIMIT)
    began = flight.view.snapshot.time
    qtbot.waitUntil(lambda: flight.view.snapshot.time > began + 0.2, timeout=LIMIT)


def test_a_flight_that_diverges_is_told_and_begun_again(window, failure, qtbot):
    far = (10.0, 10.0, 10.0)
    window.workspace.flight.do(Action(push=Push([1000.0, 1000.0, 1000.0], [*far], 100.0)))
    notice = failure("the flight broke off after")
    assert "Reset" in notice.remedy
    assert window.workspace.flight.view.phase is Phase.BROKEN
    fly_again(window, qtbot)


def test_a_flight_whose_process_dies_is_told_and_flown_anew(window, failure, qtbot):
    live = window.workspace.flight.live
    os.kill(live.pid, signal.SIGKILL)
    notice = failure("killed")
    assert notice.remedy
    qtbot.waitUntil(lambda: window.workspace.flight.view.phase is Phase.ENDED, timeout=LIMIT)
    fly_again(window, qtbot)


def test_a_model_that_does_not_load_is_told_and_another_one_flies(window, failure, tmp_path, qtbot):
    bad = tmp_path / "bad.urdf"
    bad.write_text("<robot name='bad'><link name='a'/>")
    window.control.fly_model(str(bad))
    assert "bad.urdf" in failure("bad.urdf").what
    flight = window.workspace.flight
    before = flight.live
    window.control.fly(Choice("hover"))
    qtbot.waitUntil(lambda: flight.live is not before and flight.is_flying, timeout=LIMIT)


def test_a_full_disk_ends_the_log_and_not_the_flight(window, failure, tmp_path, monkeypatch, qtbot):
    if not Path("/dev/full").exists():
        pytest.skip("there is no /dev/full here: run the test on Linux")
    (tmp_path / "full.mcap").symlink_to("/dev/full")
    monkeypatch.setattr(recorder, "log_name", lambda vehicle, now: "full.mcap")
    qtbot.keyClick(window, Qt.Key.Key_R, CONTROL | Qt.KeyboardModifier.ShiftModifier)
    assert "full.mcap" in failure("full.mcap").what
    flight = window.workspace.flight
    now = flight.view.snapshot.time
    qtbot.waitUntil(lambda: flight.view.snapshot.time > now + 0.3, timeout=LIMIT)
    assert not window.recorder.is_recording


def test_a_port_in_use_is_told_and_the_flight_goes_on(window, qtbot):
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        window.show_screen("server")
        screen = window.stack.screen_of("server")
        screen.form.lines["port"].setText(str(taken.getsockname()[1]))
        qtbot.mouseClick(screen.start_button, Qt.MouseButton.LeftButton)
        qtbot.waitUntil(lambda: "in use" in screen.said.text(), timeout=LIMIT)
    flight = window.workspace.flight
    now = flight.view.snapshot.time
    qtbot.waitUntil(lambda: flight.view.snapshot.time > now + 0.2, timeout=LIMIT)
