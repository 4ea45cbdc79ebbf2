"""Opens files: from a dialog, dropped onto the window, or from the recent ones."""

from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path

from PyQt6.QtWidgets import QFileDialog, QMenu, QWidget

from workbench.common.errors import WorkbenchError
from workbench.common.plain_files import read_plain
from workbench.common.resources import controllers_dir, models_dir, worlds_dir
from workbench.control.controller_file import load_controller
from workbench.gui.file_dialogs import log_file_filter, open_file
from workbench.gui.flight_control import FlightControl
from workbench.gui.labels import MAX_MENU_PATH_CHARACTERS, menu_text
from workbench.gui.layout import add_action
from workbench.gui.notices import Notices
from workbench.gui.recent_files import FileKind, RecentFiles
from workbench.logs.readers.log_reader import log_endings

MAX_SNIFFED_BYTES = 65536
"""Number of bytes read to determine a file's kind."""
_WORLD_KEYS = ("directives:", "obstacles:")
_WORLDS_FOLDER = "worlds"
"""Name of a folder in which a file with only a title is an empty world."""


FILE_KIND_FILTERS = {
    FileKind.SCENARIO: "Scenarios (*.yaml *.yml)",
    FileKind.MODEL: "Drones (*.xacro *.urdf *.sdf *.xml)",
    FileKind.WORLD: "Worlds (*.yaml *.yml *.sdf *.world)",
    FileKind.CONTROLLER: "Controllers (*.py)",
    FileKind.LAYOUT: "Layouts (*.layout.yaml)",
    FileKind.SPEC: "Specs (*.workbench.yaml *.spec.yaml)",
}
"""Filter of a file dialog for each kind but logs, see `log_file_filter`."""
_KIND_BY_ENDING = {
    ".xacro": FileKind.MODEL,
    ".urdf": FileKind.MODEL,
    ".xml": FileKind.MODEL,
    ".world": FileKind.WORLD,
    ".py": FileKind.CONTROLLER,
}
_KIND_BY_YAML_KEY = {"charts:": FileKind.LAYOUT, "cases:": FileKind.SPEC, "margins:": FileKind.SPEC}
"""Keys at the start of a line of YAML that determine the kind."""


def kind_of(path: Path) -> FileKind:
    """Return the kind of a file, or of a Gazebo model's folder, from its name and its start.

    Raises:
        WorkbenchError: if it cannot be opened.
    """
    ending = path.suffix.lower()
    if ending in _KIND_BY_ENDING:
        return _KIND_BY_ENDING[ending]
    if ending in log_endings():
        return FileKind.LOG
    if path.is_dir() and (path / "model.config").is_file():
        return FileKind.MODEL
    if ending == ".sdf":
        return FileKind.WORLD if "<world" in _read_file_start(path) else FileKind.MODEL
    if ending in (".yaml", ".yml"):
        lines = _read_file_start(path).splitlines()
        for key, kind in _KIND_BY_YAML_KEY.items():
            if any(line.startswith(key) for line in lines):
                return kind
        world = (
            any(line.startswith(_WORLD_KEYS) for line in lines)
            or path.parent.name == _WORLDS_FOLDER
        )
        return FileKind.WORLD if world else FileKind.SCENARIO
    raise WorkbenchError(
        f"{path.name} cannot be opened: drop a scenario or world (.yaml), a drone (.xacro, .urdf, "
        f".sdf, .xml), a controller (.py), a log ({', '.join(log_endings())}), a layout or "
        "spec (.yaml)"
    )


def _read_file_start(path: Path) -> str:
    return read_plain(path, first=MAX_SNIFFED_BYTES).decode(errors="replace")


def fill_recent(menu: QMenu, files: RecentFiles, opens: Callable[[FileKind, Path], None]) -> None:
    """List the existing recent files in a menu; must be called again when they change.

    Args:
        menu: menu to fill.
        files: the recent files.
        opens: called with the selected one.
    """
    menu.clear()
    present = files.files()
    menu.setEnabled(bool(present))
    for number, (kind, path) in enumerate(present, start=1):
        text = f"&{number}  {menu_text(path, MAX_MENU_PATH_CHARACTERS)}  ({kind.label})"
        add_action(menu, text, lambda _, kind=kind, path=path: opens(kind, Path(path)))


class Opener:
    """Opens files by their kind.

    Args:
        control: flies scenarios, models, worlds and controllers.
        recent: list to add opened files to.
        notices: takes refusals.
        shows: called with the path of a file for the charts: a log, a layout, a spec.
        window: the Qt parent of dialogs.
    """

    def __init__(
        self,
        control: FlightControl,
        recent: RecentFiles,
        notices: Notices,
        shows: Mapping[FileKind, Callable[[Path], None]],
        window: QWidget,
    ) -> None:
        self._recent, self._notices, self._window = recent, notices, window
        self._control = control
        self._opens: dict[FileKind, Callable[[Path], None]] = {
            FileKind.SCENARIO: lambda path: control.fly_scenario(str(path)),
            FileKind.MODEL: lambda path: control.fly_model(str(path)),
            FileKind.WORLD: lambda path: control.fly_world(str(path)),
            FileKind.CONTROLLER: self._fly_controller,
            **shows,
        }
        self._folders = {
            FileKind.SCENARIO: models_dir() / "scenarios",
            FileKind.MODEL: models_dir(),
            FileKind.WORLD: worlds_dir(),
            FileKind.CONTROLLER: controllers_dir(),
            **dict.fromkeys(shows, Path.cwd()),
        }

    def open(self, kind: FileKind, path: Path) -> None:
        """Open a file, and remember it."""
        if not path.exists():
            self._notices.warn(f"{path}: no such file", "Open another.")
            return
        self._folders[kind] = path.parent
        self._recent.add(kind, str(path))
        self._opens[kind](path)

    def _fly_controller(self, path: Path) -> None:
        """Fly the user's own control law; the flight continues if it cannot be read."""
        try:
            load_controller(path)
        except WorkbenchError as error:
            self._notices.warn(str(error))
            return
        self._control.fly_controller(str(path))

    def drop(self, path: Path) -> None:
        """Open a file according to its kind."""
        try:
            kind = kind_of(path)
        except WorkbenchError as error:
            self._notices.warn(str(error))
            return
        self.open(kind, path)

    def ask(self, kind: FileKind) -> QFileDialog:
        """Show a file dialog, while the flight and the key that stops it keep working."""
        names = log_file_filter() if kind is FileKind.LOG else FILE_KIND_FILTERS[kind]
        kinds = f"{names};;All files (*)"
        folder = str(self._folders[kind])
        return open_file(
            self._window, f"Open {kind.label}", partial(self.open, kind), folder, kinds
        )
