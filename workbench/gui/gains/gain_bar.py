"""The bar above the gains: the gain file, its state, undo, and slots."""

from collections.abc import Callable
from functools import partial
from pathlib import Path

from PyQt6.QtCore import Qt
from PyQt6.QtWidgets import (
    QCheckBox,
    QFrame,
    QInputDialog,
    QMenu,
    QSizePolicy,
    QToolButton,
    QWidget,
)

from workbench.common.plain_text import plain_name
from workbench.control.schedule import QUANTITIES
from workbench.gains.gains import GainChange
from workbench.gui.actions import ActionRow, make_actions
from workbench.gui.file_dialogs import clipboard, open_file, save_file
from workbench.gui.gains.gain_editor import SLOTS, GainEditor
from workbench.gui.gains.gain_files import OWN, GainFileDiff, GainFiles, percent_text
from workbench.gui.labels import ElidedLabel, set_tip
from workbench.gui.layout import (
    button,
    grid,
    hbox,
    label,
    menu_button,
    named,
    scroll_area,
    tool_button,
    vbox,
)
from workbench.gui.preferences import Preferences
from workbench.gui.style import dressed, set_class
from workbench.gui.units import unit_for
from workbench.gui.workspace import Workspace

TALLEST = 240
"""Largest height of the list; longer ones scroll [px]."""
LONGEST_NAME = 20
"""Largest length of a gain file's name; the tool tip has the rest."""
FILTER = "Gain files (*.yaml *.yml)"
AUTOPILOTS = "Parameters of autopilots (*.params *.param *.parm *.txt *.yaml *.json);;All files (*)"
COMPACT = """
GainBar > QToolButton { min-height: 18px; padding: 3px 5px; }
GainBar > QToolButton:focus, GainBar > QToolButton:checked { padding: 2px 4px; }
"""
PADDING = 12
"""Padding around the text of a button [px]."""
MENU = (
    "load",
    "own",
    "save",
    "",
    "copy",
    "paste",
    "",
    "import",
    "export",
    "",
    "schedule",
    "",
    *(f"store_{slot}" for slot in SLOTS),
)


class GainFileDiffView(QFrame):
    """Shows a loaded gain file until the user takes some of it, or dismisses it.

    Args:
        gain_files: compares gain files.
        preferences: units.

    Attributes:
        ticks: tick boxes of the lines, by the parameter's name.
    """

    def __init__(self, gain_files: GainFiles, preferences: Preferences) -> None:
        super().__init__()
        self._gain_files, self._preferences = gain_files, preferences
        self.ticks: dict[str, QCheckBox] = {}
        self.setProperty("class", "card")
        self.setSizePolicy(QSizePolicy.Policy.Preferred, QSizePolicy.Policy.Maximum)
        self.said = label(wraps=True)
        self._area = scroll_area(sideways=False)
        self.fly = button("", self._take, "primary")
        self.none = button("&Tick none", self._tick_others)
        self.back = button("Take &nothing", gain_files.dismiss)
        buttons = hbox(self.none, 0, self.back, self.fly, spacing=6)
        vbox(self.said, self._area, buttons, of=self, margins=(8, 6, 8, 6), spacing=5)
        gain_files.diff_changed.connect(self._show)
        self.hide()

    def _show(self, diff: GainFileDiff | None) -> None:
        if diff is None:
            self.hide()
            return
        origin = f": {diff.origin}" if diff.origin else ""
        self.said.setText(f"{len(diff.changes)} of {plain_name(diff.name)} differ{origin}")
        content = QWidget()
        self.ticks = {}
        rows = map(self._make_row, diff.changes)
        grid(*rows, of=content, margins=(0, 0, 4, 0), spacing=(10, 2), stretches=(1,))
        self._area.setWidget(content)
        self._area.setFixedHeight(min(TALLEST, content.sizeHint().height() + 2))
        self._count()
        self.show()
        self.fly.setFocus()

    def _make_row(self, change: GainChange) -> list[QWidget]:
        words = self._gain_files.words(change.name)
        unit = unit_for(change.unit, self._preferences)
        a, b = (f"{unit.shown(value):.4g}" for value in (change.a, change.b))
        tick = QCheckBox(words)
        refused = self._gain_files.diff.refused if self._gain_files.diff else None
        tick.setChecked(refused is None or change.name in refused)
        set_tip(tick, change.name)
        tick.setAccessibleName(f"{words}: {a} becomes {b} {unit.symbol}")
        tick.toggled.connect(self._count)
        self.ticks[change.name] = tick
        right = Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter
        row: list[QWidget] = [tick]
        for text in (a, "→", b, unit.symbol, percent_text(change)):
            part = label(text, "muted" if text in ("→", unit.symbol) else "")
            part.setAlignment(Qt.AlignmentFlag.AlignVCenter if text == unit.symbol else right)
            row.append(part)
        return row

    def _count(self) -> None:
        """Show the number of ticked lines."""
        ticked = sum(tick.isChecked() for tick in self.ticks.values())
        diff = self._gain_files.diff
        writes = diff is not None and diff.target is not None
        self.fly.setText(f"{'&Write' if writes else '&Fly'} {ticked} ticked")
        if diff is not None and diff.refused == set(self._ticked()):
            self.fly.setText(f"&Write {ticked} anyway")
        self.fly.setEnabled(ticked > 0)
        self.none.setText("&Tick none" if ticked else "&Tick all")

    def _tick_others(self) -> None:
        """Tick no line, or all if none is ticked."""
        some = any(tick.isChecked() for tick in self.ticks.values())
        for tick in self.ticks.values():
            tick.setChecked(not some)

    def _take(self) -> None:
        self._gain_files.take(self._ticked())

    def _ticked(self) -> list[str]:
        return [name for name, tick in self.ticks.items() if tick.isChecked()]


