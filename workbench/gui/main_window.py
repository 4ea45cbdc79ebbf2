"""The window: side bar, top bar, screens, the 3-D view beside them, and the banner."""

from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, cast

from PyQt6.QtCore import QEvent, Qt, QTimer
from PyQt6.QtGui import (
    QCloseEvent,
    QDragEnterEvent,
    QDropEvent,
    QKeyEvent,
    QPaintEvent,
)
from PyQt6.QtWidgets import (
    QMainWindow,
    QMenuBar,
    QSplitter,
    QWhatsThis,
    QWidget,
)

from workbench.common.plain_text import plain_name
from workbench.control.installed_laws import known_laws
from workbench.gui.actions import (
    REAL_TIME_FACTORS,
    RECENT_FILES_MENU,
    THEME_NAMES,
    fill_menus,
)
from workbench.gui.arguments_dialog import ask_for_arguments
from workbench.gui.banner import Banner, BeginnerGuide
from workbench.gui.charts.chart_command import pressed_key
from workbench.gui.charts.chart_keys import give_key_to_chart
from workbench.gui.command_action import make_actions
from workbench.gui.flight_control import FlightControl, are_hooks_open, possible_actions
from workbench.gui.focus_guard import FocusGuard
from workbench.gui.help import about_page
from workbench.gui.interpreter import freeze_gc, shorten_switch_interval
from workbench.gui.keys_page import KeysPage
from workbench.gui.layout import NO_MARGINS, hbox, vbox
from workbench.gui.opener import Opener, fill_recent
from workbench.gui.recent_files import FileKind
from workbench.gui.recorder import LogRecorder
from workbench.gui.saved_files import save_screenshot
from workbench.gui.screen_table import SCREEN_TABLE, ScreenRow
from workbench.gui.screens import Screen, ScreenStack, SideBar
from workbench.gui.top_bar import TopBar
from workbench.gui.unsaved_question import ask_about_unsaved
from workbench.gui.view3d.view3d_panel import CAMERA_VIEWS, HIDABLE_PARTS, View3d
from workbench.gui.window_places import last_screen, restore_places, save_places, was_beside
from workbench.gui.workspace import Workspace
from workbench.live.choice import Choice
from workbench.live.messages import Phase
from workbench.live.view import LiveView
from workbench.plant.formats.xacro import XacroArgument
from workbench.scenario.scenario import Scenario

if TYPE_CHECKING:
    from workbench.gui.gains.gain_editor import GainEditor
    from workbench.gui.tuning.tuning_screen import TuningScreen

WINDOW_TITLE = "Drake drone workbench"
INITIAL_WINDOW_SIZE_PX = (1280, 720)
MIN_WINDOW_SIZE_PX = (960, 540)
INITIAL_SPLIT_WIDTHS_PX = (760, 430)
"""Initial shares of the width for the screens and the 3-D view."""
GUIDE_SCREEN = "tuning"
"""Screen of the guide's first stage."""
MIN_SCREEN_WIDTH_PX = 619
"""Least width of all screens, so that none scrolls horizontally [px]."""


