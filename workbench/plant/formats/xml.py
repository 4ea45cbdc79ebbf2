"""Read untrusted XML with line numbers, and limits of size and depth, without entities."""

from collections.abc import Mapping
from pathlib import Path
from xml.etree import ElementTree as ET
from xml.parsers import expat

from workbench.common.errors import WorkbenchError
from workbench.common.plain_files import read_plain

MAX_XML_BYTES = 16_000_000
"""Size limit, larger than any description [bytes]."""
MAX_XML_ELEMENTS = 200_000
MAX_XML_DEPTH = 100
_PART_TAGS = ("link", "joint", "plugin", "sensor")


class Element(ET.Element):
    """An element with its file, and its line in it, or 0.

    In a text made from a file, it has the name of the part that it belongs to instead.
    """

    file: Path = Path()
    line: int = 0
    owner: str = ""

    def like(self, attributes: Mapping[str, str]) -> "Element":
        """Return an element with this tag and place, other attributes, and no children."""
        made = Element(self.tag, dict(attributes))
        made.file, made.line, made.owner = self.file, self.line, self.owner
        return made


def read_xml(path: Path) -> Element:
    """Return the root element of an XML file.

    Raises:
        WorkbenchError: naming file and line, if it is not XML, or too large.
    """
    return _parse(read_plain(path, MAX_XML_BYTES), path, None, lines=True)


def parse_xml(text: str, path: Path) -> Element:
    """Return the root element of a text that was made from a file, without line numbers.

    Raises:
        WorkbenchError: as `read_xml` does.
    """
    root = _parse(text.encode("utf-8", "replace"), path, "utf-8", lines=False)
    for part in root.iter():
        if part.tag in _PART_TAGS and (name := part.get("name", "")):
            for element in part.iter():
                assert isinstance(element, Element)
                element.owner = f"{part.tag} '{name[:80]}'"
    return root


def _parse(data: bytes, path: Path, encoding: str | None, *, lines: bool) -> Element:
    reader = _ElementTreeBuilder(path, encoding, lines)
    try:
        try:
            return reader.read(data)
        except expat.ExpatError:
            return _ElementTreeBuilder(path, encoding, lines).read(_without_comments(data))
    except expat.ExpatError as error:
        where = f"{path}:{error.lineno}" if lines else f"{path}"
        raise WorkbenchError(f"{where}: not XML: {expat.ErrorString(error.code)}") from error
    except (ValueError, LookupError) as error:
        raise WorkbenchError(f"{path}: not XML: {error}") from error


def _without_comments(data: bytes) -> bytes:
    """Return a document with its comments replaced by their line ends.

    XML forbids two hyphens in a comment, but Gazebo's own worlds have them.
    """
    first, *rest = data.split(b"<!--")
    kept = [first]
    for part in rest:
        comment, _, after = part.partition(b"-->")
        kept.append(b"\n" * comment.count(b"\n") + after)
    return b"".join(kept)


class _ElementTreeBuilder:
    """Builds the tree from expat's events."""

    def __init__(self, path: Path, encoding: str | None, lines: bool) -> None:
        self._path = path
        self._lines = lines
        self._depth = 0
        self._count = 0
        self._skipped = 0
        self._builder = ET.TreeBuilder(element_factory=Element)
        self._parser = expat.ParserCreate(encoding)
        self._parser.buffer_text = True
        self._parser.StartElementHandler = self._start
        self._parser.EndElementHandler = self._end
        self._parser.CharacterDataHandler = self._builder.data
        self._parser.EntityDeclHandler = self._entity

    def read(self, data: bytes) -> Element:
        text = data.lstrip(b"\r\n\t ")  # not allowed before <?xml, but accepted by Gazebo
        self._skipped = data[: len(data) - len(text)].count(b"\n")
        self._parser.Parse(text, True)
        root = self._builder.close()
        assert isinstance(root, Element)
        return root

    @property
    def _line(self) -> int:
        return self._parser.CurrentLineNumber + self._skipped

    def _start(self, tag: str, attributes: dict[str, str]) -> None:
        self._depth += 1
        self._count += 1
        if self._depth > MAX_XML_DEPTH:
            raise self._fault(f"elements are nested more than {MAX_XML_DEPTH} deep")
        if self._count > MAX_XML_ELEMENTS:
            raise self._fault(f"there are more than {MAX_XML_ELEMENTS} elements")
        element = self._builder.start(tag, attributes)
        assert isinstance(element, Element)
        element.file = self._path
        element.line = self._line if self._lines else 0

    def _end(self, tag: str) -> None:
        self._depth -= 1
        self._builder.end(tag)

    def _entity(self, *_: object) -> None:
        raise self._fault("it declares its own entities: write them out")

    def _fault(self, what: str) -> WorkbenchError:
        where = f"{self._path}:{self._line}" if self._lines else self._path
        return WorkbenchError(f"{where}: {what}")


def element_location(element: ET.Element) -> str:
    """Return file and line of an element, or its part, for the beginning of a message."""
    assert isinstance(element, Element)
    if element.line:
        return f"{element.file}:{element.line}"
    return f"{element.file}: {element.owner}" if element.owner else f"{element.file}"
