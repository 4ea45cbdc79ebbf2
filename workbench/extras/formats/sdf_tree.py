"""Assemble a model from its file, its nested models and its includes."""

import os
from collections.abc import Container
from dataclasses import dataclass, field, replace
from itertools import count
from pathlib import Path

from workbench.extras.formats.sdf_include import MissingIncludeError, SdfFile, SdfFiles
from workbench.extras.formats.sdf_node import Node, checked_name
from workbench.plant.formats.sdf_pose import sdf_flag
from workbench.plant.formats.xml import MAX_XML_ELEMENTS, Element

MODEL_FRAME_NAME = "__model__"
"""Name of the frame of the model that contains an element."""
MAX_SDF_MODEL_DEPTH = 20
"""Largest depth of nested models, included or not."""
MAX_SDF_INCLUDES = 200
MAX_SDF_PARTS = 5000
"""Largest number of elements of models, links and joints."""


@dataclass(frozen=True)
class SdfFrame:
    """A frame F: of a model, a link or a joint, or a `<frame>`.

    Attributes:
        name: full name: `__model__`, `child::__model__`.
        owner: the element, with the context of its pose; for a model, that around the model.
        pose: its `<pose>`, or None.
        base: name of the default reference frame of the pose.
        inside: the element, with the context of the next two names.
        carrier: name of the frame that it is attached to; "" for a link, or a model without one.
        placement: name of the frame placed by the pose; "" for itself.
    """

    name: str
    owner: Node
    pose: Node | None
    base: str
    inside: Node
    carrier: str
    placement: str = ""


@dataclass
class SdfTree:
    """A model with all its parts, in the order of the files.

    Attributes:
        name: of the model.
        static: whether it is declared static.
        sources: the `<model>` and `<include>` elements that were read, one for each file.
        models: frames of the model and of nested models.
        links: `<link>` elements.
        joints: `<joint>` elements.
        frames: `<frame>` elements.
        plugins: `<plugin>` elements of models and includes.
        missing: `<include>`s with a missing file, each with its error.
    """

    name: str = ""
    static: bool = False
    sources: list[Node] = field(default_factory=list)
    models: list[SdfFrame] = field(default_factory=list)
    links: list[Node] = field(default_factory=list)
    joints: list[Node] = field(default_factory=list)
    frames: list[Node] = field(default_factory=list)
    plugins: list[Node] = field(default_factory=list)
    missing: list[tuple[Node, MissingIncludeError]] = field(default_factory=list)

    def check_complete(self) -> None:
        """Raise the error of the first missing include, if any."""
        for _, fault in self.missing:
            raise fault


def build_sdf_tree(
    file: SdfFile, top: Node, files: SdfFiles, taken: Container[str] | None = None
) -> SdfTree:
    """Return a model with all its parts; missing includes are listed and left out.

    Args:
        file: that contains it.
        top: its `<model>`, or the `<include>` of it.
        files: finds included ones.
        taken: for a part of a world, whose names have its own name as their scope: names of other
            models there; a second model with a name gets a number.

    Raises:
        WorkbenchError: naming file and line, for an include in a circle, models nested too deeply,
            and a model that is too large.
    """
    grower = _SdfTreeBuilder(files, file, top)
    found = grower.follow(_NestedModel(top, (), (file.path,)))
    if taken is None:
        return grower.grown(found, found.model, found.name)
    names = (f"{found.name}_{number}" if number else found.name for number in count())
    name = next(name for name in names if name not in taken)
    return grower.grown(found, _nested(found, name), name)


@dataclass(frozen=True)
class _NestedModel:
    """A model in the context of its parent.

    Attributes:
        model: the `<model>`, or an `<include>` to follow.
        includes: the `<include>`s that lead to it from its parent, the outermost first.
        files: the files that lead to it, its own last.
    """

    model: Node
    includes: tuple[Node, ...]
    files: tuple[Path, ...]

    @property
    def name(self) -> str:
        """The name of the model in its parent."""
        for include in self.includes:
            name = include.child("name")
            if name and name.text:
                return checked_name(name, name.text)
        return self.model.name

    @property
    def placement(self) -> str:
        """The name of the frame placed by its pose, "" for the model frame."""
        given = [include.text_of("placement_frame") for include in self.includes]
        return next(filter(None, given), self.model.attribute("placement_frame"))

    def first(self, tag: str) -> Node | None:
        """Return a child of the includes or the model; the outermost one takes precedence."""
        children = (over.child(tag) for over in (*self.includes, self.model))
        return next((child for child in children if child), None)


