"""Plugins of models in SDF."""

from workbench.plant.formats.sdf_node import Node
from workbench.plant.formats.xml import Element
from workbench.plant.model import DeclaredPlugin

_NAMES = ("jointName", "linkName", "joint_name", "link_name")
"""Elements of plugins that name a part of the model that the plugin belongs to."""


def read_plugin(plugin: Node) -> DeclaredPlugin:
    """Return a plugin, with the names in it as names of the whole."""
    element = _with_scope(plugin.element, plugin.scope) if plugin.scope else plugin.element
    return DeclaredPlugin(plugin.file, element)


def _with_scope(element: Element, scope: str) -> Element:
    """Return a copy in which the names of links and joints have the scope in front."""
    copy = Element(element.tag, element.attrib)
    copy.line = element.line
    copy.text, copy.tail = element.text, element.tail
    if element.tag in _NAMES and (element.text or "").strip():
        copy.text = scope + (element.text or "").strip()
    copy.extend([_with_scope(child, scope) for child in element if isinstance(child, Element)])
    return copy
