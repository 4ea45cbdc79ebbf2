"""The window: side bar, top bar, screens, the 3-D view beside them, and the banner."""

import gc
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, cast

from PyQt6 import sip
from PyQt6.QtCore import QByteArray, QEvent, QObject, Qt, QTimer
from PyQt6.QtGui import (
    QCloseEvent,
    QDragEnterEvent,
    QDropEvent,
    QGuiApplication,
    QKeyEvent,
    QPaintEvent,
)
from PyQt6.QtWidgets import (
    QAbstractButton,
    QAbstractSpinBox,
    QApplication,
    QDialog,
    QDialogButtonBox,
    QFormLayout,
    QLineEdit,
    QMainWindow,
    QMenuBar,
    QMessageBox,
    QPlainTextEdit,
    QSplitter,
    QTextEdit,
    QWhatsThis,
    QWidget,
)

from workbench.common.errors import WorkbenchError
from workbench.common.plain_text import plain_name, plain_text
from workbench.control.controller import PROGRAMS, SHIPPED
from workbench.gui.actions import RECENT, SPEEDS, THEMES, fill_menus, make_actions
from workbench.gui.banner import Banner, Guide
from workbench.gui.flight_control import FlightControl, possible
from workbench.gui.help import about_page, keys_page
from workbench.gui.labels import set_tip
from workbench.gui.layout import NO_MARGINS, hbox, label, scroll_area, vbox
from workbench.gui.opener import FileKind, Opener, RecentFiles, fill_recent
from workbench.gui.recorder import Camera, Recorder
from workbench.gui.screen_table import SCREENS, ScreenRow, find_screen
from workbench.gui.screens import Screen, ScreenStack, SideBar
from workbench.gui.top_bar import TopBar
from workbench.gui.view3d.view3d_panel import LOOKS, PARTS, View3d
from workbench.gui.workspace import Workspace
from workbench.live.choice import Choice, with_arguments
from workbench.live.messages import Phase
from workbench.live.view import LiveView
from workbench.plant.formats.xacro import XacroArgument
from workbench.scenario.scenario import Scenario

if TYPE_CHECKING:
    from workbench.gui.gains.gain_editor import GainEditor
    from workbench.gui.tuning.tuning_screen import TuningScreen

NEEDED = "needs a value"
_FIELDS = (QAbstractSpinBox, QLineEdit, QPlainTextEdit, QTextEdit)
_CONTROL = Qt.KeyboardModifier.ControlModifier
_SHIFT = Qt.KeyboardModifier.ShiftModifier
_EDITS = {
    *((key, _CONTROL) for key in map(ord, "ACVXYZ")),
    (ord("Z"), _CONTROL | _SHIFT),
}
"""Keys with Ctrl that edit text on every system: select all, copy, paste, cut, redo, undo."""
TURN = 0.0005
"""Interval after which the painting thread yields to threads that carry answers [s].

Python's default of 5 ms, needed twice for a question and once for the reply, would be most of the
delay from a slider to its margins.
"""
TITLE = "Drake drone workbench"
FIRST_SIZE = (1280, 720)
SMALLEST = (960, 540)
SHARES = (760, 430)
"""Initial shares of the width for the screens and the 3-D view."""
NARROWEST_SCREEN = 619
"""Least width of all screens, so that none scrolls horizontally [px]."""
GROUP = "window/1"
"""Group of settings; the number changes when stored values no longer fit."""
CLOSING = 2.0
"""Time limit for ending a log when the window closes [s]."""


