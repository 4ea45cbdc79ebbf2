"""The screens behind each other; each is made when it is first seen, or when nothing is to do."""

from PyQt6.QtCore import QTimer, pyqtSignal
from PyQt6.QtWidgets import QStackedWidget, QWidget

from workbench.gui.missing_page import MissingPage
from workbench.gui.module_loader import ModuleLoader
from workbench.gui.screen import Screen
from workbench.gui.screen_table import SCREENS, ScreenRow, find_screen
from workbench.gui.workspace import Workspace
from workbench.live.view import LiveView

PAUSE = 60
"""Between two screens that are made in advance, for the window to breathe [ms]."""


class ScreenStack(QStackedWidget):
    """All screens, of which one is seen.

    Args:
        workspace: what they share.
        rows: which there are.
        parent: in which it stands.
    """

    completed = pyqtSignal()
    """All screens were made in advance."""
    switched = pyqtSignal(str)
    """Name of the screen that is seen now."""

    def __init__(
        self,
        workspace: Workspace,
        rows: tuple[ScreenRow, ...] = SCREENS,
        parent: QWidget | None = None,
    ) -> None:
        super().__init__(parent)
        self._workspace = workspace
        self._rows = rows
        self._screens: dict[str, Screen] = {}
        self._pages: dict[str, QWidget] = {}
        self._name = ""
        self._ahead = [row.name for row in rows]
        self._loaded: set[str] = set()
        self._loader: ModuleLoader | None = None
        workspace.flight.begun.connect(self._begin)
        workspace.flight.viewed.connect(self._show_view)

    @property
    def name(self) -> str:
        """Of the screen that is seen, "" before the first."""
        return self._name

    @property
    def current(self) -> Screen | None:
        """The screen that is seen, None where it could not be made."""
        return self._screens.get(self._name)

    @property
    def screens(self) -> tuple[Screen, ...]:
        """Those that were made until now."""
        return tuple(self._screens.values())

    def screen_of(self, name: str) -> Screen | None:
        """Return a screen, made now if need be; None where it cannot be made."""
        self._make(self._row(name))
        return self._screens.get(name)

    def show_screen(self, name: str) -> None:
        """Show a screen; the one before lets go of what it holds."""
        if name == self._name:
            return
        if self.current is not None:
            self.current.release()
        page = self._make(self._row(name))
        self._name = name
        self.setCurrentWidget(page)
        if self.current is not None and self._workspace.flight.view.snapshot is not None:
            self.current.show_view(self._workspace.flight.view)
        self.switched.emit(name)

    def make_ahead(self, first: str) -> None:
        """Make all screens in idle time, and show one of them as soon as it can be.

        Args:
            first: name of that one.
        """
        self._ahead.sort(key=lambda name: name != first)
        self._loader = ModuleLoader([self._row(name).path for name in self._ahead], self)
        self._loader.loaded.connect(self._make_next)
        self._loader.start()

    def release(self) -> None:
        """Let the screen that is seen let go of what it holds."""
        if self.current is not None:
            self.current.release()

    def close_screens(self) -> None:
        """End what the screens have started."""
        self._ahead = []
        if self._loader is not None:
            self._loader.close()
        for screen in self._screens.values():
            screen.close_screen()

    def _row(self, name: str) -> ScreenRow:
        for row in self._rows:
            if row.name == name:
                return row
        return find_screen(name)

    def _make_next(self, module: str) -> None:
        """Make a screen whose module is there, after the window has drawn."""
        self._loaded.add(module)
        if not self._name and self._ahead and module == self._row(self._ahead[0]).path:
            self.show_screen(self._ahead.pop(0))
            return
        QTimer.singleShot(PAUSE, self._make_one)

    def _make_one(self) -> None:
        """Make the next screen that was not seen yet."""
        ready = [name for name in self._ahead if self._row(name).path in self._loaded]
        self._ahead = [name for name in self._ahead if name not in ready[:1]]
        for name in ready[:1]:
            self._make(self._row(name))
            if not self._ahead:
                self.completed.emit()

    def _make(self, row: ScreenRow) -> QWidget:
        """Return a screen's page, which is made at first, or says why it cannot be."""
        if row.name in self._pages:
            return self._pages[row.name]
        try:
            screen: Screen = row.load()(self._workspace, self)
        except Exception as error:
            said = f"the {row.title} screen cannot be shown: {type(error).__name__}: {error}"
            self._workspace.notices.fail(said, "The other screens work; restart to try again.")
            page: QWidget = MissingPage(row.title, said, self)
        else:
            self._screens[row.name] = screen
            page = screen
        self._pages[row.name] = page
        self.addWidget(page)
        view, made = self._workspace.flight.view, self._screens.get(row.name)
        if made is not None and view.snapshot is not None:
            made.begin(view)
        return page

    def _begin(self, view: LiveView) -> None:
        for screen in self._screens.values():
            screen.begin(view)

    def _show_view(self, view: LiveView) -> None:
        if self.current is not None:
            self.current.show_view(view)
