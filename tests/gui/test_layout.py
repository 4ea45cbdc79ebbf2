"""All screens in the real window: one window, names, no text cut, nothing on anything else."""

import os
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import replace
from itertools import combinations, product
from pathlib import Path

import numpy as np
import pytest
from PyQt6.QtCore import QEvent, QObject, Qt, QTimer
from PyQt6.QtWidgets import (
    QAbstractButton,
    QAbstractScrollArea,
    QAbstractSpinBox,
    QApplication,
    QComboBox,
    QLabel,
    QLineEdit,
    QMainWindow,
    QMenuBar,
    QScrollArea,
    QSizeGrip,
    QSlider,
    QSplitterHandle,
    QStackedWidget,
    QTabBar,
    QTabWidget,
    QToolButton,
    QWidget,
)
from pytestqt.qtbot import QtBot

from workbench.analysis.questions import FlyAgain, Judge, Predict, Tune
from workbench.analysis.replies import Tuned
from workbench.analysis.subject import Subject
from workbench.analysis.work import Work
from workbench.analysis.worker import find_answerer
from workbench.common.errors import WorkbenchError
from workbench.gui.charts.canvas import Canvas
from workbench.gui.gains.gain_panel import GainGroup
from workbench.gui.help import about_page, keys_page
from workbench.gui.labels import ElidedLabel
from workbench.gui.layout import hbox
from workbench.gui.screen_table import SCREENS
from workbench.gui.view3d.view3d_panel import View3d

