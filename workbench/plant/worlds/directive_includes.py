"""Files that model directives include, checked before Drake reads them."""

from collections.abc import Iterator
from pathlib import Path
from xml.etree import ElementTree as ET

from workbench.common.errors import WorkbenchError
from workbench.common.yaml_files import read_yaml, tagged_loader
from workbench.plant.formats.values import shortened_text
from workbench.plant.formats.xml import element_location, read_xml
from workbench.plant.packages import PackageFinder

MAX_DIRECTIVE_DEPTH = 20
"""Largest depth of nested includes."""
MAX_INCLUDED_FILES = 1000
"""Largest number of included files; repeated ones count again."""
_MAX_WORLD_MESH_BYTES = 15_000_000
"""Size limit of a mesh, which takes Drake 25 times as much memory [bytes]."""


_IncludedFile = tuple[Path, bool]
"""A file, and whether it has directives."""


class IncludeChecker:
    """Checks the includes in the directives of one world."""

    def __init__(self, finder: PackageFinder) -> None:
        """Start counting.

        Args:
            finder: of the named files.
        """
        self._finder = finder
        self._count = 0
        self._inner: dict[_IncludedFile, tuple[_IncludedFile, ...]] = {}

    def check(self, path: Path, *, has_directives: bool) -> None:
        """Reject files that would let Drake run for ever, or crash.

        Drake reports missing files.

        Args:
            path: the file in a directive.
            has_directives: whether it has directives, and is not a model.

        Raises:
            WorkbenchError: beginning with the file that includes itself, is nested too deeply,
                exceeds the number of files, cannot be read, or is a MuJoCo model.
        """
        self._walk((path.resolve(), has_directives), ())

    def _walk(self, file: _IncludedFile, above: tuple[_IncludedFile, ...]) -> None:
        self._count += 1
        if file in above:
            raise WorkbenchError(f"{file[0]}: includes itself: remove this include")
        if len(above) > MAX_DIRECTIVE_DEPTH:
            raise WorkbenchError(
                f"{file[0]}: is included more than {MAX_DIRECTIVE_DEPTH} deep: put it into what "
                "includes it"
            )
        if self._count > MAX_INCLUDED_FILES:
            raise WorkbenchError(
                f"{file[0]}: with this one, more than {MAX_INCLUDED_FILES} files are included: "
                "leave "
                "some out"
            )
        if file not in self._inner:
            self._inner[file] = tuple(self._named(file))
        for inner in self._inner[file]:
            self._walk(inner, (*above, file))

    def _named(self, file: _IncludedFile) -> Iterator[_IncludedFile]:
        """Yield the files named in a file that are found."""
        path, has_directives = file
        if has_directives:
            yield from self._in_directives(path)
        elif path.suffix.lower() == ".xml":
            raise WorkbenchError(f"{path}: is a MuJoCo model: give it as SDF or URDF")
        elif path.suffix.lower() != ".obj":
            for element in read_xml(path).iter():
                self._check_named(element, path)
                if element.tag == "include":
                    yield from self._of_uri(element.findtext("uri", ""), path)

    def _check_named(self, element: ET.Element, file: Path) -> None:
        """Reject a file named in an element that is outside of the world's folder, or too large."""
        uri = (element.text if element.tag == "uri" else element.get("filename")) or ""
        for near in _near(file) if uri.strip() else ():
            self._finder.refuse_outside(uri, near, element_location(element))
            found = self._finder.resolve(uri, near)
            if found and found.is_file() and found.stat().st_size > _MAX_WORLD_MESH_BYTES:
                most = f"{_MAX_WORLD_MESH_BYTES // 1_000_000} MB"
                raise WorkbenchError(
                    f"{element_location(element)}: '{shortened_text(uri)}' is larger than {most}: "
                    "use fewer faces"
                )

    def _in_directives(self, path: Path) -> Iterator[_IncludedFile]:
        items = read_yaml(path, tagged_loader()).data.get("directives")
        for item in items if isinstance(items, list) else []:
            for kind, words in item.items() if isinstance(item, dict) else []:
                uri = words.get("file") if isinstance(words, dict) else None
                found = self._finder.resolve(uri, path) if isinstance(uri, str) else None
                if found and found.is_file():
                    yield found.resolve(), kind == "add_directives"

    def _of_uri(self, uri: str, file: Path) -> Iterator[_IncludedFile]:
        """Yield the possible files of an `<include>`."""
        for found in dict.fromkeys(self._finder.resolve(uri, near) for near in _near(file)):
            if found and found.is_dir():
                yield from ((each, False) for each in _of_folder(found))
            elif found:
                yield found.resolve(), False


def _near(file: Path) -> tuple[Path, Path]:
    """Return a file, and one of its name in the working directory, which Drake searches, too."""
    return file, Path.cwd() / file.name


def _of_folder(folder: Path) -> Iterator[Path]:
    """Yield the files in the folder of a model, for all versions of SDF."""
    for config in (folder / "model.config", folder / "manifest.xml"):
        for element in read_xml(config).iter("sdf") if config.is_file() else ():
            path = folder / (element.text or "").strip()
            if path.is_file():
                yield path.resolve()
