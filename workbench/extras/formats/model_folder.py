"""Find the description in a Gazebo model's folder."""

from pathlib import Path

from workbench.common.errors import WorkbenchError
from workbench.plant.formats.xml import Element, read_xml

FOLDER_MARK = "model.config"
"""The file that names the descriptions in a folder."""


def file_in_model_folder(folder: Path) -> Path | None:
    """Return the newest `<sdf>` in a folder's `model.config`, else `model.sdf`, else None.

    Raises:
        WorkbenchError: if `model.config` is there, and does not name a file of the folder.
    """
    config = folder / FOLDER_MARK
    if config.is_file():
        return _newest(config)
    file = folder / "model.sdf"
    return file if file.is_file() else None


def _newest(config: Path) -> Path:
    """Return the file with the highest SDF version in a model.config."""
    elements = [
        element
        for element in read_xml(config).iter("sdf")
        if isinstance(element, Element) and (element.text or "").strip()
    ]
    if not elements:
        raise WorkbenchError(f"{config}: it does not name an <sdf> file: add one")
    newest = max(elements, key=_sdf_version_numbers)
    file = config.parent / (newest.text or "").strip()
    if not file.resolve().is_relative_to(config.parent.resolve()):
        raise WorkbenchError(f"{config}:{newest.line}: its <sdf> file is not in its folder")
    if not file.is_file():
        raise WorkbenchError(f"{config}:{newest.line}: its <sdf> file {file.name} does not exist")
    return file


def _sdf_version_numbers(element: Element) -> tuple[int, ...]:
    """Return an SDF version as numbers to compare, (0,) without one."""
    words = element.get("version", "").split(".")
    known = all(word.isdecimal() and len(word) < 9 for word in words)
    return tuple(map(int, words)) if known else (0,)
