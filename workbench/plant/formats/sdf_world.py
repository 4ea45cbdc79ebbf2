"""Select the flying model among those in a file, or read all of them as one world."""

from workbench.common.errors import WorkbenchError
from workbench.plant.formats.sdf_include import SdfFile, SdfFiles, model_name
from workbench.plant.formats.sdf_node import Node, flag
from workbench.plant.formats.sdf_tree import ROOT, Frame, SdfTree, grow_tree
from workbench.plant.formats.values import shortened
from workbench.plant.formats.xml import Element
from workbench.plant.remarks import Remarks

MOST_MODELS = 1000
MOST_SHOWN = 10
_SCENERY = ("sun", "ground_plane")
"""Models that come with Gazebo and are in most worlds."""


def choose_model(file: SdfFile, files: SdfFiles, remarks: Remarks) -> SdfTree:
    """Return the only model of a file or of its world, or the flying one of several.

    The flying model is the only one with a motor-model plugin or, if none has one, the only one
    that is not static.

    Args:
        file: the file.
        files: finds included ones.
        remarks: receives a remark on other models.

    Raises:
        WorkbenchError: if there is no such model, or several.
    """
    tops = top_models(file)
    if not tops:
        raise WorkbenchError(f"{file.path}: there is no <model> in it, nor an <include> of one")
    if len(tops) > MOST_MODELS:
        raise WorkbenchError(
            f"{file.path}: there are more than {MOST_MODELS} models: give a file with the drone "
            "alone"
        )
    if len(tops) == 1:
        return grow_tree(file, tops[0], files)
    top, tree = _flying(file, [top for top in tops if not is_scenery(top)], files)
    others = list_of_names([top_name(other) for other in tops if other is not top])
    text = f"'{shortened(tree.name)}' flies; left out are {others}"
    remarks.add("ignored", file.path, "models of the world", text)
    return tree


def world_of(file: SdfFile, world: Node, trees: list[SdfTree]) -> SdfTree:
    """Return models as parts of one tree with the frame of their world.

    Args:
        file: of the world.
        world: its `<world>`, or the element that contains the models.
        trees: of the models, see `grow_in_world`.
    """
    root = Frame(world.model, owner=world, pose=None, base=ROOT, inside=world, carrier="")
    return SdfTree(
        name=world.attribute("name") or file.path.stem,
        static=True,
        sources=[source for tree in trees for source in tree.sources],
        models=[root, *(model for tree in trees for model in tree.models)],
        links=[link for tree in trees for link in tree.links],
        joints=[joint for tree in trees for joint in tree.joints],
        frames=[*world.children("frame"), *(frame for tree in trees for frame in tree.frames)],
        plugins=[plugin for tree in trees for plugin in tree.plugins],
    )


def _flying(file: SdfFile, tops: list[Node], files: SdfFiles) -> tuple[Node, SdfTree]:
    """Return the flying one of several models."""
    grown: list[tuple[Node, SdfTree]] = []
    faults: list[WorkbenchError] = []
    for top in tops:
        try:
            tree = grow_tree(file, top, files)
        except WorkbenchError as fault:  # scenery may be missing
            faults.append(fault)
            continue
        if tree.missing and not has_motors(tree):
            faults.append(tree.missing[0][1])
        else:
            grown.append((top, tree))
    flying = [(top, tree) for top, tree in grown if has_motors(tree)]
    if not flying and faults:
        others = f" (and so with {len(faults) - 1} more models)" if len(faults) > 1 else ""
        raise WorkbenchError(f"{faults[0]}{others}")
    flying = flying or [(top, tree) for top, tree in grown if not tree.static]
    if not flying:
        raise WorkbenchError(
            f"{file.path}: all its models are static: give a file with the drone alone"
        )
    if len(flying) > 1:
        raise WorkbenchError(
            f"{file.path}: several of its models could be the drone: "
            f"{list_of_names([tree.name for _, tree in flying])}: give a file with that model alone"
        )
    return flying[0]


def top_models(file: SdfFile) -> list[Node]:
    """Return the models and includes of a file and of the worlds in it."""
    places = [file.root, *file.root.findall("world")]
    return [
        Node(top, file.path, file.version, "", ROOT)
        for place in places
        for top in place
        if isinstance(top, Element) and top.tag in ("model", "include")
    ]


def is_scenery(top: Node) -> bool:
    """Return whether a model is certainly static, even if its file is missing."""
    static = top.child("static")
    if static and flag(static, static.text):
        return True
    return bool(gazebos_own(top))


def gazebos_own(top: Node) -> str:
    """Return `sun` or `ground_plane` for an include of that model of Gazebo, else ""."""
    name = model_name(top.text_of("uri")) if top.element.tag == "include" else ""
    name = name.lower().replace(" ", "_")
    return name if name in _SCENERY else ""


def has_motors(tree: SdfTree) -> bool:
    """Return whether a model has a motor-model plugin of RotorS, PX4 or gz-sim."""
    return any(map(_is_motor, tree.plugins))


def motor_names(tree: SdfTree) -> list[str]:
    """Return the names of links and joints in the motor-model plugins of a model."""
    return [
        plugin.text_of(tag)
        for plugin in tree.plugins
        if _is_motor(plugin)
        for tag in ("jointName", "linkName")
    ]


def same_part(name: str, full_name: str) -> bool:
    """Return whether a name in a plugin may refer to a link or joint, ignoring scopes."""
    return _without_scopes(name) == _without_scopes(full_name)


def _without_scopes(name: str) -> str:
    return name.replace("::", "/").rpartition("/")[2]


def _is_motor(plugin: Node) -> bool:
    name = plugin.attribute("filename") + plugin.attribute("name")
    return "motormodel" in "".join(filter(str.isalnum, name)).lower()


def top_name(top: Node) -> str:
    """Return the name of a model, as far as it is known without opening other files."""
    return top.attribute("name") or top.text_of("name") or model_name(top.text_of("uri"))


def list_of_names(names: list[str]) -> str:
    """Return names for a message."""
    more = f" and {len(names) - MOST_SHOWN} more" if len(names) > MOST_SHOWN else ""
    return ", ".join(f"'{shortened(name)}'" for name in names[:MOST_SHOWN]) + more
