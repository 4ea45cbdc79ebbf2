"""The document of an MJCF file as MuJoCo sees it: includes, copies, settings and defaults."""

import math
from collections.abc import Iterator, Mapping, Sequence
from itertools import count
from pathlib import Path
from typing import NamedTuple

import numpy as np

from workbench.common.errors import WorkbenchError
from workbench.extras.formats.mjcf_compiler import Compiler, read_compiler
from workbench.extras.formats.mjcf_defaults import Defaults
from workbench.extras.formats.mjcf_elements import attribute_fault, elements
from workbench.extras.formats.mjcf_pose import rotation_from_euler
from workbench.plant.formats.values import (
    attribute_number,
    attribute_triple,
    shortened_text,
)
from workbench.plant.formats.xml import MAX_XML_ELEMENTS, Element, element_location, read_xml
from workbench.plant.packages import PackageFinder
from workbench.plant.remarks import Remarks

MAX_MJCF_INCLUDE_DEPTH = 20
"""Largest depth of nested includes."""
MAX_REPLICATED_ELEMENTS = 20_000
"""Largest number of elements that `<replicate>` makes, more than any drone has."""


class MjcfDocument(NamedTuple):
    """A document as it is read.

    Attributes:
        path: of the main file.
        root: its root, without includes and `<replicate>`.
        compiler: its settings.
        defaults: its defaults.
        earlier: for tag and name of each copy that `<replicate>` made of a site or a joint, the
            names that it had before, the one in the file first.
        remarks: receives remarks on what is not read, or otherwise.
    """

    path: Path
    root: Element
    compiler: Compiler
    defaults: Defaults
    earlier: Mapping[tuple[str, str], Sequence[str]]
    remarks: Remarks

    def suffixes(self, tag: str, name: str) -> list[str]:
        """Return what was added to a name for each of its copies, "" if there are none."""
        found = [
            copy.removeprefix(name)
            for (kind, copy), names in self.earlier.items()
            if kind == tag and name in names
        ]
        return found or [""]


def read_mjcf_document(
    path: Path, root: Element, finder: PackageFinder, remarks: Remarks
) -> MjcfDocument:
    """Return a document with included files, and with copies in place of `<replicate>`.

    Args:
        path: the main file.
        root: its root element.
        finder: knows which files the description may read.
        remarks: see `MjcfDocument`.

    Raises:
        WorkbenchError: naming file and element, for invalid content.
    """
    whole = _with_includes(path, root, finder)
    compiler = read_compiler(path, whole)
    copied, earlier = _without_replicates(whole, compiler)
    return MjcfDocument(path, copied, compiler, Defaults(copied), earlier, remarks)


def _with_includes(main: Path, root: Element, finder: PackageFinder) -> Element:
    """Return a copy of a document with the content of included files.

    Paths are relative to the main file, or else to the including one, as in MuJoCo. It refuses a
    missing file, one that the description may not read, one twice, and includes nested too deeply.
    """
    numbered = count(1)
    seen: set[Path] = set()

    def resolved(element: Element, files: tuple[Path, ...]) -> Element:
        """Return a copy of an element of the last of the files that lead to it, main file first."""
        if next(numbered) > MAX_XML_ELEMENTS:
            raise WorkbenchError(f"{main}: with includes there are too many elements")
        copy = element.like(element.attrib)
        copy.text = element.text
        if len(files) > 1:  # messages name the main file
            copy.file, copy.line = main, 0
            copy.owner = f"{files[-1].name}:{element.line}"
        for child in elements(element):
            if child.tag == "include":
                file = included(child, files)
                copy.extend(resolved(_included_root(file), (*files, file)))
            else:
                copy.append(resolved(child, files))
        return copy

    def included(include: Element, files: tuple[Path, ...]) -> Path:
        name = include.get("file", "")
        what = f"{element_location(include)}: <include file='{shortened_text(name)}'>"
        places = [each.parent / name for each in (files[0], files[-1])]
        file = next((each for each in places if each.is_file()), None)
        if not name or file is None:
            raise WorkbenchError(f"{what}: no such file")
        path = file.resolve()
        if path in [each.resolve() for each in files] or len(files) > MAX_MJCF_INCLUDE_DEPTH:
            raise WorkbenchError(f"{what} includes itself")
        if path in seen:
            raise WorkbenchError(f"{what}: it is included already, which MuJoCo refuses")
        finder.allowed(file, what)
        seen.add(path)
        return file

    return resolved(root, (main,))


