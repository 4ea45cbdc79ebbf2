"""What a file is that somebody wants to open."""

from enum import Enum
from pathlib import Path

from workbench.common.errors import WorkbenchError

READ = 65536
"""Of a file, to find out what it is [bytes]."""
_WORLD_KEYS = ("directives:", "obstacles:")
_WORLDS = "worlds"
"""Name of a folder in which a file of a title alone is an empty world."""


class FileKind(Enum):
    """What can be opened."""

    SCENARIO = "scenario"
    MODEL = "model"
    WORLD = "world"
    CONTROLLER = "controller"
    LOG = "log"


FILTERS = {
    FileKind.SCENARIO: "Scenarios (*.yaml *.yml)",
    FileKind.MODEL: "Drones (*.xacro *.urdf *.sdf *.xml)",
    FileKind.WORLD: "Worlds (*.yaml *.yml *.sdf *.world)",
    FileKind.CONTROLLER: "Controllers (*.py)",
    FileKind.LOG: "Logs (*.mcap)",
}
"""What a file dialog shows of each."""
_BY_ENDING = {
    ".xacro": FileKind.MODEL,
    ".urdf": FileKind.MODEL,
    ".xml": FileKind.MODEL,
    ".world": FileKind.WORLD,
    ".py": FileKind.CONTROLLER,
    ".mcap": FileKind.LOG,
}


def kind_of(path: Path) -> FileKind:
    """Return what a file, or a Gazebo model's folder, is, by its name and its beginning.

    Raises:
        WorkbenchError: if it is nothing that can be opened.
    """
    ending = path.suffix.lower()
    if ending in _BY_ENDING:
        return _BY_ENDING[ending]
    if path.is_dir() and (path / "model.config").is_file():
        return FileKind.MODEL
    if ending == ".sdf":
        return FileKind.WORLD if "<world" in _beginning(path) else FileKind.MODEL
    if ending in (".yaml", ".yml"):
        lines = _beginning(path).splitlines()
        world = any(line.startswith(_WORLD_KEYS) for line in lines) or path.parent.name == _WORLDS
        return FileKind.WORLD if world else FileKind.SCENARIO
    raise WorkbenchError(
        f"{path.name} cannot be opened: drop a scenario or world (.yaml), a drone (.xacro, .urdf, "
        ".sdf, .xml), or a log (.mcap)"
    )


def _beginning(path: Path) -> str:
    try:
        with path.open("rb") as file:
            return file.read(READ).decode(errors="replace")
    except OSError as error:
        raise WorkbenchError(f"{path} cannot be read: {error.strerror}") from error
