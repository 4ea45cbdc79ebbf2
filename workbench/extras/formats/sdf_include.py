"""Read SDF files, and find their includes."""

import re
from dataclasses import dataclass
from pathlib import Path
from urllib.parse import unquote

from workbench.common.errors import WorkbenchError
from workbench.extras.formats.sdf_node import Node
from workbench.plant.formats.model_folder import description_file
from workbench.plant.formats.template import refuse_template
from workbench.plant.formats.values import shortened_text
from workbench.plant.formats.xml import Element, element_location, read_xml
from workbench.plant.packages import PackageFinder

OLDEST_SDF_VERSION = (1, 3)
"""First version with poses in elements instead of attributes."""

_SDF_VERSION_PATTERN = re.compile(r"(\d{1,4})\.(\d{1,4})(\.\d{1,4})*")


class MissingIncludeError(WorkbenchError):
    """The file of an `<include>` is not found."""


@dataclass(frozen=True)
class SdfFile:
    """A file that was read.

    Attributes:
        path: of the file.
        root: its `<sdf>` element.
        version: of SDF.
        size: number of elements.
    """

    path: Path
    root: Element
    version: tuple[int, int]
    size: int


class SdfFiles:
    """SDF files; each one is read once."""

    def __init__(self, finder: PackageFinder) -> None:
        self._finder = finder
        self._read: dict[Path, SdfFile] = {}

    def open(self, path: Path) -> SdfFile:
        """Return the content of a file.

        Raises:
            WorkbenchError: naming file and line, if it is not an SDF file.
        """
        if path not in self._read:
            self._read[path] = _read_sdf_file(path)
        return self._read[path]

    def included(self, include: Node) -> SdfFile:
        """Return the file of an `<include>`.

        Raises:
            MissingIncludeError: naming the `<include>`, if its file is not found.
            WorkbenchError: if it is not SDF.
        """
        uri = include.text_of("uri")
        if not uri:
            raise include.fault("<include> without a <uri>: say which model it includes")
        try:
            return self.open(description_file(self._find(include, uri)))
        except OSError as error:
            raise include.fault(f"<include> of '{shortened_text(uri)}': {error}") from error

    def _find(self, include: Node, uri: str) -> Path:
        """Return the file or folder for the URI of an `<include>`."""
        name = model_name(uri)
        online = uri.startswith(("http://", "https://"))
        found = None if online else self._finder.resolve(uri, include.file)
        if found is None and name:
            found = self._finder.folder(name)
            if online and found and include.file.is_relative_to(found):
                found = None  # a local wrapper of the model online, by the same name
        if found:
            return found
        if not online:
            self._finder.refuse_outside(
                uri, include.file, f"{element_location(include.element)}: <include>"
            )
        problem = (
            "is on the internet, and nothing is downloaded: download the model and"
            if online
            else "is not found:"
        )
        text = (
            f"<include> of '{shortened_text(uri)}' {problem} "
            f"{self._finder.hint(shortened_text(name))}"
        )
        raise MissingIncludeError(str(include.fault(text)))


def model_name(uri: str) -> str:
    """Return the name of the model in the URI of an `<include>`, or "".

    In a model:// URI or a relative path it is the first part; in an address at Fuel, which ends in
    `models/NAME` and perhaps a version, it is the part after `models`.
    """
    scheme, separator, rest = uri.partition("://")
    parts = [
        part for part in (rest if separator else uri).split("/") if part not in ("", ".", "..")
    ]
    if scheme in ("http", "https") and "models" in parts[:-1]:
        return unquote(parts[parts.index("models") + 1])
    if scheme in ("http", "https", "file") or uri.startswith("/"):
        return parts[-1] if parts else ""
    return parts[0] if parts else ""


def _read_sdf_file(path: Path) -> SdfFile:
    try:
        root = read_xml(path)
    except WorkbenchError:
        refuse_template(path)  # a template is rarely XML, and this message is better
        raise
    refuse_template(path)
    return sdf_file(path, root)


def sdf_file(path: Path, root: Element) -> SdfFile:
    """Return a file for its root element, which may be the result of xacro.

    Raises:
        WorkbenchError: naming file and line, if it is not an SDF file.
    """
    if root.tag == "robot":
        raise WorkbenchError(
            f"{element_location(root)}: this is URDF (<robot>), but an SDF file is included here: "
            "convert it "
            "to SDF"
        )
    if root.tag != "sdf":
        raise WorkbenchError(
            f"{element_location(root)}: the root element is <{shortened_text(root.tag)}>, an SDF "
            "file has <sdf>"
        )
    text = root.get("version", "").strip()
    match = _SDF_VERSION_PATTERN.fullmatch(text)
    version: tuple[int, int] = (int(match[1]), int(match[2])) if match else (0, 0)
    if version < OLDEST_SDF_VERSION:
        raise WorkbenchError(
            f"{element_location(root)}: <sdf version='{shortened_text(text)}'>: SDF is read from "
            f"version {OLDEST_SDF_VERSION[0]}.{OLDEST_SDF_VERSION[1]} on: convert the file with "
            "`gz sdf -p`"
            if match
            else f"{element_location(root)}: <sdf version='{shortened_text(text)}'>: give it the "
            "version of SDF that it is written in, such as 1.9"
        )
    return SdfFile(path, root, version, sum(1 for _ in root.iter()))
