"""Find ROS packages, Gazebo models and files of descriptions, without ROS or Gazebo.

The search order is: the folders given for a name; folders above and beside the description; the
usual environment variables; the repository or workspace of the description.

A description is from a stranger. It may name any file, but is given only those of its own folder,
package or repository, and of the packages that are found for it.
"""

import os
import shlex
from collections import deque
from collections.abc import Iterator, Mapping
from functools import cached_property
from itertools import islice
from pathlib import Path
from urllib.parse import unquote

from workbench.common.errors import WorkbenchError
from workbench.plant.formats.xml import read_xml

_MODEL_PATH_VARIABLES = (
    "GZ_SIM_RESOURCE_PATH",
    "IGN_GAZEBO_RESOURCE_PATH",
    "SDF_PATH",
    "GAZEBO_MODEL_PATH",
)
_PACKAGE_FILES = ("package.xml", "model.config", "model.sdf")
_INNER_FOLDER_NAMES = (
    *("urdf", "xacro", "sdf", "mjcf", "xml", "robot", "robots", "model", "models"),
    *("description", "world", "worlds", "mesh", "meshes", "visual", "collision", "assets"),
)
"""Usual names of a folder of descriptions or meshes within the folder of a drone."""
_SEARCHED_ANCESTORS = 3
"""Number of ancestors of the description to search with their child folders."""
_PACKAGE_SEARCH_DEPTH = 4
"""Depth of the search in a folder of packages: repository, group, package, and one more."""
_MAX_SEARCHED_FOLDERS = 3000
_MAX_FOLDER_ENTRIES = 10_000
_MAX_QUOTED_CHARS = 300
_MAX_NAMED_PACKAGES = 1000
"""Limit of the number of packages named by a description."""