def _included_root(file: Path) -> Element:
    root = read_xml(file)
    if root.tag not in ("mujoco", "mujocoinclude"):
        raise WorkbenchError(
            f"{file}: the root element is <{shortened_text(root.tag)}>, an included MJCF has "
            "<mujoco> or <mujocoinclude>"
        )
    return root


_REFERRED_TAGS = ("site", "joint")
"""Elements of a body that actuators refer to, which are copied with them."""


def _without_replicates(
    root: Element, compiler: Compiler
) -> tuple[Element, dict[tuple[str, str], list[str]]]:
    """Return a document with a `<frame>` for each copy of a `<replicate>`, and their earlier names.

    The i-th copy is turned by i times `euler`, and shifted from the one before by `offset`, turned
    like that one. Names get the number of the copy, with as many digits as `count` has (MuJoCo's
    user guide, replicate; mjXReader::Body).

    Args:
        root: without includes.
        compiler: its settings.

    Raises:
        WorkbenchError: for an invalid count, or too many copies.
    """
    earlier: dict[tuple[str, str], list[str]] = {}
    numbered = count(1)

    def copied(element: Element) -> Element:
        copy = element.like(element.attrib)
        copy.text = element.text
        copy.extend(list(content(element)))  # a list: 3.11 hides errors of generators
        return copy

    def content(element: Element) -> Iterator[Element]:
        for child in elements(element):
            if child.tag == "replicate":
                yield from replicated(child)
            else:
                yield copied(child)

    def replicated(element: Element) -> Iterator[Element]:
        for name in element.attrib.keys() - {"count", "euler", "offset", "sep", "childclass"}:
            raise attribute_fault(element, name, "MuJoCo has no such attribute: leave it out")
        times = attribute_number(element, "count")
        if times != int(times) or not 0 <= times <= MAX_REPLICATED_ELEMENTS:
            raise attribute_fault(
                element, "count", f"give it the number of copies, up to {MAX_REPLICATED_ELEMENTS}"
            )
        if any(child.tag == "inertial" for child in elements(element)):
            raise WorkbenchError(
                f"{element_location(element)}: <replicate> has an <inertial>, which a body has "
                "once: move it "
                "out, or into a <body>"
            )
        angles = np.array(attribute_triple(element, "euler", "0 0 0"))
        offset = np.array(attribute_triple(element, "offset", "0 0 0"))
        scale = 1.0 if compiler.radians else math.pi / 180.0
        childclass = {
            name: element.attrib[name] for name in ["childclass"] if name in element.attrib
        }
        p = np.zeros(3)
        originals = list(content(element))
        for index in range(int(times)):
            limit(element)
            R = rotation_from_euler(scale * index * angles, compiler.eulerseq)
            words = {"pos": _numbers_text(p), "quat": _numbers_text(R.ToQuaternion().wxyz())}
            frame = element.like(words | childclass)
            frame.tag = "frame"
            suffix = f"{element.get('sep', '')}{index:0{len(str(int(times)))}}"
            frame.extend([renamed(child, suffix) for child in originals])
            yield frame
            p = p + R.multiply(offset)
        for tag in _REFERRED_TAGS:
            for each in (each for child in originals for each in child.iter(tag)):
                earlier.pop((tag, each.get("name", "")), None)

    def limit(element: Element) -> None:
        if next(numbered) > MAX_REPLICATED_ELEMENTS:
            raise WorkbenchError(
                f"{element_location(element)}: <replicate> would make more than "
                f"{MAX_REPLICATED_ELEMENTS} elements"
            )

    def renamed(element: Element, suffix: str) -> Element:
        limit(element)
        copy = element.like(element.attrib)
        name = element.get("name")
        if name:
            copy.set("name", name + suffix)
            if element.tag in _REFERRED_TAGS:
                before = earlier.get((element.tag, name), [])
                earlier[element.tag, name + suffix] = [*before, name]
        copy.extend([renamed(child, suffix) for child in elements(element)])
        return copy

    return copied(root), earlier


def _numbers_text(values: np.ndarray) -> str:
    return " ".join(map(repr, values.tolist()))
