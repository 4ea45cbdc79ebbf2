"""Above the gains: the profile, what is kept, undo, slots, and files."""

from collections.abc import Callable
from functools import partial
from pathlib import Path

from PyQt6.QtGui import QAction, QGuiApplication, QKeySequence
from PyQt6.QtWidgets import (
    QHBoxLayout,
    QLabel,
    QMenu,
    QSizePolicy,
    QToolButton,
    QVBoxLayout,
    QWidget,
)

from workbench.gui.elided_label import ElidedLabel
from workbench.gui.gains.gain_desk import GainDesk
from workbench.gui.gains.gain_dialogs import ask_to_load, ask_to_save
from workbench.gui.gains.gain_slots import SLOTS
from workbench.gui.gains.offer_list import OfferList
from workbench.gui.gains.profile_actions import PROFILE_ACTIONS
from workbench.gui.style import set_class
from workbench.gui.workspace import Workspace

LONGEST_NAME = 20
"""Of a profile; the rest of it stands in the tool tip."""
COMPACT = """
ProfileBar > QToolButton { min-height: 18px; padding: 3px 5px; }
ProfileBar > QToolButton:focus, ProfileBar > QToolButton:checked { padding: 2px 4px; }
"""
PADDING = 12
"""Around the text of a button [px]."""
MENU = ("load", "own", "save", "", "copy", "paste", "", *(f"store_{slot}" for slot in SLOTS))