class PackageFinder:
    """Finds folders and files for one description, and caches its searches.

    Attributes:
        source: the description's file, absolute.
        packages: the given folders, absolute, by package or model name.
    """

    def __init__(self, source: Path, packages: Mapping[str, Path | str] | None = None) -> None:
        """Search for one description.

        Args:
            source: the description.
            packages: folders to use without a search, by the name of a package or model.

        Raises:
            WorkbenchError: if one of them is not a folder.
        """
        self.source = source.absolute()
        self.packages = {
            name: _given_folder(name, folder) for name, folder in (packages or {}).items()
        }
        self._shallow = _shallow()
        above = [*self.source.parents, *_resolved(self.source).parents]
        self._above = tuple(dict.fromkeys(above))
        tops = (_resolved(self.source.parent), _resolved(self.source).parent)
        self._own = tuple(dict.fromkeys(map(own_folder, tops)))
        self._found: dict[str, tuple[Path, ...]] = {}
        self._crawled: dict[tuple[Path, int], dict[str, list[Path]]] = {}

    def folder(self, name: str) -> Path | None:
        """Return the folder of a ROS package or Gazebo model, None if not found."""
        return next(iter(self._folders(name)), None)

    @cached_property
    def readable(self) -> tuple[Path, ...]:
        """The files and folders that the description may read before it names a package."""
        found = [folder for folder in self._roots() if folder not in self._shallow]
        for folder in self._shallow.intersection(self._own):  # of a user, only files beside it
            found += [each for each in _files(folder) if not each.name.startswith(".")]
        return (*found, *self.packages.values())

    def reach(self, path: Path) -> Path | None:
        """Return the file or folder for which the description may read a file, or None.

        That is its own folder, package or repository; a folder that the user or an environment
        variable gives; or a package or model that is found by its name.

        Args:
            path: links are followed before it is decided.
        """
        real = _resolved(path)
        for folder in self.readable:
            if real.is_relative_to(folder):
                return folder
        for folder in real.parents:
            if folder in self._shallow:
                break
            if any(self._folders(name) for name in _package_names(folder)):
                return folder
        return None

    def allowed(self, path: Path, place: object) -> Path:
        """Return the file or folder for which the description may read a file, see `reach`.

        Args:
            path: the file.
            place: what names it, for the beginning of a message.

        Raises:
            WorkbenchError: if it may not.
        """
        folder = self.reach(path)
        if folder is None:
            raise WorkbenchError(
                f"{place}: '{str(path)[:_MAX_QUOTED_CHARS]}' is outside of its folder and "
                f"packages: {self.hint('NAME')} with the folder that holds it"
            )
        return folder

    def resolve(self, uri: str, file: Path) -> Path | None:
        """Return the file or folder that a URI or a path refers to.

        Args:
            uri: package://NAME/..., model://NAME/..., file://..., or a path; absolute, or relative
                to the file that names it, to the description, or to a folder that models are in.
            file: the one that contains the URI.

        Returns:
            An absolute path to an existing file or folder that the description may read, or None.
            Web addresses are not followed.
        """
        return next((found for found, allowed in self._existing(uri, file) if allowed), None)

    def refuse_outside(self, uri: str, file: Path, place: object) -> None:
        """Reject a URI or path that only a file refers to which the description may not read.

        Args:
            uri: see `resolve`.
            file: see `resolve`.
            place: what names it, for the beginning of a message.

        Raises:
            WorkbenchError: for such a file.
        """
        existing = dict(self._existing(uri, file))
        if existing and not any(existing.values()):
            self.allowed(next(iter(existing)), place)

    def _existing(self, uri: str, file: Path) -> Iterator[tuple[Path, bool]]:
        """Yield the files and folders that a URI may refer to, and whether each may be read."""
        text = uri.strip()
        for spelling in dict.fromkeys((text, unquote(text))):
            for found, package in self._places(spelling, file.absolute()):
                if exists(found):
                    inside = package and _resolved(found).is_relative_to(_resolved(package))
                    yield found, bool(inside or self.reach(found))

    @staticmethod
    def hint(name: str) -> str:
        """Return advice about a package that is not found, as a clause for a message."""
        return f"give --package {shlex.quote(f'{name}=DIR')}"

    def _roots(self) -> Iterator[Path]:
        """Yield the folder of the description, and those given by environment variables."""
        yield from self._own
        for folder in (*_folders_in("ROS_PACKAGE_PATH"), *_model_folders()):
            yield _resolved(folder)
        for folder in _folders_in("AMENT_PREFIX_PATH"):
            yield _resolved(folder / "share")

    def _places(self, text: str, file: Path) -> Iterator[tuple[Path, Path | None]]:
        """Yield the paths that a text may mean, with the package that it names.

        They may not exist.
        """
        scheme, sign, rest = text.partition("://")
        path = Path(rest if sign else text)
        if sign and scheme in ("package", "model"):
            yield from self._in_package(rest, file)
        elif (sign and scheme != "file") or not path.name:
            return
        elif path.is_absolute():
            yield path, None
        else:
            for folder in (file.parent, self.source.parent, *_model_folders()):
                yield folder / path, None
            name, *others = path.parts
            for folder in self._folders(name):
                yield folder.joinpath(*others), folder

    def _in_package(self, rest: str, file: Path) -> Iterator[tuple[Path, Path | None]]:
        """Yield possible paths of a file of a package or model, with its folder if it is found.

        If there is no such package, the description may have been copied with its folders, such as
        `meshes/` beside or above it.
        """
        name, _, inner = rest.strip("/").partition("/")
        inner = inner.strip("/")
        folders = self._folders(name)
        for folder in folders:
            yield folder / inner, folder
        if not folders and inner:
            for folder in tuple(file.parents)[:-1]:
                yield folder / inner, None

    def _folders(self, name: str) -> tuple[Path, ...]:
        """Return all folders for a name, the most likely first."""
        if name in self.packages:
            return (self.packages[name],)
        if not name or name.startswith(".") or "/" in name or "\0" in name:
            return ()
        if name not in self._found:
            if len(self._found) >= _MAX_NAMED_PACKAGES:
                return ()
            candidates = dict.fromkeys(self._candidates(name))
            self._found[name] = tuple(path for path in candidates if _is_folder(path))
        return self._found[name]

    def _candidates(self, name: str) -> Iterator[Path]:
        """Yield candidate folders for a name: those that declare it before those only called so."""
        for level, folder in enumerate(self._above):
            yield from self._crawl(folder, 1 if level < _SEARCHED_ANCESTORS else 0).get(name, ())
            yield from self._crawl(folder / name, 0).get(name, ())
        for folder in self._above:
            if folder not in self._shallow:  # /etc is no package, nor is each folder of a user
                if folder.name == name:
                    yield folder
                yield folder / name
        for folder in _folders_in("ROS_PACKAGE_PATH"):
            yield from self._crawl(folder, _PACKAGE_SEARCH_DEPTH).get(name, ())
        for folder in _folders_in("AMENT_PREFIX_PATH"):
            yield folder / "share" / name
        for folder in _model_folders():
            yield folder / name
            if folder.name == name:
                yield folder
        for folder in self._above:
            if folder.name == "src" or exists(folder / ".git"):
                yield from self._crawl(folder, _PACKAGE_SEARCH_DEPTH).get(name, ())

    def _crawl(self, top: Path, depth: int) -> Mapping[str, list[Path]]:
        """Return the packages and models at and below a folder, by all their names."""
        if (top, depth) not in self._crawled:
            deepest = 1 if top in self._shallow else depth
            self._crawled[top, depth] = _crawl(top, min(depth, deepest))
        return self._crawled[top, depth]