GAIN_ACTIONS: tuple[ActionRow, ...] = (
    ActionRow(
        "keep", "", "&Keep", "Keep the gains that fly, so that Revert restores them.", "Ctrl+K"
    ),
    ActionRow(
        "revert",
        "",
        "Re&vert",
        "Fly the kept gains at once, in any case.",
        "Ctrl+Shift+K",
    ),
    ActionRow("undo", "", "↶", "Undo the last change.", "Ctrl+Z"),
    ActionRow("redo", "", "↷", "Redo the change that was undone.", "Ctrl+Shift+Z"),
    *(
        ActionRow(
            f"compare_{slot}",
            "",
            slot,
            f"Fly the gains of slot {slot}; press again to go back. An empty slot stores those "
            "shown.",
            f"F{number}",
        )
        for number, slot in enumerate(SLOTS, start=2)
    ),
    *(
        ActionRow(
            f"store_{slot}",
            "",
            f"Store in slot &{slot}",
            f"Store the gains that are shown in slot {slot}.",
            f"Shift+F{number}",
        )
        for number, slot in enumerate(SLOTS, start=2)
    ),
    ActionRow(
        "load",
        "",
        "&Load...",
        "Choose gains from a gain file; none flies until you confirm.",
        "Ctrl+Shift+L",
    ),
    ActionRow(
        "own",
        "",
        "&Model's own...",
        "Choose gains from those of the model.",
        "Ctrl+Shift+M",
    ),
    ActionRow("save", "", "&Save...", "Write the gains that fly to a gain file.", "Ctrl+S"),
    ActionRow(
        "copy",
        "",
        "&Copy YAML",
        "Copy the gains that fly as the text of a gain file.",
        "Ctrl+Shift+C",
    ),
    ActionRow(
        "import",
        "",
        "&Import from autopilot...",
        "Choose gains from an autopilot's parameter file; none flies until you confirm.",
        "Ctrl+Shift+I",
    ),
    ActionRow(
        "export",
        "",
        "&Export to autopilot...",
        "Write the gains that fly to an autopilot's file; all else in it stays.",
        "Ctrl+Shift+E",
    ),
    ActionRow(
        "schedule",
        "",
        "Sc&hedule...",
        "Use a set of gains at each of some speeds, heights, payloads or voltages.",
        "Ctrl+Shift+H",
    ),
    ActionRow(
        "paste", "", "&Paste YAML...", "Choose gains from the text of a gain file.", "Ctrl+Shift+V"
    ),
)


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

    def __init__(self, workspace: Workspace, editor: GainEditor, gain_files: GainFiles) -> None:
        super().__init__()
        self._workspace, self._editor, self._gain_files = workspace, editor, gain_files
        self.setAccessibleName("Gain file")
        self.setStyleSheet(COMPACT)
        self.setSizePolicy(QSizePolicy.Policy.Preferred, QSizePolicy.Policy.Maximum)
        window = Qt.ShortcutContext.WindowShortcut
        self.actions_by_name = make_actions(self, self._handlers(), GAIN_ACTIONS, window)
        self.buttons: dict[str, QToolButton] = {}
        self._said: dict[str, str] = {}
        self.name, self.law = label(kind="heading"), ElidedLabel()
        self.state = named(dressed(ElidedLabel(), "muted"), "State of the gains")
        self.diff = GainFileDiffView(gain_files, workspace.preferences)
        changes = map(self._button, ("keep", "revert", "undo", "redo"))
        slots = (self._button(f"compare_{slot}") for slot in SLOTS)
        row = hbox(*changes, 0, *slots, spacing=3)
        menu = menu_button("Gain file ▾", "Files, clipboard and slots", self._fill_menu)
        top = hbox(self.name, (self.law, 1), dressed(menu, "compact"))
        vbox(top, self.state, row, self.diff, of=self, margins=(8, 6, 8, 2), spacing=3)
        for signal in (editor.state_changed, editor.flown_changed, gain_files.named):
            signal.connect(self._show)
        self._show()

    def _show(self) -> None:
        editor = self._editor
        name = self._gain_files.name or "No gain file"
        short = name if len(name) <= LONGEST_NAME else f"{name[: LONGEST_NAME - 1]}…"
        changed = "◆ changed " if self._gain_files.is_changed else ""
        law = self._editor.table.controller
        self.name.setText(short)
        self.law.setText(f"{changed}· {law.name}")
        for part in (self.name, self.law):
            set_tip(part, f"{name}, with the controller {law.name} ({law.file})")
        said = editor.summary()
        entered = (
            "" if editor.is_at_once or not editor.unflown or editor.warning else " (Enter flies)"
        )
        self.state.setText(said + entered)
        flies = bool(editor.rows)
        works = {
            "keep": flies and bool(editor.tried),
            "undo": bool(editor.next_undo),
            "redo": bool(editor.next_redo),
        }
        for name, action in self.actions_by_name.items():
            action.setEnabled(works.get(name, flies))
        self._say("undo", f"Undo {editor.next_undo}")
        self._say("redo", f"Redo {editor.next_redo}")
        set_class(self.buttons["keep"], "compact primary" if works["keep"] else "compact")
        for slot in SLOTS:
            stored = editor.slots.get(slot)
            button = self.buttons[f"compare_{slot}"]
            button.setCheckable(stored is not None)
            button.setChecked(stored is not None and stored == editor.proposed_gains)
            does = "Store the gains in" if stored is None else "Compare with"
            button.setText(slot if stored is None else f"{slot}•")
            self._say(f"compare_{slot}", f"{does} slot {slot}")

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
        for slot in SLOTS:
            slots[f"compare_{slot}"] = partial(editor.compare, slot)
            slots[f"store_{slot}"] = partial(editor.store, slot)
        return slots | {
            "keep": editor.keep,
            "revert": editor.revert,
            "undo": editor.undo,
            "redo": editor.redo,
            "load": self._load,
            "own": gain_files.load_own,
            "save": self._save,
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
            f"({', '.join(each.name for each in QUANTITIES)}); nothing for one set:"
        )
        dialog.setTextValue(schedule.label if schedule else "speed=0,4,8")
        dialog.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        dialog.textValueSelected.connect(lambda text: self._editor.schedule_gains(text.strip()))
        dialog.open()

    def _load(self) -> None:
        ask_to_load(self, self._gain_files.load)

    def _import(self) -> None:
        title = "Import gains from an autopilot's file"
        open_file(self, title, self._gain_files.load_autopilot, kinds=AUTOPILOTS)

    def _export(self) -> None:
        title = "Export gains to an autopilot's file"  # everything in it but the gains stays
        save_file(self, title, self._gain_files.export, kinds=AUTOPILOTS)

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
        made.setFixedWidth(self.fontMetrics().horizontalAdvance(text) + PADDING)
        action.changed.connect(lambda: made.setEnabled(action.isEnabled()))
        self.buttons[name] = made
        return made

    def _fill_menu(self, menu: QMenu) -> None:
        for name in MENU:
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
    open_file(parent, "Load gains", chosen, kinds=FILTER)


def ask_to_save(parent: QWidget, chosen: Callable[[Path], None]) -> None:
    """Show a dialog for writing a gain file; an existing one gets another entry in its history.

    Args:
        parent: the Qt parent.
        chosen: called with the path.
    """
    save_file(parent, "Save gains", chosen, OWN, FILTER).setDefaultSuffix("yaml")