class ProfileBar(QWidget):
    """Keeps, reverts, undoes, compares, loads and saves, and says what the state is.

    Its keys work wherever the keyboard is in the window while the bar is shown.

    Args:
        workspace: units, notices.
        desk: does it.
        parent: whose life it shares.

    Attributes:
        actions_by_name: of the table `PROFILE_ACTIONS`.
        buttons: of those that have one.
    """

    def __init__(self, workspace: Workspace, desk: GainDesk, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._workspace, self._desk = workspace, desk
        self.setAccessibleName("Profile of gains")
        self.setStyleSheet(COMPACT)
        self.setSizePolicy(QSizePolicy.Policy.Preferred, QSizePolicy.Policy.Maximum)
        self.actions_by_name = self._make_actions()
        self.buttons: dict[str, QToolButton] = {}
        self._said: dict[str, str] = {}
        self.name = QLabel(self)
        self.state = ElidedLabel(self)
        self.offer = OfferList(desk.profiles, workspace.preferences, self)
        self._lay_out()
        desk.state_changed.connect(self._show)
        desk.flown_changed.connect(self._show)
        self._show()

    def _show(self) -> None:
        desk = self._desk
        profile = desk.profiles.name or "No profile"
        short = profile if len(profile) <= LONGEST_NAME else f"{profile[: LONGEST_NAME - 1]}…"
        changed = " ◆ changed" if desk.profiles.is_changed else ""
        self.name.setText(f"<b>{short}</b>{changed}")
        self.name.setToolTip(profile)
        said = desk.said()
        entered = "" if desk.is_at_once or not desk.unflown or desk.doubt else " (Enter flies)"
        self.state.setText(said + entered)
        flies = bool(desk.rows)
        works = {
            "keep": flies and bool(desk.tried),
            "undo": bool(desk.next_undo),
            "redo": bool(desk.next_redo),
        }
        for name, action in self.actions_by_name.items():
            action.setEnabled(works.get(name, flies))
        self._say("undo", f"Undo {desk.next_undo}")
        self._say("redo", f"Redo {desk.next_redo}")
        set_class(self.buttons["keep"], "compact primary" if works["keep"] else "compact")
        shown = {name: desk.proposed[name] for name in desk.profile_names}
        for slot in SLOTS:
            stored = desk.slots.get(slot)
            button = self.buttons[f"compare_{slot}"]
            button.setCheckable(stored is not None)
            button.setChecked(stored is not None and stored == shown)
            does = "Store the gains in" if stored is None else "Compare with"
            button.setText(slot if stored is None else f"{slot}•")
            self._say(f"compare_{slot}", f"{does} slot {slot}")

    def _say(self, name: str, said: str) -> None:
        if self._said.get(name) == said:
            return
        self._said[name] = said
        shortcut = self.actions_by_name[name].shortcut().toString()
        self.buttons[name].setToolTip(f"{said} ({shortcut})")
        self.buttons[name].setAccessibleName(said.strip())

    def _make_actions(self) -> dict[str, QAction]:
        handlers = self._handlers()
        made = {}
        for row in PROFILE_ACTIONS:
            action = QAction(row.text, self)
            action.setShortcut(QKeySequence(row.shortcut))
            action.setToolTip(row.tip)
            action.setStatusTip(row.help)
            action.setAutoRepeat(row.name in ("undo", "redo"))
            action.triggered.connect(lambda _checked, handler=handlers[row.name]: handler())
            self.addAction(action)
            made[row.name] = action
        return made

    def _handlers(self) -> dict[str, Callable[[], None]]:
        desk = self._desk
        slots: dict[str, Callable[[], None]] = {}
        for slot in SLOTS:
            slots[f"compare_{slot}"] = partial(self._compare, slot)
            slots[f"store_{slot}"] = partial(desk.store, slot)
        return slots | {
            "keep": desk.keep,
            "revert": desk.revert,
            "undo": desk.undo,
            "redo": desk.redo,
            "load": self._load,
            "own": desk.profiles.load_own,
            "save": self._save,
            "copy": self._copy,
            "paste": self._paste,
        }

    def _compare(self, slot: str) -> None:
        """Let an empty slot have the gains; compare with one that has some."""
        if slot in self._desk.slots:
            self._desk.recall(slot)
        else:
            self._desk.store(slot)

    def _load(self) -> None:
        ask_to_load(self, "", self._desk.load)

    def _save(self) -> None:
        ask_to_save(self, "gains.yaml", self._write)

    def _write(self, path: Path) -> None:
        unflown = len(self._desk.unflown)
        self._desk.save(path, f"tuned in flight, from {self._desk.profiles.name}")
        if unflown:
            self._workspace.notices.inform(
                f"What flies is saved: {unflown} proposed and not flown, and so not in it."
            )

    def _copy(self) -> None:
        clipboard = QGuiApplication.clipboard()
        assert clipboard is not None
        clipboard.setText(self._desk.as_yaml())
        self._workspace.notices.inform("The gains that fly are on the clipboard, as YAML.")

    def _paste(self) -> None:
        clipboard = QGuiApplication.clipboard()
        assert clipboard is not None
        self._desk.profiles.paste(clipboard.text())

    def _button(self, name: str) -> QToolButton:
        """Return the button of an action; it has the focus by Tab, too."""
        action = self.actions_by_name[name]
        button = QToolButton(self)
        button.setText(action.text())
        button.setToolTip(action.toolTip())
        button.setAccessibleName(action.statusTip())
        button.setProperty("class", "compact")
        text = f"{action.text()}•" if name.startswith("compare") else action.text()
        button.setFixedWidth(self.fontMetrics().horizontalAdvance(text) + PADDING)
        button.clicked.connect(action.trigger)
        action.changed.connect(lambda: button.setEnabled(action.isEnabled()))
        self.buttons[name] = button
        return button

    def _menu(self, text: str, said: str, names: tuple[str, ...]) -> QToolButton:
        button = QToolButton(self)
        button.setText(f"{text} ▾")
        button.setAccessibleName(said)
        button.setProperty("class", "compact")
        button.setPopupMode(QToolButton.ToolButtonPopupMode.InstantPopup)
        menu = QMenu(button)
        menu.setToolTipsVisible(True)
        for name in names:
            if name:
                menu.addAction(self.actions_by_name[name])
            else:
                menu.addSeparator()
        button.setMenu(menu)
        return button

    def _lay_out(self) -> None:
        self.state.setProperty("class", "muted")
        self.state.setAccessibleName("State of the gains")
        row = QHBoxLayout()
        row.setSpacing(3)
        for name in ("keep", "revert", "undo", "redo"):
            row.addWidget(self._button(name))
        row.addStretch()
        for slot in SLOTS:
            row.addWidget(self._button(f"compare_{slot}"))
        top = QHBoxLayout()
        top.addWidget(self.name, 1)
        top.addWidget(self._menu("Profile", "Files, clipboard and slots", MENU))
        layout = QVBoxLayout(self)
        layout.setContentsMargins(8, 6, 8, 2)
        layout.setSpacing(3)
        layout.addLayout(top)
        layout.addWidget(self.state)
        layout.addLayout(row)
        layout.addWidget(self.offer)
