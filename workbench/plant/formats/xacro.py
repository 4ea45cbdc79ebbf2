"""Expand a xacro file to URDF text, in a process of its own: xacro runs the file's expressions."""

from collections.abc import Mapping
from pathlib import Path

from workbench.common.errors import WorkbenchError
from workbench.plant.formats.xacro_arguments import MissingArgumentsError, XacroArgument
from workbench.plant.formats.xacro_cache import keep_expansion, kept_expansion
from workbench.plant.formats.xml import Element
from workbench.plant.limited import LimitedError, run_limited
from workbench.plant.packages import PackageFinder

_SECONDS = 20.0
_MEGABYTES = 2000


def is_xacro(root: Element) -> bool:
    """Return whether a document has elements of xacro's, whatever its file is called."""
    prefixes = tuple(
        f"{key.removeprefix('xmlns:')}:"
        for key, value in root.attrib.items()
        if key.startswith("xmlns:") and value.rstrip("/#").endswith("xacro")
    )
    return bool(prefixes) and any(element.tag.startswith(prefixes) for element in root.iter())


def expand_xacro(path: Path, args: Mapping[str, str], finder: PackageFinder) -> str:
    """Return the URDF text that a xacro file stands for.

    Args:
        path: the xacro file; includes are looked up beside it.
        args: values for its arguments, as text.
        finder: looks up the packages of `$(find PACKAGE)`.

    Raises:
        WorkbenchError: naming the file that was being read, the line where it is known, and the
            fault; also for an argument that no file knows (xacro itself would ignore it), for
            arguments that need a value, all of them at once, and for what never ends.
    """
    request: dict[str, object] = {
        "path": str(path),
        "args": dict(args),
        "source": str(finder.source),
        "packages": {name: str(folder) for name, folder in finder.packages.items()},
    }
    kept = kept_expansion(request)
    if kept is not None:
        return kept
    try:
        answer = run_limited(
            "workbench.plant.formats.xacro_child",
            request,
            seconds=_SECONDS,
            megabytes=_MEGABYTES,
        )
    except LimitedError as error:
        raise WorkbenchError(
            f"{path}: cannot be expanded: {error}: simplify its expressions and macros"
        ) from error
    if "needed" in answer:
        needed = tuple(XacroArgument(name, default) for name, default in answer["needed"])
        raise MissingArgumentsError(str(path), needed)
    text = str(answer["text"])
    if answer["read"]:
        keep_expansion(request, text, answer["read"])
    return text
