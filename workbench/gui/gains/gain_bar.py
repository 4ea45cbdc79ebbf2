"""The bar above the gains: the gain file, its state, undo, and slots."""

from collections.abc import Callable
from functools import partial
from pathlib import Path

from PyQt6.QtCore import Qt, pyqtSignal
from PyQt6.QtWidgets import (
    QInputDialog,
    QMenu,
    QToolButton,
    QWidget,
)

from workbench.control.schedule import SCHEDULE_QUANTITIES
from workbench.gains.formats import gain_format_names, gain_formats
from workbench.gui.command_action import make_actions
from workbench.gui.file_dialogs import clipboard, open_file, save_file
from workbench.gui.gains.gain_actions import GAIN_ACTIONS, GAIN_MENU_ACTIONS, GAIN_SLOTS
from workbench.gui.gains.gain_editor import GainEditor
from workbench.gui.gains.gain_file_diff_view import GainFileDiffView
from workbench.gui.gains.gain_files import MODEL_GAIN_FILE, GainFiles
from workbench.gui.labels import FixedLinesLabel, WrappedName, set_tip
from workbench.gui.layout import (
    hbox,
    label,
    menu_button,
    named,
    tool_button,
    vbox,
)
from workbench.gui.style import set_class, with_class
from workbench.gui.units import gain_text
from workbench.gui.workspace import Workspace

MAX_FILE_NAME_CHARACTERS = 20
"""Largest length of a gain file's name; the tool tip has the rest."""
GAIN_FILE_FILTER = "Gain files (*.yaml *.yml)"
GAIN_BAR_STYLE = """
GainBar > QToolButton { min-height: 18px; padding: 3px 5px; }
GainBar > QToolButton:focus, GainBar > QToolButton:checked { padding: 2px 4px; }
"""
MAX_SLOT_DIFFERENCES = 4
"""Largest number of gains that the tip of a slot lists."""
GAIN_STATE_LINES = 2
"""Height of the state of the gains, in lines: it moves nothing, whatever it says."""
BUTTON_PADDING_PX = 12
"""Padding around the text of a button [px]."""


def _autopilot_files() -> str:
    """Return the filter of a dialog for files of autopilots' parameters."""
    suffixes = " ".join(f"*{each}" for found in gain_formats() for each in found.suffixes)
    return f"Parameters of autopilots ({suffixes});;All files (*)"


