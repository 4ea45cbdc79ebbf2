"""Expand a xacro file in a separate process, which reads no other files than those allowed.

The file may name packages and files that are known only while it is expanded. The process then
returns these names, this one decides about them, and another process begins anew.
"""

import hashlib
import json
import math
import re
import time
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from workbench.common.cache import cache_folder, release
from workbench.common.errors import WorkbenchError
from workbench.common.plain_files import read_plain, write_atomically
from workbench.ipc.limited import LimitedError, run_limited
from workbench.plant.formats.xml import MAX_XML_BYTES, Element
from workbench.plant.packages import PackageFinder

_XACRO_CPU_S = 3.0
_XACRO_MEMORY_MB = 400
"""Limits of an expansion; a drone with four sensors takes 0.2 s and 40 MB."""
_MAX_XACRO_PASSES = 20
_XACRO_CHILD_MODULE = "workbench.plant.formats.xacro_child"
_FIND_PATTERN = re.compile(r"\$\(find\s+([^\s()${}]+)\s*\)(?:/([^\s\"'<>$]+))?")
MAX_CACHED_EXPANSIONS = 200
"""Largest number of cached expansions; the oldest are deleted first."""
_MAX_ARGUMENTS_LISTED = 40


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
    kept = cached_expansion(request)
    if kept is not None:
        return kept
    answer = _expanded(path, args, finder)
    text = str(answer["text"])
    if answer["lasting"]:
        cache_expansion(request, text, answer["read"])
    return text


def files_of_xacro(path: Path, args: Mapping[str, str], finder: PackageFinder) -> list[Path]:
    """Return the files that the expansion of a xacro file reads, itself among them.

    Raises:
        WorkbenchError: as `expand_xacro`.
    """
    return [Path(file) for file in _expanded(path, args, finder)["read"]]


def packages_in(text: str) -> list[tuple[str, str]]:
    """Return the packages of all `$(find PACKAGE)` in a text, each with the file named in it."""
    return [(match[1], match[2] or "") for match in _FIND_PATTERN.finditer(text)]


def _expanded(path: Path, args: Mapping[str, str], finder: PackageFinder) -> Any:
    """Return the answer of a process that was given all packages and files that it needs."""
    packages: dict[str, str | None] = {
        name: str(folder) for name, folder in finder.packages.items()
    }
    roots = dict.fromkeys(map(str, finder.readable))
    text = read_plain(path, MAX_XML_BYTES).decode(errors="replace")
    wanted = [(name, rest, str(path)) for name, rest in packages_in(text) if name not in packages]
    until = time.monotonic() + _XACRO_CPU_S
    for _ in range(_MAX_XACRO_PASSES):
        for name, folder in _folders(wanted, finder).items():
            packages[name] = str(folder) if folder else None
            if folder and folder == finder.folder(name):
                roots[str(folder.resolve())] = None
        try:
            answer = run_limited(
                _XACRO_CHILD_MODULE,
                {"path": str(path), "args": dict(args), "packages": packages, "roots": [*roots]},
                seconds=max(1, math.ceil(until - time.monotonic())),
                megabytes=_XACRO_MEMORY_MB,
                reads=roots,
            )
        except LimitedError as error:
            raise WorkbenchError(
                f"{path}: cannot be expanded: {error}: simplify its expressions and macros"
            ) from error
        if "needed" in answer:
            needed = tuple(XacroArgument(name, default) for name, default in answer["needed"])
            raise MissingArgumentsError(str(path), needed)
        if "text" in answer:
            return answer
        wanted = answer["wanted"]
        for file in answer["outside"]:
            roots[str(finder.allowed(Path(file), answer["in"]))] = None
    raise WorkbenchError(
        f"{path}: names packages in more than {_MAX_XACRO_PASSES} steps, each in a file of the one "
        "before: give them with --package NAME=DIR"
    )


def _folders(
    wanted: Iterable[tuple[str, str, str]], finder: PackageFinder
) -> dict[str, Path | None]:
    """Return the folders of packages, each with a file in it, and the file that names it.

    A description copied out of its package may still have the folders around it.
    """
    found: dict[str, Path | None] = {}
    for name, rest, file in wanted:
        if not found.get(name):
            found[name] = finder.folder(name)
        if not found[name] and rest:
            part = finder.resolve(f"package://{name}/{rest}", Path(file))
            if part and part.is_file():
                found[name] = part.parents[len(Path(rest).parts) - 1]
    return found


def cached_expansion(request: dict[str, object]) -> str | None:
    """Return the cached result of a request of `expand_xacro`, if its files are unchanged."""
    try:
        entry = json.loads(_expansion_file(request).read_text(encoding="utf-8"))
        if all(_file_digest(Path(path)) == digest for path, digest in entry["read"].items()):
            return str(entry["text"])
    except (OSError, ValueError, KeyError, TypeError, AttributeError, WorkbenchError):
        return None  # not cached, or damaged: expand it
    return None


def cache_expansion(request: dict[str, object], text: str, read: Sequence[str]) -> None:
    """Cache an expansion with digests of the files read; ignore errors of writing."""
    try:
        entry = {"read": {path: _file_digest(Path(path)) for path in read}, "text": text}
        place = _expansion_file(request)
        write_atomically(place, json.dumps(entry))
        kept = sorted(place.parent.glob("*.json"), key=lambda path: path.stat().st_mtime)
        for old in kept[:-MAX_CACHED_EXPANSIONS]:
            old.unlink(missing_ok=True)
    except (OSError, WorkbenchError):
        return  # the cache is optional


def _expansion_file(request: dict[str, object]) -> Path:
    """Return the cache file for a request."""
    asked = json.dumps([request, release("xacro"), str(Path.cwd())], sort_keys=True)
    return cache_folder("xacro") / f"{hashlib.sha256(asked.encode()).hexdigest()[:24]}.json"


def _file_digest(path: Path) -> str:
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
        more = (
            f" and {len(needed) - _MAX_ARGUMENTS_LISTED} more"
            if len(needed) > _MAX_ARGUMENTS_LISTED
            else ""
        )
        super().__init__(
            f"{path}: has arguments without a default: give "
            f"{' '.join(needed[:_MAX_ARGUMENTS_LISTED])}{more}"
        )
        self.arguments = arguments
