"""The arrangement of the tuning screen's parts, by the size of the window."""

from collections.abc import Sequence

from PyQt6.QtCore import QEvent, QObject, QSize, Qt, pyqtSignal
from PyQt6.QtGui import QAction, QResizeEvent
from PyQt6.QtWidgets import (
    QAbstractScrollArea,
    QLayout,
    QSplitter,
    QTabWidget,
    QVBoxLayout,
    QWidget,
)

from workbench.gui.layout import column, hbox
from workbench.gui.tuning.card import TuningCard
from workbench.gui.tuning.card_window import CardWindow
from workbench.gui.tuning.margins_card import MarginsCard

TUNING_GAP_PX = 6
MIN_TWO_COLUMNS_PX = 900
"""Least width with gains beside the tabs [px]."""
MIN_THREE_COLUMNS_PX = 1300
"""Least width with the response between them [px]."""
MIN_GAINS_WIDTH_PX = 440
"""Least width of the gains, whose sliders then have 150 px [px]."""
MIN_RESPONSE_WIDTH_PX = 372
WIDE_SCREEN_SHARES = (0.3, 0.3)
"""Shares of a wide screen for gains and response; the rest is for margins and tabs."""
LOW_SCREEN_PX = 820
"""Height below which the table of margins is folded, as a Bode plot needs its room [px]."""
TAB_STYLES_BY_WIDTH = (
    (500, "QTabBar::tab { padding: 6px 2px; margin-right: 0; }"),
    (700, "QTabBar::tab { padding: 6px 5px; margin-right: 0; }"),
)
"""Widths of the tabs [px] up to which they are closer together, so that all of them are visible."""
MIN_TABS_WIDTH_PX = 372
MIN_TUNING_HEIGHT_PX = 420
"""Width of the tabs, and height of everything, without clipping [px]; their bar may scroll."""


