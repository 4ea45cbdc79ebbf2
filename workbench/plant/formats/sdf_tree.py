"""Put a model together from its file, its nested models and what it includes."""

import os
from collections.abc import Container
from dataclasses import dataclass, replace
from itertools import count
from pathlib import Path

from workbench.plant.formats.sdf_include import MissingIncludeError, SdfFile, SdfFiles
from workbench.plant.formats.sdf_node import Node, checked_name, flag
from workbench.plant.formats.xml import MOST_ELEMENTS, Element

ROOT = "__model__"
"""The frame of the model that words belong to."""
DEEPEST = 20
"""Models in models, whether included or written out."""
MOST_INCLUDES = 200
MOST_PARTS = 5000
"""Elements of models, links and joints: far more than a drone has."""


@dataclass(frozen=True)
class Frame:
    """A frame F: of a model, a link or a joint, or a `<frame>`.

    Attributes:
        name: in the whole: `__model__`, `child::__model__`.
        owner: the element, in the words in which its pose is given: of a model those of what is
            around it.
        pose: its `<pose>`, if it has one.
        base: the name of the frame that the pose is given in, unless it says otherwise.
        inside: the element, in the words in which the next two are given.
        carrier: the name of the frame that it moves with; "" for a link, or a model without one.
        placement: the name of the frame that the pose places; "" for itself.
    """

    name: str
    owner: Node
    pose: Node | None
    base: str
    inside: Node
    carrier: str
    placement: str = ""


@dataclass(frozen=True)
class SdfTree:
    """A model with all that belongs to it, in the order of the files.

    Attributes:
        name: of the model.
        static: whether it says that it never moves.
        sources: the `<model>` and `<include>` elements that were read, of each file one.
        models: frames of the model and of those in it.
        links: `<link>` elements.
        joints: `<joint>` elements.
        frames: `<frame>` elements.
        plugins: `<plugin>` elements of models and includes.
        missing: `<include>`s in the model whose files are not here, each with the error that says
            so.
    """

    name: str
    static: bool
    sources: tuple[Node, ...]
    models: tuple[Frame, ...]
    links: tuple[Node, ...]
    joints: tuple[Node, ...]
    frames: tuple[Node, ...]
    plugins: tuple[Node, ...]
    missing: tuple[tuple[Node, MissingIncludeError], ...] = ()


def grow_tree(file: SdfFile, top: Node, files: SdfFiles) -> SdfTree:
    """Return the whole of a model; what it includes and is not here is told, and left out.

    Args:
        file: it stands in.
        top: its `<model>`, or the `<include>` that stands for it.
        files: where to find included ones.

    Raises:
        WorkbenchError: naming file and line of an include that leads nowhere or in a circle, of
            what is nested too deep, and of a model that is too large.
    """
    grower = _Grower(files, file, top)
    found = grower.follow(_Found(top, (), (file.path,)))
    grower.add(found, found.model, 1)
    return _tree(grower, found, found.name)


def grow_in_world(file: SdfFile, top: Node, files: SdfFiles, taken: Container[str]) -> SdfTree:
    """Return the whole of a model as a part of its world: its names begin with its own.

    Args:
        file: see `grow_tree`.
        top: see `grow_tree`.
        files: see `grow_tree`.
        taken: names that other models have; a second of one name gets a number behind it.

    Raises:
        WorkbenchError: see `grow_tree`.
    """
    grower = _Grower(files, file, top)
    found = grower.follow(_Found(top, (), (file.path,)))
    names = (f"{found.name}_{number}" if number else found.name for number in count())
    name = next(name for name in names if name not in taken)
    grower.add(found, _nested(found, name), 1)
    for _, fault in grower.missing:
        raise fault
    return _tree(grower, found, name)


def _tree(grower: "_Grower", found: "_Found", name: str) -> SdfTree:
    """Return what was collected of a model."""
    static = found.first("static")
    return SdfTree(
        name=name,
        static=static is not None and flag(static, static.text),
        sources=tuple(grower.sources),
        models=tuple(grower.models),
        links=tuple(grower.links),
        joints=tuple(grower.joints),
        frames=tuple(grower.frames),
        plugins=tuple(grower.plugins),
        missing=tuple(grower.missing),
    )


@dataclass(frozen=True)
class _Found:
    """A model as it was found, in the words of what is around it.

    Attributes:
        model: the `<model>`, or an `<include>` that is still to be followed.
        includes: the `<include>`s that led here from what is around it, the outer ones first.
        files: the files that led here from the first on, its own last.
    """

    model: Node
    includes: tuple[Node, ...]
    files: tuple[Path, ...]

    @property
    def name(self) -> str:
        """What the model is called where it is used."""
        for include in self.includes:
            name = include.child("name")
            if name and name.text:
                return checked_name(name, name.text)
        return self.model.name

    @property
    def placement(self) -> str:
        """The name of the frame inside that its pose places, "" for the model's own."""
        given = [include.text_of("placement_frame") for include in self.includes]
        return next(filter(None, given), self.model.attribute("placement_frame"))

    def first(self, tag: str) -> Node | None:
        """Return a child of the includes or the model; what an outer one says holds."""
        children = (over.child(tag) for over in (*self.includes, self.model))
        return next((child for child in children if child), None)


