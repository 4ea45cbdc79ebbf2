"""What is wrong with the layout of widgets that can be seen, each fault as a sentence."""

from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from itertools import combinations

import pytest
from PyQt6.QtCore import QPointF, QRectF, Qt
from PyQt6.QtGui import QFontMetrics, QFontMetricsF, QPainter
from PyQt6.QtWidgets import (
    QAbstractButton,
    QAbstractScrollArea,
    QAbstractSpinBox,
    QComboBox,
    QHeaderView,
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
    QToolButton,
    QWidget,
)

from workbench.gui.charts.canvas import Canvas
from workbench.gui.gains.gain_row import GainRow
from workbench.gui.tuning.bode_plots import BodePlots
from workbench.gui.view3d.view3d_panel import View3d

LEAST_CHART = 110
"""Height below which a chart shows nothing [px]."""
NARROWEST_SLIDER, WIDE_SLIDER, LARGE = 70, 120, 1800
"""Least width of a slider, that in a large window, and width of a large window [px]."""
LEAST_GAIN_SLIDER, LEAST_BODE = 150, (400, 250)
"""Least width of a gain's slider, and least size of Bode plots [px]."""
LEAST_TEXT = 9.0
"""Least size of text [pt]."""
INNER = (QAbstractSpinBox, QComboBox, QTabBar, QAbstractScrollArea)
"""They lay their parts out by themselves."""


CARET = 2
"""Space of a text field at each side of its text [px]."""


def faults(window: QWidget) -> Iterator[str]:
    """Yield a sentence for each fault of the widgets that can be seen."""
    for each in (window, *window.findChildren(QWidget)):
        if not each.isVisible() or isinstance(each.parent(), INNER):
            continue
        yield from _cut_text(each)
        if isinstance(each, Canvas) and each.height() < LEAST_CHART:
            yield f"{_name(each)} is {each.height()} px high"
        least = WIDE_SLIDER if window.width() >= LARGE else NARROWEST_SLIDER
        least = LEAST_GAIN_SLIDER if isinstance(each.parent(), GainRow) else least
        if isinstance(each, QSlider) and each.width() < least:
            yield f"{_name(each)} is {each.width()} px wide"
        if isinstance(each, BodePlots) and (
            each.width() < LEAST_BODE[0] or each.height() < LEAST_BODE[1]
        ):
            yield f"Bode plots of {each.width()} x {each.height()} px"
        texts = QLabel | QAbstractButton | QLineEdit | QTabBar
        if isinstance(each, texts) and _points(each) < LEAST_TEXT:
            yield f"{_name(each)} has text of {_points(each):.1f} pt"
        if isinstance(each, QTabBar):
            needed = each.tabRect(each.count() - 1).right() - each.tabRect(0).left()
            if needed > each.width() and not any(  # there they may be scrolled, by arrows
                view.isVisible() for view in window.findChildren(View3d)
            ):
                yield f"tabs of {_name(each)} are cut: {each.width()} of {needed} px"
        if isinstance(each, QScrollArea) and each.horizontalScrollBar().maximum() > 0:
            yield f"{_name(each)} is cut: {each.horizontalScrollBar().maximum()} px too wide"
        if isinstance(each, QScrollArea) and _scrolls(each):
            above = each.parent()
            while isinstance(above, QWidget) and not (
                isinstance(above, QScrollArea) and _scrolls(above)
            ):
                above = above.parent()
            if isinstance(above, QWidget):
                yield f"{_name(each)} scrolls in {_name(above)}, which scrolls"
        if not isinstance(each, INNER):
            yield from _places(each)


def _cut_text(each: QWidget) -> Iterator[str]:
    """Yield whether a text is cut."""
    if _paints_itself(each):
        return
    if isinstance(each, QLabel) and each.text() and each.pixmap().isNull():
        room = each.contentsRect()
        if each.wordWrap():
            if each.heightForWidth(each.width()) > each.height() + 1:
                yield f"{_name(each)} is cut below"
        elif _label_width(each) > each.width() + 1:
            yield f"{_name(each)} is cut: {room.width()} of {_label_width(each)} px"
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
        if each.sizeHint().height() > each.height() + 3:
            yield f"{_name(each)} is cut in height"
    if isinstance(each, QComboBox):
        needed = each.fontMetrics().horizontalAdvance(each.currentText()) + 24
        if needed > each.width():
            yield f"{_name(each)} cuts '{each.currentText()}': {each.width()} of {needed} px"

    if isinstance(each, QAbstractSpinBox):
        line = each.lineEdit()
        room = line.width() - 2 * CARET if line is not None else each.width()
        needed = each.fontMetrics().horizontalAdvance(each.text())
        if needed > room + 1:
            yield f"{_name(each)} cuts '{each.text()}': {room} of {needed} px"
    if isinstance(each, QHeaderView) and each.orientation() is Qt.Orientation.Horizontal:
        for column in range(each.count()):
            wide, needed = each.sectionSize(column), each.sectionSizeHint(column)
            if not each.isSectionHidden(column) and 0 < wide < needed - 1:
                yield f"column {column} of {_name(each)} is cut: {wide} of {needed} px"