class ArgumentsDialog(QDialog):
    """A line for each argument; the flight, and the key that stops it, keep working meanwhile.

    Args:
        file: name of the file that needs them.
        arguments: its arguments; those without a default need a value.
        given: called with the values that differ from the defaults, by name.
        parent: the Qt parent.

    Attributes:
        lines: lines by the argument's name.
        buttons: its buttons; Open is disabled until nothing is missing.
    """

    def __init__(
        self,
        file: str,
        arguments: Sequence[XacroArgument],
        given: Callable[[Mapping[str, str]], None],
        parent: QWidget | None = None,
    ) -> None:
        super().__init__(parent)
        file = plain_name(file)
        self.setWindowTitle(f"Arguments of {file}")
        self.setModal(False)
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self._arguments, self._given = tuple(arguments), given
        self.lines: dict[str, QLineEdit] = {}
        said = label(
            f"{file} takes arguments. Give a value to each that is marked with ✱.", wraps=True
        )
        form = QWidget()
        self._form = QFormLayout(form)
        for each in self._arguments:
            self._add(each)
        box = QDialogButtonBox.StandardButton
        self.buttons = QDialogButtonBox(box.Open | box.Cancel)
        self.buttons.accepted.connect(self.accept)
        self.buttons.rejected.connect(self.reject)
        vbox(said, (scroll_area(form), 1), self.buttons, of=self)
        self.resize(460, min(520, 160 + 36 * len(self._arguments)))
        self._look()

    def accept(self) -> None:
        """Pass the values on, and close."""
        self._given(
            {
                each.name: self.lines[each.name].text().strip()
                for each in self._arguments
                if self.lines[each.name].text().strip() != each.default
            }
        )
        super().accept()

    def _add(self, argument: XacroArgument) -> None:
        line = QLineEdit(argument.default or "")
        needed = argument.default is None
        line.setPlaceholderText(NEEDED if needed else "")
        line.setAccessibleName(f"{argument.name}, {NEEDED}" if needed else argument.name)
        line.textChanged.connect(self._look)
        self.lines[argument.name] = line
        shown = plain_name(argument.name)
        name = label(f"{shown} ✱") if needed else label(shown, "muted")
        self._form.addRow(name, line)

    def _look(self) -> None:
        """Enable Open when every argument that needs a value has one."""
        missing = [
            each.name
            for each in self._arguments
            if each.default is None and not self.lines[each.name].text().strip()
        ]
        button = self.buttons.button(QDialogButtonBox.StandardButton.Open)
        assert button is not None
        button.setEnabled(not missing)
        set_tip(button, f"These need a value: {', '.join(missing)}" if missing else "")


class FocusGuard(QObject):
    """Watches the focused widget.

    When a focused button is disabled or hidden, as Take off after the take-off, Qt moves the focus
    to the next widget. That widget would then receive the space bar, which was not meant for it. So
    the focus moves to the frame around the button, which ignores keys; Tab continues from there.

    On X11 a field uses Ctrl+E, Ctrl+K and others itself, as in a terminal, which disables the app's
    shortcuts there. Here it keeps only the keys that edit text on every system.

    Args:
        parent: the Qt parent; this object is deleted with it.
    """

    def __init__(self, parent: QObject) -> None:
        super().__init__(parent)
        self._field: QWidget | None = None
        application = QGuiApplication.instance()
        assert isinstance(application, QApplication)
        application.focusChanged.connect(self._follow)

    def eventFilter(self, watched: QObject | None, event: QEvent | None) -> bool:
        """Keep the app's shortcuts working in a field; Qt's name."""
        if not isinstance(event, QKeyEvent) or event.type() is not QEvent.Type.ShortcutOverride:
            return False
        key, modifiers = event.key(), event.modifiers()
        if modifiers not in (_CONTROL, _CONTROL | _SHIFT) or (key, modifiers) in _EDITS:
            return False
        if not (ord("A") <= key <= ord("Z") or ord("0") <= key <= ord("9")):
            return False
        event.ignore()
        return True

    def _follow(self, before: QWidget | None, now: QWidget | None) -> None:
        self._watch(now if isinstance(now, _FIELDS) else None)
        if now is None or before is None or not isinstance(now, QAbstractButton):
            return
        if before.isEnabled() and before.isVisible():
            return  # the user has moved the focus
        frame = before.parentWidget()
        while frame is not None and not (frame.isEnabled() and frame.isVisible()):
            frame = frame.parentWidget()
        if frame is not None and frame.window() is now.window():
            frame.setFocus()

    def _watch(self, field: QWidget | None) -> None:
        if self._field is not None and not sip.isdeleted(self._field):
            self._field.removeEventFilter(self)
        self._field = field
        if field is not None:
            field.installEventFilter(self)


def take_short_turns() -> None:
    """Let threads that carry orders and answers wait less for the thread that paints."""
    sys.setswitchinterval(TURN)