class _SdfTreeBuilder:
    """Collects the parts of a model."""

    def __init__(self, files: SdfFiles, file: SdfFile, top: Node) -> None:
        self._files = files
        self._size = file.size
        self._includes = 0
        self._parts = 0
        self._tree = SdfTree(sources=[top])

    def grown(self, found: _NestedModel, inside: Node, name: str) -> SdfTree:
        """Return a model with its parts.

        Args:
            found: the model.
            inside: see `_add`.
            name: of the model.
        """
        self._add(found, inside, 1)
        static = found.first("static")
        self._tree.name = name
        self._tree.static = static is not None and sdf_flag(static.element, static.text)
        return self._tree

    def follow(self, found: _NestedModel) -> _NestedModel:
        """Return the model that an include leads to; a model is returned unchanged."""
        while found.model.element.tag == "include":
            include = found.model
            file = self._open(include, found.files)
            top = only_model(file)
            if top is None:
                raise include.fault(
                    f"it includes {file.path}, which does not have exactly one <model>: include a "
                    "file that has"
                )
            model = replace(include, element=top, file=file.path, version=file.version)
            self._tree.sources.append(model)
            found = _NestedModel(model, (*found.includes, include), (*found.files, file.path))
        return found

    def _open(self, include: Node, files: tuple[Path, ...]) -> SdfFile:
        """Return the file of an include, within limits."""
        self._includes += 1
        if self._includes > MAX_SDF_INCLUDES:
            raise include.fault(f"there are more than {MAX_SDF_INCLUDES} includes: leave some out")
        if len(files) > MAX_SDF_MODEL_DEPTH:
            raise include.fault(
                f"includes are more than {MAX_SDF_MODEL_DEPTH} levels deep: leave some out"
            )
        file = self._files.included(include)
        if os.path.realpath(file.path) in map(os.path.realpath, files):
            way = " -> ".join(path.name for path in (*files, file.path))
            raise include.fault(f"the file includes itself ({way}): take this <include> out")
        self._size += file.size
        if self._size > MAX_XML_ELEMENTS:
            raise include.fault(
                f"with this include there are more than {MAX_XML_ELEMENTS} elements: leave some out"
            )
        return file

    def _add(self, found: _NestedModel, inside: Node, depth: int) -> None:
        """Add a model and its contents.

        Args:
            found: the model.
            inside: the same with the context of its contents.
            depth: 1 for the outermost model, one more for each nested model.
        """
        if depth > MAX_SDF_MODEL_DEPTH:
            raise inside.fault(
                f"models are more than {MAX_SDF_MODEL_DEPTH} levels deep: leave some out"
            )
        links, models = len(self._tree.links), len(self._tree.models)
        for child in inside.children():
            self._add_child(child, found.files, depth)
        for include in found.includes:
            self._tree.plugins += [
                replace(inside, element=plugin.element, file=plugin.file, version=plugin.version)
                for plugin in include.children("plugin")
            ]
        own = [link.name for link in self._tree.links[links:] if link.scope == inside.scope]
        nested = [
            model.name.removeprefix(inside.scope)
            for model in self._tree.models[models:]
            if model.owner.scope == inside.scope
        ]
        self._tree.models.append(
            SdfFrame(
                name=inside.model,
                owner=found.model,
                pose=found.first("pose"),
                base=MODEL_FRAME_NAME,
                inside=inside,
                carrier=inside.attribute("canonical_link") or next(iter(own + nested), ""),
                placement=found.placement,
            )
        )

    def _add_child(self, child: Node, files: tuple[Path, ...], depth: int) -> None:
        """Add a direct child of a model."""
        tag = child.element.tag
        self._parts += 1 + (len(child.element) if tag in ("link", "joint") else 0)
        if self._parts > MAX_SDF_PARTS:
            raise child.fault(
                f"with this element there are more than {MAX_SDF_PARTS} links, joints, frames and "
                "elements of them: leave some out"
            )
        match tag:
            case "link":
                self._tree.links.append(child)
            case "joint":
                self._tree.joints.append(child)
            case "frame":
                self._tree.frames.append(child)
            case "plugin":
                self._tree.plugins.append(child)
            case "model" | "include":
                try:
                    found = self.follow(_NestedModel(child, (), files))
                except MissingIncludeError as fault:
                    self._tree.missing.append((child, fault))
                    return
                merged = tag == "include" and sdf_flag(child.element, child.attribute("merge"))
                self._add(
                    found, self._merged(found) if merged else _nested(found, found.name), depth + 1
                )

    def _merged(self, found: _NestedModel) -> Node:
        """Return the context of a merged model, with its parts in the scope of its parent.

        Its own frame remains, with a name that no file can refer to.
        """
        frame = f"{found.model.scope}{found.name}\n{self._includes}"
        return replace(found.model, model=frame)


def only_model(file: SdfFile) -> Element | None:
    """Return the only `<model>` or `<include>` of a file without a world, or None."""
    tops = [top for top in file.root if top.tag in ("model", "include", "world")]
    top = tops[0] if len(tops) == 1 else None
    return top if isinstance(top, Element) and top.tag != "world" else None


def _nested(found: _NestedModel, name: str) -> Node:
    """Return the context of a model with its own scope."""
    scope = f"{found.model.scope}{name}::"
    return replace(found.model, scope=scope, model=f"{scope}__model__")
