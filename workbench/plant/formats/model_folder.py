"""Find the description in a Gazebo model's folder."""

from pathlib import Path

from workbench.common.errors import WorkbenchError
from workbench.plant.formats.xml import Element, read_xml


def description_file(path: Path) -> Path:
    """Return the description at a path: the file itself, or that in the folder of a model.

    In a folder it is the newest `<sdf>` in `model.config`, else `model.sdf`, else the only
    description, else the only `.urdf.xacro` (others may be parts of it).

    Raises:
        WorkbenchError: if there is none, or several.
    """
    if not path.is_dir():
        return path
    config = path / "model.config"
    if config.is_file():
        return _newest(config)
    if (path / "model.sdf").is_file():
        return path / "model.sdf"
    found = sorted(file for file in path.iterdir() if file.suffix in (".xacro", ".urdf", ".sdf"))
    for candidates in (found, [file for file in found if file.name.endswith(".urdf.xacro")]):
        if len(candidates) == 1:
            return candidates[0]
    if not found:
        raise WorkbenchError(f"{path}: no model.config, .xacro, .urdf or .sdf file in this folder")
    raise WorkbenchError(
        f"{path}: several descriptions are in this folder: name one of "
        f"{', '.join(file.name for file in found)}"
    )


def _newest(config: Path) -> Path:
    """Return the file with the highest SDF version in a model.config."""
    elements = [
        element
        for element in read_xml(config).iter("sdf")
        if isinstance(element, Element) and (element.text or "").strip()
    ]
    if not elements:
        raise WorkbenchError(f"{config}: it does not name an <sdf> file: add one")
    newest = max(elements, key=_version)
    file = config.parent / (newest.text or "").strip()
    if not file.resolve().is_relative_to(config.parent.resolve()):
        raise WorkbenchError(f"{config}:{newest.line}: its <sdf> file is not in its folder")
    if not file.is_file():
        raise WorkbenchError(f"{config}:{newest.line}: its <sdf> file {file.name} does not exist")
    return file


def _version(element: Element) -> tuple[int, ...]:
    """Return an SDF version as numbers to compare, (0,) without one."""
    words = element.get("version", "").split(".")
    known = all(word.isdecimal() and len(word) < 9 for word in words)
    return tuple(map(int, words)) if known else (0,)
