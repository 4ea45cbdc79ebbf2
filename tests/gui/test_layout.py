"""All screens in the real window: one window, names, no text cut, nothing on anything else."""

import os
import subprocess
import sys
from dataclasses import replace
from itertools import product
from pathlib import Path

import numpy as np
import pytest
from PyQt6.QtCore import QEvent, QObject, Qt, QTimer
from PyQt6.QtWidgets import (
    QAbstractButton,
    QAbstractSpinBox,
    QApplication,
    QComboBox,
    QLabel,
    QLineEdit,
    QSlider,
    QTabWidget,
    QWidget,
)
from pytestqt.qtbot import QtBot

from tests.gui.layout_faults import faults, painted_text
from workbench.analysis.queries import Judge, Predict, Tune
from workbench.analysis.replies import Searched, Tuned
from workbench.analysis.subject import AnalysedVehicle
from workbench.analysis.work import Work
from workbench.analysis.worker import find_answerer
from workbench.common.errors import WorkbenchError
from workbench.gui.gains.gain_panel import GainGroup
from workbench.gui.help import about_page
from workbench.gui.keys_page import KeysPage
from workbench.gui.layout import hbox
from workbench.gui.screen_table import SCREEN_TABLE
from workbench.gui.tuning.drawn_loop import drawn_measurement
from workbench.live.messages import Phase
from workbench.scenario.excitation import ActiveExcitation, Excitation, Shape

CONTROLS = (QAbstractButton, QAbstractSpinBox, QComboBox, QLineEdit, QSlider)
SCALE = float(os.environ.get("QT_SCALE_FACTOR", "1"))
SIZES = (
    ((1024, 640), (1024, 700), (1280, 720), (1366, 768), (1920, 1080), (2560, 1440), (3840, 2160))
    if SCALE == 1.0
    else tuple(
        (round(x / SCALE), round(y / SCALE)) for x, y in ((1920, 1080), (2560, 1440), (3840, 2160))
    )
)
"""Of the window, in Qt's pixels: where Qt scales, each is several of the screen's."""
SMALL, NARROW = (1280, 720), (1024, 700)
FEW_SIZES = tuple(dict.fromkeys((SIZES[0], SMALL, SIZES[-1])))
TIME = np.linspace(0.0, 2.0, 50)
TUNED = Tuned(
    before={"kp_velocity_x": 4.45},
    gains={"kp_velocity_x": 5.5},
    met=False,
    stopped=False,
    wishes=(
        ("level.rise_time <= 0.433 s", "0.5123 s", "0.3812 s", True),
        ("tilt.phase_margin >= 45 deg", "38.91 deg", "44.03 deg", False),
    ),
    steps={"x": (TIME, TIME, 0.5 * TIME)},
    said=("The overshoot is at odds with the rise time.",),
)


@pytest.fixture(scope="module")
def workspace(shared_workspace):
    return shared_workspace


class Windows(QObject):
    """Takes note of every widget that is shown as a window of its own."""

    def __init__(self):
        super().__init__()
        self.seen: list[str] = []
        self.of_the_app: tuple[str, ...] = ()

    def eventFilter(self, receiver, event):
        if event.type() == QEvent.Type.Show and receiver.isWidgetType() and receiver.isWindow():
            self.seen.append(type(receiver).__name__)
        return False


@pytest.fixture(scope="module")
def windows(qapp):
    """Watch before the window is made: it is asked for before `shared_window`."""
    made = Windows()
    qapp.installEventFilter(made)
    return made


def no_engine():
    raise WorkbenchError("The 3-D view needs PyQt6-WebEngine, which is not installed.")


