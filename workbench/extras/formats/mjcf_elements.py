"""Elements of MJCF and their attributes."""

from collections.abc import Iterator
from xml.etree import ElementTree

from workbench.common.errors import WorkbenchError
from workbench.plant.formats.values import attribute_numbers, shortened_text
from workbench.plant.formats.xml import Element, element_location


def keyword_attribute(element: Element, name: str, default: str, known: str) -> str:
    """Return an attribute with one of some values, which are given as words.

    Raises:
        WorkbenchError: if it has another.
    """
    value = element.get(name, default)
    if value not in known.split():
        raise attribute_fault(element, name, f"use {' or '.join(known.split())}")
    return value


def padded_numbers(element: Element, name: str, default: str, size: int) -> list[float]:
    """Return the first numbers of an attribute, with zeros in place of missing ones."""
    return [*attribute_numbers(element, name, default), *[0.0] * size][:size]


def is_true_attribute(element: Element, name: str, default: str) -> bool:
    """Return whether an attribute is `true`.

    Raises:
        WorkbenchError: if it is neither `true` nor `false`.
    """
    return keyword_attribute(element, name, default, "true false") == "true"


def attribute_fault(element: Element, name: str, advice: str) -> WorkbenchError:
    """Return an error about an attribute of an element."""
    text = shortened_text(element.get(name, ""))
    return WorkbenchError(f"{element_location(element)}: <{element.tag} {name}='{text}'>: {advice}")


def elements(parent: ElementTree.Element, *tags: str) -> Iterator[Element]:
    """Yield the children with one of these tags; all children without tags."""
    for child in parent:
        if isinstance(child, Element) and (child.tag in tags or not tags):
            yield child


def elements_of(root: Element, group: str, *tags: str) -> Iterator[Element]:
    """Yield the children of all elements of a group, such as `asset`, see `elements`."""
    for block in elements(root, group):
        yield from elements(block, *tags)
