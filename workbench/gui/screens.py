"""The base class of screens, their stack, and the side bar that selects the visible one.

Each screen is made on first use, or when the app is idle.
"""

import contextlib
import importlib
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Future
from functools import partial

from PyQt6.QtCore import QSize, Qt, QTimer, pyqtSignal
from PyQt6.QtGui import QAction
from PyQt6.QtWidgets import (
    QFrame,
    QSizePolicy,
    QStackedWidget,
    QToolButton,
    QWidget,
)

from workbench.gui.errands import FutureCallbacks
from workbench.gui.icons import icon
from workbench.gui.labels import Label
from workbench.gui.layout import vbox
from workbench.gui.screen_table import SCREEN_TABLE, ScreenRow, find_screen
from workbench.gui.style import with_class
from workbench.gui.theme import Look
from workbench.gui.workspace import Workspace
from workbench.live.view import LiveView


class Screen(QWidget):
    """A page of the app behind one button of the side bar."""

    def __init__(self, workspace: Workspace) -> None:
        super().__init__()
        self.workspace = workspace

    def begin(self, view: LiveView) -> None:
        """Note that a flight has begun: vehicle, topics and scenario are known."""

    def take_over(self, view: LiveView) -> None:
        """Note that another controller has taken over in flight."""

    def show_view(self, view: LiveView) -> None:
        """Show a view; called at most sixty times a second, and only while visible."""

    def unsaved(self) -> str:
        """Return which data would be lost with the flight, as a sentence; "" for none."""
        return ""

    def save_unsaved(self, saved: Callable[[], object]) -> None:
        """Let the user save that data, and call back when it is saved."""

    def play_or_pause(self) -> bool:
        """Play or pause what it shows; return whether that is something else than the flight."""
        return False

    def release(self) -> None:
        """Release held controls: the screen is left, or the window has lost the focus."""

    def close_screen(self) -> None:
        """End everything that the screen has started; the app closes."""


SIDE_BAR_ICON_PX = 26
"""Edge length of an icon [layout pixels]."""

LOADING_TEXTS = ("Starting", "The first screen is being loaded.")
"""Title and sentence of the page that stands until there is a screen."""
SCREEN_PRELOAD_PAUSE_MS = 60
"""Pause between screens that are made in advance, in which the window handles events [ms]."""


class SideBar(QFrame):
    """Buttons one below the other; that of the present screen has a bar beside it.

    Args:
        actions: actions that show screens, by name.
        look: source of colours.
    """

    def __init__(self, actions: Mapping[str, QAction], look: Look) -> None:
        super().__init__()
        self.setObjectName("side_bar")
        self.setAccessibleName("Screens")
        self._look = look
        self._actions = {row.name: actions[f"show_{row.name}"] for row in SCREEN_TABLE}
        layout = vbox(of=self, margins=(0, 6, 0, 6), spacing=2)
        for row in SCREEN_TABLE:
            button = QToolButton(self)
            button.setDefaultAction(self._actions[row.name])
            button.setProperty("class", "side")
            button.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextUnderIcon)
            button.setIconSize(QSize(SIDE_BAR_ICON_PX, SIDE_BAR_ICON_PX))
            button.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)
            button.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
            button.setAccessibleName(f"{row.title} screen")
            layout.addWidget(button)
        layout.addStretch(1)
        look.changed.connect(self.paint_icons)
        self.paint_icons()

    def mark(self, name: str) -> None:
        """Mark the visible screen's button."""
        for each, action in self._actions.items():
            action.setChecked(each == name)
        self.paint_icons()

    def paint_icons(self) -> None:
        """Draw the icons in the present colours, that of the present screen in the accent's."""
        for row in SCREEN_TABLE:
            action = self._actions[row.name]
            colour = "accent" if action.isChecked() else "muted"
            action.setIcon(icon(row.icon, self._look.colour(colour)))


def import_all(imports: "Sequence[tuple[str, Future[str]]]") -> None:
    """Import modules one after another.

    A module that cannot be imported is skipped: its user gets the error.

    Args:
        imports: full name of each, and a Future of it; a cancelled one is not imported.
    """
    for name, future in imports:
        if future.set_running_or_notify_cancel():
            with contextlib.suppress(Exception):
                importlib.import_module(name)
            future.set_result(name)


def missing_page(title: str, said: str, parent: QWidget) -> QWidget:
    """Return a page in place of a screen that there is not: a sentence in the centre.

    Args:
        title: title of the screen.
        said: the reason.
        parent: the Qt parent.
    """
    page = QWidget(parent)
    layout = vbox(1, of=page)
    words = with_class(Label(said), "muted")
    words.setWordWrap(True)
    for label in (with_class(Label(title), "title"), words):
        label.setAlignment(Qt.AlignmentFlag.AlignCenter)
        layout.addWidget(label)
    layout.addStretch(2)
    return page