class GainBar(QWidget):
    """Keeps, reverts, undoes, compares, loads and saves, and shows the state.

    Its keys work anywhere in the window while the bar is shown.

    Args:
        workspace: units, notices.
        editor: keeps, reverts, undoes and compares.
        gain_files: loads and saves.

    Attributes:
        actions_by_name: actions of the table `GAIN_ACTIONS`.
        buttons: buttons of the actions that have one.
    """

    history_wanted = pyqtSignal()
    """The history should be shown."""
    report_wanted = pyqtSignal()
    """The report of the session should be written."""

    def __init__(self, workspace: Workspace, editor: GainEditor, gain_files: GainFiles) -> None:
        super().__init__()
        self._workspace, self._editor, self._gain_files = workspace, editor, gain_files
        self.setAccessibleName("Gain file")
        self.setStyleSheet(GAIN_BAR_STYLE)
        window = Qt.ShortcutContext.WindowShortcut
        self.actions_by_name = make_actions(
            self, self._handlers(), workspace.keys, GAIN_ACTIONS, window
        )
        for name in ("import", "export"):
            self.actions_by_name[name].setVisible(bool(gain_format_names()))
        self.buttons: dict[str, QToolButton] = {}
        self._said: dict[str, str] = {}
        self.name, self.law = label(kind="heading"), WrappedName()
        self.state = named(FixedLinesLabel(GAIN_STATE_LINES), "State of the gains")
        self.state.setAlignment(Qt.AlignmentFlag.AlignTop)
        self.diff = GainFileDiffView(gain_files, workspace.preferences)
        changes = map(self._button, ("keep", "revert", "undo", "redo"))
        slots = (self._button(f"compare_{slot}") for slot in GAIN_SLOTS)
        doubted = map(self._button, ("discard", "confirm"))
        row = hbox(*changes, 0, *doubted, 0, *slots, spacing=3)
        menu = menu_button("Gain file ▾", "Files, clipboard and slots", self._fill_menu)
        top = hbox(self.name, (self.law, 1), with_class(menu, "compact"), spacing=4)
        vbox(top, self.state, row, self.diff, of=self, margins=(8, 6, 8, 2), spacing=3)
        for signal in (
            editor.state_changed,
            editor.flown_changed,
            editor.warning_changed,
            editor.value_refused,
            gain_files.named,
        ):
            signal.connect(self._show)
        self._show()

    def _show(self) -> None:
        editor = self._editor
        name = self._gain_files.name or "No gain file"
        short = (
            name
            if len(name) <= MAX_FILE_NAME_CHARACTERS
            else f"{name[: MAX_FILE_NAME_CHARACTERS - 1]}…"
        )
        law = self._editor.controller
        self.name.setText(short)
        self.law.setText(f"·\N{NO-BREAK SPACE}{law.name}")
        for part in (self.name, self.law):
            set_tip(part, f"{name}, with the controller {law.name} ({law.file})")
        said, tone = self._state()
        self.state.setText(said)
        set_tip(self.state, said)
        self.state.setAccessibleDescription(said)
        set_class(self.state, tone)
        flies = bool(editor.rows)
        works = {
            "keep": flies and bool(editor.tried),
            "discard": bool(editor.unflown),
            "confirm": bool(editor.warning),
            "undo": bool(editor.next_undo),
            "redo": bool(editor.next_redo),
        }
        for name, action in self.actions_by_name.items():
            action.setEnabled(works.get(name, flies))
        self._say("undo", f"Undo {editor.next_undo}")
        self._say("redo", f"Redo {editor.next_redo}")
        set_class(self.buttons["keep"], "compact primary" if works["keep"] else "compact")
        for slot in GAIN_SLOTS:
            stored = editor.slots.get(slot)
            button = self.buttons[f"compare_{slot}"]
            button.setCheckable(stored is not None)
            button.setChecked(stored is not None and stored == editor.proposed_gains)
            button.setText(slot if stored is None else f"{slot}•")
            self._say(f"compare_{slot}", self._slot_text(slot))
            verb = "Store in" if stored is None else "Replace"
            self.actions_by_name[f"store_{slot}"].setText(f"{verb} slot &{slot}")

    def _slot_text(self, slot: str) -> str:
        """Return what the button of a slot does."""
        if slot not in self._editor.slots:
            return f"Store the gains in slot {slot}"
        editor = self._editor
        differences = [
            f"{editor.words(name)} {gain_text(value)} (now {gain_text(editor.proposed[name])})"
            for name, value in editor.slots[slot].items()
            if value != editor.proposed[name]
        ]
        if not differences:
            said = f"Slot {slot} has the present gains"
            returns = editor.before_slot not in ({}, editor.proposed_gains)
            return f"{said}; return to those before it" if returns else said
        more = len(differences) - MAX_SLOT_DIFFERENCES
        shown = ", ".join(differences[:MAX_SLOT_DIFFERENCES])
        return f"Fly slot {slot}: {shown}{f', and {more} more' if more > 0 else ''}"

    def _state(self) -> tuple[str, str]:
        """Return the state of the gains in words, and its tone: what hinders them comes first."""
        editor = self._editor
        if not editor.rows:
            return "No gains yet", "muted"
        if editor.faults:
            *_, newest = editor.faults.values()
            return f"✕ {newest}".replace("^2", "²"), "bad"
        if editor.warning:
            return f"▲ Not flown: {editor.warning.rstrip('.')}.", "warning"
        saved = "Saved" if self._gain_files.name else "Unchanged"
        saved = "Unsaved" if self._gain_files.is_changed else saved
        entered = " (Enter flies)" if editor.unflown and not editor.is_at_once else ""
        return f"{saved} · {editor.summary()}{entered}", "muted"

    def _say(self, name: str, said: str) -> None:
        if self._said.get(name) == said:
            return
        self._said[name] = said
        shortcut = self.actions_by_name[name].shortcut().toString()
        set_tip(self.buttons[name], f"{said} ({shortcut})")
        self.buttons[name].setAccessibleName(said.strip())

    def _handlers(self) -> dict[str, Callable[[], None]]:
        editor, gain_files = self._editor, self._gain_files
        slots: dict[str, Callable[[], None]] = {}
        for slot in GAIN_SLOTS:
            slots[f"compare_{slot}"] = partial(editor.compare, slot)
            slots[f"store_{slot}"] = partial(editor.store, slot)
        return slots | {
            "keep": editor.keep,
            "revert": editor.revert,
            "undo": editor.undo,
            "redo": editor.redo,
            "discard": editor.discard,
            "confirm": editor.confirm,
            "load": self._load,
            "own": gain_files.load_own,
            "save": self._save,
            "history": self.history_wanted.emit,
            "report": self.report_wanted.emit,
            "copy": self._copy,
            "paste": self._paste,
            "schedule": self._schedule,
            "import": self._import,
            "export": self._export,
        }

    def _schedule(self) -> None:
        """Ask for a scheduling quantity and the values that get sets of gains."""
        schedule = self._editor.schedule
        dialog = QInputDialog(self)
        dialog.setWindowTitle("Schedule gains")
        dialog.setLabelText(
            "A set of gains at each of some values, and lines between them, as speed=0,4,8\n"
            f"({', '.join(each.name for each in SCHEDULE_QUANTITIES)}); nothing for one set:"
        )
        dialog.setTextValue(schedule.label if schedule else "speed=0,4,8")
        dialog.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        dialog.textValueSelected.connect(lambda text: self._editor.schedule_gains(text.strip()))
        dialog.open()

    def _load(self) -> None:
        ask_to_load(self, self._gain_files.load)

    def _import(self) -> None:
        title = "Import gains from an autopilot's file"
        open_file(self, title, self._gain_files.load_autopilot, kinds=_autopilot_files())

    def _export(self) -> None:
        title = "Export gains to an autopilot's file"  # everything in it but the gains stays
        save_file(self, title, self._gain_files.export, kinds=_autopilot_files())

    def _save(self) -> None:
        ask_to_save(self, self._write)

    def _write(self, path: Path) -> None:
        unflown = len(self._editor.unflown)
        self._gain_files.save(path)
        if unflown:
            self._workspace.notices.inform(
                f"The gains that fly are saved: {unflown} proposed but not flown, so not saved."
            )

    def _copy(self) -> None:
        clipboard().setText(self._gain_files.as_yaml())
        self._workspace.notices.inform("The gains that fly are on the clipboard, as YAML.")

    def _paste(self) -> None:
        self._gain_files.paste(clipboard().text())

    def _button(self, name: str) -> QToolButton:
        """Return the button of an action; Tab can focus it, too."""
        action = self.actions_by_name[name]
        made = tool_button(action.text(), action.trigger, "compact", action.toolTip())
        made.setParent(self)  # Tab goes to it before the menu
        made.setAccessibleName(action.statusTip())
        text = f"{action.text()}•" if name.startswith("compare") else action.text()
        width = self.fontMetrics().horizontalAdvance(f"{text.replace('&', '')}i")
        made.setFixedWidth(width + BUTTON_PADDING_PX)
        action.changed.connect(lambda: made.setEnabled(action.isEnabled()))
        if name.startswith("compare"):  # a right click stores
            made.addAction(self.actions_by_name[name.replace("compare", "store")])
            made.setContextMenuPolicy(Qt.ContextMenuPolicy.ActionsContextMenu)
        self.buttons[name] = made
        return made

    def _fill_menu(self, menu: QMenu) -> None:
        for name in GAIN_MENU_ACTIONS:
            if name:
                menu.addAction(self.actions_by_name[name])
            else:
                menu.addSeparator()


def ask_to_load(parent: QWidget, chosen: Callable[[Path], None]) -> None:
    """Show a dialog for an existing gain file.

    Args:
        parent: the Qt parent.
        chosen: called with the path.
    """
    open_file(parent, "Load gains", chosen, kinds=GAIN_FILE_FILTER)


def ask_to_save(parent: QWidget, chosen: Callable[[Path], None]) -> None:
    """Show a dialog for writing a gain file; an existing one gets another entry in its history.

    Args:
        parent: the Qt parent.
        chosen: called with the path.
    """
    save_file(parent, "Save gains", chosen, MODEL_GAIN_FILE, GAIN_FILE_FILTER).setDefaultSuffix(
        "yaml"
    )
