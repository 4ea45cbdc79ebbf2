"""The start page: what can be flown and what was flown, as cards with pictures."""

from collections.abc import Mapping
from functools import partial
from pathlib import Path

from PyQt6.QtCore import QPoint, QRect, QSize, Qt
from PyQt6.QtGui import QIcon, QPainter, QShowEvent
from PyQt6.QtWidgets import QFrame, QToolButton, QWidget

from workbench.common.plain_text import plain_name
from workbench.common.resources import find_model, find_scenario, list_models, list_scenarios
from workbench.gui.click_guard import ClickGuard
from workbench.gui.flow_layout import FlowLayout
from workbench.gui.help import set_card_help
from workbench.gui.labels import menu_text, set_tip
from workbench.gui.layout import NO_MARGINS, button, hbox, label, scrolled, vbox
from workbench.gui.preferences import log_folder
from workbench.gui.recent_files import FileKind
from workbench.gui.screens import Screen
from workbench.gui.start.data_sheet_dialog import DataSheetDialog
from workbench.gui.start.sketch import PLACEHOLDER_SKETCHES, Sketch, sketch_pixmap
from workbench.gui.start.sketches import Sketches
from workbench.gui.theme import Look
from workbench.gui.workspace import Workspace
from workbench.live.view import LiveView

CARD_PICTURE_SIZE_PX = (168, 96)
START_CARD_SPACING_PX = 10
START_CARD_PADDING_PX = 13
UNREADABLE_TEXT = "could not be read"
NO_FLIGHTS_TEXT = "No flight was recorded or opened yet: press Record, or open a log."


def shown_name(path: Path) -> str:
    """Return the name of a file without its endings; a log's stays whole."""
    return path.name.partition(".")[0] if path.suffix in (".xacro", ".urdf", ".yaml") else path.name


class FileCard(QToolButton):
    """A picture with a name below it, which opens a file.

    Args:
        kind: kind of the file.
        path: its path.
        name: its shown name.
        look: source of colours.
    """

    def __init__(self, kind: FileKind, path: Path, name: str, look: Look) -> None:
        super().__init__()
        self.path, self.name, self._look = path, name, look
        self._sketch, self._fades = PLACEHOLDER_SKETCHES[kind], True
        self._fault = ""
        ClickGuard(self)
        self.setProperty("class", "card")
        self.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextUnderIcon)
        self.setIconSize(QSize(*CARD_PICTURE_SIZE_PX))
        room = CARD_PICTURE_SIZE_PX[0]
        elided = self.fontMetrics().elidedText(menu_text(name), Qt.TextElideMode.ElideMiddle, room)
        self.setText(elided)
        self.setFixedWidth(room + 2 * START_CARD_PADDING_PX)
        self.setAccessibleName(f"{kind.label} {plain_name(name)}")
        set_tip(self, str(path))
        self._look.changed.connect(self._draw)
        self._draw()

    def show_sketch(self, sketch: Sketch) -> None:
        """Show its picture, or over a placeholder that the file cannot be read."""
        self._fault = sketch.fault
        if sketch.points:
            self._sketch, self._fades = sketch, False
        if said := f"{UNREADABLE_TEXT}: {sketch.fault}" if sketch.fault else sketch.said:
            set_tip(self, f"{said}\n{self.path}")
            self.setAccessibleDescription(plain_name(said))
        self._draw()

    def _draw(self) -> None:
        ratio, look = self.devicePixelRatioF(), self._look
        made = sketch_pixmap(self._sketch, look, *CARD_PICTURE_SIZE_PX, ratio, fades=self._fades)
        if self._fault:
            painter = QPainter(made)
            painter.setPen(look.colour("warning"))
            painter.drawText(
                QRect(QPoint(), self.iconSize()), Qt.AlignmentFlag.AlignCenter, UNREADABLE_TEXT
            )
            painter.end()
        self.setIcon(QIcon(made))