def spare_collector() -> None:
    """Exclude present objects from garbage collection, as they live as long as the window.

    A collection of all of them would stop painting for a tenth of a second.
    """
    gc.collect()
    gc.freeze()


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
        rows: tuple[ScreenRow, ...] = SCREENS,
        *,
        first: str = "",
        view3d: bool = True,
    ) -> None:
        super().__init__()
        take_short_turns()
        self.workspace = workspace
        self.control = FlightControl(workspace.flight, workspace.preferences, self)
        workspace.flight.draws = view3d
        store = workspace.preferences.store
        self._store = store
        self.recent = RecentFiles(store, self)
        self.recorder = Recorder(workspace.flight, workspace.preferences, workspace.notices, self)
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
        self._camera = Camera(self, workspace)
        self._focus_guard = FocusGuard(self)
        self.actions_by_name = make_actions(self, self._handlers())
        self.side_bar = SideBar(self.actions_by_name, workspace.look)
        self.top_bar = TopBar(workspace, self.actions_by_name, self.control, self.recorder)
        self.stack = ScreenStack(workspace, rows)
        for name in PARTS:
            self.actions_by_name[name].setChecked(True)
        self.view3d = View3d(workspace, self.actions_by_name)
        self.banner = Banner(workspace, self.actions_by_name)
        self.guide = Guide(workspace.flight, workspace.notices, store, self._show_tuning, self)
        self.splitter = QSplitter(Qt.Orientation.Horizontal)
        self._first = first or self._last_screen()
        self._painted = self._closed = False
        self._question: QMessageBox | None = None
        self._lay_out()
        self._connect()
        self._restore_places()
        self._set_beside(view3d and self._was_beside())

    def show_screen(self, name: str) -> None:
        """Show a screen by its name."""
        self.stack.show_screen(name)
        self.side_bar.mark(name)  # also the button that was clicked twice

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
            "screenshot": self._camera.take,
            "quit": self._quit,
            "arm": partial(control.request, "arm"),
            "take_off": partial(control.request, "take_off"),
            "hold": control.hold,
            "land": partial(control.request, "land"),
            "stop": partial(control.request, "stop"),
            "pause": self._pause,
            "step": control.step,
            "reset": control.reset,
            "view_3d": self._toggle_beside,
            "browse_3d": lambda: self.view3d.browse(),
            "dismiss": lambda: self.banner.dismiss(),
            "full_screen": self._toggle_full_screen,
            "guide": lambda: self.guide.begin(),
            "explain": QWhatsThis.enterWhatsThisMode,
            "keys": lambda: keys_page(self).show(),
            "about": lambda: about_page(self).show(),
        }
        for name in (*SHIPPED, *PROGRAMS):
            handlers[f"controller_{name}"] = partial(control.fly_controller, name)
        for screen in SCREENS:
            handlers[f"show_{screen.name}"] = partial(self.show_screen, screen.name)
        for factor in SPEEDS:
            handlers[f"speed_{factor:g}"] = partial(control.set_speed, factor)
        for name in PARTS:
            handlers[name] = lambda: self.view3d.show_parts()
        for way in LOOKS:
            handlers[f"look_{way}"] = partial(self._look, way)
        for theme in THEMES:
            handlers[f"theme_{theme}"] = partial(self._set_theme, theme)
        return handlers

    def _lay_out(self) -> None:
        self.setWindowTitle(TITLE)
        self.setMinimumSize(*SMALLEST)
        self.resize(*FIRST_SIZE)
        self.setAcceptDrops(True)
        bar = QMenuBar(self)
        self.setMenuBar(bar)
        menus = fill_menus(bar, self.actions_by_name)
        self.recent_menu = menus[RECENT]
        fill = partial(fill_recent, self.recent_menu, self.recent, self.opener.open)
        self.recent_menu.aboutToShow.connect(fill)
        self.recent.changed.connect(fill)
        fill()
        self.splitter.setChildrenCollapsible(False)
        self.stack.setMinimumWidth(NARROWEST_SCREEN)
        self.splitter.addWidget(self.stack)
        self.splitter.addWidget(self.view3d)
        self.splitter.setStretchFactor(0, 3)
        self.splitter.setStretchFactor(1, 2)
        self.splitter.setSizes(list(SHARES))
        right = vbox(self.top_bar, (self.splitter, 1), self.guide, self.banner, spacing=0)
        centre = QWidget()
        hbox(self.side_bar, (right, 1), of=centre, margins=NO_MARGINS, spacing=0)
        self.setCentralWidget(centre)

    def _connect(self) -> None:
        flight = self.workspace.flight
        flight.viewed.connect(self._show_possible)
        flight.begun.connect(self._show_title)
        flight.arguments_wanted.connect(self._ask_for_arguments)
        flight.asks_first = self._ask_to_save
        flight.phase_changed.connect(lambda phase: self._show_possible(flight.view))
        self.recorder.changed.connect(self._show_recording)
        self.stack.completed.connect(spare_collector)
        self.stack.switched.connect(self.side_bar.mark)
        self.workspace.log.what_if_wanted.connect(self._show_what_if)
        self.workspace.preferences.changed.connect(lambda name: self._show_theme())
        self._able: frozenset[str] | None = None
        self._show_possible(flight.view)
        self._show_theme()

    def _show_possible(self, view: LiveView) -> None:
        """Disable actions that have no effect now; stop is always enabled."""
        paused = self.actions_by_name["pause"]
        if paused.isChecked() != (view.phase is Phase.PAUSED):
            paused.setChecked(view.phase is Phase.PAUSED)
        able = possible(view)
        if able == self._able:
            return
        self._able = able
        for name in ("arm", "take_off", "hold", "land", "pause", "step", "reset", "record"):
            self.actions_by_name[name].setEnabled(name in able)
        for factor in SPEEDS:
            self.actions_by_name[f"speed_{factor:g}"].setEnabled("speed" in able)
        self.top_bar.speed.setEnabled("speed" in able)

    def _show_title(self, view: LiveView) -> None:
        title = view.scenario.title if view.scenario else ""
        vehicle = view.vehicle.name if view.vehicle else ""
        parts = (plain_name(title), plain_name(vehicle), TITLE)
        self.setWindowTitle(" \N{EM DASH} ".join(filter(None, parts)))

    def _pause(self) -> None:
        self._show_possible(self.workspace.flight.view)  # the mark follows the flight, not the key
        self.control.pause()

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
        for theme in THEMES:
            self.actions_by_name[f"theme_{theme}"].setChecked(theme == chosen)

    def _show_in_charts(self, method: str, path: Path) -> None:
        self.show_screen("visualization")
        opens = getattr(self.stack.current, method, None)
        if opens is None:
            self.workspace.notices.warn("this version of the app cannot show such files")
        else:
            opens(path)

    def _ask_for_arguments(self, what: Choice | Scenario, needed: Sequence[XacroArgument]) -> None:
        """Ask for missing arguments of a drone's file; the present flight continues."""
        model = what.model if isinstance(what, Choice) else what.vehicle.model
        name = Path(model).name or "The drone's description"

        def fly(values: Mapping[str, str]) -> None:
            self.control.fly(with_arguments(what, values))

        dialog = ArgumentsDialog(name, needed, fly, self)
        names = ", ".join(each.name for each in needed if each.default is None)
        dialog.rejected.connect(
            lambda: self.workspace.notices.warn(
                f"{name} was not opened: it needs values for {names}.",
                "Open it again to give them, or open another.",
            )
        )
        dialog.show()

    def _show_tuning(self) -> "GainEditor | None":
        """Show the tuning screen, and return its gains; None if it cannot be made."""
        screen = self._tuning_screen()
        return screen.gains if screen is not None else None

    def _show_what_if(self) -> None:
        screen = self._tuning_screen()
        if screen is not None:
            screen.tabs.setCurrentWidget(screen.what_if)

    def _tuning_screen(self) -> "TuningScreen | None":
        """Show the tuning screen, and return it; None if it cannot be made."""
        self.show_screen("tuning")
        return cast("TuningScreen | None", self.stack.screen_of("tuning"))

    def _toggle_beside(self) -> None:
        self._set_beside(not self.view3d.isVisibleTo(self))

    def _set_beside(self, beside: bool) -> None:
        self.view3d.setVisible(beside)
        self.actions_by_name["view_3d"].setChecked(beside)

    def _look(self, way: str) -> None:
        self.view3d.look(way)

    def _toggle_full_screen(self) -> None:
        self.setWindowState(self.windowState() ^ Qt.WindowState.WindowFullScreen)
        self.actions_by_name["full_screen"].setChecked(self.isFullScreen())

    def _quit(self) -> None:
        self._ask_to_save(self.close)

    def _unsaved(self) -> Screen | None:
        """Return the screen with data that would be lost with the flight."""
        return next((screen for screen in self.stack.screens if screen.unsaved()), None)

    def _ask_to_save(self, go_on: Callable[[], object]) -> None:
        """Continue with what ends the flight, once nothing would be lost or the user agrees.

        It does not ask because of a flight in the air: that can be repeated, and its log is
        completed. The question is not modal: the flight continues, and F12 stops the rotors.
        """
        if self._question is not None:
            self._question.close()
        screen = self._unsaved()
        if screen is None:
            go_on()
            return
        kinds = QMessageBox.StandardButton
        box = QMessageBox(
            QMessageBox.Icon.Question,
            "Unsaved gains",
            plain_text(screen.unsaved()),
            kinds.Save | kinds.Discard | kinds.Cancel,
            self,
        )
        box.setTextFormat(Qt.TextFormat.PlainText)
        box.setModal(False)
        save, discard = box.button(kinds.Save), box.button(kinds.Discard)
        assert save is not None and discard is not None
        save.setText("&Save…")
        save.clicked.connect(lambda: screen.save_unsaved(go_on))
        discard.clicked.connect(lambda: go_on())
        box.finished.connect(self._forget_question)
        self._question = box
        box.show()

    def _forget_question(self) -> None:
        if self._question is not None:
            self._question.deleteLater()
            self._question = None

    def _begin(self) -> None:
        """Make the screens, once the window is visible."""
        if not self._closed:
            self.stack.setFocus()
            self.stack.make_ahead(self._first)

    def paintEvent(self, event: QPaintEvent | None) -> None:
        super().paintEvent(event)
        if not self._painted:
            self._painted = True
            QTimer.singleShot(0, self._begin)

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
            self._keep_places()
            self.hide()
            self._end_log()
            self.stack.close_screens()
            self.view3d.close_view()
            self._camera.close()
            self.workspace.close()
        super().closeEvent(event)

    def _end_log(self) -> None:
        """End a recording properly, quickly enough that the user does not notice."""
        live = self.workspace.flight.live
        if self.recorder.is_recording and live is not None:
            until = time.monotonic() + CLOSING
            ended = live.stop_log()
            while not ended.done() and time.monotonic() < until:
                time.sleep(0.01)

    def _keep_places(self) -> None:
        """Store the window's position and layout for the next start."""
        store = self._store
        # a start without 3-D does not change the stored value
        draws = self.workspace.flight.draws
        beside = self.view3d.isVisibleTo(self) if draws else self._was_beside()
        store.setValue(f"{GROUP}/geometry", self.saveGeometry())
        if beside:
            store.setValue(f"{GROUP}/splitter", self.splitter.saveState())
        store.setValue(f"{GROUP}/screen", self.stack.name or self._first)
        store.setValue(f"{GROUP}/beside", beside)
        store.sync()

    def _restore_places(self) -> None:
        """Restore the positions of window and splitter; invalid stored values are ignored."""
        for name, restore in (
            ("geometry", self.restoreGeometry),
            ("splitter", self.splitter.restoreState),
        ):
            kept = self._store.value(f"{GROUP}/{name}")
            if isinstance(kept, QByteArray):
                restore(kept)

    def _last_screen(self) -> str:
        """Return the name of the last screen."""
        try:
            return find_screen(str(self._store.value(f"{GROUP}/screen", ""))).name
        except WorkbenchError:
            return SCREENS[0].name

    def _was_beside(self) -> bool:
        """Return whether the 3-D view was beside the screen."""
        return str(self._store.value(f"{GROUP}/beside", True)).lower() == "true"