class MainWindow(QMainWindow):
    """The window of the app.

    Args:
        workspace: services that its screens share.
        rows: the existing screens.
        first: name of the first screen; "" for the last one of the previous run.
        view3d: whether there is a 3-D view.
    """

    def __init__(
        self,
        workspace: Workspace,
        rows: tuple[ScreenRow, ...] = SCREEN_TABLE,
        *,
        first: str = "",
        view3d: bool = True,
    ) -> None:
        super().__init__()
        shorten_switch_interval()
        self.workspace = workspace
        self.control = FlightControl(workspace.flight, workspace.preferences, self)
        workspace.flight.draws = view3d
        store = workspace.preferences.store
        self._store = store
        self.recent = workspace.recent
        self.recorder = LogRecorder(
            workspace.flight, workspace.preferences, workspace.notices, self
        )
        self.recorder.recorded.connect(lambda path: self.recent.add(FileKind.LOG, path))
        shows = {
            kind: partial(self._show_in_charts, name)
            for kind, name in (
                (FileKind.LOG, "open_log"),
                (FileKind.LAYOUT, "open_layout"),
                (FileKind.SPEC, "open_spec"),
            )
        }
        self.opener = Opener(self.control, self.recent, workspace.notices, shows, self)
        self.recent.wanted.connect(self.opener.open)
        self.recent.choice_wanted.connect(self.opener.ask)
        self._focus_guard = FocusGuard(self)
        self.actions_by_name = make_actions(self, self._handlers(), workspace.keys)
        self.side_bar = SideBar(self.actions_by_name, workspace.look)
        self.top_bar = TopBar(workspace, self.actions_by_name, self.control, self.recorder)
        self.stack = ScreenStack(workspace, rows)
        for name in HIDABLE_PARTS:
            self.actions_by_name[name].setChecked(True)
        self.view3d = View3d(workspace, self.actions_by_name)
        self.banner = Banner(workspace, self.actions_by_name)
        flight, in_text = workspace.flight, workspace.keys.in_text
        self.guide = BeginnerGuide(flight, store, self._show_tuning, self, in_text)
        self.splitter = QSplitter(Qt.Orientation.Horizontal)
        self._first = first or last_screen(store)
        self._painted = self._closed = False
        self._known_flight: Choice | Scenario | None = None
        self._lay_out()
        self._connect()
        restore_places(store, self, self.splitter)
        self._set_beside(view3d and was_beside(store))

    def show_screen(self, name: str) -> None:
        """Show a screen by its name."""
        self.stack.show_screen(name)
        self.side_bar.mark(name)  # also the button that was clicked twice

    def begin_with_guide(self) -> None:
        """Show the guide with the first screen, which is loaded once the window is painted."""
        self._first = GUIDE_SCREEN
        once = Qt.ConnectionType.SingleShotConnection
        self.stack.switched.connect(self.guide.begin, once)  # pyrefly: ignore[bad-argument-count]

    def _handlers(self) -> dict[str, Callable[[], object]]:
        """Return the function of each action in the table."""
        control, opener = self.control, self.opener
        handlers: dict[str, Callable[[], object]] = {
            "open_scenario": lambda: opener.ask(FileKind.SCENARIO),
            "open_model": lambda: opener.ask(FileKind.MODEL),
            "open_world": lambda: opener.ask(FileKind.WORLD),
            "open_controller": lambda: opener.ask(FileKind.CONTROLLER),
            "open_log": lambda: opener.ask(FileKind.LOG),
            "record": self._record,
            "screenshot": partial(save_screenshot, self, self.workspace),
            "quit": self._quit,
            "arm": partial(control.request, "arm"),
            "take_off": partial(control.request, "take_off"),
            "hold": control.hold,
            "land": partial(control.request, "land"),
            "open_hooks": partial(self._order, control.toggle_hooks),
            "stop": partial(control.request, "stop"),
            "pause": partial(self._order, control.pause),
            "step": control.step,
            "reset": control.reset,
            "view_3d": self._toggle_beside,
            "browse_3d": lambda: self.view3d.browse(),
            "dismiss": lambda: self.banner.dismiss(),
            "notices": lambda: self.banner.toggle_list(),
            "full_screen": self._toggle_full_screen,
            "guide": lambda: self.guide.begin(),
            "explain": QWhatsThis.enterWhatsThisMode,
            "keys": lambda: KeysPage(self.workspace.keys, self).show(),
            "about": lambda: about_page(self).show(),
        }
        for name in known_laws():
            handlers[f"controller_{name}"] = partial(control.fly_controller, name)
        for screen in SCREEN_TABLE:
            handlers[f"show_{screen.name}"] = partial(self.show_screen, screen.name)
        for factor in REAL_TIME_FACTORS:
            handlers[f"speed_{factor:g}"] = partial(control.set_speed, factor)
        for name in HIDABLE_PARTS:
            handlers[name] = lambda: self.view3d.show_parts()
        for way in CAMERA_VIEWS:
            handlers[f"look_{way}"] = lambda way=way: self.view3d.look(way)
        for theme in THEME_NAMES:
            handlers[f"theme_{theme}"] = partial(self._set_theme, theme)
        return handlers

    def _lay_out(self) -> None:
        self.setWindowTitle(WINDOW_TITLE)
        self.setMinimumSize(*MIN_WINDOW_SIZE_PX)
        self.resize(*INITIAL_WINDOW_SIZE_PX)
        self.setAcceptDrops(True)
        bar = QMenuBar(self)
        self.setMenuBar(bar)
        menus = fill_menus(bar, self.actions_by_name)
        self.recent_menu = menus[RECENT_FILES_MENU]
        fill = partial(fill_recent, self.recent_menu, self.recent, self.opener.open)
        self.recent_menu.aboutToShow.connect(fill)
        self.recent.changed.connect(fill)
        fill()
        self.splitter.setChildrenCollapsible(False)
        self.stack.setMinimumWidth(MIN_SCREEN_WIDTH_PX)
        self.splitter.addWidget(self.stack)
        self.splitter.addWidget(self.view3d)
        self.splitter.setStretchFactor(0, 3)
        self.splitter.setStretchFactor(1, 2)
        self.splitter.setSizes(list(INITIAL_SPLIT_WIDTHS_PX))
        right = vbox(self.top_bar, (self.splitter, 1), self.guide, self.banner, spacing=0)
        centre = QWidget()
        hbox(self.side_bar, (right, 1), of=centre, margins=NO_MARGINS, spacing=0)
        self.setCentralWidget(centre)

    def _connect(self) -> None:
        flight = self.workspace.flight
        flight.viewed.connect(self._show_possible)
        flight.begun.connect(self._show_title)
        flight.begun.connect(self._leave_start)
        flight.arguments_wanted.connect(self._ask_for_arguments)
        flight.asks_first = self._ask_to_save
        flight.phase_changed.connect(lambda phase: self._show_possible(flight.view))
        self.recorder.changed.connect(self._show_recording)
        self.stack.completed.connect(freeze_gc)
        self.stack.switched.connect(self.side_bar.mark)
        self.workspace.log.card_wanted.connect(self._show_card)
        self.workspace.preferences.changed.connect(lambda name: self._show_theme())
        self._able: frozenset[str] | None = None
        self._show_possible(flight.view)
        self._show_theme()

    def _show_possible(self, view: LiveView) -> None:
        """Disable actions that have no effect now; stop is always enabled."""
        marks = {"pause": view.phase is Phase.PAUSED, "open_hooks": are_hooks_open(view)}
        for name, on in marks.items():
            self.actions_by_name[name].setChecked(on)
        able = possible_actions(view)
        if able == self._able:
            return
        self._able = able
        for name in self.control.actions:
            self.actions_by_name[name].setEnabled(name in able)
        for factor in REAL_TIME_FACTORS:
            self.actions_by_name[f"speed_{factor:g}"].setEnabled("speed" in able)
        self.top_bar.speed.setEnabled("speed" in able)

    def _show_title(self, view: LiveView) -> None:
        title = view.scenario.title if view.scenario else ""
        vehicle = view.vehicle.name if view.vehicle else ""
        parts = (plain_name(title), plain_name(vehicle), WINDOW_TITLE)
        self.setWindowTitle(" \N{EM DASH} ".join(filter(None, parts)))

    def _play(self) -> None:
        """Play or pause what the screen shows, or else the flight."""
        screen = self.stack.current
        if screen is None or not screen.play_or_pause():
            self.actions_by_name["pause"].trigger()

    def _order(self, give: Callable[[], object]) -> None:
        """Give an order by an action whose mark follows the flight, not the key."""
        self._show_possible(self.workspace.flight.view)
        give()

    def _record(self) -> None:
        self._show_recording()
        self.recorder.toggle()

    def _show_recording(self) -> None:
        self.actions_by_name["record"].setChecked(self.recorder.is_recording)

    def _set_theme(self, theme: str) -> None:
        self.workspace.preferences.set("theme", theme)
        self._show_theme()

    def _show_theme(self) -> None:
        chosen = self.workspace.preferences.text("theme")
        for theme in THEME_NAMES:
            self.actions_by_name[f"theme_{theme}"].setChecked(theme == chosen)

    def _show_in_charts(self, method: str, path: Path) -> None:
        self.show_screen("visualization")
        opens = getattr(self.stack.current, method, None)
        if opens is None:
            self.workspace.notices.warn("this version of the app cannot show such files")
        else:
            opens(path)

    def _leave_start(self, _: LiveView) -> None:
        """Leave the start page for Home if another flight begins, and not the same one anew."""
        if self.stack.name == "start" and self.workspace.flight.what is not self._known_flight:
            self.show_screen("home")
        self._known_flight = self.workspace.flight.what

    def _ask_for_arguments(self, what: Choice | Scenario, needed: Sequence[XacroArgument]) -> None:
        ask_for_arguments(what, needed, self.control.fly, self.workspace.notices, self)

    def _show_tuning(self) -> "GainEditor | None":
        """Show the tuning screen, and return its gains; None if it cannot be made."""
        screen = self._tuning_screen()
        return screen.gains if screen is not None else None

    def _show_card(self, title: str) -> None:
        screen = self._tuning_screen()
        if screen is not None:
            screen.show_card(title)

    def _tuning_screen(self) -> "TuningScreen | None":
        """Show the tuning screen, and return it; None if it cannot be made."""
        self.show_screen(GUIDE_SCREEN)
        return cast("TuningScreen | None", self.stack.screen_of(GUIDE_SCREEN))

    def _toggle_beside(self) -> None:
        self._set_beside(not self.view3d.isVisibleTo(self))

    def _set_beside(self, beside: bool) -> None:
        self.view3d.setVisible(beside)
        self.actions_by_name["view_3d"].setChecked(beside)

    def _toggle_full_screen(self) -> None:
        self.setWindowState(self.windowState() ^ Qt.WindowState.WindowFullScreen)
        self.actions_by_name["full_screen"].setChecked(self.isFullScreen())

    def _quit(self) -> None:
        self._ask_to_save(self.close, "quitting")

    def _unsaved(self) -> Screen | None:
        """Return the screen with data that would be lost with the flight."""
        return next((screen for screen in self.stack.screens if screen.unsaved()), None)

    def _ask_to_save(self, go_on: Callable[[], object], before: str = "the next flight") -> None:
        """Continue with what ends the flight, once nothing would be lost or the user agrees."""
        ask_about_unsaved(self._unsaved(), go_on, before, self)

    def _begin(self) -> None:
        """Make the screens, once the window is visible."""
        if not self._closed:
            self._known_flight = self.workspace.flight.what
            (self.stack.currentWidget() or self.stack).setFocus()
            self.stack.make_ahead(self._first)

    def paintEvent(self, event: QPaintEvent | None) -> None:
        super().paintEvent(event)
        if not self._painted:
            self._painted = True
            QTimer.singleShot(0, self._begin)

    def keyPressEvent(self, event: QKeyEvent | None) -> None:
        """Handle a single key that the focused widget has not used."""
        keys = self.workspace.keys
        if event is not None and pressed_key(event) == keys.key("play"):
            if not event.isAutoRepeat():
                self._play()
        elif event is None or not give_key_to_chart(event, self.stack, keys):
            super().keyPressEvent(event)

    def changeEvent(self, event: QEvent | None) -> None:
        super().changeEvent(event)
        leaves = event is not None and event.type() == QEvent.Type.ActivationChange
        if leaves and not self.isActiveWindow():
            self.stack.release()

    def dragEnterEvent(self, event: QDragEnterEvent | None) -> None:
        mime = event.mimeData() if event else None
        if event and mime and any(url.isLocalFile() for url in mime.urls()):
            event.acceptProposedAction()

    def dropEvent(self, event: QDropEvent | None) -> None:
        mime = event.mimeData() if event else None
        if event and mime:
            for url in mime.urls()[:1]:
                event.acceptProposedAction()
                self.opener.drop(Path(url.toLocalFile()))

    def closeEvent(self, event: QCloseEvent | None) -> None:
        """Store the window's position, and end everything.

        Closing the window by its frame asks the same question as Ctrl+Q. Ending the program, as by
        Ctrl+C in its terminal, does not: nobody might be there to answer.
        """
        by_frame = event is not None and event.spontaneous()
        if event is not None and by_frame and not self._closed and self._unsaved() is not None:
            event.ignore()
            self._quit()
            return
        if not self._closed:
            self._closed = True
            # a start without 3-D does not change the stored value
            draws = self.workspace.flight.draws
            beside = self.view3d.isVisibleTo(self) if draws else was_beside(self._store)
            screen = self.stack.name or self._first
            save_places(self._store, self, self.splitter, screen=screen, beside=beside)
            self.hide()
            self.recorder.end_with_app()
            self.stack.close_screens()
            self.view3d.close_view()
            self.workspace.close()
        super().closeEvent(event)