class FileGroup(QFrame):
    """Files of a kind below a heading.

    Args:
        kind: the kind.
        title: the heading.
        help: what a click does.
        workspace: colours, and opens the file of a card that is clicked.

    Attributes:
        kind: the kind.
    """

    def __init__(self, kind: FileKind, title: str, help: str, workspace: Workspace) -> None:
        super().__init__()
        self.kind, self._workspace = kind, workspace
        self.setProperty("class", "card")
        set_card_help(self, f"Start: {title}")
        self.cards: list[FileCard] = []
        self.nothing = label("", "muted", wraps=True)
        holder = QWidget()
        self._flow = FlowLayout(holder, spacing=START_CARD_SPACING_PX)
        head = hbox(label(title, "heading"), (label(help, "muted"), 1))
        vbox(head, self.nothing, holder, of=self, margins=(12, 8, 12, 10), spacing=6)

    def show_files(self, files: Mapping[Path, str], nothing: str = "") -> None:
        """Show files, by their paths and names; cards of known ones stay."""
        known = {(card.path, card.name): card for card in self.cards}
        for card in self.cards:
            self._flow.removeWidget(card)
            if files.get(card.path) != card.name:
                card.deleteLater()
        self.cards = [known.get(file) or self._make(*file) for file in files.items()]
        for card in self.cards:
            self._flow.addWidget(card)
            card.show()
        self.nothing.setText(nothing)
        self.nothing.setVisible(not self.cards)

    def _make(self, path: Path, name: str) -> FileCard:
        card = FileCard(self.kind, path, name, self._workspace.look)
        card.clicked.connect(lambda: self._workspace.recent.wanted.emit(self.kind, path))
        return card


class StartScreen(Screen):
    """Drones, scenarios and recent flights, and every way to another flight, in one place.

    Args:
        workspace: services that all screens share.

    Attributes:
        drones, scenarios, flights: groups of cards.
        sketches: source of the cards' pictures.
    """

    def __init__(self, workspace: Workspace) -> None:
        super().__init__(workspace)
        self._shipped: dict[FileKind, dict[Path, str]] = {
            FileKind.MODEL: {find_model(name): name for name in list_models()},
            FileKind.SCENARIO: {find_scenario(name): name for name in list_scenarios()},
            FileKind.LOG: {},
        }
        self.sketches = Sketches(self)
        self.sketches.ready.connect(self._show_sketch)
        ask = workspace.recent.choice_wanted.emit
        self.open_scenario = button("Open &scenario…", partial(ask, FileKind.SCENARIO))
        self.open_drone = button("Open &drone…", partial(ask, FileKind.MODEL))
        self.open_log = button("Open lo&g…", partial(ask, FileKind.LOG))
        help = "Write the description of a multirotor from its data sheet, and fly it"
        self.new_drone = button("&New drone from a data sheet…", self._ask_sheet, "primary", help)
        self._groups = tuple(
            FileGroup(kind, title, help, workspace)
            for kind, title, help in (
                (FileKind.MODEL, "Drones", "A click flies one in the present scenario."),
                (FileKind.SCENARIO, "Scenarios", "A click starts it."),
                (FileKind.LOG, "Recent flights", "A click shows it in charts."),
            )
        )
        self.drones, self.scenarios, self.flights = self._groups
        page = QWidget()
        ways = QWidget()
        row = FlowLayout(ways)
        for each in (self.new_drone, self.open_scenario, self.open_drone, self.open_log):
            row.addWidget(each)
        vbox(ways, *self._groups, 1, of=page, margins=(12, 10, 12, 12), spacing=10)
        vbox(scrolled(page), of=self, margins=NO_MARGINS)
        workspace.recent.changed.connect(self._show_files)
        self._show_files()

    def begin(self, view: LiveView) -> None:
        """Do nothing: what flies now has its own screens."""

    def showEvent(self, event: QShowEvent | None) -> None:
        """Draw the pictures that are missing."""
        super().showEvent(event)
        self._ask_sketches()

    def close_screen(self) -> None:
        """End the process that draws."""
        self.sketches.close()

    def _show_files(self) -> None:
        recent = self.workspace.recent.files()
        for group in self._groups:
            paths = [Path(path) for kind, path in recent if kind is group.kind]
            named = self._shipped[group.kind]
            own = {path: shown_name(path) for path in paths if path not in named}
            group.show_files(own | named, NO_FLIGHTS_TEXT if group is self.flights else "")
        if self.isVisible():
            self._ask_sketches()

    def _ask_sketches(self) -> None:
        for group in self._groups:
            for card in group.cards:
                self.sketches.ask(group.kind, card.path)

    def _show_sketch(self, path: Path, sketch: Sketch) -> None:
        for group in self._groups:
            for card in group.cards:
                if card.path == path:
                    card.show_sketch(sketch)

    def _ask_sheet(self) -> None:
        """Ask for a data sheet; the flight, and the key that stops it, keep working."""
        dialog = DataSheetDialog(log_folder(self.workspace.preferences), self.window())
        dialog.written.connect(partial(self.workspace.recent.wanted.emit, FileKind.MODEL))
        dialog.show()
