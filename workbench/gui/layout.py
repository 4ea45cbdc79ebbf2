"""Layouts, and the small widgets in them: boxes, grids, scroll areas, buttons and labels."""

from collections.abc import Callable, Iterable, Sequence
from typing import TypeVar

from PyQt6.QtCore import QEvent, QObject, QSize, Qt
from PyQt6.QtGui import QAction, QResizeEvent
from PyQt6.QtWidgets import (
    QAbstractButton,
    QBoxLayout,
    QComboBox,
    QFrame,
    QGridLayout,
    QHBoxLayout,
    QLayout,
    QMenu,
    QPushButton,
    QScrollArea,
    QToolButton,
    QVBoxLayout,
    QWidget,
)

from workbench.gui.click_guard import ClickGuard
from workbench.gui.labels import Label, set_tip
from workbench.gui.style import Widget, with_class
from workbench.gui.wheel import ComboBox

Box = TypeVar("Box", bound=QBoxLayout)
Button = TypeVar("Button", bound=QAbstractButton)
MAX_PAGE_WIDTH_PX = 1500
MAX_PAGE_HEIGHT_PX = 1000
"""Largest height of a page [px]; beyond it its parts would only spread out."""

SCROLL_BAR_WIDTH_PX = 11
"""Width of a scroll bar in our style, which covers part of the scrolled content [px]."""


LayoutPart = QWidget | QLayout | int | tuple[QWidget | QLayout, int | Qt.AlignmentFlag]
"""Part of a box: a widget or a layout, with an optional stretch or alignment; or empty space, given
by its stretch."""
BoxMargins = tuple[int, int, int, int]
NO_MARGINS = (0, 0, 0, 0)


def hbox(
    *parts: LayoutPart,
    of: QWidget | None = None,
    margins: BoxMargins | None = None,
    spacing: int | None = None,
) -> QHBoxLayout:
    """Return parts side by side.

    Args:
        parts: from left to right.
        of: widget that gets the layout, None for a nested layout.
        margins: margins at left, top, right and bottom [px]; None for those of the style.
        spacing: between the parts [px]; None for that of the style.
    """
    return _fill_box(QHBoxLayout(of), parts, margins, spacing)


def vbox(
    *parts: LayoutPart,
    of: QWidget | None = None,
    margins: BoxMargins | None = None,
    spacing: int | None = None,
) -> QVBoxLayout:
    """Return parts one below the other; arguments as for `hbox`."""
    return _fill_box(QVBoxLayout(of), parts, margins, spacing)


def _fill_box(
    box: Box, parts: Sequence[LayoutPart], margins: BoxMargins | None, spacing: int | None
) -> Box:
    if margins is not None:
        box.setContentsMargins(*margins)
    if spacing is not None:
        box.setSpacing(spacing)
    fill(box, *parts)
    return box


def fill(box: QBoxLayout, *parts: LayoutPart) -> None:
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
    margins: BoxMargins | None = None,
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
    return _connected_button(QPushButton(text), pressed, kind, help)


def tool_button(
    text: str, pressed: Callable[[], object] | None = None, kind: str = "", help: str = ""
) -> QToolButton:
    """Return a button that is as narrow as its text; arguments as for `button`."""
    made = QToolButton()
    made.setText(text)
    return _connected_button(made, pressed, kind, help)


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


def add_action(
    to: QWidget, text: str, act: Callable[[bool], object], checked: bool | None = None
) -> QAction:
    """Add an action to a menu or a widget, and return it.

    Args:
        to: the menu or the widget.
        text: its text, with the mnemonic, and a key after a tab.
        act: called when it is chosen, with the new state of a switch.
        checked: state of a switch; None if it is none.
    """
    action = QAction(text, to)
    action.setCheckable(checked is not None)
    action.setChecked(bool(checked))
    action.triggered.connect(act)
    to.addAction(action)
    return action


def _connected_button(
    made: Button, pressed: Callable[[], object] | None, kind: str, help: str
) -> Button:
    set_tip(made, help)
    ClickGuard(made)
    if pressed is not None:
        made.clicked.connect(lambda: pressed())  # without the state that Qt tells
    return with_class(made, kind)


def label(text: str = "", kind: str = "", *, wraps: bool = False) -> Label:
    """Return a label of a class, see `style`."""
    made = with_class(Label(text), kind)
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
    box = named(ComboBox(), name, help or name)
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


def column(*parts: LayoutPart, spacing: int | None = None) -> QWidget:
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
    page = _Page()
    page.setLayout(layout)
    page.setMaximumSize(MAX_PAGE_WIDTH_PX, MAX_PAGE_HEIGHT_PX)
    area = scroll_area(page)
    area.setAlignment(Qt.AlignmentFlag.AlignHCenter | Qt.AlignmentFlag.AlignTop)
    vbox(area, of=screen, margins=NO_MARGINS)


def scrolled(part: QWidget) -> QScrollArea:
    """Return an area that gives a part its full width and scrolls it vertically if necessary."""
    area = scroll_area(part, sideways=False)
    part.installEventFilter(_WidthAdjuster(area, part))
    return area


class _WidthAdjuster(QObject):
    """Gives an area the width that its part needs once more of it is shown."""

    def __init__(self, area: QScrollArea, part: QWidget) -> None:
        super().__init__(area)
        self._area = area
        self._widen(part)

    def _widen(self, part: QWidget) -> None:
        self._area.setMinimumWidth(part.minimumSizeHint().width() + SCROLL_BAR_WIDTH_PX)

    def eventFilter(self, part: QObject | None, event: QEvent | None) -> bool:
        if event is not None and event.type() is QEvent.Type.LayoutRequest:
            assert isinstance(part, QWidget)
            self._widen(part)
        return False


class CardPair(QWidget):
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


class _Page(QWidget):
    """Requests the least height that its layout needs at a width.

    A scroll area would give it the preferred height.
    """

    def heightForWidth(self, width: int) -> int:
        layout = self.layout()
        return layout.minimumHeightForWidth(width) if layout is not None else 0