class _Grower:
    """Collects the parts of a model."""

    def __init__(self, files: SdfFiles, file: SdfFile, top: Node) -> None:
        self._files = files
        self._size = file.size
        self._includes = 0
        self._parts = 0
        self.sources = [top]
        self.models: list[Frame] = []
        self.links: list[Node] = []
        self.joints: list[Node] = []
        self.frames: list[Node] = []
        self.plugins: list[Node] = []
        self.missing: list[tuple[Node, MissingIncludeError]] = []

    def follow(self, found: _Found) -> _Found:
        """Return the model that includes lead to; a model is returned as it is."""
        while found.model.element.tag == "include":
            include = found.model
            file = self._open(include, found.files)
            top = only_model(file)
            if top is None:
                raise include.fault(
                    f"it includes {file.path}, which has not just one <model>: take one that has"
                )
            model = replace(include, element=top, file=file.path, version=file.version)
            self.sources.append(model)
            found = _Found(model, (*found.includes, include), (*found.files, file.path))
        return found

    def _open(self, include: Node, files: tuple[Path, ...]) -> SdfFile:
        """Return the file that an include means, within bounds."""
        self._includes += 1
        if self._includes > MOST_INCLUDES:
            raise include.fault(f"there are more than {MOST_INCLUDES} includes: leave some out")
        if len(files) > DEEPEST:
            raise include.fault(f"includes are more than {DEEPEST} levels deep: leave some out")
        file = self._files.included(include)
        if os.path.realpath(file.path) in map(os.path.realpath, files):
            way = " -> ".join(path.name for path in (*files, file.path))
            raise include.fault(f"the file includes itself ({way}): take this <include> out")
        self._size += file.size
        if self._size > MOST_ELEMENTS:
            raise include.fault(
                f"with this include there are more than {MOST_ELEMENTS} elements: leave some out"
            )
        return file

    def add(self, found: _Found, inside: Node, depth: int) -> None:
        """Add a model and all in it.

        Args:
            found: the model.
            inside: the same, where its own words hold.
            depth: 1 for the whole, one more for a model in it.
        """
        if depth > DEEPEST:
            raise inside.fault(f"models are more than {DEEPEST} levels deep: leave some out")
        links, models = len(self.links), len(self.models)
        for child in inside.children():
            self._add_child(child, found.files, depth)
        for include in found.includes:
            self.plugins += [
                replace(inside, element=plugin.element, file=plugin.file, version=plugin.version)
                for plugin in include.children("plugin")
            ]
        own = [link.name for link in self.links[links:] if link.scope == inside.scope]
        nested = [
            model.name.removeprefix(inside.scope)
            for model in self.models[models:]
            if model.owner.scope == inside.scope
        ]
        self.models.append(
            Frame(
                name=inside.model,
                owner=found.model,
                pose=found.first("pose"),
                base=ROOT,
                inside=inside,
                carrier=inside.attribute("canonical_link") or next(iter(own + nested), ""),
                placement=found.placement,
            )
        )

    def _add_child(self, child: Node, files: tuple[Path, ...], depth: int) -> None:
        """Add what a model has directly in it."""
        tag = child.element.tag
        self._parts += 1 + (len(child.element) if tag in ("link", "joint") else 0)
        if self._parts > MOST_PARTS:
            raise child.fault(
                f"with this there are more than {MOST_PARTS} links, joints, frames and elements of "
                "them: leave some out"
            )
        match tag:
            case "link":
                self.links.append(child)
            case "joint":
                self.joints.append(child)
            case "frame":
                self.frames.append(child)
            case "plugin":
                self.plugins.append(child)
            case "model" | "include":
                try:
                    found = self.follow(_Found(child, (), files))
                except MissingIncludeError as fault:
                    self.missing.append((child, fault))
                    return
                merged = tag == "include" and flag(child, child.attribute("merge"))
                self.add(
                    found, self._merged(found) if merged else _nested(found, found.name), depth + 1
                )

    def _merged(self, found: _Found) -> Node:
        """Return the inside of a model whose parts become those of the model around it.

        Its own frame remains, by a name that no file can refer to.
        """
        frame = f"{found.model.scope}{found.name}\n{self._includes}"
        return replace(found.model, model=frame)


def only_model(file: SdfFile) -> Element | None:
    """Return the `<model>` or `<include>` of a file that has just one and no world."""
    tops = [top for top in file.root if top.tag in ("model", "include", "world")]
    top = tops[0] if len(tops) == 1 else None
    return top if isinstance(top, Element) and top.tag != "world" else None


def _nested(found: _Found, name: str) -> Node:
    """Return the inside of a model that has a scope of its own."""
    scope = f"{found.model.scope}{name}::"
    return replace(found.model, scope=scope, model=f"{scope}__model__")
