"""What nobody caught is told, and the app goes on."""

import subprocess
import sys
import threading

import pytest
from PyQt6.QtCore import QTimer

from workbench.gui.app import MAX_ERROR_CHARACTERS, CrashGuard
from workbench.gui.notices import Severity


@pytest.fixture
def guard(workspace, capsys):
    made = CrashGuard(workspace.notices)
    made.install()
    yield made
    made.uninstall()


def fall(words="the map is upside down"):
    raise ValueError(words)


def test_an_exception_in_a_slot_becomes_a_notice(guard, told, qtbot, capsys):
    QTimer.singleShot(0, fall)
    qtbot.waitUntil(lambda: bool(told), timeout=5000)
    (notice,) = told
    assert notice.severity is Severity.FAILURE
    assert "ValueError: the map is upside down (test_crash.py:" in notice.what
    assert "Ctrl+R" in notice.remedy
    assert "in fall" in notice.details
    assert "in fall" in capsys.readouterr().err


def test_an_exception_in_a_thread_is_told_in_the_window_s_thread(guard, told, qtbot, workspace):
    where = []
    workspace.notices.told.connect(lambda _: where.append(threading.current_thread()))
    thread = threading.Thread(target=fall)
    thread.start()
    thread.join()
    qtbot.waitUntil(lambda: bool(told), timeout=5000)
    assert where == [threading.main_thread()]


def test_the_next_slot_is_called_as_ever(guard, told, qtbot):
    heard = []
    QTimer.singleShot(0, fall)
    QTimer.singleShot(1, lambda: heard.append("here"))
    qtbot.waitUntil(lambda: heard == ["here"] and bool(told), timeout=5000)


def test_long_words_are_cut_in_the_banner_and_whole_in_the_details(guard, told, qtbot):
    QTimer.singleShot(0, lambda: fall("x" * 5000))
    qtbot.waitUntil(lambda: bool(told), timeout=5000)
    assert len(told[0].what) < MAX_ERROR_CHARACTERS + 120
    assert "x" * 5000 in told[0].details


def test_ctrl_c_closes_and_tells_nothing(guard, told, qtbot):
    with qtbot.waitSignal(guard.interrupted, timeout=5000):
        guard.catch(KeyboardInterrupt, KeyboardInterrupt(), None)
    assert told == []


def test_afterwards_exceptions_go_where_they_went_before(workspace):
    before = (sys.excepthook, threading.excepthook)
    guard = CrashGuard(workspace.notices)
    guard.install()
    assert sys.excepthook == guard.catch
    guard.uninstall()
    assert (sys.excepthook, threading.excepthook) == before


def test_nothing_of_qt_is_left_for_the_end_of_python():
    """Not even what the collector does not see, and what was never given to the window."""
    script = """
import gc
from PyQt6 import sip
from PyQt6.QtCore import QObject
from PyQt6.QtWidgets import QApplication, QLabel, QWidget
from workbench.gui.app import delete_objects

app, objects, alone = QApplication([]), QObject(), QWidget()
child = QLabel("child", alone)
gc.freeze()
delete_objects()
print([sip.isdeleted(each) for each in (objects, alone, child, app)])
"""
    command = [sys.executable, "-c", script]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[True, True, True, False]"