@pytest.fixture(scope="module")
def window(request, qapp, windows, shared_window, workspace, canned):
    """The window before a flight out of a can, with what opens on its screens open.

    Margins and prediction are answered here, not by processes of which nobody knows when. In place
    of the web engine's 3-D view there is Qt's own.
    """
    analysis, subject = workspace.analysis, AnalysedVehicle(canned.views[0].scenario, {})
    answered = set()

    def answer(question):
        kind = type(question)
        if kind in (Judge, Predict):
            *_, reply = find_answerer(kind)(subject, question, Work(1, None, None))
            QTimer.singleShot(0, lambda: analysis.tell(question, reply))
            answered.add(kind)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(analysis, "warm_up", lambda: None)
        patch.setattr(analysis, "ask", answer)
        patch.setattr(shared_window.view3d, "_load", no_engine)
        for index in range(60):
            view = replace(canned.views[index], url="http://localhost:7000")
            patch.setattr(workspace.flight, "_view", view)
            if index == 0:
                workspace.flight.begun.emit(view)
            workspace.flight.streamed.emit(list(canned.published[index]))
            workspace.flight.viewed.emit(view)
        shared_window.show_screen("tuning")
        shared_window.stack.current.autotune.search()
        analysis.tell(Tune({}, ()), TUNED)
        workspace.log.open(Path("flight.csv"))
        QtBot(request).waitUntil(lambda: answered == {Judge, Predict}, timeout=120_000)
        for row in SCREEN_TABLE:  # each for the first time
            shared_window.show_screen(row.name)
            QApplication.processEvents()
        windows.of_the_app = tuple(windows.seen)
        qapp.removeEventFilter(windows)
        yield shared_window


def pages_of(screen):
    """Yield the name of each tab of a screen while it is shown, or "" of the screen alone."""
    tabs = [each for each in screen.findChildren(QTabWidget) if each.isVisible()]
    for each in tabs:
        for index in range(each.count()):
            each.setCurrentIndex(index)
            yield each.tabText(index)
        each.setCurrentIndex(0)
    if not tabs:
        yield ""


def seen_faults(window):
    """Return the faults of a window's layout, and of the text that its widgets paint."""
    for _ in range(5):  # a layout may ask for another one
        QApplication.processEvents()
    with painted_text() as painted:
        window.grab()
    return [*faults(window), *sorted(painted)]


def test_there_is_one_window(window, windows):
    """Of all that was shown since it was made, with every screen."""
    assert windows.of_the_app == ("MainWindow",)


def test_every_control_has_a_name(window, qapp):
    buddies = {label.buddy() for label in window.findChildren(QLabel)}
    for row in SCREEN_TABLE:
        window.show_screen(row.name)
        qapp.processEvents()
        for control in window.stack.current.findChildren(CONTROLS):
            if not control.isVisible() or control.focusPolicy() is Qt.FocusPolicy.NoFocus:
                continue
            if isinstance(control.parent(), QAbstractSpinBox | QComboBox):
                continue  # part of a control that has a name
            named = control.accessibleName() or control in buddies or control.focusProxy()
            text = control.text() if isinstance(control, QAbstractButton) else ""
            assert named or text, f"{row.name}: {type(control).__name__} in {control.parent()}"


@pytest.mark.parametrize(
    ("theme", "sizes"),
    [
        pytest.param("light", FEW_SIZES, id="light"),
        *(
            pytest.param(theme, SIZES, marks=pytest.mark.slow, id=f"{theme}, every size")
            for theme in ("light", "dark")
        ),
    ],
)
def test_all_screens_are_laid_out_well(window, workspace, qapp, theme, sizes):
    """In every size, alone and beside the 3-D view."""
    workspace.preferences.set("theme", theme)
    found = []
    for beside, size in product((False, True), reversed(sizes)):
        window.resize(*size)
        if window.view3d.isVisibleTo(window) is not beside:
            window.actions_by_name["view_3d"].trigger()
            workspace.flight.viewed.emit(workspace.flight.view)
        for row in SCREEN_TABLE:
            window.show_screen(row.name)
            qapp.processEvents()
            for page in pages_of(window.stack.current):
                where = f"{size}, 3-D {beside}, {row.title} {page}"
                found += [f"{where}: {fault}" for fault in seen_faults(window)]
        stop = window.top_bar.button("stop")
        assert stop.width() >= stop.sizeHint().width(), f"{size}, 3-D {beside}"
    assert not found, "\n".join(dict.fromkeys(found))


