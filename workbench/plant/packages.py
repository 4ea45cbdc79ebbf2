"""Find ROS packages, Gazebo models, and the files that descriptions name, without ROS or Gazebo.

A name is looked for among the folders that were given for it; else above and beside the
description; else where the usual environment variables point; else in the repository or workspace
that the description lies in.
"""

import os
import shlex
from collections import deque
from collections.abc import Iterator, Mapping
from itertools import islice
from pathlib import Path
from urllib.parse import unquote

from workbench.common.errors import WorkbenchError
from workbench.plant.formats.xml import read_xml

_MODEL_PATHS = (
    "GZ_SIM_RESOURCE_PATH",
    "IGN_GAZEBO_RESOURCE_PATH",
    "SDF_PATH",
    "GAZEBO_MODEL_PATH",
)
_MARKERS = ("package.xml", "model.config", "model.sdf")
_NEAR = 3
"""So many ancestors of the description have their child folders looked into."""
_DEPTH = 4
"""Of a folder of packages: repository, group, package, with one to spare."""
_MOST_FOLDERS = 3000
_MOST_ENTRIES = 10_000
_MOST_NAMES = 1000
"""A description that names more packages than this is not serious."""


class PackageFinder:
    """Finds folders and files for one description, and remembers where it looked.

    Attributes:
        source: the description's file, absolute.
        packages: the folders that were given, absolute, by package or model name.
    """

    def __init__(self, source: Path, packages: Mapping[str, Path | str] | None = None) -> None:
        """Look around a file.

        Args:
            source: the description.
            packages: folders to take without looking, by the name of a package or model.

        Raises:
            WorkbenchError: if one of them is no folder.
        """
        self.source = source.absolute()
        self.packages = {name: _given(name, folder) for name, folder in (packages or {}).items()}
        above = [*self.source.parents, *_resolved(self.source).parents]
        self._above = tuple(dict.fromkeys(above))
        self._found: dict[str, tuple[Path, ...]] = {}
        self._crawled: dict[tuple[Path, int], dict[str, list[Path]]] = {}

    def folder(self, name: str) -> Path | None:
        """Return the folder of a ROS package or Gazebo model, None where it is not found."""
        return next(iter(self._folders(name)), None)

    def resolve(self, uri: str, file: Path) -> Path | None:
        """Return the file or folder that a URI or a path stands for.

        Args:
            uri: package://NAME/..., model://NAME/..., file://..., or a path; absolute, or relative
                to the file that names it, to the description, or to a folder that models are in.
            file: where it stands.

        Returns:
            An absolute path to what is there, or None. What lies on the web is not looked up.
        """
        text = uri.strip()
        return next(
            (
                found
                for spelling in dict.fromkeys((text, unquote(text)))
                for found in self._places(spelling, file.absolute())
                if _is_there(found)
            ),
            None,
        )

    def hint(self, name: str) -> str:
        """Return what a user can do about a package that is not found, a clause for a message."""
        return f"give --package {shlex.quote(f'{name}=DIR')}"

    def _places(self, text: str, file: Path) -> Iterator[Path]:
        """Yield the paths that a text may mean, whether there is anything or not."""
        scheme, sign, rest = text.partition("://")
        path = Path(rest if sign else text)
        if sign and scheme in ("package", "model"):
            yield from self._in_package(rest, file)
        elif (sign and scheme != "file") or not path.name:
            return
        elif path.is_absolute():
            yield path
        else:
            models = [folder for name in _MODEL_PATHS for folder in _folders_in(name)]
            for folder in (file.parent, self.source.parent, *models):
                yield folder / path
            name, *others = path.parts
            for folder in self._folders(name):
                yield folder.joinpath(*others)

    def _in_package(self, rest: str, file: Path) -> Iterator[Path]:
        """Yield where the file of a package or model may be.

        Where there is no such package, perhaps the description was taken out of it with the
        folders around it: `meshes/` beside or above.
        """
        name, _, inner = rest.strip("/").partition("/")
        inner = inner.strip("/")
        folders = self._folders(name)
        if not folders and inner:
            folders = tuple(file.parents)[:-1]
        for folder in folders:
            yield folder / inner

    def _folders(self, name: str) -> tuple[Path, ...]:
        """Return all folders of a name, the likeliest first."""
        if name in self.packages:
            return (self.packages[name],)
        if name in ("", ".", "..") or "/" in name or "\0" in name:
            return ()
        if name not in self._found:
            if len(self._found) >= _MOST_NAMES:
                return ()
            candidates = dict.fromkeys(self._candidates(name))
            self._found[name] = tuple(path for path in candidates if _is_folder(path))
        return self._found[name]

    def _candidates(self, name: str) -> Iterator[Path]:
        """Yield folders that may be the one of a name: those that say so before mere namesakes."""
        for level, folder in enumerate(self._above):
            yield from self._crawl(folder, 1 if level < _NEAR else 0).get(name, ())
            yield from self._crawl(folder / name, 0).get(name, ())
        for folder in self._above:
            if folder.name == name:
                yield folder
            yield folder / name
        for folder in _folders_in("ROS_PACKAGE_PATH"):
            yield from self._crawl(folder, _DEPTH).get(name, ())
        for folder in _folders_in("AMENT_PREFIX_PATH"):
            yield folder / "share" / name
        for folder in (folder for path in _MODEL_PATHS for folder in _folders_in(path)):
            yield folder / name
            if folder.name == name:
                yield folder
        for folder in self._above:
            if folder.name == "src" or _is_there(folder / ".git"):
                yield from self._crawl(folder, _DEPTH).get(name, ())

    def _crawl(self, top: Path, depth: int) -> Mapping[str, list[Path]]:
        """Return the packages and models at and below a folder, by all their names."""
        if (top, depth) not in self._crawled:
            deepest = 1 if top in _shallow() else depth
            self._crawled[top, depth] = _crawl(top, min(depth, deepest))
        return self._crawled[top, depth]


