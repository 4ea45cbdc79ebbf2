"""A control engineer's round by mouse and keyboard alone, on the real window with real processes.

Bad gains are loaded, the weakest loop is found on Bode, measured, repaired by the two sliders, a
gust is flown, the repair compared with what A has, and pinned; then `workbench regress` is green.
"""

import math
import subprocess
import sys

import pytest
from PyQt6.QtCore import QPoint, QSettings, Qt
from PyQt6.QtWidgets import QApplication, QFileDialog, QLineEdit, QTabBar

from workbench.design.judge.loop_judgement import hover_margins
from workbench.design.linear.operating_point import HOLDING_POINT
from workbench.design.linear.study import LinearStudy
from workbench.gains.gains import GainFile, save_gains
from workbench.gui.gains.gain_bar import GainBar
from workbench.gui.gains.gain_file_diff_view import GainFileDiffView
from workbench.gui.main_window import MainWindow
from workbench.gui.preferences import Preferences
from workbench.gui.workspace import make_workspace
from workbench.live.choice import Choice

pytestmark = pytest.mark.slow

LIMIT = 600_000
"""Any single thing happens within this time, however slow the machine is [ms]."""
LEFT = Qt.MouseButton.LeftButton
CONTROL, SHIFT = Qt.KeyboardModifier.ControlModifier, Qt.KeyboardModifier.ShiftModifier
BAD = {"kp_pitch": 350.0, "kd_pitch": 22.0}
"""A pitch loop of 21 degrees of phase margin, and stable."""
WANTED = 45.0
"""Phase margin that the pitch loop is to have [deg]."""


@pytest.fixture
def window(qtbot, style, tmp_path):
    store = QSettings(str(tmp_path / "kept.ini"), QSettings.Format.IniFormat)
    made = MainWindow(make_workspace(Preferences(store)), first="tuning", view3d=False)
    qtbot.addWidget(made)
    made.resize(1500, 900)
    made.control.fly(Choice("hover"))
    style(made.workspace.look)
    made.show()
    made.activateWindow()
    yield made
    made.close()


class Engineer:
    """Who sits in front of the window."""

    def __init__(self, qtbot, window) -> None:
        self.qtbot, self.window = qtbot, window
        self.screen = window.stack.current

    def until(self, so) -> None:
        self.qtbot.waitUntil(lambda: bool(so()), timeout=LIMIT)

    def press(self, key, modifier=Qt.KeyboardModifier.NoModifier) -> None:
        self.qtbot.keyClick(QApplication.focusWidget() or self.window, key, modifier)

    def click(self, button) -> None:
        self.until(button.isEnabled)
        self.qtbot.mouseClick(button, LEFT)

    def tab(self, bar: QTabBar, name: str) -> None:
        """Click on a tab by its name."""
        (index,) = [i for i in range(bar.count()) if bar.tabText(i) == name]
        self.qtbot.mouseClick(bar, LEFT, pos=bar.tabRect(index).center())

    def type(self, field: QLineEdit, text: str) -> None:
        field.setFocus()
        field.selectAll()
        self.qtbot.keyClicks(field, text)


def test_bad_gains_are_found_repaired_compared_and_pinned(window, qtbot, tmp_path):
    qtbot.waitUntil(lambda: window.stack.name == "tuning", timeout=LIMIT)
    engineer = Engineer(qtbot, window)
    screen, flight = engineer.screen, window.workspace.flight
    engineer.until(lambda: bool(screen.gains.flown) and screen.judgement.proposed is not None)
    load(engineer, tmp_path)

    # the weakest loop stands in Bode's head, red in the table of margins
    engineer.tab(screen.tabs.tabBar(), "Frequency")
    card = screen.frequency
    engineer.until(lambda: margin_of(screen) == pytest.approx(phase_margin(BAD), abs=0.1))
    card.loops.setFocus()
    engineer.press(Qt.Key.Key_End)
    engineer.press(Qt.Key.Key_Home)  # the weakest loop
    engineer.until(lambda: card.curves.loop == "pitch" and "flown" in card.curves.shown)
    margin = math.degrees(card.curves.shown["flown"].margins.phase_margin)
    assert margin == pytest.approx(phase_margin(BAD), abs=0.1) and margin < 30.0
    # an empty slot takes what flies: A has the bad gains
    engineer.click(screen.findChild(GainBar).buttons["compare_A"])
    assert screen.gains.slots["A"]["kp_pitch"] == BAD["kp_pitch"]

    measure(engineer, card)
    repair(engineer, card)
    flown = {name: screen.gains.flown[name] for name in BAD}
    assert phase_margin(flown) == pytest.approx(WANTED, abs=1.5)
    engineer.press(Qt.Key.Key_K, CONTROL)

    # a gust, and its response with numbers
    bar = screen.excitation.tabs
    engineer.tab(bar, "Gust")
    engineer.until(lambda: screen.excitation.button.text() == "Gust now")
    if screen.excitation.repeats.isChecked():
        qtbot.mouseClick(screen.excitation.repeats, LEFT)
    engineer.click(screen.excitation.button)
    engineer.until(lambda: flight.view.exciting is not None)
    engineer.until(lambda: flight.view.exciting is None)
    engineer.until(lambda: screen.response.history.numbers is not None)
    assert screen.response.history.numbers.peak > 0.0

    # against A, in one table
    engineer.tab(screen.tabs.tabBar(), "Compare")
    compare = screen.compare
    engineer.until(lambda: "A" in [each.name for each in compare.chosen])
    engineer.until(lambda: len(compare._known()) >= 2)
    spec = pin(engineer, tmp_path)
    window.close()
    command = [sys.executable, "-m", "workbench", "regress", str(spec)]
    done = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path)
    assert done.returncode == 0, done.stdout + done.stderr