def test_cards_of_sensors_that_are_off_are_laid_out_well(window, workspace, qapp):
    """In the smallest windows, where their buttons have the least height."""
    view = workspace.flight.view
    none = dict.fromkeys(("imu", "gps", "lidar", "magnetometer", "height", "barometer"))
    off = replace(view, snapshot=replace(view.snapshot, sensors=(), **none))
    home = window.show_screen("home") or window.stack.current
    for size in SIZES[:2]:
        window.resize(*size)
        qapp.processEvents()
        home.begin(off)
        assert all(each.isVisible() for each in home.offers.values())
        assert not [*seen_faults(home)], size
    home.begin(view)


@pytest.mark.slow
def test_all_screens_are_laid_out_well_where_each_pixel_is_four():
    """As on small screens of many pixels: 1920 x 1080 and 3840 x 2160 of them.

    Qt takes its scale from the environment, once, so this file runs again in a process of its own.
    """
    options = ("-qn0", "-pno:cacheprovider", "-knot where_each_pixel_is_four")
    done = subprocess.run(
        [sys.executable, "-m", "pytest", __file__, *options],
        env={**os.environ, "QT_SCALE_FACTOR": "2"},
        capture_output=True,
        text=True,
        timeout=600.0,
        check=False,
    )
    assert done.returncode == 0, done.stdout[-6000:]


STEP = Excitation("x", Shape.STEP, 1.0, 1.0, True)


class RunningStates:
    """Brings a window into states of a flight that is being tuned, one after the other."""

    def __init__(self, window, canned, patch, qtbot) -> None:
        self._flight, self._canned = window.workspace.flight, canned
        self._patch, self._qtbot = patch, qtbot
        window.show_screen("tuning")
        self._screen = window.stack.current
        self._screen.gains.set_linked(False)

    def _show(self, **other) -> None:
        view = replace(self._canned.views[-1], **other)
        self._patch.setattr(self._flight, "_view", view)
        self._flight.viewed.emit(view)

    def withheld(self) -> str:
        """A step that begins at 2 m/s is no step from rest."""
        exciting = ActiveExcitation(STEP, began=1.5, round=1)
        for view, published in zip(self._canned.views, self._canned.published, strict=True):
            if view.snapshot.time > self._flight.view.snapshot.time:
                self._flight.streamed.emit(list(published))
                self._show(snapshot=view.snapshot, exciting=exciting)
        self._show()
        assert self._screen.response.history.numbers.withheld
        return "Step"

    def flying_back(self) -> str:
        self._show(exciting=ActiveExcitation(STEP, began=1.5, round=2, returning=True))
        return "Step"

    def ended_early(self) -> str:
        self._show(excitation_ended="the drone came closer than 0.5 m to an obstacle")
        return "Step"

    def measured(self) -> str:
        card = self._screen.frequency
        frequency = np.geomspace(2.0, 60.0, 40)
        response = 20.0 / (1j * frequency)
        known, spread = np.full(40, 0.97), np.full(40, 0.04)
        drawn = drawn_measurement(frequency, response, known, spread)
        card.measuring.keep(card.curves.loop, card.curves.cut, self._screen.trial.flown, drawn)
        return "Frequency"

    def tuning(self) -> str:
        self._screen.autotune.search()
        best = {"kp_velocity_x": 5.1234, "kp_velocity_y": 5.1234, "kd_velocity_z": 0.0712}
        said = "level.settling_time <= 0.61 s, 0.7312 s"
        searched = Searched("local search in compiled flights", 0.42, best, said)
        self._screen.workspace.analysis.searched.emit(searched)
        return "Tune"

    def unstable(self) -> str:
        """All gains of roll and pitch, far beyond what rotor lag allows."""
        self._screen.gains.propose("kd_pitch", 0.5)
        self._qtbot.waitUntil(lambda: bool(self._screen.gains.warning))
        return "Frequency"

    def ended(self) -> str:
        self._screen.gains.discard()
        said = "the flight's process was ended by signal 9: restart it by Reset (Ctrl+R)"
        self._show(phase=Phase.ENDED, said=said)
        return "Step"


