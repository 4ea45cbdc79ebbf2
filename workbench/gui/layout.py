"""Layouts, and the small widgets in them: boxes, grids, scroll areas, buttons and labels."""

from collections.abc import Callable, Iterable, Sequence
from typing import TypeVar

from PyQt6.QtCore import QEvent, QObject, QPoint, QRect, QSize, Qt
from PyQt6.QtGui import QResizeEvent
from PyQt6.QtWidgets import (
    QAbstractButton,
    QBoxLayout,
    QComboBox,
    QFrame,
    QGridLayout,
    QHBoxLayout,
    QLayout,
    QLayoutItem,
    QMenu,
    QPushButton,
    QScrollArea,
    QToolButton,
    QVBoxLayout,
    QWidget,
)

from workbench.gui.labels import Label, set_tip
from workbench.gui.style import Widget, dressed

Box = TypeVar("Box", bound=QBoxLayout)
Button = TypeVar("Button", bound=QAbstractButton)
WIDEST = 1500
TALLEST = 1000
"""Largest height of a page [px]; beyond it its parts would only spread out."""

BAR = 11
"""Width of a scroll bar in our style, which covers part of the scrolled content [px]."""


Part = QWidget | QLayout | int | tuple[QWidget | QLayout, int | Qt.AlignmentFlag]
"""Part of a box: a widget or a layout, with an optional stretch or alignment; or empty space, given
by its stretch."""
Margins = tuple[int, int, int, int]
NO_MARGINS = (0, 0, 0, 0)


def hbox(
    *parts: Part,
    of: QWidget | None = None,
    margins: Margins | None = None,
    spacing: int | None = None,
) -> QHBoxLayout:
    """Return parts side by side.

    Args:
        parts: from left to right.
        of: widget that gets the layout, None for a nested layout.
        margins: margins at left, top, right and bottom [px]; None for those of the style.
        spacing: between the parts [px]; None for that of the style.
    """
    return _filled(QHBoxLayout(of), parts, margins, spacing)


def vbox(
    *parts: Part,
    of: QWidget | None = None,
    margins: Margins | None = None,
    spacing: int | None = None,
) -> QVBoxLayout:
    """Return parts one below the other; arguments as for `hbox`."""
    return _filled(QVBoxLayout(of), parts, margins, spacing)


def _filled(box: Box, parts: Sequence[Part], margins: Margins | None, spacing: int | None) -> Box:
    if margins is not None:
        box.setContentsMargins(*margins)
    if spacing is not None:
        box.setSpacing(spacing)
    fill(box, *parts)
    return box


def fill(box: QBoxLayout, *parts: Part) -> None:
    """Append parts to a box."""
    for part in parts:
        match part:
            case int(stretch):
                box.addStretch(stretch)
            case QWidget():
                box.addWidget(part)
            case QLayout():
                box.addLayout(part)
            case QWidget() as widget, Qt.AlignmentFlag() as side:  # first, as it is an int, too
                box.addWidget(widget, 0, side)
            case QLayout() as layout, int(stretch):
                box.addLayout(layout, stretch)
            case QWidget() as widget, int(stretch):
                box.addWidget(widget, stretch)


def grid(
    *rows: Sequence[QWidget | QLayout | None],
    of: QWidget | None = None,
    margins: Margins | None = None,
    spacing: tuple[int, int] | None = None,
    stretches: Sequence[int] = (),
) -> QGridLayout:
    """Return rows of parts in columns.

    Args:
        rows: from top to bottom; None leaves a place empty.
        of: widget that gets the layout, None for a nested layout.
        margins: as for `hbox`.
        spacing: between columns and between rows [px]; None for that of the style.
        stretches: stretch of each column, 0 without one.
    """
    made = QGridLayout(of)
    if margins is not None:
        made.setContentsMargins(*margins)
    if spacing is not None:
        made.setHorizontalSpacing(spacing[0])
        made.setVerticalSpacing(spacing[1])
    for line, row in enumerate(rows):
        for column, part in enumerate(row):
            if isinstance(part, QWidget):
                made.addWidget(part, line, column)
            elif part is not None:
                made.addLayout(part, line, column)
    for column, stretch in enumerate(stretches):
        made.setColumnStretch(column, stretch)
    return made


def button(
    text: str, pressed: Callable[[], object] | None = None, kind: str = "", help: str = ""
) -> QPushButton:
    """Return a button.

    Args:
        text: its text, with the mnemonic.
        pressed: called when it is pressed.
        kind: its class, see `style`.
        help: its tool tip.
    """
    return _ready(QPushButton(text), pressed, kind, help)


def tool_button(
    text: str, pressed: Callable[[], object] | None = None, kind: str = "", help: str = ""
) -> QToolButton:
    """Return a button that is as narrow as its text; arguments as for `button`."""
    made = QToolButton()
    made.setText(text)
    return _ready(made, pressed, kind, help)


