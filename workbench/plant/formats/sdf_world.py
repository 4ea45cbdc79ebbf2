"""Choose the model that flies, of those in a file."""

from workbench.errors import WorkbenchError
from workbench.plant.formats.sdf_include import SdfFile, SdfFiles, model_name
from workbench.plant.formats.sdf_node import Node
from workbench.plant.formats.sdf_poses import ROOT
from workbench.plant.formats.sdf_tree import SdfTree, grow_tree
from workbench.plant.formats.sdf_values import flag
from workbench.plant.formats.values import shortened
from workbench.plant.formats.xml import Element
from workbench.plant.remarks import Remarks

MOST_MODELS = 1000
MOST_SHOWN = 10
_SCENERY = ("sun", "ground_plane")
"""What comes with Gazebo, and in most worlds."""


def choose_model(file: SdfFile, files: SdfFiles, remarks: Remarks) -> SdfTree:
    """Return the one model of a file or of its world, or the one of several that flies.

    That is the only one with a motor-model plugin; where none has one, the only one that is not
    static.

    Args:
        file: the file.
        files: where to find included ones.
        remarks: where to note the models that are left out.

    Raises:
        WorkbenchError: if there is no model, or none or several that may be meant.
    """
    tops = _tops(file)
    if not tops:
        raise WorkbenchError(f"{file.path}: there is no <model> in it, nor an <include> of one")
    if len(tops) > MOST_MODELS:
        raise WorkbenchError(
            f"{file.path}: there are more than {MOST_MODELS} models: give the drone's own file"
        )
    if len(tops) == 1:
        return grow_tree(file, tops[0], files)
    top, tree = _flying(file, [top for top in tops if not _is_scenery(top)], files)
    others = _list([_name(other) for other in tops if other is not top])
    text = f"'{shortened(tree.name)}' is the one that flies; left out are {others}"
    remarks.add("ignored", file.path, "models of the world", text)
    return tree


def _flying(file: SdfFile, tops: list[Node], files: SdfFiles) -> tuple[Node, SdfTree]:
    """Return the one of several models that flies."""
    grown: list[tuple[Node, SdfTree]] = []
    faults: list[WorkbenchError] = []
    for top in tops:
        try:
            grown.append((top, grow_tree(file, top, files)))
        except WorkbenchError as fault:  # scenery that is not at hand need not keep us
            faults.append(fault)
    flying = [(top, tree) for top, tree in grown if _has_motors(tree)]
    if not flying and faults:
        others = f" (and so with {len(faults) - 1} more models)" if len(faults) > 1 else ""
        raise WorkbenchError(f"{faults[0]}{others}")
    flying = flying or [(top, tree) for top, tree in grown if not tree.static]
    if not flying:
        raise WorkbenchError(f"{file.path}: all its models are static: give the drone's own file")
    if len(flying) > 1:
        raise WorkbenchError(
            f"{file.path}: several of its models could be the drone: "
            f"{_list([tree.name for _, tree in flying])}: give that model's own file"
        )
    return flying[0]


def _tops(file: SdfFile) -> list[Node]:
    """Return the models and includes of a file and of the worlds in it."""
    places = [file.root, *file.root.findall("world")]
    return [
        Node(top, file.path, file.version, "", ROOT)
        for place in places
        for top in place
        if isinstance(top, Element) and top.tag in ("model", "include")
    ]


def _is_scenery(top: Node) -> bool:
    """Return whether something stands still for certain, found or not."""
    static = top.child("static")
    if static and flag(static, static.text):
        return True
    name = model_name(top.text_of("uri")) if top.element.tag == "include" else ""
    return name.lower().replace(" ", "_") in _SCENERY


def _has_motors(tree: SdfTree) -> bool:
    """Return whether a model has a motor-model plugin of RotorS, PX4 or gz-sim."""
    names = [plugin.attribute("filename") + plugin.attribute("name") for plugin in tree.plugins]
    return any("motormodel" in "".join(filter(str.isalnum, name)).lower() for name in names)


def _name(top: Node) -> str:
    """Return the name of a model, as far as it can be known without opening files."""
    return top.attribute("name") or top.text_of("name") or model_name(top.text_of("uri"))


def _list(names: list[str]) -> str:
    """Return names for a message."""
    more = f" and {len(names) - MOST_SHOWN} more" if len(names) > MOST_SHOWN else ""
    return ", ".join(f"'{shortened(name)}'" for name in names[:MOST_SHOWN]) + more