class ScreenStack(QStackedWidget):
    """All screens, one of which is visible.

    Args:
        workspace: services that they share.
        rows: the existing screens.

    Attributes:
        name: name of the visible screen, "" before the first.
    """

    completed = pyqtSignal()
    """All screens were made in advance."""
    switched = pyqtSignal(str)
    """Name of the visible screen."""

    def __init__(self, workspace: Workspace, rows: tuple[ScreenRow, ...] = SCREEN_TABLE) -> None:
        super().__init__()
        self._workspace = workspace
        self._rows = rows
        self._screens: dict[str, Screen] = {}
        self._pages: dict[str, QWidget] = {}
        self.name = ""
        self._loading = missing_page(*LOADING_TEXTS, self)
        self._loading.setAccessibleName(f"{LOADING_TEXTS[0]} screen")
        self.addWidget(self._loading)
        self._ahead = [row.name for row in rows]
        self._loaded: set[str] = set()
        self._imports: list[tuple[str, Future[str]]] = []
        self._answers = FutureCallbacks(workspace.notices.warn, self)
        workspace.flight.begun.connect(self._begin)
        workspace.flight.taken_over.connect(self._take_over)
        workspace.flight.viewed.connect(self._show_view)

    @property
    def current(self) -> Screen | None:
        """The visible screen, None if it could not be made."""
        return self._screens.get(self.name)

    @property
    def screens(self) -> tuple[Screen, ...]:
        """The screens made so far."""
        return tuple(self._screens.values())

    def screen_of(self, name: str) -> Screen | None:
        """Return a screen, and make it if necessary; None if it cannot be made."""
        self._make(self._row(name))
        return self._screens.get(name)

    def show_screen(self, name: str) -> None:
        """Show a screen; the previous one releases held controls."""
        if name == self.name:
            self._pages[name].setFocus()
            return
        if self.current is not None:
            self.current.release()
        page = self._make(self._row(name))
        self.name = name
        self.setCurrentWidget(page)
        self.removeWidget(self._loading)
        page.setFocus()  # Tab goes through the screen, and single keys are for it
        if self.current is not None and self._workspace.flight.view.snapshot is not None:
            self.current.show_view(self._workspace.flight.view)
        self.switched.emit(name)

    def make_ahead(self, first: str) -> None:
        """Make all screens in idle time, and show one of them as soon as possible.

        Args:
            first: name of that one.
        """
        self._ahead.sort(key=lambda name: name != first)
        self._imports = [(self._row(name).path, Future()) for name in self._ahead]
        for _, future in self._imports:
            self._answers.expect(future, self._make_next)
        self._workspace.errands.do(partial(import_all, self._imports))

    def release(self) -> None:
        """Let the visible screen release held controls."""
        if self.current is not None:
            self.current.release()

    def close_screens(self) -> None:
        """End everything that the screens have started."""
        self._ahead = []
        self._answers.close()
        for _, future in self._imports:
            future.cancel()
        for screen in self._screens.values():
            screen.close_screen()

    def _row(self, name: str) -> ScreenRow:
        for row in self._rows:
            if row.name == name:
                return row
        return find_screen(name)

    def _make_next(self, module: str) -> None:
        """Make a screen whose module is loaded, after the window has painted."""
        self._loaded.add(module)
        if not self.name and self._ahead and module == self._row(self._ahead[0]).path:
            self.show_screen(self._ahead.pop(0))
            return
        QTimer.singleShot(SCREEN_PRELOAD_PAUSE_MS, self._make_one)

    def _make_one(self) -> None:
        """Make the next screen that was not visible yet."""
        ready = [name for name in self._ahead if self._row(name).path in self._loaded]
        self._ahead = [name for name in self._ahead if name not in ready[:1]]
        for name in ready[:1]:
            self._make(self._row(name))
            if not self._ahead:
                self.completed.emit()

    def _make(self, row: ScreenRow) -> QWidget:
        """Return a screen's page, made on first use, or a page that says why it cannot be made."""
        if row.name in self._pages:
            return self._pages[row.name]
        try:
            screen: Screen = row.load()(self._workspace)
        except Exception as error:
            said = f"the {row.title} screen cannot be shown: {type(error).__name__}: {error}"
            self._workspace.notices.fail(said, "The other screens work; restart to try again.")
            page: QWidget = missing_page(row.title, said, self)
        else:
            self._screens[row.name] = screen
            page = screen
        self._pages[row.name] = page
        page.setAccessibleName(f"{row.title} screen")
        self.addWidget(page)
        view, made = self._workspace.flight.view, self._screens.get(row.name)
        if made is not None and view.snapshot is not None:
            made.begin(view)
        return page

    def _begin(self, view: LiveView) -> None:
        for screen in self._screens.values():
            screen.begin(view)

    def _take_over(self, view: LiveView) -> None:
        for screen in self._screens.values():
            screen.take_over(view)

    def _show_view(self, view: LiveView) -> None:
        if self.current is not None:
            self.current.show_view(view)
