"""Find the description in a folder."""

from pathlib import Path

from workbench.common.errors import WorkbenchError
from workbench.plant.readers import URDF_SUFFIXES, description_formats, missing_reader


def description_file(path: Path) -> Path:
    """Return the description at a path: the file itself, or that in the folder of a model.

    In a folder it is the file that an installed format finds there, as that of a Gazebo model, else
    the only description, else the only `.urdf.xacro` (others may be parts of it).

    Raises:
        WorkbenchError: if there is none, or several.
    """
    if not path.is_dir():
        return path
    formats = description_formats()
    for each in formats:
        if found := each.find_in_folder(path):
            return found
    suffixes = (*URDF_SUFFIXES, *(suffix for each in formats for suffix in each.suffixes))
    files = sorted(file for file in path.iterdir() if file.suffix in suffixes)
    for candidates in (files, [file for file in files if file.name.endswith(".urdf.xacro")]):
        if len(candidates) == 1:
            return candidates[0]
    if files:
        raise WorkbenchError(
            f"{path}: several descriptions are in this folder: name one of "
            f"{', '.join(file.name for file in files)}"
        )
    marks = [each.folder_mark for each in formats if each.folder_mark]
    if not marks and ((path / "model.config").is_file() or any(path.glob("*.sdf"))):
        raise missing_reader(path, "the folder of a Gazebo model")
    *names, last = (*marks, *suffixes)
    raise WorkbenchError(f"{path}: no {', '.join(names)} or {last} file in this folder")