STATES = ("withheld", "flying_back", "ended_early", "measured", "tuning", "unstable", "ended")


@pytest.mark.parametrize(
    ("theme", "sizes"),
    [
        pytest.param("light", (NARROW,), id="light"),
        *(
            pytest.param(theme, SIZES, marks=pytest.mark.slow, id=f"{theme}, every size")
            for theme in ("light", "dark")
        ),
    ],
)
def test_no_text_is_cut_while_a_flight_is_tuned(
    window, workspace, canned, monkeypatch, qtbot, theme, sizes
):
    workspace.preferences.set("theme", theme)
    if window.view3d.isVisibleTo(window):
        window.actions_by_name["view_3d"].trigger()
    found = []
    states = RunningStates(window, canned, monkeypatch, qtbot)
    tabs = window.stack.current.tabs
    for state in STATES:
        title = getattr(states, state)()
        for size in sizes:
            window.resize(*size)
            QApplication.processEvents()
            names = [tabs.tabText(index) for index in range(tabs.count())]
            if title in names:
                tabs.setCurrentIndex(names.index(title))
            found += [f"{size}, {state}: {fault}" for fault in seen_faults(window)]
    assert not found, "\n".join(dict.fromkeys(found))


def test_what_opens_on_the_tuning_screen_is_laid_out_well(window, qapp):
    """In every size, alone: beside the 3-D view it may be narrower than what is open needs."""
    if window.view3d.isVisibleTo(window):
        window.actions_by_name["view_3d"].trigger()
    window.show_screen("tuning")
    screen = window.stack.current
    closed = [group for group in screen.findChildren(GainGroup) if not group.is_open]
    forms = [card.form.button for card in (screen.response, screen.margins)]
    assert closed and not any(button.isChecked() for button in forms)
    for group in closed:
        group.set_open(True)
    for button in forms:
        button.click()
    found = []
    for size in FEW_SIZES:
        window.resize(*size)
        for page in pages_of(screen):
            found += [f"{size}, {page}: {fault}" for fault in seen_faults(window)]
    for group in closed:
        group.set_open(False)
    for button in forms:
        button.click()
    assert not found, "\n".join(dict.fromkeys(found))


@pytest.mark.parametrize(
    "kind", [lambda window: KeysPage(window.workspace.keys, window), about_page]
)
def test_dialogs_fit_into_the_smallest_window(window, qapp, qtbot, kind):
    window.resize(*SIZES[0])
    page = kind(window)
    qtbot.addWidget(page)
    page.show()
    qapp.processEvents()
    assert list(faults(page)) == []
    assert page.width() <= window.width() and page.height() <= window.height()
    assert page.findChildren(QAbstractButton)


def test_a_drop_down_list_shows_whole_rows(window, qapp, qtbot, case):
    """In the style that was applied before the window was made."""
    for count in (3, 7, 18):
        with case(count):
            box = QComboBox()
            qtbot.addWidget(box)
            box.addItems([f"item {number}" for number in range(count)])
            box.setCurrentIndex(count // 2)
            box.show()
            box.showPopup()
            qapp.processEvents()
            rows = box.view().viewport().height() / box.view().sizeHintForRow(0)
            assert rows == pytest.approx(min(count, box.maxVisibleItems()))
            box.hidePopup()


def test_a_part_with_an_alignment_takes_no_share(qtbot):
    """Alignments of Qt are integers, as stretches are."""
    page, wide, small = QWidget(), QLabel("wide"), QLabel("small")
    qtbot.addWidget(page)
    box = hbox((wide, 1), (small, Qt.AlignmentFlag.AlignVCenter), of=page)
    assert (box.stretch(0), box.stretch(1)) == (1, 0)
    place = box.itemAt(1)
    assert place is not None and place.alignment() == Qt.AlignmentFlag.AlignVCenter
