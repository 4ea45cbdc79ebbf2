"""Expand a xacro file to URDF text."""

import xml.etree.ElementTree as ET
from collections.abc import Mapping
from pathlib import Path
from xml.parsers.expat import ExpatError

import xacro

from workbench.errors import WorkbenchError, unknown_name

_XACRO_NAMESPACES = ("http://www.ros.org/wiki/xacro", "http://ros.org/wiki/xacro")


def expand_xacro(path: Path, args: Mapping[str, str]) -> str:
    """Return the URDF text that a xacro file stands for.

    Args:
        path: the xacro file; includes are looked up beside it.
        args: values for its `xacro:arg` elements, as text.

    Raises:
        WorkbenchError: naming the file, the fault and the line where xacro knows it; also for
            an argument that the file does not declare (xacro itself would ignore it).
    """
    xacro.all_includes.clear()  # xacro would add to those of earlier files, broken ones too
    try:
        document = xacro.process_file(str(path), mappings=dict(args))
    except ExpatError as error:
        raise WorkbenchError(f"{_being_read(path)}:{error.lineno}: not XML: {error}") from error
    except (Exception, SystemExit) as error:  # a file's own expressions may raise anything
        raise WorkbenchError(f"{_being_read(path)}: xacro stopped: {_one_line(error)}") from error
    known = _declared_args([path, *map(Path, xacro.all_includes)])
    for name in args:
        if name not in known:
            raise unknown_name(f"argument of {path.name}", name, known)
    return str(document.toxml())


def _declared_args(paths: list[Path]) -> set[str]:
    """Return the names of all `xacro:arg` elements in some files."""
    return {
        element.get("name", "")
        for path in paths
        for namespace in _XACRO_NAMESPACES
        for element in ET.parse(path).getroot().iter(f"{{{namespace}}}arg")
    }


def _being_read(path: Path) -> str:
    """Name the file that xacro had open when it stopped (an include, perhaps)."""
    return str(xacro.filestack[-1] if xacro.filestack else path)


def _one_line(error: BaseException) -> str:
    """Return xacro's message without the expression it adds on lines of their own."""
    return str(error).partition("\nwhen ")[0].replace("\n", " ") or type(error).__name__
