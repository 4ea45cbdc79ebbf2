"""The page of frames: a tree with the place of each."""

from PyQt6.QtCore import Qt
from PyQt6.QtWidgets import QHeaderView, QLineEdit, QTreeWidget, QTreeWidgetItem, QWidget

from workbench.common.plain_text import plain_name
from workbench.common.quantity import number_text
from workbench.gui.labels import Label, tip_text
from workbench.gui.layout import buddy, named, vbox
from workbench.gui.poses import frame_pairs, poses_in_parent, poses_in_world
from workbench.gui.units import unit_for
from workbench.gui.workspace import Workspace
from workbench.link.topics import PREFIX, Topic

MIN_DIGIT_PERIOD_S = 0.1
"""Digits that change faster are illegible [s]."""
FRAME_PLACE_DECIMALS = 3
"""Decimals of the place of a frame [m]: parts are mounted to the millimetre."""
FRAME_COLUMNS = ("Frame", "x", "y", "z", "Roll", "Pitch", "Yaw", "x in W", "y in W", "z in W")


class FramesPage(QWidget):
    """The tree of frames.

    Args:
        workspace: signals and units.
    """

    def __init__(self, workspace: Workspace) -> None:
        super().__init__()
        self._workspace = workspace
        self._pairs: tuple[tuple[str, str], ...] = ()
        self._items: dict[str, QTreeWidgetItem] = {}
        self._shown = -1.0
        self.search = named(QLineEdit(), "Find frame")
        self.search.setClearButtonEnabled(True)
        self.search.setPlaceholderText("part of a name")
        self.tree = named(QTreeWidget(), "Frames: pose in the parent, and place in W")
        self.tree.setColumnCount(len(FRAME_COLUMNS))
        self.tree.setUniformRowHeights(True)
        head = self.tree.header()
        if head is not None:
            head.setStretchLastSection(False)
            head.setSectionResizeMode(QHeaderView.ResizeMode.Stretch)
            head.setSectionResizeMode(0, QHeaderView.ResizeMode.ResizeToContents)
            head.setDefaultAlignment(Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)
        self.hint = Label("No flight has sent its frames yet.")
        name = buddy("Find fra&me", self.search, kind="")
        parts = (name, self.search, self.hint, (self.tree, 1))
        vbox(*parts, of=self, margins=(0, 8, 0, 0), spacing=6)
        self.search.textChanged.connect(self._filter)
        self._name_columns()
        workspace.preferences.changed.connect(self._on_preference)

    def begin(self, topics: tuple[Topic, ...]) -> None:
        """Show the frames of a new flight."""
        topic = next((each for each in topics if each.name == f"{PREFIX}frames"), None)
        self._pairs = frame_pairs(topic.about) if topic is not None else ()
        self._items.clear()
        self.tree.clear()
        self._shown = -1.0
        root = self.tree.invisibleRootItem()
        for parent, child in self._pairs:
            if parent not in self._items and root is not None:
                self._items[parent] = QTreeWidgetItem(root, [plain_name(parent)])
            self._items[child] = QTreeWidgetItem(self._items[parent], [plain_name(child)])
        for item in self._items.values():
            for column in range(1, len(FRAME_COLUMNS)):
                side = Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter
                item.setTextAlignment(column, side)
        self.tree.expandAll()
        self.hint.setVisible(not self._pairs)
        self._name_columns()
        self._filter(self.search.text())

    def refresh(self, now: float) -> None:
        """Show the newest poses."""
        if self._shown <= now < self._shown + MIN_DIGIT_PERIOD_S:
            return
        numbers = self._workspace.signals.newest("frames").get("poses")
        if not isinstance(numbers, tuple):
            return
        self._shown = now
        poses = poses_in_parent(numbers)
        world = poses_in_world(self._pairs, poses)
        angle = unit_for("rad", self._workspace.preferences)
        for (_, child), pose in zip(self._pairs, poses, strict=False):
            texts = [
                *(number_text(each, FRAME_PLACE_DECIMALS) for each in pose.p),
                *map(angle.number, pose.roll_pitch_yaw()),
                *(number_text(each, FRAME_PLACE_DECIMALS) for each in world[child].p),
            ]
            self._write(self._items[child], texts)

    def _write(self, item: QTreeWidgetItem, texts: list[str]) -> None:
        for column, text in enumerate(texts, 1):
            if item.text(column) != text:
                item.setText(column, text)

    def _on_preference(self, name: str) -> None:
        if name == "angle_unit":
            self._shown = -1.0
            self._name_columns()

    def _name_columns(self) -> None:
        angle = unit_for("rad", self._workspace.preferences).symbol
        self.tree.setHeaderLabels(
            [
                FRAME_COLUMNS[0],
                *(f"{name} m" for name in FRAME_COLUMNS[1:4]),
                *(f"{name} {angle}" for name in FRAME_COLUMNS[4:7]),
                *(f"{name} m" for name in FRAME_COLUMNS[7:]),
            ]
        )
        head = self.tree.headerItem()
        if head is not None:
            head.setTextAlignment(0, Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter)
            for column, name in enumerate(FRAME_COLUMNS[1:7], 1):
                head.setToolTip(column, tip_text(f"{name} in the parent frame"))

    def _filter(self, text: str) -> None:
        """Hide frames without the text in their own name or in one below them."""
        wanted = text.lower()
        for item in self._items.values():
            item.setHidden(not _has(item, wanted))


def _has(item: QTreeWidgetItem, wanted: str) -> bool:
    below = (item.child(index) for index in range(item.childCount()))
    return wanted in item.text(0).lower() or any(
        _has(each, wanted) for each in below if each is not None
    )