class Arrangement(QWidget):
    """Gains on the left, the response beside them or in a tab, margins above the tabs on the right.

    Below `MIN_TWO_COLUMNS_PX` gains and margins are in tabs, too, so that one card at a time fills
    the screen. Any card can fill its column, or be moved to a window of its own.

    Args:
        gains: left part.
        response: excitation and response.
        margins: margins of all loops.
        tabs: all other parts, with their names.
        actions: actions whose keys work in the windows of cards, too.
    """

    windows_changed = pyqtSignal()
    """A card was moved to a window of its own, or back."""

    def __init__(
        self,
        gains: QWidget,
        response: QWidget,
        margins: MarginsCard,
        tabs: QTabWidget,
        actions: Sequence[QAction],
    ) -> None:
        super().__init__()
        self._actions = actions
        self._gains, self._response = gains, response
        self._margins, self._tabs = margins, tabs
        self._columns = 0
        self._is_low: bool | None = None
        self._is_divided = False
        self._filling: TuningCard | None = None
        self._hidden: list[QWidget] = []
        self._windows: dict[TuningCard, CardWindow] = {}
        tabs.setDocumentMode(True)
        tabs.setUsesScrollButtons(True)
        tabs.setElideMode(Qt.TextElideMode.ElideNone)
        tabs.setMinimumWidth(MIN_TABS_WIDTH_PX)
        self._middle = column(spacing=TUNING_GAP_PX)
        self._right = column(margins, (tabs, 1), spacing=TUNING_GAP_PX)
        self.splitter = QSplitter(Qt.Orientation.Horizontal)
        self.splitter.setHandleWidth(TUNING_GAP_PX)
        self.splitter.setChildrenCollapsible(False)
        for part in (gains, self._middle, self._right):
            self.splitter.addWidget(part)
        self.splitter.splitterMoved.connect(self._keep_divided)
        tabs.installEventFilter(self)
        gaps = (TUNING_GAP_PX,) * 4
        box = hbox(self.splitter, of=self, margins=gaps)
        box.setSizeConstraint(QLayout.SizeConstraint.SetNoConstraint)
        for card in (each for part in (gains, response, margins, tabs) for each in _cards(part)):
            card.fill_wanted.connect(self.fill_column)
            card.window_wanted.connect(self.move_to_window)
        tabs.currentChanged.connect(lambda _: self._fill(None))

    def minimumSizeHint(self) -> QSize:
        """Return the smallest size, with all parts in tabs."""
        return QSize(MIN_TABS_WIDTH_PX + 2 * TUNING_GAP_PX, MIN_TUNING_HEIGHT_PX)

    def resizeEvent(self, event: QResizeEvent | None) -> None:
        """Arrange the parts according to the size; a divider that the user has moved stays."""
        super().resizeEvent(event)
        width = self.width()
        self.arrange(
            3 if width >= MIN_THREE_COLUMNS_PX else 2 if width >= MIN_TWO_COLUMNS_PX else 1
        )
        if not self._is_divided:
            self.splitter.setSizes(self._widths())
        self._fold(self.height() < LOW_SCREEN_PX)

    def eventFilter(self, watched: QObject | None, event: QEvent | None) -> bool:
        """Adapt the bar of the tabs to its width, not the cards: those take a tenth of a second."""
        bar = self._tabs.tabBar()
        if event is not None and event.type() is QEvent.Type.Resize and bar is not None:
            width = self._tabs.width()
            style = next((style for most, style in TAB_STYLES_BY_WIDTH if width < most), "")
            if style != bar.styleSheet():
                bar.setStyleSheet(style)
        return False

    def arrange(self, columns: int) -> None:
        """Arrange the parts side by side, or in tabs.

        Args:
            columns: 3 for gains, response, and margins with the tabs; 2 for gains, and margins with
                the tabs; 1 for only tabs.
        """
        if columns == self._columns:
            return
        self._columns, self._is_divided, self._is_low = columns, False, None
        self._fill(None)
        chosen = self._tabs.currentWidget()
        middle, right = self._middle.layout(), self._right.layout()
        assert isinstance(middle, QVBoxLayout) and isinstance(right, QVBoxLayout)
        parts = {"Gains": self._gains, "Step": self._response, "Margins": self._margins}
        for part in parts.values():
            if self._tabs.indexOf(part) >= 0:
                self._tabs.removeTab(self._tabs.indexOf(part))
        tabbed = {1: ["Gains", "Step", "Margins"], 2: ["Step"], 3: []}[columns]
        for index, title in enumerate(tabbed):
            self._tabs.insertTab(index, parts[title], title)
        if columns > 1:
            self.splitter.insertWidget(0, self._gains)
            right.insertWidget(0, self._margins)
        if columns == 3:
            middle.addWidget(self._response)
        self._middle.setVisible(columns == 3)
        self._gains.setMinimumWidth(MIN_GAINS_WIDTH_PX if columns > 1 else 0)
        for title, part in parts.items():
            if title not in tabbed:
                part.show()  # hidden since it has another parent
        stays = columns == 3 and chosen is not None and self._tabs.indexOf(chosen) >= 0
        self._tabs.setCurrentIndex(self._tabs.indexOf(chosen) if stays else 0)

    def _fold(self, low: bool) -> None:
        """Fold the margins if the height is too low for them and a tab; not in a tab of their own.

        Nothing changes while the height stays low, so that the user may unfold them.
        """
        if low is not self._is_low:
            self._is_low = low
            self._margins.set_folded(low and self._columns > 1)
        self._margins.fold.setVisible(self._columns > 1)

    def _widths(self) -> list[int]:
        """Return the widths of gains, response and the rest [px]."""
        if self._columns == 1:
            return [0, 0, self.width()]
        gains, response = (round(share * self.width()) for share in WIDE_SCREEN_SHARES)
        wide = self._columns == 3
        gains = max(MIN_GAINS_WIDTH_PX, gains) if wide else MIN_GAINS_WIDTH_PX
        response = max(MIN_RESPONSE_WIDTH_PX, response) if wide else 0
        rest = self.width() - gains - response - (self._columns + 1) * TUNING_GAP_PX
        return [gains, response, rest]

    def _keep_divided(self) -> None:
        self._is_divided = True

    @property
    def windowed(self) -> tuple[TuningCard, ...]:
        """The cards that have a window of their own."""
        return tuple(self._windows)

    def show_card(self, card: TuningCard) -> None:
        """Show a card that is a tab or in one, or in a window of its own."""
        if card in self._windows:
            self._windows[card].raise_()
            self._windows[card].activateWindow()
            return
        tabs = filter(None, map(self._tabs.widget, range(self._tabs.count())))
        tab = next((each for each in tabs if each is card or each.isAncestorOf(card)), None)
        if tab is not None:
            self._tabs.setCurrentWidget(tab)

    def fill_column(self, card: TuningCard) -> None:
        """Let a card have its column alone, or bring back what it has hidden."""
        if card not in self._windows:
            self._fill(card if card is not self._filling else None)

    def move_to_window(self, card: TuningCard) -> None:
        """Move a card to a window of its own, or back to its place."""
        if card in self._windows:
            self._windows[card].close()
            return
        self._fill(None)
        window = self._windows[card] = CardWindow(card, self, self._actions)
        window.closed.connect(lambda: self._forget_window(card))
        window.show()
        self.windows_changed.emit()

    def close_windows(self) -> None:
        """Bring all cards back to their places."""
        for window in tuple(self._windows.values()):
            window.close()

    def _forget_window(self, card: TuningCard) -> None:
        del self._windows[card]
        self.windows_changed.emit()

    def _fill(self, card: TuningCard | None) -> None:
        """Let a card have its column alone; None for no card."""
        for part in self._hidden:
            part.show()
        self._hidden = []
        part: QWidget | None = card
        while part is not None and part not in (self._gains, self._middle, self._right):
            above = part.parentWidget()
            if above is not None and not isinstance(above, QAbstractScrollArea):
                beside = [each for each in above.children() if isinstance(each, QWidget)]
                self._hidden += [
                    each
                    for each in beside
                    if each is not part and not each.isHidden() and not each.isWindow()
                ]
            part = above
        for part in self._hidden:
            part.hide()
        if self._filling is not None:
            self._filling.set_filling(False)
        if card is not None:
            card.set_filling(True)
        self._filling = card


def _cards(part: QWidget) -> list[TuningCard]:
    """Return the cards of a part, itself among them."""
    return [part] if isinstance(part, TuningCard) else part.findChildren(TuningCard)