def _crawl(top: Path, depth: int) -> dict[str, list[Path]]:
    """Search for packages and models breadth first, within limits."""
    found: dict[str, list[Path]] = {}
    seen: set[tuple[int, int]] = set()
    todo = deque([(top, 0)])
    while todo and len(seen) < _MAX_SEARCHED_FOLDERS:
        folder, level = todo.popleft()
        try:
            status = folder.stat()
            if (status.st_dev, status.st_ino) in seen:  # links may lead in a circle
                continue
            seen.add((status.st_dev, status.st_ino))
            for name in _package_names(folder):
                found.setdefault(name, []).append(folder)
            if level < depth:
                todo += [(child, level + 1) for child in _child_folders(folder)]
        except (OSError, ValueError):  # closed to us, or no path at all
            continue
    return found


def _package_names(folder: Path) -> set[str]:
    """Return the names of a folder as a package or model, none if it is neither."""
    marks = [mark for mark in _PACKAGE_FILES if (folder / mark).is_file()]
    names = {folder.name} if marks else set()
    if "package.xml" in marks:
        try:
            names.add(read_xml(folder / "package.xml").findtext("name", "").strip())
        except WorkbenchError:  # a broken package.xml of a neighbour is not this user's concern
            return names
    return names


def _child_folders(folder: Path) -> list[Path]:
    with os.scandir(folder) as entries:
        names = [entry.name for entry in islice(entries, _MAX_FOLDER_ENTRIES) if entry.is_dir()]
    return [folder / name for name in sorted(names) if not name.startswith(".")]


def _folders_in(variable: str) -> list[Path]:
    """Return the folders that an environment variable lists."""
    texts = os.environ.get(variable, "").split(os.pathsep)
    return [Path(text).absolute() for text in texts if text]


def _model_folders() -> list[Path]:
    return [folder for variable in _MODEL_PATH_VARIABLES for folder in _folders_in(variable)]


def own_folder(folder: Path) -> Path:
    """Return the repository, else the package, else the folder of the drone around a folder."""
    shallow = _shallow()
    above = [each for each in (folder, *folder.parents) if each not in shallow]
    for marks in ((".git",), _PACKAGE_FILES):
        for each in above:
            if any(exists(each / mark) for mark in marks):
                return each
    return (
        folder.parent
        if folder.name.lower() in _INNER_FOLDER_NAMES and folder.parent in above
        else folder
    )


def _files(folder: Path) -> list[Path]:
    """Return the files in a folder, within limits."""
    try:
        with os.scandir(folder) as entries:
            return [
                folder / each.name
                for each in islice(entries, _MAX_FOLDER_ENTRIES)
                if each.is_file()
            ]
    except OSError:
        return []


def _shallow() -> set[Path]:
    """Return the folders that contain the whole machine, or all files of a user."""
    try:
        home = Path.home()
    except RuntimeError:
        return {Path("/")}
    return {Path("/"), home, *home.parents}


def _given_folder(name: str, folder: Path | str) -> Path:
    try:
        path = Path(folder).expanduser()
    except RuntimeError:  # ~NOBODY
        path = Path(folder)
    if not _is_folder(path):
        raise WorkbenchError(
            f"package '{name}': '{folder}' is not a folder: give --package {name}=DIR with the "
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


def exists(path: Path) -> bool:
    """Return whether a path is a file or folder; a device or a pipe would never end."""
    try:
        return path.is_file() or path.is_dir()
    except (OSError, ValueError):  # a name too long, a folder closed to us, a null character
        return False