def _label_width(each: QLabel) -> int:
    """Return the width that a label's text needs, whatever the label asks for [px]."""
    wanted = each.sizeHint().width()
    if each.textFormat() is not Qt.TextFormat.PlainText:
        return wanted
    text = each.text().replace("&", "") if each.buddy() is not None else each.text()
    lines = text.split("\n")
    return max(wanted, *(each.fontMetrics().horizontalAdvance(line) for line in lines))


def _points(each: QWidget) -> float:
    """Return the size of a widget's text [pt]."""
    return round(each.fontInfo().pixelSize() * 72.0 / each.logicalDpiY(), 1)


def _scrolls(area: QScrollArea) -> bool:
    bar = area.verticalScrollBar()
    return bar is not None and bar.isVisible() and bar.maximum() > 0


def _paints_itself(each: QWidget) -> bool:
    """Return whether a class of ours paints it; Qt's own have a paintEvent, too."""
    return _is_painted(type(each))


@cache
def _is_painted(kind: type) -> bool:
    ours = (each for each in kind.__mro__ if each.__module__.startswith("workbench"))
    return any("paintEvent" in vars(each) for each in ours)


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


@contextmanager
def painted_text():
    """Watch what is painted meanwhile; the faults of its text, as sentences, fill a set."""
    found: set[str] = set()
    draw = QPainter.drawText

    def watch(self, *args):
        fault = _painted_fault(self, args)
        if fault:
            found.add(fault)
        return draw(self, *args)

    with pytest.MonkeyPatch.context() as patch:
        for kind in (QFontMetrics, QFontMetricsF):
            patch.setattr(kind, "elidedText", _watched_elision(kind.elidedText, found))
        patch.setattr(QPainter, "drawText", watch)
        yield found


def _watched_elision(elide, found):
    def watch(self, text, *args):
        shown = elide(self, text, *args)
        if shown != text:
            found.add(f"'{text}' is elided to '{shown}'")
        return shown

    return watch


def _painted_fault(painter: QPainter, args) -> str:
    """Return what is wrong with a text that is drawn on a widget, "" if nothing is."""
    widget = painter.device()
    text = next((each for each in args if isinstance(each, str)), "")
    if not isinstance(widget, QWidget) or not text.strip():
        return ""
    points = painter.fontInfo().pixelSize() * 72.0 / widget.logicalDpiY()
    if points < LEAST_TEXT - 0.05:
        return f"'{text}' of {type(widget).__name__} has {points:.1f} pt"
    metrics = painter.fontMetrics()
    first, *rest = args
    if isinstance(first, QRectF) or hasattr(first, "toRectF"):
        box = QRectF(first)
        flags = int(rest[0]) if isinstance(rest[0], int) else getattr(rest[0], "value", 0)
        needed = painter.boundingRect(box, flags, text)
        if needed.height() < 1.5 * metrics.height():  # only the letters of a line must be seen
            needed.setHeight(metrics.tightBoundingRect(text).height())
            needed.moveTop(box.center().y() - 0.5 * needed.height())
        if not flags & Qt.TextFlag.TextDontClip.value and not _contains(box, needed):
            return (
                f"'{text}' of {type(widget).__name__} is clipped: {needed.width():.0f} x "
                f"{needed.height():.0f} in {box.width():.0f} x {box.height():.0f} px"
            )
    elif isinstance(first, QPointF) or hasattr(first, "toPointF"):
        needed = QRectF(metrics.boundingRect(text)).translated(QPointF(first))
    else:
        needed = QRectF(metrics.boundingRect(text)).translated(float(first), float(rest[0]))
    shown = painter.transform().mapRect(needed)
    if not _contains(QRectF(widget.rect()), shown):
        return f"'{text}' reaches out of {type(widget).__name__}"
    return ""


def _contains(box: QRectF, part: QRectF) -> bool:
    return box.adjusted(-1.5, -1.5, 1.5, 1.5).contains(part)