LEAST_CHART = 110
"""Height below which a chart shows nothing [px]."""
NARROWEST_SLIDER, WIDE_SLIDER, LARGE = 70, 120, 1800
"""Least width of a slider, that in a large window, and width of a large window [px]."""
INNER = (QAbstractSpinBox, QComboBox, QTabBar, QAbstractScrollArea)
"""They lay their parts out by themselves."""
CONTROLS = (QAbstractButton, QAbstractSpinBox, QComboBox, QLineEdit, QSlider)
SCALE = float(os.environ.get("QT_SCALE_FACTOR", "1"))
SIZES = (
    ((1024, 640), (1024, 700), (1280, 720), (1366, 768), (1920, 1080), (3840, 2160))
    if SCALE == 1.0
    else tuple((round(x / SCALE), round(y / SCALE)) for x, y in ((1920, 1080), (3840, 2160)))
)
"""Of the window, in Qt's pixels: where Qt scales, each is several of the screen's."""
FEW_SIZES = tuple(dict.fromkeys((SIZES[0], SIZES[len(SIZES) // 2], SIZES[-1])))
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


def faults(window: QWidget) -> Iterator[str]:
    """Yield a sentence for each fault of the widgets that can be seen."""
    for each in (window, *window.findChildren(QWidget)):
        if not each.isVisible() or isinstance(each.parent(), INNER):
            continue
        yield from _cut_text(each)
        if isinstance(each, Canvas) and each.height() < LEAST_CHART:
            yield f"{_name(each)} is {each.height()} px high"
        least = WIDE_SLIDER if window.width() >= LARGE else NARROWEST_SLIDER
        if isinstance(each, QSlider) and each.width() < least:
            yield f"{_name(each)} is {each.width()} px wide"
        if isinstance(each, QTabBar):
            needed = each.tabRect(each.count() - 1).right() - each.tabRect(0).left()
            beside = any(view.isVisible() for view in window.findChildren(View3d))
            if needed > each.width() and not beside:  # there they may be scrolled, by arrows
                yield f"tabs of {_name(each)} are cut: {each.width()} of {needed} px"
        if isinstance(each, QScrollArea) and each.horizontalScrollBar().maximum() > 0:
            yield f"{_name(each)} is cut: {each.horizontalScrollBar().maximum()} px too wide"
        if not isinstance(each, INNER):
            yield from _places(each)


def _cut_text(each: QWidget) -> Iterator[str]:
    """Yield whether a text is cut that no tool tip has."""
    if isinstance(each, ElidedLabel) or _paints_itself(each):
        return
    if isinstance(each, QLabel) and each.text() and each.pixmap().isNull():
        room = each.contentsRect()
        if each.wordWrap():
            if each.heightForWidth(each.width()) > each.height() + 1:
                yield f"{_name(each)} is cut below"
        elif each.sizeHint().width() > each.width() + 1:
            yield f"{_name(each)} is cut: {room.width()} of {each.sizeHint().width()} px"
        elif each.sizeHint().height() > each.height() + 3:
            yield f"{_name(each)} is cut in height"
    if isinstance(each, QAbstractButton) and each.text():
        icon_only = (
            isinstance(each, QToolButton)
            and each.toolButtonStyle() is Qt.ToolButtonStyle.ToolButtonIconOnly
            and not each.icon().isNull()
        )
        words = each.text().replace("&", "")
        needed = each.fontMetrics().horizontalAdvance(words)
        if isinstance(each, QToolButton) and len(words) > 1:  # its hint has a blank at each side
            blanks = each.fontMetrics().horizontalAdvance("  ")
            needed = max(needed, each.sizeHint().width() - blanks)
        elif not isinstance(each, QToolButton):
            needed = max(needed, each.minimumSizeHint().width())
        if not icon_only and needed > each.width() + 1:
            yield f"{_name(each)} is cut: {each.width()} of {needed} px"
    if isinstance(each, QComboBox):
        needed = each.fontMetrics().horizontalAdvance(each.currentText()) + 24
        if needed > each.width() and each.currentText() not in each.toolTip():
            yield f"{_name(each)} cuts '{each.currentText()}': {each.width()} of {needed} px"


def _paints_itself(each: QWidget) -> bool:
    """Return whether a class of ours paints it; Qt's own have a paintEvent, too."""
    ours = (kind for kind in type(each).__mro__ if kind.__module__.startswith("workbench"))
    return any("paintEvent" in vars(kind) for kind in ours)


def _places(parent: QWidget) -> Iterator[str]:
    """Yield what of a widget's children lies outside of it, or on another one."""
    shown = [
        each
        for each in parent.children()
        if isinstance(each, QWidget)
        and each.isVisible()
        and not each.isWindow()
        and not isinstance(each, QSizeGrip | QSplitterHandle)
        and not each.testAttribute(Qt.WidgetAttribute.WA_TransparentForMouseEvents)
    ]
    scrolls = isinstance(parent.parent(), QAbstractScrollArea)
    room = parent.rect().adjusted(-1, -1, 1, 1)
    for each in shown:
        if not scrolls and not room.contains(each.geometry()):
            yield f"{_name(each)} reaches out of {_name(parent)}"
    if isinstance(parent, QStackedWidget | QMainWindow):
        return
    for one, other in combinations(shown, 2):
        common = one.geometry().intersected(other.geometry())
        if common.width() > 1 and common.height() > 1 and not isinstance(other, QMenuBar):
            yield f"{_name(one)} lies on {_name(other)}"


def _name(each: QWidget) -> str:
    words = each.text() if isinstance(each, QLabel | QAbstractButton) else ""
    words = words or each.accessibleName() or each.objectName()
    parent = each.parent()
    above = ""
    while isinstance(parent, QWidget) and not above:
        above = parent.accessibleName() or parent.objectName()
        parent = parent.parent()
    return f"{type(each).__name__} '{words}' of '{above}'"


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
    yield made
    qapp.removeEventFilter(made)


def no_engine():
    raise WorkbenchError("The 3-D view needs PyQt6-WebEngine, which is not installed.")


@pytest.fixture(scope="module")
def window(request, windows, shared_window, workspace, canned, fly_again):
    """The window before a flight out of a can, with what opens on its screens open.

    Margins and prediction are answered here, not by processes of which nobody knows when. In place
    of the web engine's 3-D view there is Qt's own.
    """
    analysis, subject = workspace.analysis, Subject(canned.views[0].scenario, {})
    answered = set()

    def answer(question):
        kind = type(question)
        if kind is FlyAgain:
            QTimer.singleShot(0, lambda: analysis.tell(*fly_again(question)))
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
        for row in SCREENS:  # each for the first time
            shared_window.show_screen(row.name)
            QApplication.processEvents()
        windows.of_the_app = tuple(windows.seen)
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


def test_there_is_one_window(window, windows):
    """Of all that was shown since it was made, with every screen."""
    assert windows.of_the_app == ("MainWindow",)


def test_every_control_has_a_name(window, qapp):
    buddies = {label.buddy() for label in window.findChildren(QLabel)}
    for row in SCREENS:
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
        for row in SCREENS:
            window.show_screen(row.name)
            qapp.processEvents()
            for page in pages_of(window.stack.current):
                for _ in range(5):  # a layout may ask for another one
                    qapp.processEvents()
                where = f"{size}, 3-D {beside}, {row.title} {page}"
                found += [f"{where}: {fault}" for fault in faults(window)]
        stop = window.top_bar.button("stop")
        assert stop.width() >= stop.sizeHint().width(), f"{size}, 3-D {beside}"
    assert found == []


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
            for _ in range(5):
                qapp.processEvents()
            found += [f"{size}, {page}: {fault}" for fault in faults(window)]
    for group in closed:
        group.set_open(False)
    for button in forms:
        button.click()
    assert found == []


def test_a_log_leads_to_the_flight_that_would_have_been(window, qtbot):
    window.show_screen("visualization")
    window.stack.current.log_bar.again.click()
    tuning = window.stack.current
    assert window.stack.name == "tuning" and tuning.tabs.currentWidget() is tuning.what_if
    qtbot.waitUntil(lambda: "again" in tuning.what_if.plot.names)
    assert tuning.what_if.said.text() == "dh_drone flies flight.csv: as it flew"


@pytest.mark.parametrize("kind", [keys_page, about_page])
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
