"""Read SDF files, and find their includes."""

import re
from dataclasses import dataclass
from pathlib import Path
from urllib.parse import unquote

from workbench.common.errors import WorkbenchError
from workbench.common.plain_files import read_plain
from workbench.plant.formats.model_folder import description_file
from workbench.plant.formats.sdf_node import Node
from workbench.plant.formats.values import shortened
from workbench.plant.formats.xml import MOST_BYTES, Element, place, read_xml
from workbench.plant.packages import PackageFinder

OLDEST = (1, 3)
"""First version with poses in elements instead of attributes."""

_TEMPLATE = re.compile(rb"\{\{[^\n]*?\}\}|\{%|<%")
_VERSION = re.compile(r"(\d{1,4})\.(\d{1,4})(\.\d{1,4})*")


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
            self._read[path] = _read(path)
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
            raise include.fault(f"<include> of '{shortened(uri)}': {error}") from error

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
            self._finder.refuse_outside(uri, include.file, f"{place(include.element)}: <include>")
        problem = (
            "is on the internet, and nothing is downloaded: download the model and"
            if online
            else "is not found:"
        )
        text = f"<include> of '{shortened(uri)}' {problem} {self._finder.hint(shortened(name))}"
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


def _read(path: Path) -> SdfFile:
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
            f"{place(root)}: this is URDF (<robot>), but an SDF file is included here: convert it "
            "to SDF"
        )
    if root.tag != "sdf":
        raise WorkbenchError(
            f"{place(root)}: the root element is <{shortened(root.tag)}>, an SDF file has <sdf>"
        )
    text = root.get("version", "").strip()
    match = _VERSION.fullmatch(text)
    version: tuple[int, int] = (int(match[1]), int(match[2])) if match else (0, 0)
    if version < OLDEST:
        raise WorkbenchError(
            f"{place(root)}: <sdf version='{shortened(text)}'>: SDF is read from version "
            f"{OLDEST[0]}.{OLDEST[1]} on: convert the file with `gz sdf -p`"
            if match
            else f"{place(root)}: <sdf version='{shortened(text)}'>: give it the version of "
            "SDF that it is written in, such as 1.9"
        )
    return SdfFile(path, root, version, sum(1 for _ in root.iter()))


def refuse_template(path: Path) -> None:
    """Reject a jinja or erb template; comments are ignored.

    Raises:
        WorkbenchError: naming file and line of the first template mark.
    """
    data = read_plain(path, MOST_BYTES)
    line = 1
    for index, part in enumerate(data.split(b"<!--")):
        comment, _, text = part.partition(b"-->") if index else (b"", b"", part)
        line += comment.count(b"\n")
        match = _TEMPLATE.search(text)
        if match:
            line += text[: match.start()].count(b"\n")
            raise WorkbenchError(
                f"{path}:{line}: '{shortened(match[0].decode(errors='replace'))}' makes this a "
                "template: render it first (jinja or erb) and give the result"
            )
        line += text.count(b"\n")
