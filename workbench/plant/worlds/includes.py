"""Files that directives and models include: walked before Drake, which follows circles for ever."""

from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from workbench.common.errors import WorkbenchError
from workbench.common.yaml_files import read_yaml
from workbench.plant.formats.xml import read_xml
from workbench.plant.packages import PackageFinder
from workbench.plant.worlds.tagged import TaggedLoader

DEEPEST = 20
"""So deep may files include each other."""
MOST_FILES = 1000
"""So many may be included, one that is included twice counted twice."""


class _File(NamedTuple):
    path: Path
    has_directives: bool


class Includes:
    """Walks what the directives of one world include."""

    def __init__(self, finder: PackageFinder) -> None:
        """Begin to count.

        Args:
            finder: of the files that are named.
        """
        self._finder = finder
        self._count = 0
        self._inner: dict[_File, tuple[_File, ...]] = {}

    def check(self, path: Path, *, has_directives: bool) -> None:
        """Refuse what would keep Drake busy for ever, or end in a crash.

        What cannot be found is left for Drake to name.

        Args:
            path: the file that a directive names.
            has_directives: whether it is one of directives, and not a model.

        Raises:
            WorkbenchError: beginning with the file that includes itself, that lies too deep, is
                one too many, cannot be read, or is a model of MuJoCo's.
        """
        self._walk(_File(path.resolve(), has_directives), ())

    def _walk(self, file: _File, above: tuple[_File, ...]) -> None:
        self._count += 1
        if file in above:
            raise WorkbenchError(f"{file.path}: includes itself: take the include out of it")
        if len(above) > DEEPEST:
            raise WorkbenchError(
                f"{file.path}: is included more than {DEEPEST} deep: put it into what includes it"
            )
        if self._count > MOST_FILES:
            raise WorkbenchError(
                f"{file.path}: with this more than {MOST_FILES} files are included: leave some out"
            )
        if file not in self._inner:
            self._inner[file] = tuple(self._named(file))
        for inner in self._inner[file]:
            self._walk(inner, (*above, file))

    def _named(self, file: _File) -> Iterator[_File]:
        """Yield the files that a file names, as far as they are found."""
        if file.has_directives:
            yield from self._in_directives(file.path)
        elif file.path.suffix.lower() == ".xml":
            raise WorkbenchError(f"{file.path}: is a model of MuJoCo's: give it as SDF or URDF")
        elif file.path.suffix.lower() not in (".urdf", ".obj"):  # these include nothing
            for element in read_xml(file.path).iter("include"):
                yield from self._of_uri(element.findtext("uri", ""), file.path)

    def _in_directives(self, path: Path) -> Iterator[_File]:
        items = read_yaml(path, TaggedLoader).data.get("directives")
        for item in items if isinstance(items, list) else []:
            for kind, words in item.items() if isinstance(item, dict) else []:
                uri = words.get("file") if isinstance(words, dict) else None
                found = self._finder.resolve(uri, path) if isinstance(uri, str) else None
                if found and found.is_file():
                    yield _File(found.resolve(), kind == "add_directives")

    def _of_uri(self, uri: str, file: Path) -> Iterator[_File]:
        """Yield what an `<include>` may mean: Drake looks in the working directory as well."""
        places = (file, Path.cwd() / file.name)
        for found in dict.fromkeys(self._finder.resolve(uri, place) for place in places):
            if found and found.is_dir():
                yield from (_File(each, False) for each in _of_folder(found))
            elif found:
                yield _File(found.resolve(), False)


def _of_folder(folder: Path) -> Iterator[Path]:
    """Yield the models of a model's folder, of all versions of SDF."""
    for config in (folder / "model.config", folder / "manifest.xml"):
        for element in read_xml(config).iter("sdf") if config.is_file() else ():
            path = folder / (element.text or "").strip()
            if path.is_file():
                yield path.resolve()