def phase_margin(gains) -> float:
    """The pitch loop's, as `workbench judge` has it [deg]."""
    found = hover_margins(LinearStudy().sampled(HOLDING_POINT, gains))
    return math.degrees(found["pitch"].phase_margin)


def margin_of(screen) -> float:
    """The pitch loop's of what flies, as the table of margins has it [deg]."""
    judged = screen.judgement.flown
    return math.degrees({each.name: each for each in judged.loops}["pitch"].phase_margin)


def load(engineer, folder) -> None:
    """Load a gain file by the dialog that Ctrl+Shift+L shows, and fly what differs."""
    path = folder / "bad.yaml"
    gains = {name: engineer.screen.gains.flown[name] for name in engineer.screen.gains.kept}
    save_gains(path, GainFile("dh_drone", "made bad", {**gains, **BAD}))
    engineer.press(Qt.Key.Key_L, CONTROL | SHIFT)
    dialogs = lambda: [  # noqa: E731
        each for each in engineer.window.findChildren(QFileDialog) if each.isVisible()
    ]
    engineer.until(dialogs)
    field = dialogs()[0].findChild(QLineEdit)
    field.setText(str(path))
    engineer.qtbot.keyClick(field, Qt.Key.Key_Return)
    view = engineer.screen.findChild(GainFileDiffView)
    engineer.until(view.isVisible)
    engineer.click(view.fly)
    engineer.until(lambda: engineer.screen.gains.flown["kp_pitch"] == BAD["kp_pitch"])
    engineer.until(lambda: not engineer.screen.gains.unflown)


def measure(engineer, card) -> None:
    """Measure the loop on the flight, ten times as fast as it is, and see it beside the model."""
    engineer.window.control.set_speed(10.0)
    engineer.click(card.measuring.button)
    engineer.until(lambda: engineer.window.workspace.flight.view.measuring is not None)
    engineer.until(lambda: engineer.window.workspace.flight.view.measuring is None)
    engineer.until(lambda: any(each.name == "measured" for each in card._drawn))
    (measured,) = [each for each in card._drawn if each.name == "measured"]
    model = card.curves.shown["flown"]
    crossover = model.margins.crossover
    found = abs(measured.at(crossover, measured.open_loop))
    assert found == pytest.approx(1.0, rel=0.12)


def repair(engineer, card) -> None:
    """Move the phase slider by the mouse and the keyboard until the loop has what is wanted."""
    shaping = card.shaping
    engineer.until(lambda: shaping.phase.slider.isEnabled())
    slider = shaping.phase.slider
    place = lambda value: QPoint(  # noqa: E731
        round(slider._x(slider.scale.place(value))), slider.height() // 2
    )
    start = place(shaping.phase.value)
    engineer.qtbot.mousePress(slider, LEFT, pos=start)
    engineer.qtbot.mouseMove(slider, place(math.radians(WANTED)))
    engineer.until(lambda: abs(math.degrees(shaping.phase.value) - WANTED) < 3.0)
    engineer.qtbot.mouseRelease(slider, LEFT, pos=place(math.radians(WANTED)))
    for _ in range(20):  # the rest by the arrow keys
        engineer.until(lambda: shaping._base is None)
        left = WANTED - math.degrees(shaping.phase.value)
        if abs(left) < 0.8:
            break
        key = Qt.Key.Key_Right if left > 0.0 else Qt.Key.Key_Left
        engineer.qtbot.keyClick(slider, key)
    engineer.qtbot.keyClick(shaping.bandwidth.slider, Qt.Key.Key_Right)  # and a little faster
    gains = engineer.screen.gains
    engineer.until(lambda: shaping._base is None)
    engineer.until(lambda: all(gains.flown[name] == gains.proposed[name] for name in BAD))
    assert gains.warning == ""


def pin(engineer, folder):
    """Pin what flies as a regression of the gust."""
    card = engineer.screen.pin
    engineer.tab(engineer.screen.tabs.tabBar(), "Pin")
    engineer.type(card.name, "round")
    engineer.type(card.folder, str(folder))
    engineer.click(card.button)
    engineer.until(lambda: bool(card.command.text()))
    return folder / "round.workbench.yaml"