def _crawl(top: Path, depth: int) -> dict[str, list[Path]]:
    """Look for packages and models, the upper ones first, within bounds."""
    found: dict[str, list[Path]] = {}
    seen: set[tuple[int, int]] = set()
    todo = deque([(top, 0)])
    while todo and len(seen) < _MOST_FOLDERS:
        folder, level = todo.popleft()
        try:
            status = folder.stat()
            if (status.st_dev, status.st_ino) in seen:  # links may lead in a circle
                continue
            seen.add((status.st_dev, status.st_ino))
            for name in _names(folder):
                found.setdefault(name, []).append(folder)
            if level < depth:
                todo += [(child, level + 1) for child in _children(folder)]
        except (OSError, ValueError):  # closed to us, or no path at all
            continue
    return found


def _names(folder: Path) -> set[str]:
    """Return what a folder is called as a package or model, nothing if it is neither."""
    marks = [mark for mark in _MARKERS if (folder / mark).is_file()]
    names = {folder.name} if marks else set()
    if "package.xml" in marks:
        try:
            names.add(read_xml(folder / "package.xml").findtext("name", "").strip())
        except WorkbenchError:  # a broken package.xml of a neighbour is not this user's concern
            return names
    return names


def _children(folder: Path) -> list[Path]:
    with os.scandir(folder) as entries:
        names = [entry.name for entry in islice(entries, _MOST_ENTRIES) if entry.is_dir()]
    return [folder / name for name in sorted(names) if not name.startswith(".")]


def _folders_in(variable: str) -> list[Path]:
    """Return the folders that an environment variable lists."""
    texts = os.environ.get(variable, "").split(os.pathsep)
    return [Path(text).absolute() for text in texts if text]


def _shallow() -> set[Path]:
    """Return the folders that have the whole machine, or all that a user has, below them."""
    try:
        home = Path.home()
    except RuntimeError:
        return {Path("/")}
    return {Path("/"), home, *home.parents}


def _given(name: str, folder: Path | str) -> Path:
    try:
        path = Path(folder).expanduser()
    except RuntimeError:  # ~NOBODY
        path = Path(folder)
    if not _is_folder(path):
        raise WorkbenchError(
            f"package '{name}': '{folder}' is no folder: give --package {name}=DIR with the "
            "folder that holds its files"
        )
    return _resolved(path)


def _resolved(path: Path) -> Path:
    try:
        return path.resolve()
    except (OSError, RuntimeError, ValueError):  # links in a circle, a null character
        return path.absolute()


def _is_folder(path: Path) -> bool:
    try:
        return path.is_dir()
    except OSError:
        return False


def _is_there(path: Path) -> bool:
    """Return whether a path is a file or folder; a device or a pipe would never end."""
    try:
        return path.is_file() or path.is_dir()
    except OSError:  # a name too long, a folder closed to us
        return False