def menu_button(text: str, help: str, fill: Callable[[QMenu], None]) -> QToolButton:
    """Return a button that opens a menu.

    Args:
        text: its text, with the mnemonic.
        help: its tool tip, and its name for screen readers.
        fill: fills the menu each time it opens.
    """
    made = named(tool_button(text, help=help), help)
    made.setPopupMode(QToolButton.ToolButtonPopupMode.InstantPopup)
    menu = QMenu(made)
    menu.setToolTipsVisible(True)
    menu.aboutToShow.connect(menu.clear)
    menu.aboutToShow.connect(lambda: fill(menu))
    made.setMenu(menu)
    return made


def _ready(made: Button, pressed: Callable[[], object] | None, kind: str, help: str) -> Button:
    set_tip(made, help)
    if pressed is not None:
        made.clicked.connect(lambda: pressed())  # without the state that Qt tells
    return dressed(made, kind)


def label(text: str = "", kind: str = "", *, wraps: bool = False) -> Label:
    """Return a label of a class, see `style`."""
    made = dressed(Label(text), kind)
    made.setWordWrap(wraps)
    return made


def buddy(text: str, widget: QWidget, help: str = "", kind: str = "muted") -> Label:
    """Return a label with a mnemonic for a widget; name the widget if it has no name."""
    made = label(text, kind)
    made.setBuddy(widget)
    if not widget.accessibleName():
        widget.setAccessibleName(text.replace("&", ""))
    if help:
        set_tip(widget, help)
        widget.setAccessibleDescription(help)
    return made


def choice(name: str, texts: Iterable[str] = (), help: str = "") -> QComboBox:
    """Return a box with texts to choose from; its tool tip is its name without other help."""
    box = named(QComboBox(), name, help or name)
    box.addItems([*texts])
    return box


def named(widget: Widget, name: str, help: str = "") -> Widget:
    """Name a new widget for screen readers, give it a tool tip, and return it."""
    widget.setAccessibleName(name)
    if help:
        set_tip(widget, help)
    return widget


def scroll_area(part: QWidget | None = None, *, sideways: bool = True) -> QScrollArea:
    """Return an area without a frame that scrolls a part.

    Args:
        part: the part; None if it is set later.
        sideways: whether a part that is too wide is scrolled, else it is clipped.
    """
    area = QScrollArea()
    area.setWidgetResizable(True)
    area.setFrameShape(QFrame.Shape.NoFrame)
    area.setFocusPolicy(Qt.FocusPolicy.NoFocus)
    if not sideways:
        area.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
    if part is not None:
        area.setWidget(part)
    return area


def column(*parts: Part, spacing: int | None = None) -> QWidget:
    """Return a widget with parts one below the other, and no margins; arguments as for `vbox`."""
    made = QWidget()
    vbox(*parts, of=made, margins=NO_MARGINS, spacing=spacing)
    return made


def fit_page(screen: QWidget, layout: QLayout) -> None:
    """Fill a screen with a layout, centred if the screen is large.

    Args:
        screen: screen without a layout.
        layout: layout of the page.
    """
    vbox(scroll_area(_Ground(layout)), of=screen, margins=NO_MARGINS)


def scrolled(part: QWidget) -> QScrollArea:
    """Return an area that gives a part its full width and scrolls it vertically if necessary."""
    area = scroll_area(part, sideways=False)
    part.installEventFilter(_Widening(area, part))
    return area


class _Widening(QObject):
    """Gives an area the width that its part needs once more of it is shown."""

    def __init__(self, area: QScrollArea, part: QWidget) -> None:
        super().__init__(area)
        self._area = area
        self._widen(part)

    def _widen(self, part: QWidget) -> None:
        self._area.setMinimumWidth(part.minimumSizeHint().width() + BAR)

    def eventFilter(self, part: QObject | None, event: QEvent | None) -> bool:
        if event is not None and event.type() is QEvent.Type.LayoutRequest:
            assert isinstance(part, QWidget)
            self._widen(part)
        return False


class Pair(QWidget):
    """Two cards side by side, or one below the other if they would be clipped.

    Args:
        left: left or upper card.
        right: right or lower card.
        shares: shares of the width [ratio].
        spacing: space between them [px].
    """

    def __init__(
        self, left: QWidget, right: QWidget, shares: tuple[int, int], spacing: int
    ) -> None:
        super().__init__()
        self._parts = (left, right)
        self._box = QBoxLayout(QBoxLayout.Direction.LeftToRight, self)
        self._box.setContentsMargins(0, 0, 0, 0)
        self._box.setSpacing(spacing)
        for part, share in zip(self._parts, shares, strict=True):
            self._box.addWidget(part, share)

    def minimumSizeHint(self) -> QSize:
        """Return the width of the wider card, and the height in the present arrangement."""
        widest = max(part.minimumSizeHint().width() for part in self._parts)
        return QSize(widest, self._box.minimumSize().height())

    def resizeEvent(self, event: QResizeEvent | None) -> None:
        """Arrange the cards for the width."""
        needed = sum(part.minimumSizeHint().width() for part in self._parts)
        across = self.width() >= needed + self._box.spacing()
        directions = QBoxLayout.Direction
        self._box.setDirection(directions.LeftToRight if across else directions.TopToBottom)
        super().resizeEvent(event)


