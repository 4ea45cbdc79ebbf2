"""Expand a xacro file in a separate process, as xacro evaluates expressions in the file."""

import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from workbench.common.cache import cache_folder, release
from workbench.common.errors import WorkbenchError
from workbench.common.plain_files import write_atomically
from workbench.ipc.limited import LimitedError, run_trusted
from workbench.plant.formats.xml import Element
from workbench.plant.packages import PackageFinder

_SECONDS = 20.0
_MEGABYTES = 2000
MOST_KEPT = 200
"""Largest number of cached expansions; the oldest are deleted first."""
_MOST_NAMED = 40


def is_xacro(root: Element) -> bool:
    """Return whether a document has elements of xacro."""
    prefixes = tuple(
        f"{key.removeprefix('xmlns:')}:"
        for key, value in root.attrib.items()
        if key.startswith("xmlns:") and value.rstrip("/#").endswith("xacro")
    )
    return bool(prefixes) and any(element.tag.startswith(prefixes) for element in root.iter())


def expand_xacro(path: Path, args: Mapping[str, str], finder: PackageFinder) -> str:
    """Return the text that a xacro file expands to.

    Args:
        path: the xacro file; includes are looked up beside it.
        args: values for its arguments, as text.
        finder: looks up the packages of `$(find PACKAGE)`.

    Raises:
        MissingArgumentsError: naming all arguments that need a value.
        WorkbenchError: naming the file that was being read, the line if known, and the error; also
            for an unknown argument, which xacro would ignore, and if expansion does not end.
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
        answer = run_trusted(
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


def kept_expansion(request: dict[str, object]) -> str | None:
    """Return the cached result of a request of `expand_xacro`, if its files are unchanged."""
    try:
        entry = json.loads(_place(request).read_text(encoding="utf-8"))
        if all(_digest(Path(path)) == digest for path, digest in entry["read"].items()):
            return str(entry["text"])
    except (OSError, ValueError, KeyError, TypeError, AttributeError, WorkbenchError):
        return None  # not cached, or damaged: expand it
    return None


def keep_expansion(request: dict[str, object], text: str, read: Sequence[str]) -> None:
    """Cache an expansion with digests of the files read; ignore errors of writing."""
    try:
        entry = {"read": {path: _digest(Path(path)) for path in read}, "text": text}
        place = _place(request)
        write_atomically(place, json.dumps(entry))
        kept = sorted(place.parent.glob("*.json"), key=lambda path: path.stat().st_mtime)
        for old in kept[:-MOST_KEPT]:
            old.unlink(missing_ok=True)
    except (OSError, WorkbenchError):
        return  # the cache is optional


def _place(request: dict[str, object]) -> Path:
    """Return the cache file for a request."""
    asked = json.dumps([request, release("xacro"), str(Path.cwd())], sort_keys=True)
    return cache_folder("xacro") / f"{hashlib.sha256(asked.encode()).hexdigest()[:24]}.json"


def _digest(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


@dataclass(frozen=True)
class XacroArgument:
    """An argument of a xacro file.

    Attributes:
        name: of the argument.
        default: as in the file, None if it needs a value.
    """

    name: str
    default: str | None = None


class MissingArgumentsError(WorkbenchError):
    """A xacro file that needs values for arguments; the message is for the command line.

    Args:
        path: of the file.
        arguments: of the file, those that need a value first.
    """

    def __init__(self, path: str, arguments: tuple[XacroArgument, ...]) -> None:
        needed = [f"--arg {each.name}:=…" for each in arguments if each.default is None]
        more = f" and {len(needed) - _MOST_NAMED} more" if len(needed) > _MOST_NAMED else ""
        super().__init__(
            f"{path}: has arguments without a default: give {' '.join(needed[:_MOST_NAMED])}{more}"
        )
        self.arguments = arguments
