"""Opens files: chosen in a dialog, dropped onto the window, or from the recent ones."""

from collections.abc import Callable
from pathlib import Path

from PyQt6.QtWidgets import QFileDialog, QWidget

from workbench.common.errors import WorkbenchError
from workbench.common.resources import controllers_dir, models_dir, worlds_dir
from workbench.gui.file_dialogs import show_file_dialog
from workbench.gui.flight_control import FlightControl
from workbench.gui.notices import Notices
from workbench.gui.opening import FILTERS, FileKind, kind_of
from workbench.gui.recent import Recent, RecentFiles


class Opener:
    """Gives files to whoever shows them.

    Args:
        control: flies scenarios, models, worlds and controllers.
        recent: remembers them.
        notices: where refusals are told.
        shows_log: told the path of a log that is to be shown.
        window: above which dialogs open.
    """

    def __init__(
        self,
        control: FlightControl,
        recent: RecentFiles,
        notices: Notices,
        shows_log: Callable[[Path], None],
        window: QWidget,
    ) -> None:
        self._recent, self._notices, self._window = recent, notices, window
        self._opens: dict[FileKind, Callable[[Path], None]] = {
            FileKind.SCENARIO: lambda path: control.fly_scenario(str(path)),
            FileKind.MODEL: lambda path: control.fly_model(str(path)),
            FileKind.WORLD: lambda path: control.fly_world(str(path)),
            FileKind.CONTROLLER: lambda path: control.fly_controller(str(path)),
            FileKind.LOG: shows_log,
        }
        self._folders = {
            FileKind.SCENARIO: models_dir() / "scenarios",
            FileKind.MODEL: models_dir(),
            FileKind.WORLD: worlds_dir(),
            FileKind.CONTROLLER: controllers_dir(),
            FileKind.LOG: Path.cwd(),
        }

    def open(self, kind: FileKind, path: Path) -> None:
        """Open a file, and remember it."""
        if not path.exists():
            self._notices.warn(f"{path}: no such file", "Open another.")
            return
        self._folders[kind] = path.parent
        self._recent.add(kind, str(path))
        self._opens[kind](path)

    def open_recent(self, file: Recent) -> None:
        """Open a file again."""
        self.open(file.kind, Path(file.path))

    def drop(self, path: Path) -> None:
        """Open a file by what it is."""
        try:
            kind = kind_of(path)
        except WorkbenchError as error:
            self._notices.warn(str(error))
            return
        self.open(kind, path)

    def ask(self, kind: FileKind) -> QFileDialog:
        """Let a file be chosen, while the flight, and the key that stops it, go on."""
        dialog = QFileDialog(self._window, f"Open {kind.value}", str(self._folders[kind]))
        dialog.setNameFilters([FILTERS[kind], "All files (*)"])
        dialog.setFileMode(QFileDialog.FileMode.ExistingFile)
        show_file_dialog(dialog, lambda path: self.open(kind, Path(path)))
        return dialog