class _Ground(QWidget):
    """Holds a page, and requests the least height that the page needs at its width.

    A scroll area alone would request the page's preferred height.
    """

    def __init__(self, layout: QLayout) -> None:
        super().__init__()
        self._page = QWidget(self)
        self._layout = layout
        self._page.setLayout(layout)
        self._page.installEventFilter(self)

    def minimumSizeHint(self) -> QSize:
        """Return the least size without clipping."""
        least = self._layout.minimumSize()
        if not self._layout.hasHeightForWidth():
            return least
        width = min(max(self.width(), least.width()), WIDEST)
        return QSize(least.width(), self._layout.minimumHeightForWidth(width))

    def sizeHint(self) -> QSize:
        """Return the same size; more is empty space."""
        return self.minimumSizeHint()

    def resizeEvent(self, event: QResizeEvent | None) -> None:
        """Centre the page."""
        super().resizeEvent(event)
        width, height = min(self.width(), WIDEST), min(self.height(), TALLEST)
        self._page.setGeometry((self.width() - width) // 2, 0, width, height)
        if event is not None and event.size().width() != event.oldSize().width():
            self.updateGeometry()

    def eventFilter(self, watched: QObject | None, event: QEvent | None) -> bool:
        """Update the size when something on the page changes its size."""
        if event is not None and event.type() is QEvent.Type.LayoutRequest:
            self.updateGeometry()
        return False


class FlowLayout(QLayout):
    """Places widgets side by side and wraps lines; hidden ones take no space.

    Args:
        parent: widget that gets the layout, if it exists yet.
        spacing: space between widgets, in both directions [px].
    """

    def __init__(self, parent: QWidget | None = None, spacing: int = 8) -> None:
        super().__init__(parent)
        self.setContentsMargins(0, 0, 0, 0)
        self.setSpacing(spacing)
        self._items: list[QLayoutItem] = []

    def addItem(self, item: QLayoutItem | None) -> None:
        """Add an item; Qt's name, like the following ones."""
        if item is not None:
            self._items.append(item)

    def count(self) -> int:
        """Return the number of items."""
        return len(self._items)

    def itemAt(self, index: int) -> QLayoutItem | None:
        """Return an item, None beyond the last one."""
        return self._items[index] if 0 <= index < len(self._items) else None

    def takeAt(self, index: int) -> QLayoutItem | None:
        """Remove and return an item."""
        return self._items.pop(index) if 0 <= index < len(self._items) else None

    def expandingDirections(self) -> Qt.Orientation:
        """Request no additional space."""
        return Qt.Orientation(0)

    def hasHeightForWidth(self) -> bool:
        """Tell Qt that its height depends on its width."""
        return True

    def heightForWidth(self, width: int) -> int:
        """Return the height of all lines at a width [px]."""
        return self._place(QRect(0, 0, width, 0), move=False)

    def sizeHint(self) -> QSize:
        """Return the size of all items in one line."""
        hints = [item.sizeHint() for item in self._shown()]
        width = sum(each.width() for each in hints) + self.spacing() * max(0, len(hints) - 1)
        return self._around(QSize(width, max((each.height() for each in hints), default=0)))

    def minimumSize(self) -> QSize:
        """Return the width of the widest item and the height of the highest one."""
        hints = [item.sizeHint() for item in self._shown()]
        widest = max((each.width() for each in hints), default=0)
        return self._around(QSize(widest, max((each.height() for each in hints), default=0)))

    def setGeometry(self, rect: QRect) -> None:
        """Place all items within a rectangle."""
        super().setGeometry(rect)
        self._place(rect, move=True)

    def _shown(self) -> list[QLayoutItem]:
        return [item for item in self._items if not item.isEmpty()]

    def _around(self, size: QSize) -> QSize:
        margins = self.contentsMargins()
        more = QSize(margins.left() + margins.right(), margins.top() + margins.bottom())
        return size + more

    def _place(self, rect: QRect, *, move: bool) -> int:
        """Return the height of all items at a rectangle's width, and place them if requested."""
        room = rect.marginsRemoved(self.contentsMargins())
        x, y, high = room.left(), room.top(), 0
        line: list[tuple[QLayoutItem, QRect]] = []

        def end_line() -> None:
            for item, place in line if move else ():
                item.setGeometry(place.translated(0, (high - place.height()) // 2))

        for item in self._shown():
            size = item.sizeHint()
            if line and x + size.width() > room.left() + room.width():
                end_line()
                x, y, high, line = room.left(), y + high + self.spacing(), 0, []
            line.append((item, QRect(QPoint(x, y), size)))
            x, high = x + size.width() + self.spacing(), max(high, size.height())
        end_line()
        return y + high - rect.top() + self.contentsMargins().bottom()
